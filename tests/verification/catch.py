# SPDX-License-Identifier: GPL-3.0-or-later
"""A disc is thrown at a wall: left alone it flies off, a bounded traction on its back catches it.

Momentum, and angular momentum about the origin, change by the impulses of traction and contact at each step, to rounding:
translations and the linearised rotation strain nothing, so they belong to a free body's discrete motions.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, Figures, boundary, signorini, stored, table  # noqa: E402

import numpy as np  # noqa: E402

SCENE = SOURCE / "scenes" / "catch.toml"
STEP, END, THROW = 5e-3, 1.5, 1.0  # s, s, m/s
PLACE, WALL = 0.202, 0.302  # m from the start
TRACTION = 1.0  # N/m², the bound
ALPHA, GAMMA = 1e-4, 0.1
# Of 300 steps that are each right to about 1e-14 of the forces in contact, of which a whole impulse is the sum.
ROUNDING = 1e-11


def products(points: np.ndarray, simplices: np.ndarray, sizes: np.ndarray, field: np.ndarray) -> np.ndarray:
    """∫ over the simplices, of these sizes, of the product of two linear fields: once the rows of (x, y, rotation), once
    the nodal values (times × nodes × 2); times × 3."""
    rigid = np.zeros((3, len(points), 2))
    rigid[0, :, 0] = rigid[1, :, 1] = 1
    rigid[2] = np.column_stack([-points[:, 1], points[:, 0]])
    corners = simplices.shape[1]
    mass = (1 + np.eye(corners)) / (corners * (corners + 1))
    return np.einsum("s,ij,rsic,tsjc->tr", sizes, mass, rigid[:, simplices], field[:, simplices])


def squares(points: np.ndarray, simplices: np.ndarray, sizes: np.ndarray, field: np.ndarray) -> np.ndarray:
    """∫ over the simplices of the square of a linear field, at all times."""
    corners = simplices.shape[1]
    mass = (1 + np.eye(corners)) / (corners * (corners + 1))
    return np.einsum("s,ij,tsic,tsjc->t", sizes, mass, field[:, simplices], field[:, simplices])


def objective(error: np.ndarray, control: np.ndarray) -> float:
    """The J of docs/method.md, section 3, of the squared norms of y - y_d at the times 0…N and of u in the steps 1…N."""
    return STEP / 4 * (error[:-1] + error[1:]).sum() + ALPHA * STEP / 2 * control.sum() + GAMMA * error[-1]


def areas(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    a, b = (points[cells[:, i]] - points[cells[:, 0]] for i in (1, 2))
    return abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def hand(points: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The edges on which the traction acts, within 60 degrees of the leftmost point, and their lengths."""
    edges = boundary(cells)
    middle = points[edges].mean(axis=1)
    edges = edges[-middle[:, 0] > np.cos(np.pi / 3) * np.linalg.norm(middle, axis=1)]
    return edges, np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)


def momenta(out: Path) -> tuple[float, np.ndarray]:
    """Mass, and momentum and angular momentum at all times; density 1."""
    points, cells, velocity = stored(out, "state", "velocity")
    return areas(points, cells).sum(), products(points, cells, areas(points, cells), velocity[:, :, :2])


def contact_forces(out: Path) -> np.ndarray:
    """Resultant and moment at all steps; the wall pushes to the left."""
    contact = table(out / "contact.csv")
    by_step = np.zeros((round(END / STEP) + 1, 3))
    index = contact["step"].astype(int)
    np.add.at(by_step[:, 0], index, -contact["force"])
    np.add.at(by_step[:, 2], index, contact["y"] * contact["force"])
    return by_step[1:]


def mean_displacement(out: Path) -> np.ndarray:
    """Of the body along x, at all times."""
    points, cells, y = stored(out, "state", "displacement")
    size = areas(points, cells)
    return products(points, cells, size, y[:, :, :2])[:, 0] / size.sum()


