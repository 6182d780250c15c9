# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of clamps, contact and obstacles: the effect of each on a small scene is that of docs/reference/keys.md."""

from pathlib import Path

import numpy as np
import pytest
from harness import attempt, table
from regression.keys.runs import BLOCK, DATA, FLAT, FREE, ROUNDING, Run, Runner, T, near, same

WEIGHT = FREE | {"load__body": ["1", "-1"]}


@pytest.mark.key("clamp.on", "clamp.components")
@pytest.mark.parametrize("components", (["x", "y"], ["x"], ["y"]), ids=str)
@pytest.mark.parametrize("group, axis, place", (("left", 0, 0), ("top", 1, 1)))
def test_clamp(group: str, axis: int, place: float, components: list[str], simulate: Runner) -> None:
    done = simulate(clamp=[{"on": group, "components": components}], **WEIGHT)
    moved = abs(done.field("displacement")[-1])
    on = abs(done.points[:, axis] - place) < ROUNDING
    assert 2 < on.sum() < len(on) and (moved[~on] > 0).all()
    assert [name for c, name in enumerate("xy") if (moved[on, c] == 0).all()] == components, "and no other component"


@pytest.mark.key("clamp.components")
def test_clamp_of_all_components(simulate: Runner) -> None:
    default = simulate(clamp=[{"on": "left"}], **WEIGHT)
    same(default, simulate(clamp=[{"on": "left", "components": ["x", "y"]}], **WEIGHT))


@pytest.mark.key("clamp.value")
@pytest.mark.parametrize("components, value, end", (
    (["x", "y"], ["0.1*t^2", "0.2*t^2*(1+x)"], [0.1 * T**2, 0.2 * T**2]),
    (["y", "x"], ["0.1*t^2", "0.2*t^2"], [0.2 * T**2, 0.1 * T**2]),  # each value is its component's
    (["y"], ["0.3*t^2"], [None, 0.3 * T**2]),
), ids=str)  # fmt: skip
def test_clamp_value(components: list[str], value: list[str], end: list[float | None], simulate: Runner) -> None:
    done = simulate(clamp=[{"on": "left", "components": components, "value": value}], **FREE)
    same(done, simulate(done.folder / "scene.toml"))
    left = done.points[:, 0] == 0
    for c, expected in enumerate(end):
        if expected is not None:
            near(done.field("displacement")[-1][left, c], np.full(left.sum(), expected))


@pytest.mark.key("contact.on")
@pytest.mark.parametrize("group, axis, place, nodes", (
    ("bottom", "y", 0, 5), ("top", "y", 1, 5), ("left", "x", 0, 5), ("boundary", None, 0, 16)))  # fmt: skip
def test_contact_on(group: str, axis: str | None, place: float, nodes: int, simulate: Runner) -> None:
    done = simulate(contact__on=group, **FREE)
    assert done.manifest["candidates"] == len(done.start["x"]) == nodes
    assert axis is None or (abs(done.start[axis] - place) < ROUNDING).all()


@pytest.mark.key("contact.mass")
@pytest.mark.parametrize("mass, moved", (("consistent", True), ("massless", False)))
def test_contact_mass(mass: str, moved: bool, simulate: Runner) -> None:
    done = simulate(contact__mass=mass, **FLAT)
    near(done.steps["kinetic_energy"][0], 0.5)  # the whole mass stays
    towards = simulate(contact__mass=mass, initial__velocity=["0", "y < 0.01 ? -1 : 0"], **FLAT).steps["kinetic_energy"][0]
    assert (towards > 0.03) if moved else (abs(towards) < ROUNDING), "that of the lower nodes, towards the plane"


INSIDE = FLAT | {"contact__obstacle__point": [0, 0.05]}


@pytest.mark.key("contact.initial")
@pytest.mark.parametrize("initial", ({}, {"contact__initial": "outside"}), ids=("default", "outside"))
def test_start_inside_an_obstacle_is_refused(initial: dict[str, str], tmp_path: Path) -> None:
    assert attempt("simulate", BLOCK, tmp_path / "inside", **initial, **INSIDE).returncode == 2


@pytest.mark.key("contact.initial")
def test_start_inside_an_obstacle_is_projected(simulate: Runner) -> None:
    done = simulate(contact__initial="project", **INSIDE)
    near(done.start["gap"], np.zeros(5))
    lower = done.points[:, 1] == 0
    near(done.field("displacement")[0][:, 1], np.where(lower, 0.05, 0))


