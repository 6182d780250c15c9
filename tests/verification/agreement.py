# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways to the same solution agree.

    agreement.py SIGNORINI SOURCE solvers|ranks    condensed, full VI, conjugate gradients; one, two and three ranks
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, HALF_DISC, SOURCE, relative, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402


# The half ball at its reference control, coarse enough to be quick.
PUSHED = {"control__initial": ["0", "0", "-1"], "mesh__size": 3, "time__step": 2.5e-4}
# 9 degrees off the horizontal, 0.56 m below the ball: it touches beside its lowest point, and is pushed along the plane.
TILTED = {"contact__obstacle__point": [0, 0, -15.75], "contact__obstacle__normal": [0.1, -0.12, 1]}


def displacements(out: Path) -> list[np.ndarray]:
    """One array per stored time."""
    with h5py.File(out / "state.h5") as file:
        states = file["Function/displacement"]
        return [states[name][:] for name in sorted(states)]


def same_sets(a: Path, b: Path) -> bool:
    """Whether the same candidates carry a force at all steps."""
    ta, tb = table(a / "contact.csv"), table(b / "contact.csv")
    for obstacle in np.unique(ta["obstacle"]) if "obstacle" in ta else [None]:
        own = ta["obstacle"] == obstacle if obstacle is not None else slice(None)
        assert (ta["force"][own] > 0).any(), "no contact: the comparison says nothing"
    places = all(np.allclose(ta[axis], tb[axis], rtol=0, atol=1e-9) for axis in "xyz" if axis in ta)
    return np.array_equal(ta["force"] > 0, tb["force"] > 0) and places


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
# Four walls for every node, of which three always depend on each other, and one moves.
BOX = {"initial__velocity": ["-1.5", "-1"], "time__end": 0.8,
       "contact": [half_space("boundary", ["-0.1 + 0.2*t", 0], [1, 0]), half_space("boundary", [1.05, 0], [-1, 0]),
                   half_space("boundary", [0, -0.1], [0, 1]), half_space("boundary", [0, 1.1], [0.1, -1])]}  # fmt: skip

FULL, ITERATIVE = ("full VI", {"solver__vi": "full"}, 1e-10), ("conjugate gradients", {"solver__linear": "iterative"}, None)


def compare_solvers(folder: Path) -> bool:
    holds = True
    both, iterative = (FULL, ITERATIVE), (ITERATIVE,)  # the full VI takes one obstacle per node
    # Conjugate gradients leave 1e-12 of the solution's size at each of up to 150 steps; of 40 at most in the block's and cube's.
    cases = [("half-disc", HALF_DISC, {"control__initial": ["0", "-1"]}, both, 1e-9),
             ("half-disc, degree 2", HALF_DISC, {"control__initial": ["0", "-1"], "mesh__size": 1.5, "mesh__degree": 2}, both, 1e-9),
             ("block on a tilted plane", BLOCK, {"mesh__size": 0.1}, both, 1e-10),
             ("block on a ball", BLOCK, {"mesh__size": 0.1, "contact__obstacle": BALL}, both, 1e-10),
             ("block between a ball and a plane", BLOCK, OPPOSITE | {"mesh__size": 0.1}, both, 1e-10),
             ("block in a corner", BLOCK, CORNER | {"mesh__size": 0.1}, iterative, 1e-10),
             ("block in a box", BLOCK, BOX | {"mesh__size": 0.1}, iterative, 1e-10),
             ("block, contact-stabilized", BLOCK, {"mesh__size": 0.1, "time__scheme": "contact-stabilized"}, both, 1e-10),
             ("block, massless", BLOCK, {"mesh__size": 0.1, "contact__mass": "massless"}, both, 1e-10),
             ("cube, contact-stabilized", CUBE, {"time__scheme": "contact-stabilized"}, both, 1e-10),
             ("cube, massless", CUBE, {"contact__mass": "massless"}, both, 1e-10),
             ("half ball", HALF_BALL, PUSHED, both, 1e-9),
             ("half ball, degree 2", HALF_BALL, PUSHED | {"mesh__size": 4, "mesh__degree": 2}, both, 1e-9),
             ("half ball on a tilted plane", HALF_BALL, PUSHED | TILTED, both, 1e-9),
             ("half ball on a ball", HALF_BALL, PUSHED | {"contact": ball("contact", [0.5, -0.3, -23.5], 8)}, both, 1e-9),
             ("cube between a ball and a plane", CUBE, OPPOSITE_IN_SPACE, both, 1e-10),
             ("cube in a corner", CUBE, CORNER_IN_SPACE, iterative, 1e-10)]  # fmt: skip
    for name, scene, overrides, others, tolerance in cases:
        condensed = folder / "condensed"
        if scene in (HALF_DISC, HALF_BALL):  # whose desired motion would be simulated beside
            overrides = {"objective__desired": {"displacement": ["0", "0", "0"][: 2 if scene == HALF_DISC else 3]}} | overrides
        signorini("simulate", scene, condensed, solver__linear="direct", **overrides)
        for title, other, own_tolerance in others:
            out = folder / "other"
            signorini("simulate", scene, out, **(overrides | other))
            pairs = list(zip(displacements(condensed), displacements(out), strict=True))
            size = np.max([abs(a).max() for a, _ in pairs])
            difference = np.max([abs(a - b).max() for a, b in pairs]) / size
            sets = same_sets(condensed, out)
            print(f"{name}: condensed and {title} differ by {difference:.1e} of the largest displacement, "
                  f"active sets {'equal' if sets else 'differ'} at all {len(pairs) - 1} steps")  # fmt: skip
            holds &= difference <= (own_tolerance or tolerance) and sets
    return holds