def left_alone(out: Path, figures: Figures) -> None:
    signorini("simulate", SCENE, out, control__initial=["0", "0"])
    steps = table(out / "steps.csv")
    mass, momentum = momenta(out)
    forces = contact_forces(out)
    touching = steps["step"][steps["active"] > 0]
    assert len(touching) > 10, "hardly any contact: the case says nothing"
    print("left alone:")
    figures.show("first step in contact", touching[0], np.ceil(WALL / THROW / STEP), 0)
    figures.show("contact force of steps.csv and contact.csv, N/m", abs(steps["contact_force_x"][1:] - forces[:, 0]).max(), 0,
                 1e-12 * abs(forces).max())  # fmt: skip
    largest = mass * THROW
    figures.show("worst change of momenta without its impulse", abs(np.diff(momentum, axis=0) - STEP * forces).max() / largest,
                 0, ROUNDING)  # fmt: skip
    speed = momentum[-1, 0] / mass
    # Some energy goes with waves and the contact, none comes.
    figures.show("speed of the rebound, m/s", speed, -THROW, 0.2 * THROW)
    # Then it flies until the end, from where the impact left it: within as much as the body gives way in 0.1 s of contact.
    flight = END - STEP * touching[-1]
    figures.show("mean displacement at the end, m", mean_displacement(out)[-1], WALL + speed * flight, 0.1 * THROW)


def caught(out: Path, figures: Figures) -> None:
    signorini("optimize", SCENE, out)
    steps, history = table(out / "steps.csv"), table(out / "history.csv")
    mass, momentum = momenta(out)
    forces = contact_forces(out)
    points, cells, u = stored(out, "control", "control")
    edges, lengths = hand(points, cells)
    u = u[:, :, :2]
    on = np.unique(edges)
    assert not np.delete(u, on, axis=1).any(), "the control acts beside the group that it is for"
    traction = products(points, edges, lengths, u)
    print("caught:")
    figures.least("steps in contact", (steps["active"] > 0).sum(), 10)
    figures.least("impulse of the wall, N s/m", -STEP * forces[:, 0].sum(), 0.1 * mass * THROW)
    change = np.diff(momentum, axis=0) - STEP * (forces + traction)
    figures.show("worst change of momenta without its impulse", abs(change).max() / (mass * THROW), 0, ROUNDING)
    total = STEP * (forces + traction).sum(axis=0)
    figures.show("momentum gained, N s/m: that of all impulses", momentum[-1, 0] - momentum[0, 0], total[0],
                 ROUNDING * mass * THROW)  # fmt: skip

    distance = abs(mean_displacement(out)[-1] - PLACE)
    speed = np.linalg.norm(momentum[-1, :2]) / mass
    # Left alone from then on, the disc stays between the place and the wall for longer than all this took.
    figures.show("distance from the place at the end, m", distance, 0, (WALL - PLACE) / 10)
    figures.show("speed at the end, m/s", speed, 0, (WALL - PLACE - distance) / END)
    # What is left of the motion within the body is of the order of that of the whole.
    kinetic = steps["kinetic_energy"][-1] / (mass * THROW**2 / 2)
    figures.show("kinetic energy at the end / of the throw", kinetic, 0, 2 * ((WALL - PLACE) / END / THROW) ** 2)

    J = history["objective"]
    _, _, y = stored(out, "state", "displacement")
    own = objective(squares(points, cells, areas(points, cells), y[:, :, :2] - [PLACE, 0]), squares(points, edges, lengths, u))
    # Sums of some hundred terms of one sign each.
    figures.show("objective / that of the stored fields", J[-1] / own, 1, 1e-12)
    figures.least("objective of the first guess / this", J[0] / J[-1], 50)
    assert (np.diff(J) < 0).all(), "J rose"
    figures.show("largest traction, N/m²", abs(u).max(), TRACTION, 0)
    # Braking with all there is, and then pulling back the same way.
    figures.least("part of the tractions' values along x at a bound", (abs(u[:, on, 0]) == TRACTION).mean(), 0.05)


def main() -> int:
    figures = Figures()
    with tempfile.TemporaryDirectory() as folder:
        left_alone(Path(folder), figures)
        caught(Path(folder), figures)
    return 1 if figures.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
