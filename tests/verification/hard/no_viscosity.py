# SPDX-License-Identifier: GPL-3.0-or-later
"""Without viscosity: energy stays where there is no contact, and never rises through tens of impacts.

Energy is the kinetic, the elastic and, of a constant load, the potential one, E_k − Σ f·(y_j − y_{j−1}). Without contact the
steps keep it exactly. A body that rings in its place keeps it to 1e-12 in 10,000 steps: ten roundings of the energy in a
step (ε = 2e-16, a few each for kinetic and elastic energy) add up as a walk does to √10,000 · 10 ε = 2e-13. One that flies
off loses digits of its deformation beside the way it has come, so that a step rounds as in time_steps.

Impacts are counted from the series of contact forces: of a body between two walls every change of the wall that pushes;
under gravity every force after a flight of at least 20 steps, in which a wave runs across the body and back. How many there are
until most of the energy is in the body's vibrations is chaotic: the last digits, which differ between processors, decide whether
78 or 130.
"""

import sys
import tempfile
from pathlib import Path

from table import SCHEMES, Table, energy, run
from time_steps import rounding

import numpy as np

MESH = """
Point(1) = {0, 0, 0};  Point(2) = {0, -1, 0};  Point(3) = {1, 0, 0};  Point(4) = {0, 1, 0};  Point(5) = {-1, 0, 0};
Circle(1) = {2, 1, 3};  Circle(2) = {3, 1, 4};  Circle(3) = {4, 1, 5};  Circle(4) = {5, 1, 2};
Line(5) = {5, 1};  Line(6) = {1, 3};
Curve Loop(1) = {1, -6, -5, 4};  Curve Loop(2) = {2, 3, 5, 6};
Plane Surface(1) = {1};  Plane Surface(2) = {2};
Physical Surface("body") = {1, 2};
Physical Curve("contact") = {1, 2, 3, 4};
Physical Curve("lower") = {1, 4};
Physical Curve("middle") = {5, 6};
"""
BODY = """
[mesh]
file = "disc.geo"
size = 0.4
[time]
end = {end!r}
step = {step!r}
[material]
density = 1.0
young = 100.0
poisson = 0.3
[output]
every = {every}
"""
STEP = 0.02  # s
COURANT = 0.6  # waves run 12 m/s
STEPS = 10_000
IMPACTS = 50


def change_of_energy(folder: Path, text: str, over: dict) -> tuple[float, int]:
    """Largest change in 10,000 steps, of the first energy; steps in contact."""
    scene = folder / "free.toml"
    scene.write_text(BODY.format(end=STEPS * STEP, step=STEP, every=STEPS) + text)
    found, _ = run("simulate", scene, folder / "out", **over)
    total = energy(found)
    return abs(total / total[0] - 1).max(), int((found["active"] > 0).sum())


def ringing(folder: Path, over: dict) -> tuple[float, float, int]:
    """Change of energy of a body that rings, held at its middle, what it may be, and steps in contact."""
    change, contact = change_of_energy(folder, """
[[clamp]]
on = "middle"
[contact]
on = "lower"
obstacle = { shape = "half-space", point = [0, -2], normal = [0, 1] }
[initial]
velocity = ["0.2*y", "-0.3*y"]
""", over)  # fmt: skip
    return change, 1e-12, contact


def flying(folder: Path, over: dict) -> tuple[float, float, int]:
    """The same of a body that rings and flies over twice its size."""
    change, contact = change_of_energy(folder, """
[contact]
on = "lower"
obstacle = { shape = "half-space", point = [0, -9], normal = [0, 1] }
[initial]
velocity = ["0.02 + 0.3*x", "-0.3*y"]
""", over)  # fmt: skip
    return change, np.sqrt(STEPS) * rounding(COURANT, STEPS), contact


def between_walls(folder: Path, over: dict) -> tuple[int, float, float, float]:
    """Impacts of a body thrown to and fro between two walls; of the first energy, the largest rise, what of it rounding may
    be, and the loss."""
    steps, gap, speed = 20_000, 0.01, 0.2
    mass = ', mass = "massless"' if "contact__mass" in over else ""
    wall = '{{ on = "contact"{mass}, obstacle = {{ shape = "half-space", point = [{x}, 0], normal = [{n}, 0] }} }}'
    scene = folder / "walls.toml"
    scene.write_text(
        "contact = [" + ", ".join(wall.format(mass=mass, x=-n * (1 + gap), n=n) for n in (1, -1)) + "]\n"
        + BODY.format(end=steps * STEP, step=STEP, every=steps)
        + f'[initial]\nvelocity = ["{speed}", "0"]\n'
    )  # fmt: skip
    found, _ = run("simulate", scene, folder / "out", **{key: value for key, value in over.items() if not mass})
    sides = np.sign(found["contact_force_x"])
    impacts = 1 + int((np.diff(sides[sides != 0]) != 0).sum()) if sides.any() else 0
    total = energy(found)
    reach = 10 * gap / (speed * STEP)  # what sticks out of a body that rings, and slides on, is not far from its place
    return impacts, np.maximum(0, np.diff(total).max() / total[0]), rounding(COURANT, reach), 1 - total[-1] / total[0]


def bouncing(folder: Path, over: dict) -> tuple[int, float, float, float]:
    """The same of a body that bounces under gravity, of the energy of its fall."""
    steps, height, weight = 160_000, 5.0, 0.01  # m, N/m³
    scene = folder / "bouncing.toml"
    scene.write_text(BODY.format(end=steps * STEP, step=STEP, every=steps) + f"""
[contact]
on = "lower"
obstacle = {{ shape = "half-space", point = [0, {-1 - height}], normal = [0, 1] }}
[load]
body = ["0", "{-weight}"]
""")
    found, _ = run("simulate", scene, folder / "out", **over)
    total = energy(found) - np.cumsum(found["external_work"])
    touched = np.flatnonzero(found["contact_force_y"] > 0)
    impacts = 1 + int((np.diff(touched) > 20).sum()) if len(touched) else 0
    fall = np.pi * weight * height
    reach = height / (np.sqrt(2 * weight * height) * STEP)
    return impacts, np.maximum(0, np.diff(total).max() / fall), rounding(COURANT, reach), -total[-1] / fall


def main() -> int:
    lines = Table("no viscosity")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "disc.geo").write_text(MESH)
        for scheme, over in SCHEMES.items():
            for case, free in (("ringing", ringing), ("flying", flying)):
                change, most, contact = free(folder, over)
                lines.row(f"{scheme}, {case}, {STEPS:,} steps",
                          f"change of energy {change:.1e} <= {most:.1e}, {contact} steps in contact",
                          contact == 0 and change <= most)  # fmt: skip
            for case, impact in (("between two walls", between_walls), ("bouncing under gravity", bouncing)):
                impacts, rise, most, loss = impact(folder, over)
                lines.row(f"{scheme}, {case}", f"{impacts} impacts >= {IMPACTS}, rise {rise:.1e} <= {most:.1e}, loss {loss:.3f}",
                          impacts >= IMPACTS and rise <= most)  # fmt: skip
    return 1 if lines.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
