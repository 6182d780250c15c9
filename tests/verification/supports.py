# SPDX-License-Identifier: GPL-3.0-or-later
"""Supports that yield, against closed forms: a stiff block on springs and dashpots, a pulse that leaves a bar at an absorbing end."""

from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

LENGTH, WAVE, WIDTH = 10.0, 30.0, 0.8  # of the bar m, of its waves m/s, of the pulse m
STIFFNESS, DAMPING, YOUNG = 40.0, 0.6, 1e7  # N/m³ and N s/m³ on the lower side of 1 m, Pa; the block's mass is 1 kg/m

BLOCK = f"""
[mesh]
file = "{SOURCE / "tests" / "data" / "square.geo"}"
size = 0.5
[time]
end = 2.0
step = 0.01
[material]
density = 1.0
young = {YOUNG}
poisson = 0.0
[[foundation]]
on = "bottom"
stiffness = {{ normal = {STIFFNESS} }}
damping = {{ normal = {DAMPING} }}
[initial]
velocity = ["0", "-1"]
[[output.probe]]
name = "block"
body = true
"""

BAR = f"""
[mesh]
file = "{SOURCE / "meshes" / "bar.geo"}"
[time]
end = 0.5
step = 0.005
[material]
density = 1.0
young = {WAVE**2}
poisson = 0.0
[[foundation]]
on = "contact"
absorbing = true
[initial]
displacement = ["0", "exp(-((y - {LENGTH / 2})/{WIDTH})^2)"]
velocity = ["0", "-{2 * WAVE / WIDTH**2}*(y - {LENGTH / 2})*exp(-((y - {LENGTH / 2})/{WIDTH})^2)"]
[output]
fields = []
"""


def motion(tmp_path: Path, scene: str, **overrides: object) -> dict[str, np.ndarray]:
    (tmp_path / "scene.toml").write_text(scene)
    signorini("simulate", tmp_path / "scene.toml", tmp_path / "run", **overrides)
    return table(tmp_path / "run" / "steps.csv")


def test_block_on_springs(tmp_path: Path) -> None:
    """The centre of mass moves as the midpoint rule moves a mass on a spring and a dashpot, but for the block's own compliance:
    k / E = 4e-6 of the motion, and its waves."""
    steps = motion(tmp_path, BLOCK)
    tau, state = 0.01, np.array([0.0, -1.0])  # displacement, velocity
    rate = np.array([[0, 1], [-STIFFNESS, -DAMPING]])
    advance = np.linalg.solve(np.eye(2) - tau / 2 * rate, np.eye(2) + tau / 2 * rate)
    found = table(tmp_path / "run" / "probes.csv")["block.momentum_y"]
    expected = [state[1]]
    for _ in steps["step"][1:]:
        state = advance @ state
        expected.append(state[1])
    assert np.sum(np.diff(np.sign(expected)) != 0) >= 4, "it swings"
    assert np.max(np.abs(found - expected)) < 1e-3
    assert steps["foundation_energy"].max() > 0.3 and steps["foundation_dissipation"].sum() > 0.3
    total = steps["kinetic_energy"] + steps["elastic_energy"] + steps["foundation_energy"] + np.cumsum(steps["foundation_dissipation"])
    rounding = 1e-16 * YOUNG  # of y·Ay where |y| = 0.15 m, some 20 entries
    assert np.max(np.abs(total - total[0])) < rounding


@pytest.mark.parametrize("damping, part", ((True, 2e-3), (False, 0.99)), ids=("absorbing", "free"))
def test_end_of_a_bar(tmp_path: Path, damping: bool, part: float) -> None:
    """What of the pulse's energy is left after it has run to the end: next to nothing, or all where the end is free."""
    scene = BAR if damping else BAR.replace("absorbing = true", "stiffness = { normal = 1e-9 }")
    steps = motion(tmp_path, scene, mesh__size=0.125, time__step=0.125 / WAVE / 2)
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    left = energy[-1] / energy[0]
    assert left < part if damping else left > part


def test_reflected_energy_falls_with_the_mesh(tmp_path: Path) -> None:
    """The triangles at the end give its nodes unequal masses at equal dashpots: what they reflect is of order 1 in amplitude and 2
    in energy."""
    left = []
    for size in (0.25, 0.125, 0.0625):
        steps = motion(tmp_path, BAR, mesh__size=size, time__step=size / WAVE / 2)
        energy = steps["kinetic_energy"] + steps["elastic_energy"]
        left.append(energy[-1] / energy[0])
    orders = np.log2(np.array(left[:-1]) / left[1:])
    print("reflected", ", ".join(f"{one:.1e}" for one in left), "orders", orders)
    assert left[-1] < 5e-4 and np.all(orders > 1.3)


@pytest.mark.parametrize("name, more", (
    ("springs", {}),
    ("drag", {"foundation": [], "material__rayleigh": {"alpha": 1.0}}),
), ids=("springs", "drag"))  # fmt: skip
def test_steps_of_varying_length(tmp_path: Path, name: str, more: dict) -> None:
    """They follow the motion on springs or with drag to their tolerance, by fewer steps than the shortest ones would be."""
    fine = motion(tmp_path, BLOCK, time__step=1e-3, material__young=1e5, **more)["kinetic_energy"][-1]
    steps = motion(tmp_path, BLOCK, time={"end": 2.0, "step": "auto", "tolerance": 1e-2}, material__young=1e5, **more)
    lengths = np.diff(steps["time"])
    print(f"{name}: {len(lengths)} steps of {lengths.min():.1e} to {lengths.max():.1e} s")
    assert abs(steps["kinetic_energy"][-1] - fine) < 2e-2 * 0.5
    assert len(lengths) < 2.0 / lengths.min() / 2
