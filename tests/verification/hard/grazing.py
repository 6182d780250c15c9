# SPDX-License-Identifier: GPL-3.0-or-later
"""Grazing and rest: a body that just reaches the plane, and one that lies on it for 10,000 steps.

Grazing. A load pushes a disc that flies towards a plane back, so that its least gap in free flight would be −d (or d), on a
step; free flight itself is run first, and followed by the steps exactly. With d > 0 above the plane nothing happens. At less
depth than that by which the second least gap of free flight is greater, one step alone closes one gap, and what contact does
is proportional to d, down to the rounding of gaps: it comes in continuously. Deeper, the whole body rebounds, at most as fast
as it came: the impulse is at most 2 m (√(2 a d) + a τ).

Contact-stabilized steps project the predictor y_{k−1} + τ v_{k−1}, which does not contain the load and is a τ²/2 deeper. They
graze when it does; its projection alone takes energy then, in proportion to d times the gap a τ²/2 − O(d) that y_k still has,
and no force acts. Predictors that are less than 1e-10 of the body deep are left as they are, hence no smaller depths.

Rest. A block without lateral contraction rests under its weight with the displacement −(w/E)(H y − y²/2): elements of degree 2
have it exactly, and so the start is the discrete equilibrium; whatever moves is rounding. A step rounds the velocity to
(2/τ) ε |y|; if that adds up in one direction, a body that nothing supports sideways drifts by 2 ε |y| n² in n steps (as a random
walk it would by n^(3/2)), with |y| at most w H²/2E. With lateral contraction the block starts undeformed on the plane, without
motion, and settles with viscosity, which damps its slowest vibrations (2 a second) by e^-100 and more until half of the run;
from then on to the end it may not drift either. Flat bodies, since a disc on one node may roll as it likes, and does where
its mesh leans.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from harness import stored
from schemes import DISC, EPSILON, SCHEMES, run

BLOCK = """
Point(1) = {-0.5, 0, 0};  Point(2) = {0.5, 0, 0};  Point(3) = {0.5, 1, 0};  Point(4) = {-0.5, 1, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("contact") = {1};
"""
SIZE = 2.0  # m, the disc's
YOUNG = 100.0  # Pa, with density 1
STEP, TURN, PUSH = 0.02, 50, 0.1  # s, the step at which the disc turns, m/s² away from the plane
FALL = PUSH * (TURN * STEP) ** 2 / 2
MASS = np.pi  # kg/m, at most
DEPTHS = [10.0**-i for i in range(2, 13)]  # of the size; for contact-stabilized steps those above 1e-10
# A parabola is summed up in TURN steps, of gaps and places of about a metre: ten roundings each.
ROUNDING = 10 * TURN * EPSILON
REST = 10_000
DRIFT = 2 * EPSILON * REST**2 / (2 * YOUNG)  # m, at most
PENETRATION = 1e-10  # of a block 1 m high


def graze(folder: Path, depth: float, scheme: str) -> dict[str, np.ndarray]:
    """steps.csv of a disc that would come `depth` (m) below the plane if it did not deform."""
    (folder / "disc.geo").write_text(DISC)
    scene = folder / "graze.toml"
    scene.write_text(f"""
[mesh]
file = "disc.geo"
size = 0.4
[time]
end = {2 * TURN * STEP}
step = {STEP}
[material]
density = 1.0
young = {YOUNG}
poisson = 0.3
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, {float(-1 - FALL + depth)!r}], normal = [0, 1] }}
[load]
body = ["0", "{PUSH}"]
[initial]
velocity = ["0", "{-PUSH * TURN * STEP!r}"]
[output]
tables = ["steps"]
""")
    return run(scene, folder / "out", **SCHEMES[scheme])


def impulse(steps: dict[str, np.ndarray]) -> float:
    return STEP * steps["contact_force_y"].sum()


def work(steps: dict[str, np.ndarray]) -> float:
    """Energy that contact takes."""
    return -steps["contact_work"].sum()


def touched(steps: dict[str, np.ndarray]) -> int:
    return int((steps["contact_force_y"] > 0).sum())


@dataclass(frozen=True)
class Turns:
    """Runs of a disc that turns at depths (m) above and below the plane, by one scheme."""

    stabilized: bool
    least: float  # gap at depth 0, m
    shallow_to: float  # the depth up to which one step alone closes one gap, m
    depths: np.ndarray
    above: list[dict[str, np.ndarray]]
    below: list[dict[str, np.ndarray]]


@pytest.fixture(scope="module", params=SCHEMES)
def turns(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Turns:
    folder, scheme = tmp_path_factory.mktemp("turns"), request.param
    stabilized = scheme == "contact-stabilized"
    far = graze(folder, -1.0, scheme)["min_gap"] - 1.0
    level, second = np.sort(far)[:2]
    shallow_to = PUSH * STEP**2 / 2 if stabilized else second - level
    if stabilized:
        level -= shallow_to
    depths = SIZE * np.array([part for part in DEPTHS if part > 1e-10 or not stabilized])
    return Turns(stabilized, far.min() - level, shallow_to, depths, [graze(folder, level - depth, scheme) for depth in depths],
                 [graze(folder, level + depth, scheme) for depth in depths])  # fmt: skip


def test_turns_above_the_plane(turns: Turns) -> None:
    gap = np.max([abs(steps["min_gap"].min() - (turns.least + depth)) for depth, steps in zip(turns.depths, turns.above)])
    # The jump is a difference of places, its work that with the load.
    idle = np.max([abs(work(steps)) for steps in turns.above])
    print(f"work of contact {idle:.0e} <= {ROUNDING * MASS * PUSH:.0e}, least gap off by {gap:.0e} <= {ROUNDING:.0e} m")
    assert not any(map(touched, turns.above)) and not any(map(impulse, turns.above))
    assert idle <= ROUNDING * MASS * PUSH
    assert gap <= ROUNDING


def test_turns_just_below_the_plane(turns: Turns) -> None:
    """In proportion to the depth."""
    shallow = turns.depths <= 1.001 * turns.shallow_to / 10
    assert shallow.sum() > 2, "hardly any depth: the case says nothing"
    depths = turns.depths[shallow]
    effect = np.array([(work if turns.stabilized else impulse)(steps) for steps in turns.below])
    slope = effect[shallow] / depths
    bend = 2 * depths / turns.shallow_to if turns.stabilized else 0 * slope  # y_k's gap is less by d, and by as much as d lifts it
    allowed = (ROUNDING / depths + bend) + (ROUNDING / depths + bend)[0]
    off = abs(slope / slope[0] - 1)
    counts = np.array([touched(steps) for steps in turns.below])[shallow]
    print(f"{'work' if turns.stabilized else 'impulse'} {effect[shallow][0]:.1e} to {effect[-1]:.1e} at depths {depths[0]:.0e} to "
          f"{depths[-1]:.0e} m, of proportion {off[1]:.0e} to {off[-1]:.0e} <= {allowed[1]:.0e} to {allowed[-1]:.0e} off, "
          f"{counts.max()} steps in contact")  # fmt: skip
    assert (effect > 0).all()
    assert (off <= allowed).all()
    assert (counts == (0 if turns.stabilized else 1)).all()


def test_turns_below_the_plane(turns: Turns) -> None:
    """The deeper, the larger the impulse; and at most as fast as it came."""
    impulses, counts = [impulse(steps) for steps in turns.below], [touched(steps) for steps in turns.below]
    bound = 2 * MASS * (np.sqrt(2 * PUSH * turns.depths) + PUSH * STEP)
    print(f"impulse {', '.join(f'{i:.1e}' for i in impulses)} N s/m in {', '.join(map(str, counts))} steps; at most "
          f"{(impulses / bound).max():.2f} of 2 m (√(2 a d) + a τ)")  # fmt: skip
    assert counts[0] > 1
    assert (impulses <= bound).all()
    assert (np.diff(impulses) <= 0).all()


def rest(folder: Path, scheme: str, text: str) -> np.ndarray:
    """Checks that a block lies on the plane all the time; its displacements at the start, at half and at the end."""
    (folder / "block.geo").write_text(BLOCK)
    scene = folder / "rest.toml"
    scene.write_text(f"""
