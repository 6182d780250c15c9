# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of solvers, storage, checks and files: the effect of each on a small scene is that of docs/reference/keys.md."""

from pathlib import Path

import numpy as np
import pytest
from harness import attempt, signorini, table
from regression.keys.runs import BLOCK, ROUNDING, Run, Runner, near, optimize_in, same


@pytest.mark.key("solver.vi", "solver.linear", "solver.memory")
@pytest.mark.parametrize("overrides, linear", (
    ({"solver__vi": "full"}, "CHOLMOD"),
    ({"solver__linear": "direct", "solver__memory": 1.0}, "CHOLMOD"),
    ({"solver__linear": "auto", "solver__memory": 1.0}, "CG"),
    ({"solver__linear": "iterative"}, "CG"),
), ids=str)  # fmt: skip
def test_solvers(overrides: dict[str, object], linear: str, plain: Run, simulate: Runner) -> None:
    """Others come to the same motion by other solves."""
    other = simulate(**overrides)
    assert plain.steps["active"].max() > 0
    same(other, plain, 1e-8)  # of the iterations, over 30 steps
    assert other.manifest["solver"].startswith(linear)
    solves = [done.manifest["counters"]["solves with D"] for done in (plain, other)]
    assert (solves[0] == solves[1]) == (overrides.get("solver__linear") == "direct")


@pytest.fixture(scope="module")
def searches(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Run]:
    """One search with each storage of its states."""
    folder = tmp_path_factory.mktemp("searches")
    memory = optimize_in(folder, iterations=3)
    room = 4 * 8 * 2 * memory.manifest["unknowns"]  # bytes of two checkpoints, y and v, for two motions
    return {"memory": memory} | {name: optimize_in(folder, iterations=3, **settings) for name, settings in {
        "disk": {"trajectory__storage": "disk"},
        "little room": {"trajectory": {"storage": "checkpoints", "budget": room}},
        "more room": {"trajectory": {"storage": "checkpoints", "budget": 3 * room}},
    }.items()}  # fmt: skip


@pytest.mark.key("trajectory.storage", "trajectory.budget")
@pytest.mark.parametrize("storage", ("disk", "little room", "more room"))
def test_storage(storage: str, searches: dict[str, Run]) -> None:
    """States stored elsewhere or recomputed give the same search to the last bit."""
    usual, other = searches["memory"], searches[storage]
    for name in set(usual.history) - {"seconds"}:
        assert np.array_equal(usual.history[name], other.history[name]), name
    same(other, usual)
    timings = other.manifest["timings"]
    assert all(("states " + what in timings) == (storage == "disk") for what in ("written", "read"))
    assert ("states recomputed" in timings) == (storage != "disk")


@pytest.mark.key("trajectory.storage", "trajectory.budget")
def test_more_room_fewer_recomputed_steps(searches: dict[str, Run]) -> None:
    steps = {storage: done.manifest["counters"]["recomputed steps"] for storage, done in searches.items()}
    assert steps["memory"] == steps["disk"] == 0 < steps["more room"] < steps["little room"]
    assert "states written" not in searches["memory"].manifest["timings"]


@pytest.mark.key("check.control")
def test_check_control() -> None:
    own = signorini("check", BLOCK).stdout
    assert "contact included" in own and "Derivatives are checked at the reference control" in own
    away = attempt("check", BLOCK, check__control=["0", "9"])
    assert away.returncode == 1 and "Derivatives are checked at the control of [check]" in away.stdout and "never" in away.stdout


LESS_THAN_ROUNDING = {"run__tolerance": 1e-30}


@pytest.mark.key("run.invariants", "run.tolerance")
def test_invariants_warn(plain: Run, simulate: Runner) -> None:
    warned = simulate(run__invariants="warn", **LESS_THAN_ROUNDING)
    assert "run.tolerance" in warned.stdout and "run.tolerance" not in plain.stdout
    assert "invariants" in warned.manifest
    same(warned, plain)


@pytest.mark.key("run.invariants", "run.tolerance")
def test_invariants_stop(plain: Run, simulate: Runner, tmp_path: Path) -> None:
    stopped = attempt("simulate", BLOCK, tmp_path / "stopped", run__invariants="stop", **LESS_THAN_ROUNDING)
    assert stopped.returncode == 3 and "run.tolerance" in stopped.stderr and not (tmp_path / "stopped").exists()
    same(simulate(run__invariants="stop"), plain)


@pytest.mark.key("run.invariants", "run.tolerance")
def test_invariants_off(simulate: Runner) -> None:
    off = simulate(run__invariants="off", output__tables=[], **LESS_THAN_ROUNDING)
    assert "run.tolerance" not in off.stdout and "invariants" not in off.manifest


@pytest.mark.key("run.tolerance")
def test_check_uses_the_tolerance_of_invariants() -> None:
    assert attempt("check", BLOCK, **LESS_THAN_ROUNDING).returncode == 1


