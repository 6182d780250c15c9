# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of obstacles with mass: free flight against closed forms, and forces and moments of contact by the momentum that they give."""

from pathlib import Path

import numpy as np
import pytest
from harness import table
from regression.keys.runs import BLOCK, Run, Runner, near, optimize_in, same

PLATE = {"name": "plate", "shape": "half-space", "point": [0.25, -0.1], "normal": [0.3, 1]}
FAR = PLATE | {"point": [0, -100]}
STEP = 0.02
# Beside the block, which neither moves nor is reached.
FLIES = {"load__body": ["0", "0"], "initial__velocity": ["0", "0"], "output": {"every": 1, "probe": [{"name": "plate", "obstacle": "plate"}]}}
HIT = {"output": {"every": 1, "probe": [{"name": "plate", "obstacle": "plate"}]}}


def probes(done: Run) -> dict[str, np.ndarray]:
    return table(done.folder / "probes.csv")


def flight(simulate: Runner, **keys: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, Run]:
    """Times, displacements and velocities of the plate (steps × 2), without contact."""
    gravity = {"load__gravity": keys.pop("gravity")} if "gravity" in keys else {}
    done = simulate(contact__obstacle=FAR | keys, **FLIES, **gravity)
    assert done.steps["active"].max() == 0
    found = probes(done)
    y, v = (np.stack([found[f"plate.{name}_{c}"] for c in "xy"], axis=1) for name in ("displacement", "velocity"))
    return done.steps["time"], y, v, done


@pytest.mark.key("contact.obstacle.mass", "contact.obstacle.velocity")
def test_free_flight(simulate: Runner) -> None:
    t, y, v, done = flight(simulate, mass=2.5, velocity=[0.3, -0.4], gravity=[1.0, -2.0])
    near(y, np.outer(t, [0.3, -0.4]) + np.outer(t**2 / 2, [1, -2]), 1e-12)
    near(v, np.array([0.3, -0.4]) + np.outer(t, [1, -2]), 1e-12)
    near(done.steps["rigid_energy"], 2.5 / 2 * (v**2).sum(axis=1), 1e-12)
    assert done.manifest["effects"]["rigid body"] and abs(done.steps["energy_residual"]).max() < 1e-13 * done.steps["rigid_energy"].max()


@pytest.mark.key("contact.obstacle.force", "contact.obstacle.mass")
def test_force(simulate: Runner) -> None:
    """Its momentum is that of the force, exactly, also of one that varies."""
    t, _, v, _ = flight(simulate, mass=2.0, force=["3*t^2", "-1"])
    near(2 * v, np.stack([t**3, -t], axis=1), 1e-12)


@pytest.mark.key("contact.obstacle.components")
@pytest.mark.parametrize("components", (["x"], ["y"]), ids=str)
def test_components(components: list[str], simulate: Runner) -> None:
    t, y, _, _ = flight(simulate, mass=1.0, velocity=[0.5, 0.7], components=components)
    near(y, np.outer(t, [0.5 * ("x" in components), 0.7 * ("y" in components)]), 1e-12)


@pytest.mark.key("contact.obstacle.stiffness", "contact.obstacle.damping")
@pytest.mark.parametrize("k, c", ((50.0, 0.0), (50.0, 3.0), ([50.0, 20.0], [0.0, 2.0]), (0.0, [4.0, 1.0])), ids=str)
def test_springs(k: float | list[float], c: float | list[float], simulate: Runner) -> None:
    """The free vibration by the trapezoidal rule, which contact-implicit steps are, on each component."""
    m, v0 = 2.0, np.array([0.3, -0.4])
    _, y, v, done = flight(simulate, mass=m, velocity=list(v0), stiffness=k, damping=c)
    springs, dashpots = (np.broadcast_to(np.asarray(value, float), 2) for value in (k, c))
    for axis in range(2):
        A = np.array([[0, 1], [-springs[axis] / m, -dashpots[axis] / m]])
        once = np.linalg.solve(np.eye(2) - STEP / 2 * A, np.eye(2) + STEP / 2 * A)
        state = np.array([0, v0[axis]])
        for n in range(len(y)):
            near(np.array([y[n, axis], v[n, axis]]), state, 1e-11)
            state = once @ state
    energy = ((m * v**2 + springs * y**2) / 2).sum(axis=1)
    near(done.steps["rigid_energy"], energy, 1e-12)
    assert abs(done.steps["rigid_dissipation"][1:] + np.diff(energy)).max() < 1e-13 * energy.max()


