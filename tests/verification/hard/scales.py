# SPDX-License-Identifier: GPL-3.0-or-later
"""Scales: a scene in other units of stiffness, length and time gives the same nondimensional figures.

With lengths times L, stiffness times E and times times T every displacement is L times as long, every force E L^(d−1) times
as large, energies E L^d, if the density is E T²/L² and viscosities E T times as large. Rescaled numbers are rounded, by
ε = 2e-16, as is all that is computed from them; contact steps pass such differences on but do not blow them up as long as
the active sets agree, which they must. 1e-9 leaves six digits for the condition of D and the length of the run.
"""

import functools
from collections.abc import Callable
from itertools import permutations, product
from pathlib import Path

import numpy as np
import pytest
from harness import stored, table, toml
from schemes import SCHEMES, run

# Factors of E, L and T: each over its range alone, and the corners where they work against each other.
FACTORS = [(1e12, 1, 1), (1, 1e-6, 1), (1, 1e6, 1), (1, 1, 1e-6), (1, 1, 1e6), (1e6, 1e-3, 1e-5),
           (1e12, 1e-6, 1e6), (1, 1e6, 1e-6), (1e12, 1e6, 1e6)]  # fmt: skip
TOLERANCE = 1e-9
STEPS = 60
STEP = 0.08  # s
CASES = {
    **{f"plane, {scheme}": (2, over) for scheme, over in SCHEMES.items()},
    "plane, full VI": (2, {"solver__vi": "full"}),
    **{f"space, {scheme}": (3, over) for scheme, over in SCHEMES.items()},
}


def mesh(file: Path, dim: int, length: float) -> None:
    """A block [−½, ½]^(d−1) × [0, 1] of simplices with a bulging bottom, no two of whose nodes are equally high. Written
    out, so that all scales have the same one."""
    n = 6 if dim == 2 else 3
    count = n + 1
    nodes = np.array(list(product(range(count), repeat=dim)))
    x = nodes / n - np.array([0.5] * (dim - 1) + [0])
    bulge = (0.3 * x[:, :-1] ** 2).sum(axis=1) + x[:, :-1] @ np.array([0.02, 0.031][: dim - 1])
    x[:, -1] += bulge * (1 - x[:, -1])

    def number(node: tuple) -> int:
        return int(np.dot(node, count ** np.arange(dim)[::-1]))

    def simplices(corner: tuple, axes: list[int]) -> list[list[int]]:
        """Kuhn's, of a cube along axes: one for each order in which to go along them."""
        found = []
        for order in permutations(axes):
            node, path = np.array(corner), [number(corner)]
            for axis in order:
                node = node + np.eye(dim, dtype=int)[axis]
                path.append(number(node))
            found.append(path)
        return found

    cells = [s for corner in product(range(n), repeat=dim) for s in simplices(corner, list(range(dim)))]
    bottom = [s for corner in product(range(n), repeat=dim - 1) for s in simplices((*corner, 0), list(range(dim - 1)))]
    kinds = {2: (1, 2), 3: (2, 4)}[dim]  # gmsh's numbers of lines and triangles, triangles and tetrahedra
    elements = [(kinds[0], 1, s) for s in bottom] + [(kinds[1], 2, s) for s in cells]
    padded = np.zeros((len(x), 3))
    padded[:, :dim] = x * length
    file.write_text("\n".join(
        ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", f'{dim - 1} 1 "contact"', f'{dim} 2 "body"',
         "$EndPhysicalNames", "$Nodes", str(len(x))]
        + [f"{i + 1} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(padded.tolist())]
        + ["$EndNodes", "$Elements", str(len(elements))]
        + [f"{i + 1} {kind} 2 {group} {group} {' '.join(str(v + 1) for v in s)}" for i, (kind, group, s) in enumerate(elements)]
        + ["$EndElements", ""]))  # fmt: skip


def simulate(folder: Path, dim: int, E: float, L: float, T: float, over: dict) -> dict[str, np.ndarray]:
    """The nondimensional figures of a body that is thrown down and pressed on a plane, with viscosity."""
    mesh(folder / "block.msh", dim, L)
    sideways, zeros = ["0"] * (dim - 2), [0] * (dim - 1)
    scene = folder / "block.toml"
    tables = {
        "mesh": {"file": "block.msh"},
        "time": {"end": STEPS * STEP * T, "step": STEP * T},
        "material": {"density": E * T**2 / L**2, "young": E, "poisson": 0.3, "viscosity": {"bulk": 0.01 * E * T, "shear": 0.01 * E * T}},
        "contact": {"on": "contact", "obstacle": {"shape": "half-space", "point": [*zeros, -0.05 * L], "normal": [*zeros, 1]}},
        "load": {"body": ["0", *sideways, repr(-0.02 * E / L)]},
        "initial": {"velocity": [repr(0.02 * L / T), *sideways, repr(-0.1 * L / T)]},
        "output": {"fields": ["displacement"]},
    }
    scene.write_text("\n".join(f"{key} = {toml(value)}" for key, value in tables.items()))
    steps = run(scene, folder / "out", output__fields=["displacement"], **over)
    contact = table(folder / "out" / "contact.csv")
    force = E * L ** (dim - 1)
    _, _, y = stored(folder / "out", "state", "displacement")
    return {
        "displacement": y / L,
        "gap": contact["gap"] / L,
        "force": contact["force"] / force,
        "energy": np.stack([steps["kinetic_energy"], steps["elastic_energy"]]) / (force * L),
        "set": contact["force"] > 0,
        "active": steps["active"],
        "weak": steps["weak"],
    }


@pytest.fixture(scope="module")
def unscaled(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], dict[str, np.ndarray]]:
    """The figures at the scale 1, by case; each motion is computed once."""

    @functools.cache
    def found(case: str) -> dict[str, np.ndarray]:
        dim, over = CASES[case]
        base = simulate(tmp_path_factory.mktemp("base"), dim, 1.0, 1.0, 1.0, over)
        pushed = base["force"].reshape(len(base["active"]), -1) > 0
        contact, changes = pushed.any(axis=1).sum(), (pushed[1:] != pushed[:-1]).any(axis=1).sum()
        print(f"contact in {contact} of {STEPS} steps, {changes} changes of the set, {pushed.any(axis=0).sum()} candidates")
        assert contact > 5 and changes > 3, "hardly any contact: the case says nothing"
        return base

    return found


@pytest.mark.parametrize("E, L, T", FACTORS, ids=[f"E {E:g}, L {L:g}, T {T:g}" for E, L, T in FACTORS])
@pytest.mark.parametrize("case", CASES)
def test_same_figures(unscaled: Callable, case: str, E: float, L: float, T: float, tmp_path: Path) -> None:
    base = unscaled(case)
    dim, over = CASES[case]
    found = simulate(tmp_path, dim, float(E), float(L), float(T), over)
    off = {key: abs(found[key] - base[key]).max() / abs(base[key]).max() for key in ("displacement", "gap", "force", "energy")}
    print("off by " + ", ".join(f"{key} {value:.0e}" for key, value in off.items()) + f" <= {TOLERANCE:.0e}")
    for key in ("set", "active", "weak"):
        assert np.array_equal(found[key], base[key]), key
    for key, value in off.items():
        assert value <= TOLERANCE, key
