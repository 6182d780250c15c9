# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests compare a run's numbers with, and how: a body of linear elements in numpy, from a run's mesh and its scene alone."""

import json
import tomllib
from itertools import combinations
from pathlib import Path

import numpy as np
from harness import boundary, stored, table

ROUNDING = 1e-11  # of sums over some hundred numbers, relative to the largest
TABLE = 1e-9  # times are printed with ten digits


def near(what: str, found: object, expected: object, tolerance: float = ROUNDING, scale: float | None = None) -> None:
    """Asserts that numbers are equal, relative to the largest expected one or to `scale`; NaN equals NaN alone."""
    found, expected = (np.asarray(values, dtype=float) for values in (found, expected))
    assert found.shape == expected.shape, what
    assert np.array_equal(np.isnan(found), np.isnan(expected)), f"{what}: no numbers in different places"
    size = np.nanmax(np.abs(expected), initial=0) if scale is None else scale
    off = np.nanmax(np.abs(found - expected), initial=0)
    assert off <= tolerance * size, f"{what}: found {found.ravel()[:12]}, expected {expected.ravel()[:12]}"


def same(what: str, found: object, expected: object) -> None:
    assert found == expected, what


class Body:
    """Mass, elasticity and viscosity of a body of one material (docs/method.md section 1), as dense matrices; unknown dim·i + c is
    component c of node i."""

    def __init__(self, points: np.ndarray, cells: np.ndarray, material: dict) -> None:
        self.points, self.cells, self.dim = points, cells, points.shape[1]
        dim, count = self.dim, self.dim * len(points)
        corners = points[cells]
        edges = corners[:, 1:] - corners[:, :1]
        self.volume = np.abs(np.linalg.det(edges)) / (2 if dim == 2 else 6)
        slopes = np.linalg.inv(edges).transpose(0, 2, 1)  # cells × dim functions × dim
        self.slopes = np.concatenate([-slopes.sum(axis=1, keepdims=True), slopes], axis=1)
        self.heights = 1 / np.linalg.norm(self.slopes, axis=2)
        self.density, young, poisson = (material[key] for key in ("density", "young", "poisson"))
        self.lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
        viscosity = material.get("viscosity", {"bulk": 0, "shear": 0})
        self.viscous = viscosity["bulk"] - 2 * viscosity["shear"] / 3, viscosity["shear"]
        self.M, self.W, self.A, self.B = (np.zeros((count, count)) for _ in range(4))
        for cell, nodes in enumerate(cells):
            own = (dim * nodes[:, None] + np.arange(dim)).ravel()
            hats = self.volume[cell] / ((dim + 1) * (dim + 2)) * (1 + np.eye(dim + 1))
            self.W[np.ix_(own, own)] += np.kron(hats, np.eye(dim))
            strains = np.array([self.strain_of(np.eye(len(own))[i].reshape(-1, dim), cell) for i in range(len(own))])
            for matrix, moduli in ((self.A, self.lame), (self.B, self.viscous)):
                matrix[np.ix_(own, own)] += self.volume[cell] * np.einsum("aij,bij->ab", isotropic(moduli, strains), strains)
        self.M = self.density * self.W

    def strain_of(self, values: np.ndarray, cell: int) -> np.ndarray:
        """The strain (3 × 3) of one cell's nodal values."""
        gradient = np.zeros((3, 3))
        gradient[: self.dim, : self.dim] = values.T @ self.slopes[cell]
        return (gradient + gradient.T) / 2

    def strains(self, values: np.ndarray) -> np.ndarray:
        """The strains (cells × 3 × 3) of nodal values (nodes × dim)."""
        return np.array([self.strain_of(values[nodes], cell) for cell, nodes in enumerate(self.cells)])

    def stresses(self, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Elastic and viscous."""
        return isotropic(self.lame, self.strains(displacement)) + isotropic(self.viscous, self.strains(velocity))

    def areas(self, on: np.ndarray) -> np.ndarray:
        """The integral of each node's hat function over the facets of the boundary whose nodes are all among `on`."""
        found = np.zeros(len(self.points))
        for facet in boundary(self.cells):
            if on[facet].all():
                corners = self.points[facet]
                first, *others = corners[1:] - corners[0]
                size = np.linalg.norm(first) if self.dim == 2 else np.linalg.norm(np.cross(first, others[0])) / 2
                found[facet] += size / self.dim
        return found

    def wave_speeds(self) -> tuple[float, float]:
        lame, shear = self.lame
        return np.sqrt((lame + 2 * shear) / self.density), np.sqrt(shear / self.density)


def isotropic(moduli: tuple[float, float], strain: np.ndarray) -> np.ndarray:
    first, second = moduli
    return first * np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) + 2 * second * strain


def von_mises(stress: np.ndarray) -> np.ndarray:
    """The von Mises stress, by differences of components."""
    squares = sum((stress[..., i, i] - stress[..., j, j]) ** 2 / 2 + 3 * stress[..., i, j] ** 2 for i, j in combinations(range(3), 2))
    return np.sqrt(squares)


class Run:
    """A run's files, and its body recomputed."""

    def __init__(self, out: Path) -> None:
        self.path, self.manifest = out, json.loads((out / "run.json").read_text())
        self.scene = tomllib.loads((out / "scene.toml").read_text())
        nodes, cells, displacement = stored(out, "state", "displacement")
        self.body = Body(nodes, cells, self.scene["material"])
        self.dim = dim = self.body.dim
        self.y, self.v = displacement[..., :dim], stored(out, "state", "velocity")[2][..., :dim]
        self.steps = self.table("steps")

    def table(self, name: str) -> dict[str, np.ndarray]:
        return table(self.path / f"{name}.csv")

    def forces(self, load: np.ndarray) -> np.ndarray:
        """Nodal forces of each step but that of `load` (steps × nodes × dim): contact, a control, clamps. Those that are left of
        M (v_k − v_{k−1})/τ + B (y_k − y_{k−1})/τ + A (y_k + y_{k−1})/2, the equation of a step."""
        flat = lambda field: field.reshape(len(field), -1)  # noqa: E731
        y, v, tau = flat(self.y), flat(self.v), np.diff(self.steps["time"])[:, None]
        left = np.diff(v, axis=0) / tau @ self.body.M + np.diff(y, axis=0) / tau @ self.body.B + (y[1:] + y[:-1]) / 2 @ self.body.A
        return left.reshape(len(tau), -1, self.dim) - load
