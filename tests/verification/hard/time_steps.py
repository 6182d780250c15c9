# SPDX-License-Identifier: GPL-3.0-or-later
"""Time steps over eight decades: a body is thrown onto a plane and its energy rises by rounding alone.

No loads, no viscosity. For every scheme the energy law leaves the work of contact alone:

    contact-implicit, massless    E_k − E_{k−1} = −(2/τ²) λ·g(y_{k−1}),   for λ·g(y_k) = 0
    contact-stabilized            E_k − E_{k−1} = −(2/τ²) λ·g(y_{k−1}) − (2/τ²) ζ·g(y_k)

where ζ ≥ 0 are the forces that bring the predictor x to z, M(z − x) = −Nζ: with the jump j = z − x the second term is
−j·M(v_k − v_{k−1})/τ = −(2/τ²) j·M(y_k − z), and z is closed where ζ > 0. No force pulls and no gap is negative, so no
term is positive.

The free flight of the same body, whose energy is kept, shows how much rounding there is: there any change is rounding.

The gap at the start is 1.3 steps long, so that contact comes at once in every decade.
"""

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from schemes import DISC, EPSILON, SCHEMES, energy, rounding, run

SIZE = 0.25  # m, of an element
SPEED = 0.1  # m/s, towards the plane; the material's waves run at 1.16 m/s
YOUNG, POISSON = 1.0, 0.3
WAVE = np.sqrt(YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON))
COURANT = (1e-4, 1e-2, 1, 1e2, 1e4)
GAP = 1.3  # steps
AGAIN = 4  # times the rounding of the flights is permitted in contact, whose residual is another sample of as much

BLOCK = """
Point(1) = {-0.5, -1, 0};  Point(2) = {0.5, -1, 0};  Point(3) = {0.5, 0, 0};  Point(4) = {-0.5, 0, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("contact") = {1};
"""
THROWS = {  # mesh, m/s sideways
    "disc": (DISC, 0.0),
    "disc at 45°": (DISC, SPEED),
    "block at 60°": (BLOCK, SPEED * np.sqrt(3)),
}

SCENE = """
[mesh]
file = "body.geo"
size = {size}
[time]
end = {end!r}
step = {step!r}
[material]
density = 1.0
young = {young}
poisson = {poisson}
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, {plane!r}], normal = [0, 1] }}
[initial]
velocity = ["{sideways!r}", "{towards!r}"]
[output]
tables = ["steps"]
"""


def steps_of(courant: float) -> int:
    """Far from its place a body's energy has few digits where steps are long."""
    return 200 if courant <= 1 else 8


def pulling(steps: int) -> float:
    """Work of contact by rounding, relative to the first energy. Closed gaps are closed to 10 ε |y|, and in a step the forces
    turn at most the whole momentum, F τ = 2 m v."""
    return 40 * EPSILON * steps


def thrown(folder: Path, name: str, courant: float, **overrides: object) -> dict[str, np.ndarray]:
    """steps.csv."""
    mesh, sideways = THROWS[name]
    (folder / "body.geo").write_text(mesh)
    step = float(courant * SIZE / WAVE)
    scene = folder / "throw.toml"
    scene.write_text(SCENE.format(size=SIZE, end=steps_of(courant) * step, step=step, young=YOUNG, poisson=POISSON,
                                  plane=-1 - GAP * SPEED * step, sideways=float(sideways), towards=-SPEED))  # fmt: skip
    return run(scene, folder / "out", **overrides)


@pytest.fixture(scope="module")
def in_flight(tmp_path_factory: pytest.TempPathFactory) -> Callable[[float], float]:
    """The largest change of energy in the free flights, relative to the first energy, by Courant number."""

    @functools.cache
    def change(courant: float) -> float:
        changes = []
        for name in THROWS:
            found = thrown(tmp_path_factory.mktemp("flight"), name, courant, contact__obstacle__point=[0, -1e9])
            assert not found["active"].any(), "it met the plane"
            changes.append(abs(energy(found) / energy(found)[0] - 1).max())
        return np.max(changes)

    return change


@pytest.mark.parametrize("courant", COURANT, ids=lambda courant: f"Courant {courant:g}")
@pytest.mark.parametrize("scheme", SCHEMES)
def test_energy_rises_by_rounding_alone(in_flight: Callable, scheme: str, courant: float, tmp_path: Path) -> None:
    flight, steps = in_flight(courant), steps_of(courant)
    found = [thrown(tmp_path, name, courant, **SCHEMES[scheme]) for name in THROWS]
    assert all(len(one["time"]) == steps + 1 for one in found)
    contact = [int((one["contact_force_y"] > 0).sum()) for one in found]
    changes = [np.diff(energy(one)) / energy(one)[0] for one in found]
    rise = np.maximum(0, np.max(changes))
    work = np.maximum(0, np.max([one["contact_work"].max() / energy(one)[0] for one in found]))
    losses = [-change.sum() for change in changes]
    print(f"contact in {'+'.join(map(str, contact))} of {steps} steps; rise {rise:.1e} <= {AGAIN} * {flight:.1e} in free flight, "
          f"work of contact {work:.1e} <= {pulling(steps):.1e}, loss {np.min(losses):.1e} to {np.max(losses):.1e}")  # fmt: skip
    assert all(contact), "no contact: the case says nothing"
    assert rise <= AGAIN * flight <= AGAIN * rounding(courant, steps)
    assert work <= pulling(steps)