@pytest.mark.key("contact.obstacle.shape", "contact.obstacle.point", "contact.obstacle.normal")
@pytest.mark.parametrize("point, normal", (
    ([0, -0.1], [0.3, 1]), ([0.5, -0.3], [0.3, 1]), ([0, -0.1], [0, 2]), ([2, -2], [-1, 1])), ids=str)  # fmt: skip
def test_half_space(point: list[float], normal: list[float], simulate: Runner) -> None:
    done = simulate(contact__obstacle={"shape": "half-space", "point": point, "normal": normal})
    n = np.array(normal) / np.hypot(*normal)
    done.gaps(lambda x, y: n[0] * (x - point[0]) + n[1] * (y - point[1]))


@pytest.mark.key("contact.obstacle.point")
def test_moving_half_space(simulate: Runner) -> None:
    pushed = simulate(**FREE | FLAT | {"contact__obstacle__point": ["0", "-0.1 + 0.5*t"]})
    near(pushed.start["gap"], np.full(5, 0.1))
    force = pushed.steps["contact_force_y"]
    assert (force[1:10] == 0).all() and force.max() > 0, "the plane arrives after 0.2 s"
    near(pushed.momentum()[1], 0.02 * force[1:].sum())
    lower = pushed.points[:, 1] == 0
    assert (pushed.field("displacement")[-1][lower, 1] >= 0.2 - ROUNDING).all()


@pytest.mark.key("contact.obstacle.center", "contact.obstacle.radius", "contact.obstacle.side")
@pytest.mark.parametrize("side", ({}, {"side": "outside"}), ids=("default", "outside"))
@pytest.mark.parametrize("center, radius", (([0.5, -1], 0.9), ([0.2, -1], 0.9), ([0.5, -1], 0.5)), ids=str)
def test_ball(center: list[float], radius: float, side: dict[str, str], simulate: Runner) -> None:
    done = simulate(contact__obstacle={"shape": "ball", "center": center, "radius": radius} | side)
    done.gaps(lambda x, y: np.hypot(x - center[0], y - center[1]) - radius)
    assert (center, radius) != ([0.5, -1], 0.9) or done.steps["active"].max() > 0


@pytest.mark.key("contact.obstacle.center", "contact.obstacle.radius", "contact.obstacle.side")
def test_inside_of_a_ball(simulate: Runner) -> None:
    done = simulate(contact__obstacle={"shape": "ball", "center": [0.5, 0.4], "radius": 2, "side": "inside"})
    done.gaps(lambda x, y: 2 - np.hypot(x - 0.5, y - 0.4))
    assert done.steps["active"].max() == 0


RESTING = {name: value for name, value in FREE.items() if "obstacle" not in name}


@pytest.mark.key("contact.obstacle.center", "contact.obstacle.radius", "contact.obstacle.distance", "contact.obstacle.point")
@pytest.mark.parametrize("obstacle", (
    {"shape": "ball", "center": ["0.5 + t", "-1.5 + t"], "radius": "0.5 + 0.2*t"},
    {"shape": "cylinder", "point": ["0.5 + t", "-1.5 + t"], "radius": "0.5 + 0.2*t"},
    {"shape": "signed-distance", "distance": "sqrt((x - 0.5 - t)^2 + (y + 1.5 - t)^2) - 0.5 - 0.2*t"},
), ids=lambda obstacle: obstacle["shape"])  # fmt: skip
def test_moving_round_obstacle(obstacle: dict[str, object], simulate: Runner) -> None:
    """Gaps of the undeformed body, which rests far from everything until the obstacle comes."""
    done = simulate(contact__obstacle=obstacle, **RESTING)
    contact = table(done.folder / "contact.csv")
    assert done.steps["active"].max() == 0 and done.manifest["effects"]["moving obstacle"]
    t, x = np.unique(contact["time"])[:, None], np.linspace(0, 1, 5)[None, :]
    near(contact["gap"].reshape(31, 5), np.hypot(x - 0.5 - t, 1.5 - t) - 0.5 - 0.2 * t, 1e-9)


