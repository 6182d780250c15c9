# SPDX-License-Identifier: GPL-3.0-or-later
"""Grazing and rest: a body that just reaches the plane, and one that lies on it for 10,000 steps.

Grazing. A load pushes a disc that flies towards a plane back, so that its least gap in free flight would be −d (or d), on a
step; free flight itself is run first, and followed by the steps exactly. With d > 0 above the plane nothing happens. At less
depth than that by which the second least gap of free flight is greater, one step alone closes one gap, and what contact does
is proportional to d, down to the rounding of gaps: it comes in continuously. Deeper, the whole body rebounds, at most as fast
as it came: the impulse is at most 2 m (√(2 a d) + a τ).

Contact-stabilized steps look at the predictor y_{k−1} + τ v_{k−1}, which does not know of the load and is a τ²/2 deeper. They
graze when it does; its projection alone takes energy then, in proportion to d times the gap a τ²/2 − O(d) that y_k still has,
and no force acts. Predictors that are less than 1e-10 of the body deep are left as they are, hence no smaller depths.

Rest. A block without lateral contraction rests under its weight with the displacement −(w/E)(H y − y²/2): elements of degree 2
hold it exactly, and so the start is the discrete equilibrium; whatever moves is rounding. A step rounds the velocity to
(2/τ) ε |y|; if that adds up all the same way, a body that nothing holds sideways drifts by 2 ε |y| n² in n steps (as a walk
it would by n^(3/2)), with |y| at most w H²/2E. With lateral contraction the block starts undeformed on the plane, without
motion, and settles with viscosity, which damps its slowest vibrations (2 a second) by e^-100 and more until half of the run;
from then on to the end it may not drift either. Flat bodies, since a disc on one node may roll as it likes, and does where
its mesh leans.
"""

import sys
import tempfile
from pathlib import Path

from table import DISC, SCHEMES, Table, run
from harness import stored

import numpy as np

BLOCK = """
Point(1) = {-0.5, 0, 0};  Point(2) = {0.5, 0, 0};  Point(3) = {0.5, 1, 0};  Point(4) = {-0.5, 1, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("contact") = {1};
"""
EPSILON = np.finfo(float).eps
SIZE = 2.0  # m, the disc's
YOUNG = 100.0  # Pa, with density 1
STEP, TURN, PUSH = 0.02, 50, 0.1  # s, the step at which the disc turns, m/s² away from the plane
MASS = np.pi  # kg/m, at most
DEPTHS = [10.0**-i for i in range(2, 13)]  # of the size; for contact-stabilized steps those above 1e-10
REST = 10_000
PENETRATION = 1e-10


FALL = PUSH * (TURN * STEP) ** 2 / 2


def graze(folder: Path, depth: float, over: dict) -> dict[str, np.ndarray]:
    """steps.csv of a disc that would come `depth` (m) below the plane if it did not deform."""
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
    steps, _ = run("simulate", scene, folder / "out", **over)
    return steps


