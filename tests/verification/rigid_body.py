# SPDX-License-Identifier: GPL-3.0-or-later
"""Obstacles with mass: a hammer on a bar against Saint-Venant's force, and the momentum of body and plate together."""

from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

# A bar of length, wave speed and impedance 1 per area, clamped at its far end, hit by a hammer.
BAR = """
Point(1) = {{0, 0, 0}}; Point(2) = {{1, 0, 0}}; Point(3) = {{1, {h}, 0}}; Point(4) = {{0, {h}, 0}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Curve Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Transfinite Curve {{1, 3}} = {n} + 1; Transfinite Curve {{2, 4}} = 2; Transfinite Surface {{1}};
Physical Surface("body") = {{1}}; Physical Curve("hit") = {{4}}; Physical Curve("far") = {{2}};
"""
HAMMER = """
[mesh]
file = "bar.geo"
[time]
step = {step}
end = 1.9
scheme = "{scheme}"
[material]
density = 1.0
young = 1.0
poisson = 0.0
[contact]
on = "hit"
[contact.obstacle]
name = "hammer"
shape = "half-space"
point = [0, 0]
normal = [1, 0]
mass = {mass}
velocity = [{speed}, 0]
components = ["x"]
[[clamp]]
on = "far"
[output]
fields = []
every = 1
[[output.probe]]
name = "hammer"
obstacle = "hammer"
"""
HEIGHT, SPEED = 0.05, 0.01
SCHEMES = {"contact-implicit": {"time__scheme": "contact-implicit"}, "contact-stabilized": {"time__scheme": "contact-stabilized"},
           "massless": {"contact__mass": "massless"}}  # fmt: skip


def hit(folder: Path, elements: int, ratio: float, scheme: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times between steps, force over ρ c v A as the mean of two steps, and the hammer's velocity over v, before waves return."""
    folder.mkdir()
    (folder / "bar.geo").write_text(BAR.format(h=HEIGHT, n=elements))
    (folder / "hammer.toml").write_text(HAMMER.format(step=0.5 / elements, scheme=scheme, mass=HEIGHT * ratio, speed=SPEED))
    signorini("simulate", folder / "hammer.toml", folder / "out")
    found = table(folder / "out" / "probes.csv")
    force = found["hammer.force_x"][1:] / (HEIGHT * SPEED)
    return found["time"][1:-1], (force[1:] + force[:-1]) / 2, found["hammer.velocity_x"][1:-1] / SPEED


@pytest.mark.parametrize("scheme", ("contact-implicit", "contact-stabilized"))
@pytest.mark.parametrize("ratio", (1, 2, 4, 6))
def test_hammer(ratio: float, scheme: str, tmp_path: Path) -> None:
    """F = ρ c A v exp(−t ρ c A/m) until the wave returns: the velocity to 0.5 %, the force in the mean square with an order above 1/4
    (a front spreads as h^(2/3), its mean square as h^(1/3))."""
    errors = []
    for elements in (40, 320):
        t, force, velocity = hit(tmp_path / str(elements), elements, ratio, scheme)
        exact = np.exp(-t / ratio)
        assert force.min() > 0
        errors.append(float(np.sqrt(np.mean((force - exact) ** 2) / np.mean(exact**2))))
        late = t > 0.2
        off = abs(velocity - exact)[late].max()
        print(f"{scheme}, mass {ratio}, {elements} elements: force {100 * errors[-1]:.2f} %, velocity {100 * off:.3f} %")
    assert off < 0.005
    assert errors[1] < 0.04 and np.log(errors[0] / errors[1]) / np.log(8) > 1 / 4


@pytest.mark.parametrize("friction", (0, 0.3), ids=("smooth", "rough"))
@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name, up", (("block", "y"), ("cube", "z")))
def test_momentum(name: str, up: str, scheme: str, ranks: int, friction: float, tmp_path: Path) -> None:
    """Body and plate without other forces keep their momentum, and their energy falls by contact and friction alone."""
    axes = "xyz"[: 2 if name == "block" else 3]
    mass, rest = 3.0, ["0"] * len(axes)
    rigid = {"mass": mass, "inertia": 0.6 if name == "block" else [0.6, 0.7, 0.8], "velocity": [0.1, 0.2, 0.3][: len(axes)]}
    signorini("simulate", SOURCE / "tests" / "data" / f"{name}.toml", tmp_path, ranks=ranks, load__body=rest, contact__friction=friction,
              output={"every": 1, "probe": [{"name": "plate", "obstacle": "obstacle 1"}, {"name": "body", "body": True}]},
              **{f"contact__obstacle__{key}": value for key, value in rigid.items()}, **SCHEMES[scheme])  # fmt: skip
    found, steps = table(tmp_path / "probes.csv"), table(tmp_path / "steps.csv")
    whole = np.stack([found[f"body.momentum_{c}"] + mass * found[f"plate.velocity_{c}"] for c in axes])
    assert steps["active"].max() > 0 and abs(np.diff(found[f"plate.velocity_{up}"])).max() > 0.01
    assert abs(whole - whole[:, :1]).max() < 1e-12 * abs(whole).max()
    energy = steps["kinetic_energy"] + steps["elastic_energy"] + steps["rigid_energy"]
    assert abs(steps["energy_residual"]).max() < 1e-12 * energy[0]
    assert steps["contact_work"].max() < 1e-13 * energy[0] and energy[-1] < energy[0]
    assert friction == 0 or steps["friction_work"].min() < -1e-4
