# SPDX-License-Identifier: GPL-3.0-or-later
"""A disc is thrown at a wall: left alone it flies off, a bounded traction on its back catches it.

Momentum, and angular momentum about the origin, change by the impulses of traction and contact at each step, to rounding:
translations and the linearised rotation strain nothing, so they belong to a free body's discrete motions.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, boundary, signorini, stored, table

SCENE = SOURCE / "scenes" / "catch.toml"
STEP, END, THROW = 5e-3, 1.5, 1.0  # s, s, m/s
PLACE, WALL = 0.202, 0.302  # m from the start
TRACTION = 1.0  # N/m², the bound
ALPHA, GAMMA = 1e-4, 0.1
# Of 300 steps that are each right to about 1e-14 of the forces in contact; a whole impulse is their sum.
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


@dataclass
class Run:
    out: Path
    steps: dict[str, np.ndarray]
    mass: float  # kg/m; density 1
    momenta: np.ndarray  # times × (momentum, angular momentum)
    contact: np.ndarray  # forces and moments, steps × 3


def read(out: Path) -> Run:
    points, cells, velocity = stored(out, "state", "velocity")
    size = areas(points, cells)
    return Run(out, table(out / "steps.csv"), size.sum(), products(points, cells, size, velocity[:, :, :2]), contact_forces(out))


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The disc without control."""
    out = tmp_path_factory.mktemp("alone")
    signorini("simulate", SCENE, out, control__initial=["0", "0"])
    run = read(out)
    assert (run.steps["active"] > 0).sum() > 10, "hardly any contact: the case says nothing"
    return run


@dataclass
class Control:
    """The optimal traction of a run."""

    edges: np.ndarray
    lengths: np.ndarray
    values: np.ndarray  # steps × nodes × 2
    forces: np.ndarray  # resultants and moments, steps × 3


@pytest.fixture(scope="module")
def caught(tmp_path_factory: pytest.TempPathFactory) -> Run:
    out = tmp_path_factory.mktemp("caught")
    signorini("optimize", SCENE, out)
    run = read(out)
    assert (run.steps["active"] > 0).sum() >= 10, "hardly any contact: the case says nothing"
    return run


@pytest.fixture(scope="module")
def control(caught: Run) -> Control:
    points, cells, u = stored(caught.out, "control", "control")
    edges, lengths = hand(points, cells)
    u = u[:, :, :2]
    return Control(edges, lengths, u, products(points, edges, lengths, u))


def test_alone_first_contact(alone: Run) -> None:
    assert alone.steps["step"][alone.steps["active"] > 0][0] == np.ceil(WALL / THROW / STEP)


def test_alone_forces_of_both_tables(alone: Run) -> None:
    forces = alone.contact
    assert alone.steps["contact_force_x"][1:] == pytest.approx(forces[:, 0], abs=1e-12 * abs(forces).max())


def test_alone_momenta_change_by_impulses(alone: Run) -> None:
    change = np.diff(alone.momenta, axis=0) - STEP * alone.contact
    assert abs(change).max() / (alone.mass * THROW) <= ROUNDING


def test_alone_rebound(alone: Run) -> None:
    speed = alone.momenta[-1, 0] / alone.mass
    # Waves and contact take some energy, and add none.
    assert speed == pytest.approx(-THROW, abs=0.2 * THROW), "m/s"
    # Then it flies until the end, from where the impact left it: within the body's compression in 0.1 s of contact.
    flight = END - STEP * alone.steps["step"][alone.steps["active"] > 0][-1]
    assert mean_displacement(alone.out)[-1] == pytest.approx(WALL + speed * flight, abs=0.1 * THROW), "m"


def test_control_acts_on_its_group_alone(control: Control) -> None:
    assert not np.delete(control.values, np.unique(control.edges), axis=1).any()


def test_caught_off_the_wall(caught: Run) -> None:
    assert -STEP * caught.contact[:, 0].sum() >= 0.1 * caught.mass * THROW, "impulse of the wall, N s/m"


def test_caught_momenta_change_by_impulses(caught: Run, control: Control) -> None:
    impulses = STEP * (caught.contact + control.forces)
    assert abs(np.diff(caught.momenta, axis=0) - impulses).max() / (caught.mass * THROW) <= ROUNDING
    gained = caught.momenta[-1, 0] - caught.momenta[0, 0]
    assert gained == pytest.approx(impulses.sum(axis=0)[0], abs=ROUNDING * caught.mass * THROW), "N s/m"


def test_caught_at_its_place(caught: Run) -> None:
    distance = abs(mean_displacement(caught.out)[-1] - PLACE)
    speed = np.linalg.norm(caught.momenta[-1, :2]) / caught.mass
    # Left alone from then on, the disc stays between the place and the wall for longer than the whole motion took.
    assert distance <= (WALL - PLACE) / 10, "m"
    assert speed <= (WALL - PLACE - distance) / END, "m/s"
    # The remaining motion within the body is of the order of that of the whole.
    kinetic = caught.steps["kinetic_energy"][-1] / (caught.mass * THROW**2 / 2)
    assert kinetic <= 2 * ((WALL - PLACE) / END / THROW) ** 2


def test_objective(caught: Run, control: Control) -> None:
    J = table(caught.out / "history.csv")["objective"]
    points, cells, y = stored(caught.out, "state", "displacement")
    own = objective(squares(points, cells, areas(points, cells), y[:, :, :2] - [PLACE, 0]),
                    squares(points, control.edges, control.lengths, control.values))  # fmt: skip
    # Sums of some hundred terms of one sign each.
    assert J[-1] / own == pytest.approx(1, abs=1e-12)
    assert J[0] / J[-1] >= 50
    assert (np.diff(J) < 0).all()


def test_bounds_of_the_control(control: Control) -> None:
    assert abs(control.values).max() == TRACTION
    # It brakes with the largest traction, and later pulls back with it.
    assert (abs(control.values[:, np.unique(control.edges), 0]) == TRACTION).mean() >= 0.05