@pytest.mark.key("output.probe.name", "output.probe.point", "output.probe.on", "output.probe.obstacle", "output.probe.body")
def test_probes(plain: Run, simulate: Runner) -> None:
    done = simulate(output__probe=[{"name": "corner", "point": [0, 1]}, {"on": "body"}, {"name": "floor", "obstacle": "obstacle 1"},
                                   {"name": "all", "body": True}])  # fmt: skip
    found = table(done.folder / "probes.csv")
    assert not (plain.folder / "probes.csv").exists()
    corner = np.flatnonzero(abs(done.points[:, :2] - [0, 1]).max(axis=1) < ROUNDING)
    for field in ("displacement", "velocity"):
        near(np.column_stack([found[f"corner.{field}_{axis}"] for axis in "xy"]), done.field(field)[:, corner[0]])
    near(found["all.center_y"] - 0.5, found["probe 2.displacement_y"])
    near(found["all.momentum_x"], found["probe 2.velocity_x"])
    near(found["floor.force_y"], done.steps["contact_force_y"])
    near(found["floor.impulse_x"][-1], 0.02 * done.steps["contact_force_x"].sum())
    assert abs(found["all.rotation"]).max() > 0.01, "one corner comes first"


def stored_times(done: Run, every: int) -> int:
    """The number of those of the first and the last state, always, every so many between, and that of the largest force."""
    force, last = done.steps["normal_force"], len(done.steps["step"]) - 1
    assert force.max() > 0
    return len({*range(0, last, every), last, int(np.flatnonzero(force >= (1 - 1e-9) * force.max())[0])})


@pytest.mark.key("output.every")
@pytest.mark.parametrize("step, every", ((0.02, 1), (0.002, 1), (0.00125, 2), (0.0005, 5)))  # 30, 300, 480, 1200 steps
def test_default_of_output_every(step: float, every: int, simulate: Runner) -> None:
    done = simulate(time__step=step, output__fields=["displacement"])
    assert done.echo["output"]["every"] == every and len(done.field("displacement")) == stored_times(done, every)
    assert len(done.steps["step"]) == round(0.6 / step) + 1


@pytest.mark.key("output.every")
@pytest.mark.parametrize("every, times", ((1, (31,)), (7, (6, 7)), (30, (3,)), (100, (3,))), ids=str)
def test_output_every(every: int, times: tuple[int, ...], optimize: Runner) -> None:
    done = optimize(output__every=every)
    stored = stored_times(done, every)
    assert stored in times
    assert len(done.field("displacement")) == stored and len(done.field("control", "control")) == stored - 1
    assert len(table(done.folder / "contact.csv")["step"]) == 5 * stored and len(done.steps["step"]) == 31


ALWAYS = {"scene.toml", "run.json", "checkpoint.h5"}


@pytest.mark.key("output.fields", "output.tables")
@pytest.mark.parametrize("field", ("displacement", "velocity", "control", "adjoint", "strain", "stress", "von_mises", "pressure"))
def test_files_of_one_field(field: str, optimize: Runner) -> None:
    done = optimize(output__fields=[field], output__tables=[])
    name = field if field in ("control", "adjoint") else "state"
    surfaces = {"surfaces.h5", "obstacles.vtkhdf"} if name == "state" else set()
    assert {path.name for path in done.folder.iterdir()} == ALWAYS | {f"{name}.xdmf", f"{name}.h5", f"{name}.vtkhdf"} | surfaces
    assert abs(done.field(field, name)).max() > 0 or field == "control"


@pytest.mark.key("output.format")
@pytest.mark.parametrize("formats, files", (
    (["xdmf"], {"state.h5", "state.xdmf"}), (["vtkhdf"], {"state.vtkhdf", "obstacles.vtkhdf"}),
    (["vtkhdf", "xdmf"], {"state.h5", "state.xdmf", "state.vtkhdf", "obstacles.vtkhdf"}),
), ids=("xdmf", "vtkhdf", "both"))  # fmt: skip
def test_output_format(formats: list[str], files: set[str], simulate: Runner) -> None:
    """Values are those of any other format (regression/vtkhdf.py)."""
    done = simulate(output__format=formats, output__tables=[])
    assert {path.name for path in done.folder.iterdir()} == {"scene.toml", "run.json", "surfaces.h5"} | files
    assert done.echo["output"]["format"] == formats


@pytest.mark.key("output.fields", "output.tables")
def test_field_of_friction(simulate: Runner) -> None:
    """Traction along the plane, whose area-weighted sum is the force: exact for linear functions on the block's lower side."""
    done = simulate(contact__friction=0.3, output__fields=["friction"], output__tables=["steps", "contact"])
    traction, contact = done.field("friction"), table(done.folder / "contact.csv")
    assert {path.name for path in done.folder.iterdir()} == {"scene.toml", "run.json", "state.xdmf", "state.h5", "state.vtkhdf",
                                                             "surfaces.h5", "obstacles.vtkhdf", "steps.csv", "contact.csv"}  # fmt: skip
    assert abs(traction).max() > 0 and (traction[:, done.points[:, 1] > 0] == 0).all(), "none away from the candidates"
    for axis, component in enumerate("xy"):
        force = contact[f"tangential_force_{component}"].reshape(31, 5).sum(axis=1)
        lower = np.flatnonzero(done.points[:, 1] == 0)[np.argsort(done.points[done.points[:, 1] == 0, 0])]
        near((traction[:, lower, axis] * contact["area"][:5]).sum(axis=1), force, 1e-10)


@pytest.mark.key("output.fields", "output.tables")
@pytest.mark.parametrize("name", ("steps", "contact", "obstacles", "history"))
def test_files_of_one_table(name: str, optimize: Runner) -> None:
    done = optimize(output__fields=[], output__tables=[name])
    assert {path.name for path in done.folder.iterdir()} == ALWAYS | {f"{name}.csv"} | ({"surfaces.h5"} if name == "contact" else set())