def moment(done: Run, center: tuple[float, float]) -> float:
    """The angular momentum that the contact forces have given to the plate about a point."""
    contact = table(done.folder / "contact.csv")
    arm = np.stack([contact["x"] - center[0], contact["y"] - center[1]])
    force = -np.stack([contact["normal_x"], contact["normal_y"]]) * contact["force"]
    return float(STEP * (arm[0] * force[1] - arm[1] * force[0])[contact["step"] > 0].sum())


@pytest.mark.key("contact.obstacle.inertia", "contact.obstacle.mass_center")
@pytest.mark.parametrize("center", ([0.25, -0.1], [0.9, -0.5]), ids=str)
def test_turning(center: list[float], simulate: Runner) -> None:
    """The impulses of contact turn the plate about its centre of mass; by default this is the half-space's point."""
    more = {} if center == PLATE["point"] else {"mass_center": center}
    done = simulate(contact__obstacle=PLATE | {"mass": 3.0, "inertia": 0.7} | more, **HIT)
    assert done.steps["active"].max() > 0
    rate = probes(done)["plate.rate"]
    assert abs(rate[-1]) > 0.05
    near(0.7 * rate[-1], moment(done, tuple(center)), 1e-12)
    near(np.diff(probes(done)["plate.rotation"]), STEP * (rate[1:] + rate[:-1]) / 2, 1e-12)
    if more:
        same(done, simulate(done.folder / "scene.toml"))


@pytest.mark.key("contact.obstacle.mass")
def test_a_heavy_plate_is_an_obstacle_at_rest(simulate: Runner) -> None:
    """The motion tends to that of the obstacle at rest with the reciprocal mass."""
    rests = simulate(contact__obstacle=PLATE, **{"output": {"every": 1}})
    assert rests.steps["active"].max() > 0
    away = [abs(simulate(contact__obstacle=PLATE | {"mass": mass}, **HIT).field("displacement") - rests.field("displacement")).max()
            for mass in (1e3, 1e4, 1e5)]  # fmt: skip
    assert away[0] < 0.01
    near(np.array(away[1:]) / np.array(away[:-1]), np.array([0.1, 0.1]), 0.01)


@pytest.mark.key("contact.obstacle.mass")
def test_load_cell_without_mass(simulate: Runner) -> None:
    """A plate without mass on springs and dashpots: contact force, spring and dashpot balance in the mean of each step."""
    k, c = 400.0, 8.0
    done = simulate(BLOCK, contact__obstacle=PLATE | {"normal": [0, 1], "mass": 0.0, "stiffness": k, "damping": c}, **HIT)
    found = probes(done)
    y = found["plate.displacement_y"]
    held = (k * (y[1:] + y[:-1]) / 2 + c * np.diff(y) / STEP)[1:]
    assert done.steps["active"].max() > 0 and y.min() < -0.01
    near(held, -found["plate.force_y"][2:], 1e-10)


@pytest.mark.key("objective.obstacle")
def test_objective_of_its_translation(simulate: Runner) -> None:
    """J is the squared distance of the translation, by the trapezoidal rule, and of its last value."""
    desired = {"displacement": ["0.2*t", "-0.1 + x"]}  # x of its centre
    done = simulate(contact__obstacle=PLATE | {"mass": 3.0, "velocity": [0.1, 0]}, objective={"desired": desired, "obstacle": "plate",
                    "tracking": 2.0, "gamma": 3.0, "alpha": 0.0}, **HIT)  # fmt: skip
    found, t = probes(done), done.steps["time"]
    square = (found["plate.displacement_x"] - 0.2 * t) ** 2 + (found["plate.displacement_y"] + 0.1 - PLATE["point"][0]) ** 2
    J = done.manifest["objective"]
    near(J["tracking"], 2 * STEP / 4 * (square[1:] + square[:-1]).sum(), 1e-11)
    near(J["terminal"], 3 * square[-1], 1e-11)


