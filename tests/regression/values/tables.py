# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number of a run's tables, of its stored fields and of run.json's `body` and `steps` is recomputed: by linear elements in numpy from
the stored displacements and velocities, by sums over tables, by formulas of docs/reference/files.md."""

import numpy as np
import pytest
from harness import stored
from recomputed import ROUNDING, TABLE, near, von_mises
from regression.values.runs import CENTRE, IMPACTS, RADIUS, SceneRun

STRESSES = pytest.mark.parametrize("run", ("thrown", "space"), indirect=True)
PROBES = pytest.mark.parametrize("run", ("thrown",), indirect=True)


# --- steps.csv --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("run", ("thrown", "bouncing", "space", "single"), indirect=True)
def test_energies(run: SceneRun) -> None:
    steps, body, y, v = run.steps, run.body, *(field.reshape(len(field), -1) for field in (run.y, run.v))
    near("kinetic energy", steps["kinetic_energy"], np.einsum("ki,ij,kj->k", v, body.M, v) / 2)
    near("elastic energy", steps["elastic_energy"], np.einsum("ki,ij,kj->k", y, body.A, y) / 2)
    moved, tau = np.diff(y, axis=0), np.diff(steps["time"])
    near("dissipation", steps["viscous_dissipation"], [0, *(np.einsum("ki,ij,kj->k", moved, body.B, moved) / tau)], TABLE)
    work = [0, *np.einsum("ki,ki->k", run.load.reshape(len(tau), -1), moved)]
    near("work of the load", steps["load_work"], work)
    near("external work", steps["external_work"], work)
    near("residual of the energy law", steps["energy_residual"], 0 * steps["time"], 1e-12, steps["kinetic_energy"].max())


class Candidates:
    """contact.csv as arrays (times × candidates), and the candidates' points, normals and nodes."""

    def __init__(self, run: SceneRun) -> None:
        rows, count = run.table("contact"), run.manifest["candidates"]
        assert len(rows["step"]) == count * len(run.y) and run.steps["active"].max() > 1
        self.each = {name: values.reshape(len(run.y), count) for name, values in rows.items()}
        self.points = np.stack([self.each[axis][0] for axis in run.axes], axis=1)
        self.normals = np.stack([self.each[f"normal_{axis}"][0] for axis in run.axes], axis=1)
        self.nodes = np.array([np.linalg.norm(run.body.points - point, axis=1).argmin() for point in self.points])
        self.force, self.gap = self.each["force"], self.each["gap"]
        self.closed = self.gap <= 1e-10 * np.sqrt(run.dim)

    def of(self, obstacle: str) -> np.ndarray:
        return self.each["obstacle"][0] == obstacle


def obstacles(run: SceneRun) -> list[str]:
    return [one["name"] for one in run.manifest["impact"]["obstacles"]]


@IMPACTS
def test_contact_in_steps(run: SceneRun) -> None:
    """The forces are those of the equation of a step."""
    force, steps, contact = run.forces(run.load), run.steps, Candidates(run)
    near("work of contact", steps["contact_work"], [0, *np.einsum("kid,kid->k", force, np.diff(run.y, axis=0))], TABLE)
    for c, axis in enumerate(run.axes):
        near(f"resultant {axis}", steps[f"contact_force_{axis}"], [0, *force[:, :, c].sum(axis=1)], TABLE, steps["normal_force"].max())
    near("sum of the moduli", steps["normal_force"], contact.force.sum(axis=1))
    near("the least gap", steps["min_gap"], contact.gap.min(axis=1))
    near("candidates in contact", steps["active"], [0, *contact.closed.sum(axis=1)[1:]])
    near("weak ones", steps["weak"], [0, *(contact.closed & ~(contact.force > 0)).sum(axis=1)[1:]])


# --- contact.csv and obstacles.csv ------------------------------------------------------------------------------------


@IMPACTS
def test_candidates(run: SceneRun) -> None:
    contact = Candidates(run)
    near("times of contact.csv", contact.each["time"], np.repeat(run.steps["time"][:, None], run.manifest["candidates"], axis=1))
    near("places of candidates", contact.points, run.body.points[contact.nodes])
    moved = np.einsum("kid,id->ki", run.y[:, contact.nodes], contact.normals)
    near("gaps follow the nodes", contact.gap - moved, np.repeat(contact.gap[:1], len(run.y), axis=0), ROUNDING, 1)


