# SPDX-License-Identifier: GPL-3.0-or-later
"""Time steps over eight decades: a body is thrown onto a plane and its energy rises by rounding alone.

No loads, no viscosity. For every scheme the energy law leaves the work of contact alone:

    contact-implicit, massless    E_k − E_{k−1} = −(2/τ²) λ·g(y_{k−1}),   for λ·g(y_k) = 0
    contact-stabilized            E_k − E_{k−1} = −(2/τ²) λ·g(y_{k−1}) − (2/τ²) ζ·g(y_k)

where ζ ≥ 0 are the forces that bring the predictor x to z, M(z − x) = −Nζ: with the jump j = z − x the second term is
−j·M(v_k − v_{k−1})/τ = −(2/τ²) j·M(y_k − z), and z is closed where ζ > 0. No force pulls and no gap is negative, so no
term is positive.

How much rounding is the same body tells in free flight, whose energy is kept: there any change is rounding.

The gap at the start is 1.3 steps long, so that contact comes at once in every decade.
"""

import sys
import tempfile
from pathlib import Path

from table import DISC, SCHEMES, Table, energy, run

import numpy as np

SIZE = 0.25  # m, of an element
SPEED = 0.1  # m/s, towards the plane; the material's waves run at 1.16 m/s
YOUNG, POISSON = 1.0, 0.3
WAVE = np.sqrt(YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON))
DECADES = range(-4, 5, 2)  # of the Courant number
GAP = 1.3  # steps

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

EPSILON = np.finfo(float).eps
ROW = 14  # entries of a row of D, each rounded


AGAIN = 4  # times the rounding that the flights show may come in contact, whose residual is another sample of as much


def rounding(courant: float, reach: float) -> float:
    """Change of energy by rounding, of the first energy, at most. A step solves D y = r to a residual ε |D| |y|, whose work is
    (2/τ²) ε |D| |y| |y_k − y_{k−1}|; |y| is
    `reach` times v τ, after so many steps of flight, and |D| is at most m (1 + (ωτ/2)²) with the largest frequency
    ω of the mesh, 12 c/h for the flattest of its linear triangles."""
    return 4 * ROW * EPSILON * reach * (1 + (6 * courant) ** 2)


def pulling(steps: int) -> float:
    """Work of contact by rounding, of the first energy. Closed gaps are closed to 10 ε |y|, and in a step the forces turn
    at most the whole momentum, F τ = 2 m v."""
    return 40 * EPSILON * steps


def throw(folder: Path, name: str, courant: float, over: dict) -> tuple[int, int, float, float, float]:
    """Steps, those in contact, and of the first energy: the largest rise, the largest work of contact, the loss."""
    found = thrown(folder, name, courant, over)
    first, steps = energy(found)[0], len(found["time"]) - 1
    change = np.diff(energy(found)) / first
    return (steps, int((found["contact_force_y"] > 0).sum()), np.maximum(0, change.max()),
            np.maximum(0, found["contact_work"].max() / first), -change.sum())  # fmt: skip


def flight(folder: Path, courant: float) -> float:
    """The largest change of energy in free flight, of the first energy."""
    largest = 0.0
    for name in THROWS:
        found = thrown(folder, name, courant, {"contact__obstacle__point": [0, -1e9]})
        assert not found["active"].any(), "it met the plane"
        largest = np.maximum(largest, abs(energy(found) / energy(found)[0] - 1).max())
    return largest


def thrown(folder: Path, name: str, courant: float, over: dict) -> dict[str, np.ndarray]:
    """steps.csv."""
    mesh, sideways = THROWS[name]
    (folder / "body.geo").write_text(mesh)
    step = float(courant * SIZE / WAVE)
    steps = 200 if courant <= 1 else 8  # far from its place a body's energy has few digits where steps are long
    scene = folder / "throw.toml"
    scene.write_text(SCENE.format(size=SIZE, end=steps * step, step=step, young=YOUNG, poisson=POISSON,
                                  plane=-1 - GAP * SPEED * step, sideways=float(sideways), towards=-SPEED))  # fmt: skip
    return run("simulate", scene, folder / "out", **over)[0]


def main() -> int:
    lines = Table("time steps")
    with tempfile.TemporaryDirectory() as folder:
        kept = {decade: flight(Path(folder), 10.0**decade) for decade in DECADES}
        for scheme, over in SCHEMES.items():
            worst = 0.0
            for decade in DECADES:
                courant = 10.0**decade
                thrown = [throw(Path(folder), name, courant, over) for name in THROWS]
                steps = thrown[0][0]
                contact, rise, work, loss = zip(*(figures[1:] for figures in thrown))
                worst = np.maximum(worst, np.max(rise) if decade <= 0 else 0)
                holds = np.min(contact) > 0 and np.max(rise) <= AGAIN * kept[decade] <= AGAIN * rounding(courant, steps) and np.max(work) <= pulling(steps)
                lines.row(f"{scheme}, Courant number 1e{decade:+d}",
                          f"contact in {'+'.join(map(str, contact))} of {steps} steps; rise {np.max(rise):.1e} <= "
                          f"{AGAIN} * {kept[decade]:.1e} in free flight, work of contact {np.max(work):.1e} <= {pulling(steps):.1e}, "
                          f"loss {np.min(loss):.1e} to {np.max(loss):.1e}", holds)  # fmt: skip
            print(f"      {scheme}: worst rise up to Courant number 1: {worst:.1e} of the first energy")
    return 1 if lines.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