[time]
end = {REST * STEP}
step = {STEP}
[load]
body = ["0", "-1"]
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, 0], normal = [0, 1] }}
[output]
every = {REST // 2}
tables = ["steps"]
{text}""")
    steps = run(scene, folder / "out", output__fields=["displacement"], **SCHEMES[scheme])
    deepest = np.maximum(0, -steps["min_gap"].min())
    print(f"contact in {touched(steps)} of {REST} steps, force at the end {steps['contact_force_y'][-1]:.12f} of 1 N/m, penetration "
          f"{deepest:.0e} <= {PENETRATION:.0e} m, kinetic energy {steps['kinetic_energy'][-1]:.0e} J/m")  # fmt: skip
    assert touched(steps) > 0.9 * REST
    assert deepest <= PENETRATION
    return stored(folder / "out", "state", "displacement")[2]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_rests_from_the_start(scheme: str, tmp_path: Path) -> None:
    y = rest(tmp_path, scheme, f"""
[mesh]
file = "block.geo"
size = 0.25
degree = 2
[material]
density = 1.0
young = {YOUNG}
poisson = 0.0
[initial]
displacement = ["0", "-(y - y^2/2)/{YOUNG}"]
""")
    drift = abs(y - y[0]).max()
    print(f"drift {drift:.0e} <= {DRIFT:.0e} m")
    assert drift <= DRIFT


@pytest.mark.parametrize("scheme", SCHEMES)
def test_comes_to_rest(scheme: str, tmp_path: Path) -> None:
    y = rest(tmp_path, scheme, f"""
[mesh]
file = "block.geo"
size = 0.25
[material]
density = 1.0
young = {YOUNG}
poisson = 0.3
viscosity = {{ bulk = 2.0, shear = 2.0 }}
""")
    drift = abs(y[-1] - y[-2]).max()
    print(f"drift {drift:.0e} <= {DRIFT:.0e} m")
    assert drift <= DRIFT
