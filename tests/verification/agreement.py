# SPDX-License-Identifier: GPL-3.0-or-later
"""Different solvers find the same solution: condensed, full VI, conjugate gradients; and so do one, two and three ranks."""

from pathlib import Path

import numpy as np
import pytest
from agreeing import optimize_on_ranks, same_sets
from harness import HALF_BALL, HALF_DISC, SOURCE, signorini, stored, table

# The half ball at its reference control, coarse enough to be quick.
PUSHED = {"control__initial": ["0", "0", "-1"], "mesh__size": 3, "time__step": 2.5e-4}
# 9 degrees off the horizontal, 0.56 m below the ball: it touches beside its lowest point, and is pushed along the plane.
TILTED = {"contact__obstacle__point": [0, 0, -15.75], "contact__obstacle__normal": [0.1, -0.12, 1]}
BLOCK, CUBE = SOURCE / "tests/data/block.toml", SOURCE / "tests/data/cube.toml"


def half_space(on: str, point: list, normal: list) -> dict:
    return {"on": on, "obstacle": {"shape": "half-space", "point": point, "normal": normal}}


def ball(on: str, center: list, radius: float) -> dict:
    return {"on": on, "obstacle": {"shape": "ball", "center": center, "radius": radius}}


BALL = {"shape": "ball", "center": [0.3, -0.75], "radius": 0.6}
# Sides that share no node; and sides that share an edge, or a corner of three.
OPPOSITE = {"initial__velocity": ["-0.3", "-1.5"], "time__end": 0.8,
            "contact": [ball("bottom", [0.3, -0.75], 0.6), half_space("top", [0, 1.05], [0.1, -1])]}  # fmt: skip
OPPOSITE_IN_SPACE = {"initial__velocity": ["-0.1", "0.2", "-1.5"], "time__end": 0.8,
                     "contact": [ball("bottom", [0.3, 0.4, -0.75], 0.6), half_space("top", [0, 0, 1.05], [0.1, 0.2, -1])]}
CORNER = {"initial__velocity": ["-1", "-1"],
          "contact": [half_space("bottom", [0, -0.1], [0.1, 1]), half_space("left", [-0.1, 0], [1, 0.2])]}  # fmt: skip
CORNER_IN_SPACE = {"initial__velocity": ["-1", "-1", "-1"],
                   "contact": [half_space("bottom", [0, 0, -0.1], [0.1, 0, 1]), half_space("left", [-0.1, 0, 0], [1, 0, 0.2]),
                               half_space("boundary", [0, -0.1, 0], [0, 1, 0])]}  # fmt: skip
# Four walls for every node: three of them always depend on each other, and one moves.
BOX = {"initial__velocity": ["-1.5", "-1"], "time__end": 0.8,
       "contact": [half_space("boundary", ["-0.1 + 0.2*t", 0], [1, 0]), half_space("boundary", [1.05, 0], [-1, 0]),
                   half_space("boundary", [0, -0.1], [0, 1]), half_space("boundary", [0, 1.1], [0.1, -1])]}  # fmt: skip

SOLVERS = {"full VI": ({"solver__vi": "full"}, 1e-10), "conjugate gradients": ({"solver__linear": "iterative"}, None)}
ONE_OBSTACLE = tuple(SOLVERS)  # the full VI takes one obstacle per node
SEVERAL = ("conjugate gradients",)
# Conjugate gradients leave 1e-12 of the solution's size at each of up to 150 steps; of 40 at most in the block's and cube's.
CASES = {
    "half disc": (HALF_DISC, {"control__initial": ["0", "-1"]}, ONE_OBSTACLE, 1e-9),
    "half disc, degree 2": (HALF_DISC, {"control__initial": ["0", "-1"], "mesh__size": 1.5, "mesh__degree": 2}, ONE_OBSTACLE, 1e-9),
    "block on a tilted plane": (BLOCK, {"mesh__size": 0.1}, ONE_OBSTACLE, 1e-10),
    "block on a ball": (BLOCK, {"mesh__size": 0.1, "contact__obstacle": BALL}, ONE_OBSTACLE, 1e-10),
    "block between a ball and a plane": (BLOCK, OPPOSITE | {"mesh__size": 0.1}, ONE_OBSTACLE, 1e-10),
    "block in a corner": (BLOCK, CORNER | {"mesh__size": 0.1}, SEVERAL, 1e-10),
    "block in a box": (BLOCK, BOX | {"mesh__size": 0.1}, SEVERAL, 1e-10),
    "block, contact-stabilized": (BLOCK, {"mesh__size": 0.1, "time__scheme": "contact-stabilized"}, ONE_OBSTACLE, 1e-10),
    "block, massless": (BLOCK, {"mesh__size": 0.1, "contact__mass": "massless"}, ONE_OBSTACLE, 1e-10),
    "cube, contact-stabilized": (CUBE, {"time__scheme": "contact-stabilized"}, ONE_OBSTACLE, 1e-10),
    "cube, massless": (CUBE, {"contact__mass": "massless"}, ONE_OBSTACLE, 1e-10),
    "half ball": (HALF_BALL, PUSHED, ONE_OBSTACLE, 1e-9),
    "half ball, degree 2": (HALF_BALL, PUSHED | {"mesh__size": 4, "mesh__degree": 2}, ONE_OBSTACLE, 1e-9),
    "half ball on a tilted plane": (HALF_BALL, PUSHED | TILTED, ONE_OBSTACLE, 1e-9),
    "half ball on a ball": (HALF_BALL, PUSHED | {"contact": ball("contact", [0.5, -0.3, -23.5], 8)}, ONE_OBSTACLE, 1e-9),
    "cube between a ball and a plane": (CUBE, OPPOSITE_IN_SPACE, ONE_OBSTACLE, 1e-10),
    "cube in a corner": (CUBE, CORNER_IN_SPACE, SEVERAL, 1e-10),
}