@IMPACTS
def test_contact_forces(run: SceneRun) -> None:
    """The nodal forces of a step are those of the table along its normals, and there are none elsewhere."""
    force, contact = run.forces(run.load), Candidates(run)
    expected = np.zeros_like(force)
    for i, node in enumerate(contact.nodes):
        expected[:, node] += contact.force[1:, i, None] * contact.normals[i]
    near("contact forces at all nodes", expected, force, TABLE)
    assert np.max(np.abs(force)) > 1 and not contact.force[0].any()


@IMPACTS
def test_areas_and_pressures(run: SceneRun) -> None:
    contact, count = Candidates(run), len(run.body.points)
    pressures = np.zeros((len(run.y), count))
    for name in obstacles(run):
        own = contact.of(name)
        areas = run.body.areas(np.isin(np.arange(count), contact.nodes[own]))[contact.nodes[own]]
        near("area of hat functions", contact.each["area"][0, own], areas, TABLE)
        near("pressure", contact.each["pressure"][:, own], contact.force[:, own] / areas, TABLE)
        np.maximum.at(pressures, (slice(None), contact.nodes[own]), contact.each["pressure"][:, own])
    near("field of the pressure", stored(run.path, "state", "pressure")[2][..., 0], pressures)


@IMPACTS
def test_obstacles(run: SceneRun) -> None:
    contact, rows = Candidates(run), run.table("obstacles")
    for name in obstacles(run):
        own, found = contact.of(name), {column: values[rows["obstacle"] == name] for column, values in rows.items()}
        near(f"rows of {name}", found["step"], np.arange(len(run.y)))
        near(f"times of {name}", found["time"], run.steps["time"])
        for c, axis in enumerate(run.axes):
            near(f"force {axis} of {name}", found[f"force_{axis}"], (contact.force[:, own] * contact.normals[own, c]).sum(axis=1), TABLE)
        near(f"sum of moduli of {name}", found["normal_force"], contact.force[:, own].sum(axis=1))
        near(f"in contact with {name}", found["active"], [0, *contact.closed[1:, own].sum(axis=1)])
        near(f"least gap of {name}", found["min_gap"], contact.gap[:, own].min(axis=1))


@pytest.mark.parametrize("run", ("thrown",), indirect=True)
def test_gaps_and_normals_at_the_start(run: SceneRun) -> None:
    contact = Candidates(run)
    floor, gap = contact.of("floor"), contact.gap[0]
    up, away = np.array([0.3, 1]) / np.hypot(0.3, 1), contact.points - CENTRE
    near("normals of the plane", contact.normals[floor], np.tile(up, (floor.sum(), 1)))
    near("gaps of the plane", gap[floor], (contact.points[floor] - [0, -0.05]) @ up)
    near("normals of the ball", contact.normals[~floor], (away / np.linalg.norm(away, axis=1)[:, None])[~floor])
    near("gaps of the ball", gap[~floor], np.linalg.norm(away, axis=1)[~floor] - RADIUS)


# --- Fields -----------------------------------------------------------------------------------------------------------


def stresses(run: SceneRun) -> np.ndarray:
    return np.array([run.body.stresses(y, v) for y, v in zip(run.y, run.v)])


@STRESSES
def test_strains_and_stresses(run: SceneRun) -> None:
    found = {name: stored(run.path, "state", name)[2] for name in ("strain", "stress", "von_mises")}
    strain, stress = np.array([run.body.strains(y) for y in run.y]), stresses(run)
    near("strains", found["strain"].reshape(strain.shape), strain)
    near("stresses", found["stress"].reshape(stress.shape), stress)
    near("von Mises stresses", found["von_mises"][..., 0], von_mises(stress))