@pytest.mark.key("contact.obstacle.center")
def test_pushed_by_a_moving_ball(simulate: Runner) -> None:
    fast = simulate(contact__obstacle={"shape": "ball", "center": [0.5, "-1.2 + t"], "radius": 1}, **RESTING)
    assert fast.steps["active"].max() > 0 and fast.momentum()[1] > 0.1


@pytest.mark.key("contact.obstacle.point", "contact.obstacle.radius", "contact.obstacle.side")
def test_cylinder_in_the_plane(simulate: Runner) -> None:
    disc = {"shape": "cylinder", "point": [0.5, -1], "radius": 0.9}
    simulate(contact__obstacle=disc).gaps(lambda x, y: np.hypot(x - 0.5, y + 1) - 0.9)
    inside = {"shape": "cylinder", "point": [0.5, 0.4], "radius": 2, "side": "inside"}
    simulate(contact__obstacle=inside).gaps(lambda x, y: 2 - np.hypot(x - 0.5, y - 0.4))


@pytest.mark.key("contact.obstacle.axis", "contact.obstacle.point", "contact.obstacle.radius")
@pytest.mark.parametrize("axis", ([1, 0, 0], [0, 2, 0], [1, 1, 0]), ids=str)
def test_cylinder_in_space(axis: list[float], simulate: Runner) -> None:
    across = np.array([-axis[1], axis[0]]) / np.hypot(*axis[:2])  # in the lower side, z = 0
    done = simulate(DATA / "cube.toml", contact__obstacle={"shape": "cylinder", "point": [0.5, 0.5, -1], "radius": 0.9, "axis": axis},
                    time__end=0.02)  # fmt: skip
    done.gaps(lambda x, y: np.hypot(across[0] * (x - 0.5) + across[1] * (y - 0.5), 1) - 0.9)


@pytest.mark.key("contact.obstacle.distance")
def test_signed_distance(simulate: Runner) -> None:
    done = simulate(contact__obstacle={"shape": "signed-distance", "distance": "3*(y + 0.1 + 0.2*x^2)"})
    done.gaps(lambda x, y: (0.1 + 0.2 * x**2) / np.hypot(1, 0.4 * x), 1e-10)  # differences: rounding over 1e-4 of the body


@pytest.mark.key("contact.obstacle.name")
@pytest.mark.parametrize("names, expected", (
    (({}, {}), ["obstacle 1", "obstacle 2"]), (({"name": "floor"}, {}), ["floor", "obstacle 2"])), ids=("defaults", "floor"))  # fmt: skip
def test_obstacle_name(names: tuple[dict[str, str], dict[str, str]], expected: list[str], simulate: Runner) -> None:
    plane = {"shape": "half-space", "point": [0, -0.1], "normal": [0, 1]}
    done = simulate(contact=[{"on": "bottom", "obstacle": plane | names[0]}, {"on": "left", "obstacle": plane | names[1]}])
    assert [contact["obstacle"]["name"] for contact in done.echo["contact"]] == expected
    assert list(table(done.folder / "obstacles.csv")["obstacle"]) == 31 * expected
    assert [one["name"] for one in done.manifest["impact"]["obstacles"]] == expected


# The block on a plane that bears its weight.
RESTS = FLAT | {"contact__obstacle__point": [0, 0]}
BELT = {"shape": "half-space", "point": [0, 0], "normal": [0, 1]}


def friction_of(done: Run) -> dict[str, np.ndarray]:
    """Columns of contact.csv, as stored time × candidate."""
    contact = table(done.folder / "contact.csv")
    return {name: contact[name].reshape(31, 5) for name in ("x", "time", "force", "tangential_force_x", "slip_velocity_x", "motion")}


@pytest.mark.key("contact.friction")
@pytest.mark.parametrize("friction", (0.3, "0.3", "0.1 + 0.4*x + 0.2*t"))
@pytest.mark.parametrize("speed", (3, -3))
def test_friction_of_what_slides(friction: float | str, speed: float, simulate: Runner) -> None:
    """It is the coefficient times the normal force, against the slip, and its work is in the account."""
    done = simulate(contact__friction=friction, initial__velocity=[str(speed), "0"], **RESTS)
    found = friction_of(done)
    coefficient = 0.1 + 0.4 * found["x"] + 0.2 * found["time"] if "x" in str(friction) else 0.3
    slips = found["motion"] == "slip"
    assert slips.sum() > 60 and (speed * found["slip_velocity_x"][slips] > 0).all()
    near(found["tangential_force_x"], -np.sign(speed) * coefficient * found["force"])
    work = 0.02 * (found["tangential_force_x"] * found["slip_velocity_x"]).sum(axis=1)
    near(done.steps["friction_work"], work)
    assert (work[1:] <= 0).all() and work.sum() < -0.1
    near(done.manifest["energy"]["friction_work"], work.sum())
    near(done.manifest["impact"]["all"]["friction_impulse"], [0.02 * found["tangential_force_x"].sum(), 0])
    assert list(done.steps["slip"]) == list(slips.sum(axis=1)) and done.manifest["effects"]["friction"]


