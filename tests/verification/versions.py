# SPDX-License-Identifier: GPL-3.0-or-later
"""Every version of the libraries finds the same: figures of contact with a half disc and a half ball, as dolfinx 0.9 with
PETSc 3.22 found them (versions.json), on meshes that this file writes itself, since every gmsh makes others. To record them anew:

    ./dev exec sh -c 'cd tests/verification && PYTHONPATH=.. python3 -c "import versions; versions.record()"'
"""

import json
import tempfile
from itertools import permutations, product
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_BALL, HALF_DISC, signorini, table
from written_mesh import groups, write_mesh

RECORDED = Path(__file__).with_suffix(".json")
# Of coordinates changed by 1e-8 at random the impulses change by at most 27e-8, the other figures by 11e-8. Roundings of
# 1.1e-16 in each of 150 steps, if all added up, would then make 4.5e-13. Between one rank and two there are 1.3e-13.
TOLERANCE = 1e-12
RADIUS = 15
# A scene, cells along its radius, keys that keep the runs short.
SCENES = {
    "half disc, 1.5 m": (HALF_DISC, 10, {}),
    "half disc, 1 m": (HALF_DISC, 15, {}),
    "half ball, 2.5 m": (HALF_BALL, 6, {"time__step": 2.5e-4}),
}


def half_round(dim: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and cells of the half disc or half ball, n cells along its radius: a grid of the half square or half cube, each
    cell cut along the diagonal that points away from the middle, its squares or cubes about the middle drawn to circles or
    spheres. Needs no function but the square root, which IEEE 754 rounds correctly, so that all machines get the same."""
    sides = [np.arange(-n, n + 1)] * (dim - 1) + [np.arange(-n, 1)]
    grid = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:-1])
    cells = []
    for cell in product(*(range(len(side) - 1) for side in sides)):
        low = np.array([side[i] for side, i in zip(sides, cell, strict=True)])
        outward = np.where(low >= 0, 1, -1)
        inner = np.array(cell) + (outward < 0)
        for axes in permutations(range(dim)):
            corner, simplex = inner.copy(), [number[tuple(inner)]]
            for axis in axes:
                corner[axis] += outward[axis]
                simplex.append(number[tuple(corner)])
            cells.append(simplex)
    points = grid.reshape(-1, dim).astype(float)
    largest, squared = abs(points).max(axis=1), (points**2).sum(axis=1)
    points *= (RADIUS / n * largest / np.sqrt(np.where(squared > 0, squared, 1)))[:, None]
    return points, np.array(cells)


def figures(scene: Path, mesh: Path, out: Path, ranks: int, **keys: object) -> dict[str, float]:
    """At no control, whose motion is pushed nowhere, and at nine tenths of the reference control, whose motion touches:
    objective and gradient; and what the plane gives the body there."""
    found = {}
    down = -np.eye(3 if scene == HALF_BALL else 2)[-1]
    for control in (0, 0.9):
        signorini("optimize", scene, out, ranks, mesh={"file": str(mesh)}, optimizer__max_iterations=0, solver__linear="direct",
                  control__initial=[f"{control * x + 0:g}" for x in down], **keys)  # fmt: skip
        history = table(out / "history.csv")
        found |= {f"J({control})": history["objective"][0], f"|g({control})|": history["gradient_norm"][0]}
    steps = table(out / "steps.csv")
    force = steps[f"contact_force_{'xyz'[len(down) - 1]}"]
    assert (force > 0).sum() > 5, "hardly any contact: the case says nothing"
    found["impulse"] = float(np.sum(force[1:] * np.diff(steps["time"])))
    found["steps in contact"] = int((force > 0).sum())
    return found


def case(name: str, folder: Path, ranks: int, moved: float = 0) -> dict[str, float]:
    """The figures of one of SCENES; `moved`: of a mesh whose coordinates are changed by up to that fraction, at random."""
    scene, n, keys = SCENES[name]
    points, cells = half_round(3 if scene == HALF_BALL else 2, n)
    facets = groups(points, cells)
    points *= 1 + moved * np.random.default_rng(1).uniform(-1, 1, points.shape)
    mesh = folder / "mesh.msh"
    write_mesh(mesh, points, cells, facets)
    return figures(scene, mesh, folder / "out", ranks, **keys)


def record() -> None:
    with tempfile.TemporaryDirectory() as folder:
        RECORDED.write_text(json.dumps({name: case(name, Path(folder), 1) for name in SCENES}, indent=2) + "\n")


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("name", SCENES)
def test_as_recorded(name: str, ranks: int, tmp_path: Path) -> None:
    recorded = json.loads(RECORDED.read_text())
    assert recorded.keys() == SCENES.keys()
    found, expected = case(name, tmp_path, ranks), recorded[name]
    assert found.pop("steps in contact") == expected.pop("steps in contact")
    assert found == pytest.approx(expected, rel=TOLERANCE, abs=0)