MEASURED = [{"of": of, "obstacle": "plate", "component": "y", "file": "", "column": f"plate.{of}_y", "deviation": 1.0} for of in ("displacement", "velocity")]
GIVEN = {"mass": 3.0, "velocity": [0.1, 0.2], "stiffness": [4.0, 5.0], "damping": 0.5, "inertia": 0.7}
SOUGHT = {"mass": 3.0, "velocity y": 0.2, "stiffness x": 4.0, "damping": 0.5, "inertia": 0.7}


@pytest.mark.key("measurement.obstacle", "unknown.of", "unknown.component", "unknown.scale")
def test_measured_and_unknown(simulate: Runner, tmp_path: Path) -> None:
    """At the true values data that are its motion leave nothing; the unknowns are the scene's own numbers, on a logarithmic scale but for velocities."""
    more = {"contact__obstacle": PLATE | GIVEN, **HIT}
    made = simulate(**more)
    assert made.steps["active"].max() > 0
    file = {"file": str(made.folder / "probes.csv")}
    unknown = [dict(zip(("of", "component"), name.split())) for name in SOUGHT]
    plain = BLOCK.read_text()
    scene = tmp_path / "fit.toml"
    scene.write_text(plain[: plain.index("[control]")].replace("square.geo", str(BLOCK.parent / "square.geo")))
    done = optimize_in(tmp_path, scene, unknown=unknown, measurement=[one | file for one in MEASURED], **more)
    found = table(done.folder / "parameters.csv")
    assert dict(zip(found["name"], found["value"])) == pytest.approx({f"{name} of plate": value for name, value in SOUGHT.items()}, rel=1e-14)
    assert list(found["unit"]) == ["kg/m", "m/s", "N/m/m", "N s/m/m", "kg m²/m"]
    assert [one["scale"] for one in done.echo["unknown"]] == ["log", "linear", "log", "log", "log"]
    rows = table(done.folder / "measurements.csv")
    assert abs(rows["value"]).max() > 0.01 and abs(rows["residual"]).max() < 1e-12


@pytest.mark.key("contact.obstacle.mass")
@pytest.mark.parametrize("mass", (0.5, 1e4))
def test_restitution(mass: float, simulate: Runner) -> None:
    """Of an impact with a plate that flies: the ratio of the relative velocities of the centres of mass; with a heavy one that at rest."""
    flat = {"load__body": ["0", "0"], "material__viscosity": {"bulk": 0.5, "shear": 0.5}, "time__end": 1.0}
    probe = {"every": 1, "probe": [{"name": "plate", "obstacle": "plate"}, {"name": "body", "body": True}]}
    upright = PLATE | {"normal": [0, 1]}
    done = simulate(contact__obstacle=upright | {"mass": mass, "velocity": [0, 0.2]}, output=probe, **flat)
    found = probes(done)
    away = found["body.momentum_y"] - found["plate.velocity_y"]  # the body has the mass 1
    expected = -away[-1] / away[0]
    assert done.manifest["impact"]["restitution"] == pytest.approx(expected, rel=1e-9) and 0.1 < expected < 1
    assert "relative to the obstacle" in done.stdout
    if mass > 1e3:
        rests = simulate(contact__obstacle=upright, output={"every": 1}, initial__velocity=["0", "-1.2"], **flat)
        near(done.manifest["impact"]["restitution"], rests.manifest["impact"]["restitution"], 1e-3)


@pytest.mark.key("contact.obstacle.stiffness")
def test_no_restitution_of_springs(simulate: Runner) -> None:
    done = simulate(contact__obstacle=PLATE | {"mass": 3.0, "stiffness": 50.0}, time__end=1.2, **HIT)
    assert done.manifest["impact"]["restitution"] is None and "an obstacle moves, and not freely" in done.stdout