@pytest.mark.key("contact.friction", "contact.friction.bound")
@pytest.mark.parametrize("key, unit", (("contact__friction", ""), ("contact__friction__bound", " [Pa]")))
def test_friction_from_a_series(key: str, unit: str, tmp_path: Path, simulate: Runner) -> None:
    (tmp_path / "series.csv").write_text(f"time,friction{unit}\n0,0.1\n10,2.1\n")
    series = {"file": str(tmp_path / "series.csv"), "column": "friction"}
    done = simulate(**{key: series}, initial__velocity=["1", "0"], **RESTS)
    formula = simulate(**{key: "0.1 + 0.2*t"}, initial__velocity=["1", "0"], **RESTS)
    near(done.steps["kinetic_energy"], formula.steps["kinetic_energy"], 1e-12)
    same(done, simulate(done.folder / "scene.toml"))
    assert done.steps["friction_work"].sum() < 0


@pytest.mark.key("contact.friction")
def test_friction_of_what_sticks(simulate: Runner) -> None:
    done = simulate(contact__friction=2, initial__velocity=["0", "0"], load__body=["0.1", "-1"], **RESTS)
    found = friction_of(done)
    sticks = found["motion"] == "stick"
    assert sticks.sum() > 60 and list(done.steps["stick"]) == list(sticks.sum(axis=1))
    assert (abs(found["slip_velocity_x"][sticks]) < ROUNDING).all() and abs(found["tangential_force_x"]).max() > 0.01
    assert (abs(found["tangential_force_x"]) <= 2 * found["force"] + ROUNDING).all()


@pytest.mark.key("contact.friction")
def test_no_friction_by_default(plain: Run, simulate: Runner) -> None:
    none = simulate(contact__friction=0)
    same(none, plain)
    assert "slip" not in none.steps and "friction_work" not in none.manifest["energy"] and not none.manifest["effects"]["friction"]


# The block above the floor, held up by its upper side: friction that needs no contact brakes it all the same.
FLIES = FLAT | {"clamp": [{"on": "top", "components": ["y"]}], "load__body": ["0", "0"], "initial__velocity": ["3", "0"]}


@pytest.mark.key("contact.friction.bound")
@pytest.mark.parametrize("bound", (0.3, "0.3", "0.1 + 0.4*x + 0.2*t"))
def test_friction_bound(bound: float | str, simulate: Runner) -> None:
    """Friction is the bound times the nodal area, against the slip, without contact, and its impulse brakes the block."""
    done = simulate(contact__friction={"bound": bound}, **FLIES)
    found = friction_of(done)
    area = np.array([0.125, 0.25, 0.25, 0.25, 0.125])
    traction = 0.1 + 0.4 * found["x"] + 0.2 * found["time"] if "x" in str(bound) else np.full((31, 5), 0.3)
    assert done.steps["active"].max() == 0 and (done.steps["slip"][1:] == 5).all()
    near(found["tangential_force_x"][1:], -(traction * area)[1:], 1e-11)
    near(done.momentum()[0], 3 + done.manifest["impact"]["all"]["friction_impulse"][0])
    near(done.steps["friction_work"], 0.02 * (found["tangential_force_x"] * found["slip_velocity_x"]).sum(axis=1))
    assert done.manifest["effects"]["friction"]


@pytest.mark.key("contact.friction.bound")
def test_friction_bound_that_holds(simulate: Runner) -> None:
    done = simulate(contact__friction={"bound": 2}, **FLIES | {"initial__velocity": ["0", "0"], "load__body": ["0.5", "0"]})
    found = friction_of(done)
    assert (done.steps["stick"][1:] == 5).all() and (found["motion"][1:] == "stick").all()
    assert abs(found["slip_velocity_x"]).max() < ROUNDING and 0.1 < -found["tangential_force_x"].sum(axis=1).min() < 2