def grazing(folder: Path, scheme: str, over: dict, lines: Table) -> None:
    stabilized = scheme == "contact-stabilized"
    far = graze(folder, -1.0, over)["min_gap"] - 1.0
    level, second = np.sort(far)[:2]
    shallow_to = PUSH * STEP**2 / 2 if stabilized else second - level
    if stabilized:
        level -= shallow_to
    depths = SIZE * np.array([part for part in DEPTHS if part > 1e-10 or not stabilized])
    above = [graze(folder, level - depth, over) for depth in depths]
    below = [graze(folder, level + depth, over) for depth in depths]

    def impulse(steps: dict) -> float:
        return STEP * steps["contact_force_y"].sum()

    def work(steps: dict) -> float:
        return -steps["contact_work"].sum()

    def touched(steps: dict) -> int:
        return int((steps["contact_force_y"] > 0).sum())

    # A parabola is summed up in TURN steps, of gaps and places of about a metre: ten roundings each.
    rounding = 10 * TURN * EPSILON
    gap = np.max([abs(steps["min_gap"].min() - (far.min() - level + depth)) for depth, steps in zip(depths, above)])
    # The jump is a difference of places, its work that with the load.
    idle = np.max([abs(work(steps)) for steps in above])
    lines.row(f"{scheme}, turns above the plane",
              f"{sum(map(touched, above))} steps in contact, impulse {np.max(list(map(impulse, above))):.0e}, work of contact {idle:.0e} <= "
              f"{rounding * MASS * PUSH:.0e}, least gap off by {gap:.0e} <= {rounding:.0e} m",
              not any(map(touched, above)) and not any(map(impulse, above)) and idle <= rounding * MASS * PUSH
              and gap <= rounding)  # fmt: skip

    effect = np.array([(work if stabilized else impulse)(steps) for steps in below])
    shallow = depths <= 1.001 * shallow_to / 10
    slope = (effect / depths)[shallow]
    bend = 2 * depths[shallow] / shallow_to if stabilized else 0 * slope  # y_k's gap is less by d, and by as much as d lifts it
    allowed = (rounding / depths[shallow] + bend) + (rounding / depths[shallow] + bend)[0]
    off = abs(slope / slope[0] - 1)
    counts = np.array([touched(steps) for steps in below])
    lines.row(f"{scheme}, turns just below it",
              f"{'work' if stabilized else 'impulse'} {effect[shallow][0]:.1e} to {effect[-1]:.1e} at depths {depths[shallow][0]:.0e} to "
              f"{depths[-1]:.0e} m, of proportion {off[1]:.0e} to {off[-1]:.0e} <= {allowed[1]:.0e} to {allowed[-1]:.0e} off, "
              f"{counts[shallow].max()} steps in contact",
              shallow.sum() > 2 and (effect > 0).all() and (off <= allowed).all()
              and (counts[shallow] == (0 if stabilized else 1)).all())  # fmt: skip
    impulses = np.array([impulse(steps) for steps in below])
    bound = 2 * MASS * (np.sqrt(2 * PUSH * depths) + PUSH * STEP)
    lines.row(f"{scheme}, turns below it",
              f"impulse {', '.join(f'{i:.1e}' for i in impulses)} N s/m in {', '.join(map(str, counts))} steps; at most "
              f"{(impulses / bound).max():.2f} of 2 m (√(2 a d) + a τ)",
              counts[0] > 1 and (impulses <= bound).all() and (np.diff(impulses) <= 0).all())  # fmt: skip


def rest(folder: Path, text: str, over: dict) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """steps.csv and the displacements at the start, at half and at the end."""
    scene = folder / "rest.toml"
    scene.write_text(f"""
[time]
end = {REST * STEP}
step = {STEP}
[load]
body = ["0", "-1"]
[output]
every = {REST // 2}
tables = ["steps"]
""" + text)  # fmt: skip
    steps, _ = run("simulate", scene, folder / "out", **({"output__fields": ["displacement"]} | over))
    return steps, stored(folder / "out", "state", "displacement")[2]


def resting(folder: Path, scheme: str, over: dict, lines: Table) -> None:
    steps, y = rest(folder, f"""
[mesh]
file = "block.geo"
size = 0.25
degree = 2
[material]
density = 1.0
young = {YOUNG}
poisson = 0.0
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, 0], normal = [0, 1] }}
[initial]
displacement = ["0", "-(y - y^2/2)/{YOUNG}"]
""", over)  # fmt: skip
    most = 2 * EPSILON * REST**2 / (2 * YOUNG)
    report(lines, f"{scheme}, block rests from the start", steps, abs(y - y[0]).max(), most)
    steps, y = rest(folder, f"""
[mesh]
file = "block.geo"
size = 0.25
[material]
density = 1.0
young = {YOUNG}
poisson = 0.3
viscosity = {{ bulk = 2.0, shear = 2.0 }}
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, 0], normal = [0, 1] }}
""", over)  # fmt: skip
    report(lines, f"{scheme}, block comes to rest", steps, abs(y[-1] - y[-2]).max(), most)


def report(lines: Table, case: str, steps: dict[str, np.ndarray], drift: float, most: float) -> None:
    pushed = int((steps["contact_force_y"] > 0).sum())
    deepest = np.maximum(0, -steps["min_gap"].min())  # of a block 1 m high
    lines.row(case, f"contact in {pushed} of {REST} steps, force at the end {steps['contact_force_y'][-1]:.12f} of 1 N/m, drift "
              f"{drift:.0e} <= {most:.0e} m, penetration {deepest:.0e} <= {PENETRATION:.0e} m, kinetic energy "
              f"{steps['kinetic_energy'][-1]:.0e} J/m",
              pushed > 0.9 * REST and drift <= most and deepest <= PENETRATION)  # fmt: skip


def main() -> int:
    lines = Table("grazing")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "disc.geo").write_text(DISC)
        (folder / "block.geo").write_text(BLOCK)
        for scheme, over in SCHEMES.items():
            grazing(folder, scheme, over, lines)
            resting(folder, scheme, over, lines)
    return 1 if lines.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
