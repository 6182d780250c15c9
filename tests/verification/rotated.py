# SPDX-License-Identifier: GPL-3.0-or-later
"""The half disc's and the half ball's experiments, turned by 37 degrees with mesh, plane and controls: nothing may depend on
the directions of the axes."""

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_BALL, HALF_DISC, signorini, stored, table
from written_mesh import groups, write_mesh

ANGLE = np.deg2rad(37)
# The coordinates, turned, are rounded, and each of up to 150 steps leaves the accuracy of its solver, 1e-12 at most
# (verification.agreement).
TOLERANCE = 1e-10
ENERGIES = ("kinetic_energy", "elastic_energy", "viscous_dissipation", "external_work", "tracking_error")
# Scene, element size, keys.
BODIES = {"half disc": (HALF_DISC, 1.5, {}), "half ball": (HALF_BALL, 2.4, {"time__step": 2.5e-4})}
VARIANTS = {
    "condensed": {},
    "full VI": {"solver__vi": "full"},
    "conjugate gradients": {"solver__linear": "iterative"},
    "degree 2": {"degree": 2},
    "degree 2, full VI": {"degree": 2, "solver__vi": "full"},
}
CASES = [("half disc", variant) for variant in VARIANTS] + [("half ball", variant) for variant in list(VARIANTS)[:3]]


def turn(dim: int) -> np.ndarray:
    """In space about an axis that is none of the coordinates'."""
    if dim == 2:
        return np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
    x, y, z = np.array([1, 2, 3]) / np.sqrt(14)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(ANGLE) * cross + (1 - np.cos(ANGLE)) * cross @ cross


def run(scene: Path, R: np.ndarray, out: Path, **overrides: object) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The experiment turned by R, pushed with nine tenths of its reference control: its figures seen from the turned axes, in
    an order that does not depend on R, and how many candidates are active at each step."""
    dim, down = len(R), -R[:, -1]

    def push(size: float) -> list[str]:
        return [f"{size * x:.17g}" for x in down]

    signorini("optimize", scene, out, optimizer__max_iterations=0, control__initial=push(0.9),
              objective__desired={"control": push(1)}, **overrides,
              contact__obstacle={"shape": "half-space", "point": list(15.75 * down), "normal": list(-down)})  # fmt: skip
    steps, contact, history = (table(out / f"{name}.csv") for name in ("steps", "contact", "history"))
    assert (contact["force"] > 0).sum() > 20, "hardly any contact: the case says nothing"
    figures = {name: steps[name] for name in ENERGIES} | {name: history[name] for name in ("objective", "gradient_norm")}
    for name in ("displacement", "velocity"):
        points, _, values = stored(out, "state", name)
        figures[name] = (values[:, :, :dim] @ R)[:, np.lexsort((points @ R).round(6).T)]
    candidates = np.column_stack([contact[axis] for axis in "xyz"[:dim]]) @ R
    order = np.lexsort([*candidates.round(6).T, contact["step"]])
    figures |= {"gaps": contact["gap"][order], "nodal forces": contact["force"][order]}
    figures["contact force"] = np.column_stack([steps[f"contact_force_{axis}"] for axis in "xyz"[:dim]]) @ R
    return figures, steps["active"]


@pytest.fixture(scope="module")
def meshed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[np.ndarray, np.ndarray]]:
    """Nodes and cells of one of BODIES, from one short run."""

    @functools.cache
    def mesh(name: str) -> tuple[np.ndarray, np.ndarray]:
        (scene, size, _), out = BODIES[name], tmp_path_factory.mktemp("mesh") / "out"
        signorini("simulate", scene, out, mesh__size=size, time__step=1e-4, time__end=1e-4)
        return stored(out, "state", "displacement")[:2]

    return mesh


@pytest.mark.parametrize("name, variant", CASES)
def test_turned(meshed: Callable, name: str, variant: str, tmp_path: Path) -> None:
    (scene, _, keys), (points, cells), solver = BODIES[name], meshed(name), dict(VARIANTS[variant])
    dim, degree = points.shape[1], solver.pop("degree", 1)
    found = []
    for R in (np.eye(dim), turn(dim)):
        mesh = tmp_path / "mesh.msh"
        write_mesh(mesh, points @ R.T, cells, groups(points, cells))
        found.append(run(scene, R, tmp_path / "out", mesh={"file": str(mesh), "degree": degree}, **solver, **keys))
    (straight, active), (turned, turned_active) = found
    off = {key: abs(turned[key] - straight[key]).max() / abs(straight[key]).max() for key in straight}
    print(f"{(active > 0).sum()} steps in contact; relative differences " + ", ".join(f"{key} {value:.1e}" for key, value in off.items()))
    assert np.array_equal(active, turned_active), "active candidates differ"
    assert off == pytest.approx(dict.fromkeys(off, 0), abs=TOLERANCE)