@pytest.mark.key("contact.mass")
def test_no_tangential_mass(simulate: Runner) -> None:
    """Forces of nodes that stick do not alternate, and a velocity of these nodes alone is none."""
    scene = RESTS | {"contact__friction": 5, "initial__velocity": ["0.3", "-1"], "time__scheme": "contact-stabilized"}
    found = {mass: friction_of(simulate(contact__mass=mass, **scene)) for mass in ("consistent", "massless-tangential")}
    scatter = {}
    for mass, contact in found.items():
        assert (contact["motion"][1:13] == "stick").all()
        scatter[mass] = abs(np.diff(contact["tangential_force_x"][1:13].sum(axis=1), 2)).max()
    print(scatter)
    assert scatter["massless-tangential"] < 0.1 * scatter["consistent"]
    light = FLAT | {"contact__friction": 2, "time__scheme": "contact-stabilized", "initial__velocity": ["y < 0.01 ? 1 : 0", "0"]}
    energies = [simulate(contact__mass=mass, **light).steps["kinetic_energy"][0] for mass in found]
    assert energies[0] > 0.03 and abs(energies[1]) < ROUNDING, "that of the lower nodes along the plane"


@pytest.mark.key("initial.static")
@pytest.mark.parametrize("friction, push", ((0, 0), (0.3, 0), (0, 0.5)))
def test_static_start(friction: float, push: float, simulate: Runner) -> None:
    """The block bears its weight from the start, so that it stays or slides without vibrations."""
    block = {"contact__obstacle": BELT, "contact__friction": friction, "load": {"body": [str(push), "-1"]}}
    done = simulate(initial={"static": True}, **block)
    moved = done.field("displacement")[-1] - done.field("displacement")[0]
    near(moved, np.full(moved.shape, [push * T**2 / 2, 0]) + 0.0, 1e-8) if push else near(moved, 0 * moved, 1e-9)
    near(done.steps["contact_force_y"][1:], np.ones(30), 1e-6)
    assert done.manifest["effects"]["static start"] and done.steps["elastic_energy"][0] > 1e-3
    falls = simulate(initial={"static": False}, **block)
    assert falls.steps["elastic_energy"][0] == 0 and falls.steps["contact_force_y"].max() > 1.5, "the load comes all at once"


@pytest.mark.key("contact.obstacle.surface_velocity")
@pytest.mark.parametrize("velocity", (["2", "0"], ["2", "-7"]), ids=("along", "and across"))
def test_belt(velocity: list[str], simulate: Runner) -> None:
    """As in the frame of the belt, whose normal velocity has no effect."""
    moves = simulate(contact__friction=0.3, contact__obstacle=BELT | {"surface_velocity": velocity}, initial__velocity=["3", "0"], **RESTS)
    rests = simulate(contact__friction=0.3, initial__velocity=["1", "0"], **RESTS)
    for name in ("force", "tangential_force_x", "slip_velocity_x"):
        near(friction_of(moves)[name], friction_of(rests)[name], 1e-10)  # of displacements 30 times as large
    works = [done.steps["friction_work"] + done.steps["belt_work"] for done in (moves, rests)]
    near(moves.steps["friction_work"], rests.steps["friction_work"], 1e-10)
    near(moves.steps["belt_work"], 0.02 * 2 * moves.steps["contact_force_x"])
    assert (rests.steps["belt_work"] == 0).all() and abs(works[0] - works[1]).max() > 1e-3


@pytest.mark.key("contact.obstacle.surface_velocity", "contact.obstacle.point")
def test_obstacle_that_moves_along_its_surface(simulate: Runner) -> None:
    """Moves the body as a belt of this speed does, also one whose speed varies."""
    belt = simulate(contact__friction=0.3, contact__obstacle=BELT | {"surface_velocity": ["0.5 + 6*t", "0"]}, **RESTS)
    moves = simulate(contact__friction=0.3, **RESTS | {"contact__obstacle__point": ["0.5*t + 3*t^2", "0"]})
    assert belt.steps["slip"].max() > 0 and belt.momentum()[0] > 0.01
    same(belt, moves, 1e-9)
    near(belt.steps["belt_work"], moves.steps["belt_work"], 1e-9)
