# SPDX-License-Identifier: GPL-3.0-or-later
"""Without viscosity: energy stays where there is no contact, and never rises through tens of impacts.

Energy is the kinetic, the elastic and, under a constant load, the potential one, E_k − Σ f·(y_j − y_{j−1}). Without contact the
steps keep it exactly. A body that rings in its place keeps it to 1e-12 in 10,000 steps: ten roundings of the energy in a
step (ε = 2e-16, a few each for kinetic and elastic energy) add up as a random walk does to √10,000 · 10 ε = 2e-13. One that
flies off loses digits of its deformation beside the distance that it has covered, so that a step rounds as in schemes.rounding.

Impacts are counted from the series of contact forces: of a body between two walls every change of the wall that pushes;
under gravity every force after a flight of at least 20 steps, in which a wave runs across the body and back. How many there are
until most of the energy is in the body's vibrations is chaotic: the last digits, which differ between processors, decide whether
78 or 130.
"""

from pathlib import Path

import numpy as np
import pytest
from schemes import SCHEMES, energy, rounding, run

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
RINGING = """
[[clamp]]
on = "middle"
[contact]
on = "lower"
obstacle = { shape = "half-space", point = [0, -2], normal = [0, 1] }
[initial]
velocity = ["0.2*y", "-0.3*y"]
"""
FLYING = """
[contact]
on = "lower"
obstacle = { shape = "half-space", point = [0, -9], normal = [0, 1] }
[initial]
velocity = ["0.02 + 0.3*x", "-0.3*y"]
"""
FREE = {  # a scene, and the change of energy that it may have
    "rings, clamped at its middle": (RINGING, 1e-12),
    "rings and flies over twice its size": (FLYING, np.sqrt(STEPS) * rounding(COURANT, STEPS)),
}


def disc(folder: Path, steps: int, more: str, before: str = "") -> Path:
    """The scene of a disc of so many steps."""
    (folder / "disc.geo").write_text(MESH)
    scene = folder / "disc.toml"
    scene.write_text(before + BODY.format(end=steps * STEP, step=STEP, every=steps) + more)
    return scene


@pytest.mark.parametrize("case", FREE)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_energy_stays(scheme: str, case: str, tmp_path: Path) -> None:
    text, most = FREE[case]
    steps = run(disc(tmp_path, STEPS, text), tmp_path / "out", **SCHEMES[scheme])
    change = abs(energy(steps) / energy(steps)[0] - 1).max()
    print(f"change of energy in {STEPS:,} steps {change:.1e} <= {most:.1e}")
    assert not (steps["active"] > 0).any(), "it met the plane"
    assert change <= most


def check(impacts: int, total: np.ndarray, first: float, most: float) -> None:
    """Enough impacts, and a rise of the energy, relative to the first, by rounding alone."""
    rise = np.maximum(0, np.diff(total).max() / first)
    print(f"{impacts} impacts >= {IMPACTS}, rise {rise:.1e} <= {most:.1e}, loss {(total[0] - total[-1]) / first:.3f}")
    assert impacts >= IMPACTS
    assert rise <= most


@pytest.mark.parametrize("scheme", SCHEMES)
def test_thrown_between_two_walls(scheme: str, tmp_path: Path) -> None:
    steps, gap, speed = 20_000, 0.01, 0.2
    mass = ', mass = "massless"' if scheme == "massless" else ""
    wall = '{{ on = "contact"{mass}, obstacle = {{ shape = "half-space", point = [{x}, 0], normal = [{n}, 0] }} }}'
    walls = "contact = [" + ", ".join(wall.format(mass=mass, x=-n * (1 + gap), n=n) for n in (1, -1)) + "]\n"
    scene = disc(tmp_path, steps, f'[initial]\nvelocity = ["{speed}", "0"]\n', walls)
    found = run(scene, tmp_path / "out", **({} if mass else SCHEMES[scheme]))
    sides = np.sign(found["contact_force_x"])
    impacts = 1 + int((np.diff(sides[sides != 0]) != 0).sum()) if sides.any() else 0
    reach = 10 * gap / (speed * STEP)  # what sticks out of a body that rings, and slides on, is not far from its place
    check(impacts, energy(found), energy(found)[0], rounding(COURANT, reach))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_bounces_under_gravity(scheme: str, tmp_path: Path) -> None:
    """Rise and loss are relative to the energy of the fall."""
    steps, height, weight = 160_000, 5.0, 0.01  # m, N/m³
    scene = disc(tmp_path, steps, f"""
[contact]
on = "lower"
obstacle = {{ shape = "half-space", point = [0, {-1 - height}], normal = [0, 1] }}
[load]
body = ["0", "{-weight}"]
""")
    found = run(scene, tmp_path / "out", **SCHEMES[scheme])
    touched = np.flatnonzero(found["contact_force_y"] > 0)
    impacts = 1 + int((np.diff(touched) > 20).sum()) if len(touched) else 0
    reach = height / (np.sqrt(2 * weight * height) * STEP)
    check(impacts, energy(found) - np.cumsum(found["external_work"]), np.pi * weight * height, rounding(COURANT, reach))