@STRESSES
def test_largest_von_mises_stress(run: SceneRun) -> None:
    equivalent, found = von_mises(stresses(run)), run.manifest["largest_von_mises"]
    time, cell = np.unravel_index(equivalent.argmax(), equivalent.shape)
    near("the largest von Mises stress", found["value"], equivalent.max())
    near("its place", found["point"], run.body.points[run.body.cells[cell]].mean(axis=0))
    near("its time", found["time"], run.steps["time"][time])
    crossing, bounces = run.manifest["body"]["crossing_time"], run.manifest["impact"]["bounces"]
    assert found["at_onset"] == any(one["start"] <= found["time"] <= one["start"] + np.minimum(crossing, (one["end"] - one["start"]) / 4)
                                    for one in bounces), "whether it is a front's"  # fmt: skip


# --- probes.csv -------------------------------------------------------------------------------------------------------


@PROBES
def test_probe_of_the_body(run: SceneRun) -> None:
    body, found, y, v = run.body, run.table("probes"), *(field.reshape(len(field), -1) for field in (run.y, run.v))
    near("times of probes.csv", found["time"], run.steps["time"])
    mass, ones = body.density * body.volume.sum(), [np.tile(axis, len(body.points)) for axis in np.eye(run.dim)]
    centre = [one @ body.M @ body.points.ravel() / mass for one in ones]
    for c, axis in enumerate("xy"):
        near(f"centre of mass {axis}", found[f"body.center_{axis}"], centre[c] + y @ body.M @ ones[c] / mass)
        near(f"momentum {axis}", found[f"body.momentum_{axis}"], v @ body.M @ ones[c])
    turn = np.stack([centre[1] - body.points[:, 1], body.points[:, 0] - centre[0]], axis=1).ravel()
    near("rotation", found["body.rotation"], y @ body.M @ turn / (turn @ body.M @ turn))


@PROBES
@pytest.mark.parametrize("axis", (0, 1), ids=("x", "y"))
@pytest.mark.parametrize("name", ("displacement", "velocity"))
def test_probes_of_a_node_and_a_side(run: SceneRun, name: str, axis: int) -> None:
    points, found = run.body.points, run.table("probes")
    field = {"displacement": run.y, "velocity": run.v}[name][:, :, axis]
    tip, side = int(np.linalg.norm(points - [0, 1], axis=1).argmin()), run.body.areas(np.abs(points[:, 0]) < 1e-9)
    near(f"{name} of a node", found[f"tip.{name}_{'xy'[axis]}"], field[:, tip])
    near(f"{name} of a side", found[f"side.{name}_{'xy'[axis]}"], field @ side / side.sum())


@PROBES
@pytest.mark.parametrize("axis", "xy")
def test_probe_of_an_obstacle(run: SceneRun, axis: str) -> None:
    found, rows = run.table("probes"), run.table("obstacles")
    force = rows[f"force_{axis}"][rows["obstacle"] == "floor"]
    near("force of an obstacle", found[f"below.force_{axis}"], force)
    near("its impulse", found[f"below.impulse_{axis}"], np.cumsum(force) * 0.01)


# --- run.json ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("run", ("thrown",), indirect=True)
def test_body_and_steps(run: SceneRun) -> None:
    found, body = run.manifest, run.body
    speeds, extent = body.wave_speeds(), np.ptp(body.points, axis=0)
    near("mass", found["body"]["mass"], body.density * body.volume.sum())
    near("extent", found["body"]["extent"], extent)
    near("pressure waves", found["body"]["pressure_waves"], [speeds[0]] * 2)
    near("shear waves", found["body"]["shear_waves"], [speeds[1]] * 2)
    near("time of a wave across", found["body"]["crossing_time"], extent.max() / speeds[0])
    near("time of a wave across the least element", found["steps"]["wave_time"], body.heights.min() / speeds[0])  # the load varies
    assert (found["unknowns"], found["free_unknowns"], found["cells"]) == (body.points.size, body.points.size, len(body.cells))
    count = len(run.y)
    assert found["steps"] | {"wave_time": 0} == {"asked": count - 1, "done": count - 1, "stored": count, "wave_time": 0}


@pytest.mark.parametrize("run", ("bouncing",), indirect=True)
def test_wave_time_of_elements_in_contact(run: SceneRun) -> None:
    """A constant load makes no waves elsewhere."""
    below = [cell for cell, nodes in enumerate(run.body.cells) if (run.body.points[nodes][:, 1] < 1e-9).sum() == 2]
    near("least time of a wave across", run.manifest["steps"]["wave_time"], run.body.heights[below].min() / run.body.wave_speeds()[0])