def compare_contact_over_ranks(folder: Path, name: str, scene: Path, **overrides: object) -> bool:
    """Gaps and forces between several obstacles, whose numbering does not depend on the ranks."""
    tables = []
    for ranks in (1, 2, 3):
        out = folder / f"ranks-{ranks}"
        signorini("simulate", scene, out, ranks, output__fields=[], **overrides)
        tables.append(table(out / "contact.csv"))
        assert same_sets(folder / "ranks-1", out)
        assert "obstacle" not in tables[0] or np.array_equal(tables[0]["obstacle"], tables[-1]["obstacle"])
    worst = np.max([abs(other[key] - tables[0][key]).max() / abs(tables[0][key]).max() for other in tables[1:] for key in ("gap", "force", "area", "pressure")])
    print(f"{name}: gaps, forces and pressures over the ranks differ by {worst:.1e} of the largest")
    return worst <= 1e-9


def compare_ranks(folder: Path, scene: Path, iterations: int = 3, **overrides: object) -> bool:
    """J and |g| at a fixed control; after some iterations too, where the step lengths, which come from small
    differences of J, have amplified the rounding."""
    histories = []
    for ranks in (1, 2, 3):
        out = folder / f"ranks-{ranks}"
        signorini("optimize", scene, out, ranks, optimizer__max_iterations=iterations, optimizer__start="guess", output__fields=[],
                  **overrides)
        histories.append(table(out / "history.csv"))
        print("{} ranks: J = {:.15e}, |g| = {:.15e}; after {} iterations {:.15e}, {:.15e}".format(
            ranks, *(histories[-1][key][0] for key in ("objective", "gradient_norm")), iterations,
            *(histories[-1][key][iterations] for key in ("objective", "gradient_norm"))))  # fmt: skip
        assert same_sets(folder / "ranks-1", out)

    def worst(row: int) -> float:
        return np.max([relative(other[key][row], histories[0][key][row])
                   for other in histories[1:] for key in ("objective", "gradient_norm")])  # fmt: skip

    print(f"{scene.stem}: largest relative difference over the ranks {worst(0):.1e}, after {iterations} iterations {worst(iterations):.1e}")
    return worst(0) <= 1e-9 and worst(iterations) <= 1e-6


def compare_all_ranks(folder: Path) -> bool:
    return all([compare_contact_over_ranks(folder, "block in a box", BLOCK, **BOX),
                compare_contact_over_ranks(folder, "cube, massless", CUBE, contact__mass="massless"),
                compare_contact_over_ranks(folder, "cube, contact-stabilized", CUBE, time__scheme="contact-stabilized"),
                compare_contact_over_ranks(folder, "cube in a corner", CUBE, **CORNER_IN_SPACE),
                compare_ranks(folder, HALF_DISC, control__initial=["0", "-0.9"]),
                compare_ranks(folder, HALF_BALL, **(PUSHED | {"control__initial": ["0", "0", "-0.9"]}))])  # fmt: skip


def main() -> int:
    part = {"solvers": compare_solvers, "ranks": compare_all_ranks}[sys.argv[3]]
    with tempfile.TemporaryDirectory() as folder:
        return 0 if part(Path(folder)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