def simulate(case: str, out: Path, **solver: object) -> None:
    scene, overrides, _, _ = CASES[case]
    if scene in (HALF_DISC, HALF_BALL):  # whose desired motion would be simulated beside
        overrides = {"objective__desired": {"displacement": ["0", "0", "0"][: 2 if scene == HALF_DISC else 3]}} | overrides
    signorini("simulate", scene, out, **(overrides | solver))


@pytest.fixture(scope="module")
def condensed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """A case, and its run by the condensed problem."""
    out = tmp_path_factory.mktemp("condensed")
    simulate(request.param, out, solver__linear="direct")
    return request.param, out


@pytest.mark.parametrize("condensed, solver", [(case, solver) for case in CASES for solver in CASES[case][2]], indirect=["condensed"])
def test_solvers(condensed: tuple[str, Path], solver: str, tmp_path: Path) -> None:
    case, expected = condensed
    overrides, own_tolerance = SOLVERS[solver]
    simulate(case, tmp_path, **overrides)
    (_, _, a), (_, _, b) = (stored(out, "state", "displacement") for out in (expected, tmp_path))
    assert a.shape == b.shape
    difference = abs(a - b).max() / abs(a).max()
    print(f"difference {difference:.1e} of the largest displacement")
    assert difference <= (own_tolerance or CASES[case][3])
    assert same_sets(expected, tmp_path), "the active sets differ"


ON_RANKS = {
    "block in a box": (BLOCK, BOX),
    "cube, massless": (CUBE, {"contact__mass": "massless"}),
    "cube, contact-stabilized": (CUBE, {"time__scheme": "contact-stabilized"}),
    "cube in a corner": (CUBE, CORNER_IN_SPACE),
}


@pytest.mark.parametrize("scene, overrides", ON_RANKS.values(), ids=ON_RANKS)
def test_contact_on_ranks(scene: Path, overrides: dict[str, object], tmp_path: Path) -> None:
    """Gaps, forces and pressures between several obstacles, whose numbering does not depend on the ranks."""
    tables = []
    for ranks in (1, 2, 3):
        out = tmp_path / f"ranks-{ranks}"
        signorini("simulate", scene, out, ranks, output__fields=[], **overrides)
        tables.append(table(out / "contact.csv"))
        first, contact = tables[0], tables[-1]
        assert same_sets(tmp_path / "ranks-1", out), f"{ranks} ranks: the active sets differ"
        assert "obstacle" not in first or np.array_equal(first["obstacle"], contact["obstacle"])
        for name in ("gap", "force", "area", "pressure"):
            assert abs(contact[name] - first[name]).max() / abs(first[name]).max() <= 1e-9, f"{name} on {ranks} ranks"


SOUGHT = {
    "half disc": (HALF_DISC, {"control__initial": ["0", "-0.9"]}),
    "half ball": (HALF_BALL, PUSHED | {"control__initial": ["0", "0", "-0.9"]}),
}


@pytest.mark.parametrize("scene, overrides", SOUGHT.values(), ids=SOUGHT)
def test_optimum_on_ranks(scene: Path, overrides: dict[str, object], tmp_path: Path) -> None:
    optimize_on_ranks(tmp_path, scene, **overrides)
