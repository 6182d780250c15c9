# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run leaves in its folder is what the documentation promises."""

import csv
import json
import re
import shutil
import subprocess
import tomllib
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness import HALF_BALL, HALF_DISC, SIGNORINI, SOURCE, captured, grids, signorini, table, toml

STEPS = ("step,time,kinetic_energy,elastic_energy,viscous_dissipation,external_work,contact_work,energy_residual,"
         "contact_force_x,contact_force_y,active,weak,min_gap,vi_iterations,momentum_residual,complementarity")  # fmt: skip
LAST = ",normal_force,load_work"
CONTACT = "step,time,x,y,gap,force,obstacle,normal_x,normal_y,area,pressure,status"
STEPS_IN_SPACE = STEPS.replace("contact_force_y,", "contact_force_y,contact_force_z,")
CONTACT_IN_SPACE = "step,time,x,y,z,gap,force,obstacle,normal_x,normal_y,normal_z,area,pressure,status"
HISTORY = ("iteration,objective,tracking,terminal,control_cost,gradient_norm,step_length,forward_sweeps,adjoint_sweeps,"
           "seconds,relative_distance_to_reference")  # fmt: skip
BLOCK = SOURCE / "tests" / "data" / "block.toml"


def header(file: Path) -> str:
    return file.read_text().splitlines()[0]


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def near(found: object, expected: object, relative: float) -> None:
    assert found == pytest.approx(expected, rel=relative, abs=0)


# --- A search, and a simulation in its folder -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def optimized(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("optimized") / "out"
    signorini("optimize", HALF_DISC, out, mesh__size=2, optimizer__max_iterations=4, output__every=50)
    return out


def test_columns(optimized: Path) -> None:
    assert header(optimized / "steps.csv") == STEPS + ",tracking_error" + LAST
    assert header(optimized / "contact.csv") == CONTACT and header(optimized / "history.csv") == HISTORY
    assert len(table(optimized / "steps.csv")["step"]) == 151


def test_stored_times(optimized: Path) -> None:
    """Steps of output.every and the step of the largest force are stored."""
    peak = int(table(optimized / "steps.csv")["normal_force"].argmax())
    stored = 5e-5 * np.array(sorted({0, 50, 100, 150, peak}))
    states = grids(optimized / "state.xdmf")
    assert set(states) == {"displacement", "velocity"}
    for times in states.values():
        near(times, stored, 1e-12)
    for name in ("control", "adjoint"):
        near(grids(optimized / f"{name}.xdmf")[name], stored[1:], 1e-12)
    assert len(table(optimized / "contact.csv")["step"]) == len(stored) * manifest(optimized)["candidates"]


def test_history(optimized: Path) -> None:
    run, history, steps = manifest(optimized), table(optimized / "history.csv"), table(optimized / "steps.csv")
    assert run["stop_reason"] == "iteration limit" and len(history["iteration"]) == 5
    near(run["objective"]["value"], history["objective"][-1], 1e-15)
    near(history["tracking"] + history["terminal"] + history["control_cost"], history["objective"], 1e-14)
    assert (np.diff(history["objective"]) < 0).all()
    error = steps["tracking_error"] ** 2
    near(5e-5 * error[1:-1].sum() / 2 + 5e-5 / 4 * error[-1], history["tracking"][-1], 1e-10)


def test_timings(optimized: Path) -> None:
    run = manifest(optimized)
    for phase in ("mesh", "assembly", "forward", "adjoint", "output"):
        assert run["timings"][phase]["seconds"] > 0 and run["timings"][phase]["calls"] >= 1, phase
    sweeps = table(optimized / "history.csv")["adjoint_sweeps"][-1]
    assert run["timings"]["adjoint"]["calls"] == run["optimizer"]["adjoint_sweeps"] == sweeps


def test_echoed_scene_repeats_the_run(optimized: Path, tmp_path: Path) -> None:
    again = tmp_path / "again"
    signorini("optimize", optimized / "scene.toml", again)
    near(table(again / "history.csv")["objective"], table(optimized / "history.csv")["objective"], 1e-12)
    assert tomllib.loads((optimized / "scene.toml").read_text()) == tomllib.loads((again / "scene.toml").read_text())


def simulate_into(out: Path, *options: str) -> subprocess.CompletedProcess:
    return captured([str(SIGNORINI), "simulate", str(HALF_DISC), "--out", str(out), "--set", "mesh.size=2", *options])


def files(out: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in out.iterdir() if path.is_file()}


def test_refused_in_the_folder_of_a_search(optimized: Path) -> None:
    before, refused = files(optimized), simulate_into(optimized)
    assert refused.returncode == 2 and refused.stdout == "" and len(refused.stderr.splitlines()) == 1
    assert all(text in refused.stderr for text in ("history, control and adjoint", f"--out {optimized}-simulate", "--replace"))
    assert files(optimized) == before


@pytest.fixture(scope="module")
def replaced(optimized: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulation that took the place of the search."""
    out = tmp_path_factory.mktemp("replaced") / "out"
    shutil.copytree(optimized, out)
    (out / "notes.txt").write_text("mine")
    done = simulate_into(out, "--replace", "--set", 'control.initial=["0", "-1"]')
    assert done.returncode == 0, done.stderr
    return out


def test_replaced_folder_describes_one_run(replaced: Path) -> None:
    """The files of the earlier one that this one does not write are gone."""
    assert not (replaced / "history.csv").exists() and not (replaced / "control.h5").exists()
    assert (replaced / "notes.txt").read_text() == "mine", "a file that is not the program's was touched"
    assert header(replaced / "steps.csv") == STEPS + LAST
    assert "adjoint" not in manifest(replaced)["timings"]


def test_nodal_forces_sum_to_the_resultant(replaced: Path) -> None:
    contact, steps = table(replaced / "contact.csv"), table(replaced / "steps.csv")
    total = np.bincount(contact["step"].astype(int), contact["force"])
    assert total.max() > 0
    near(total, steps["contact_force_y"], 1e-12)


# --- Pages and figures of the earlier run -----------------------------------------------------------------------------

PAGE = '<!DOCTYPE html>\n<html><head><meta name="generator" content="signorini report"></head></html>'
PICTURE = b"\x89PNG\r\n\x1a\n....tEXtComment\0signorini report...."
OWN = {"figures/own.png": PICTURE.replace(b"signorini", b"another"), "figures/notes.txt": b"mine", "other.html": PAGE.encode()}


@pytest.fixture
def searched(tmp_path: Path) -> Path:
    out = tmp_path / "out"
    signorini("optimize", HALF_DISC, out, mesh__size=3, optimizer__max_iterations=0)
    return out


@pytest.mark.parametrize("verb, kept", (("simulate", OWN), ("optimize", {})), ids=("simulate", "optimize"))
def test_no_old_page_stays(searched: Path, verb: str, kept: dict[str, bytes]) -> None:
    """The next run removes the page and the figures that were made of the earlier one, and what is the user's stays."""
    (searched / "figures").mkdir()
    for name, content in ({"report.html": PAGE.encode(), "comparison.html": PAGE.encode(), "figures/energy.png": PICTURE} | kept).items():
        (searched / name).write_bytes(content)
    signorini(verb, HALF_DISC, searched, mesh__size=3, optimizer__max_iterations=0)
    assert not any((searched / name).exists() for name in ("report.html", "comparison.html", "figures/energy.png"))
    assert {name: (searched / name).read_bytes() for name in kept} == kept and (searched / "figures").exists() == bool(kept)
    assert not [path for path in searched.iterdir() if path.name.startswith(".")]


def test_page_of_another_program_stays(searched: Path) -> None:
    (searched / "report.html").write_text(PAGE.replace("signorini report", "my own"))
    signorini("optimize", HALF_DISC, searched, mesh__size=3, optimizer__max_iterations=0)
    assert (searched / "report.html").exists()


# --- The times that are stored ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Indexed:
    """A run's files: the index as text and as times of each field, and the fields."""

    out: Path
    text: str
    times: dict[str, list[float]]
    fields: dict[str, list[np.ndarray]]


@pytest.fixture(scope="module", params=(1, 2), ids=("1 rank", "2 ranks"))
def ranks(request: pytest.FixtureRequest) -> int:
    return request.param


@pytest.fixture(scope="module")
def indexed(ranks: int, tmp_path_factory: pytest.TempPathFactory) -> tuple[Indexed, Indexed, list[int]]:
    """A run that stores every step, one that stores few, and these steps."""
    runs = []
    for every in (1, 75):
        out = tmp_path_factory.mktemp("index") / "out"
        signorini("simulate", HALF_DISC, out, ranks, mesh__size=3, control__initial=["0", "-1"], output__every=every,
                  output__fields=["displacement", "velocity", "stress", "von_mises", "pressure"])  # fmt: skip
        with h5py.File(out / "state.h5") as file:
            fields = {name: [values[:] for values in group.values()] for name, group in file["Function"].items()}
        runs.append(Indexed(out, (out / "state.xdmf").read_text(), grids(out / "state.xdmf"), fields))
    force = table(runs[0].out / "steps.csv")["normal_force"]
    peak = int(force.argmax())
    assert force[peak] > (1 + 1e-6) * np.delete(force, peak).max() and peak not in (0, 75, 150), "the largest force is stored anyway"
    return *runs, sorted((0, 75, 150, peak))


def test_index_of_many_times(indexed: tuple) -> None:
    """The index of a long run has for each time what that of a short one has."""
    whole, part, _ = indexed
    assert {len(times) for times in whole.times.values()} == {151} and {len(times) for times in part.times.values()} == {4}
    head, *every_time = re.split(r"(?=      <Grid )", re.sub(r"/\d{8}<", "<", whole.text))
    head_of_few, *few_times = re.split(r"(?=      <Grid )", re.sub(r"/\d{8}<", "<", part.text))
    assert head == head_of_few and len(every_time) == 151 and set(few_times) <= set(every_time)
    assert manifest(part.out)["steps"]["stored"] == 4


def test_fields_at_few_times(indexed: tuple, ranks: int) -> None:
    """They are those of every time."""
    whole, part, stored = indexed
    assert set(whole.times) == set(part.times) == set(part.fields) and len(whole.times) == 5
    for name, values in part.fields.items():
        assert [whole.times[name][step] for step in stored] == part.times[name] and abs(values[-1]).max() > 0, name
        # MUMPS adds in the order in which messages come.
        rounding = 0 if ranks == 1 else 1e-10 * np.max([abs(value).max() for value in values])
        assert all(np.abs(whole.fields[name][step] - b).max() <= rounding for step, b in zip(stored, values)), name


@pytest.mark.parametrize("column", ("step", "x", "y", "gap", "force", "pressure"))
def test_contact_at_few_times(indexed: tuple, ranks: int, column: str) -> None:
    whole, part, stored = indexed
    every_row, rows = table(whole.out / "contact.csv"), table(part.out / "contact.csv")
    assert list(dict.fromkeys(rows["step"])) == stored
    off = np.abs(every_row[column][np.isin(every_row["step"], stored)] - rows[column])
    assert np.max(off) <= (0 if ranks == 1 else 1e-10 * np.abs(rows[column]).max())


def test_largest_force_after_restart(tmp_path: Path) -> None:
    """A search that stopped and was resumed stores what one without a stop does, the step of the largest force too, in all files."""
    given = {"mesh__size": 3, "output__every": 75, "optimizer__method": "lbfgs", "control__initial": ["0", "-1"]}
    once, twice = tmp_path / "once", tmp_path / "twice"
    signorini("optimize", HALF_DISC, once, optimizer__max_iterations=3, **given)
    signorini("optimize", HALF_DISC, twice, optimizer__max_iterations=1, **given)
    command = [str(SIGNORINI), "optimize", str(HALF_DISC), "--out", str(twice), "--resume", "--quiet"]
    for key, value in (given | {"optimizer__max_iterations": 3}).items():
        command += ["--set", f"{key.replace('__', '.')}={toml(value)}"]
    subprocess.run(command, check=True)
    steps = table(once / "steps.csv")
    peak = int(steps["normal_force"].argmax())
    assert steps["normal_force"][peak] > 0 and peak not in (0, 75, 150), "the largest force is stored anyway"
    stored = sorted((0, 75, 150, peak))
    for out in (once, twice):
        assert list(dict.fromkeys(table(out / "contact.csv")["step"])) == stored, out
        near(grids(out / "state.xdmf")["displacement"], steps["time"][stored], 1e-9)
        for name in ("control", "adjoint"):
            near(grids(out / f"{name}.xdmf")[name], steps["time"][stored[1:]], 1e-9)
    assert (once / "contact.csv").read_bytes() == (twice / "contact.csv").read_bytes()


# --- Degree two and space ---------------------------------------------------------------------------------------------


def test_fields_of_degree_two(tmp_path: Path) -> None:
    """They are at the mesh's own nodes."""
    signorini("simulate", HALF_DISC, tmp_path / "out", mesh__size=3, mesh__degree=2, control__initial=["0", "-1"], output__every=150)
    with h5py.File(tmp_path / "out" / "state.h5") as file:
        nodes = file["Mesh/mesh/geometry"].shape[0]
        states = file["Function/displacement"]
        assert all(states[name].shape == (nodes, 3) for name in states)
        assert -0.9 < states[sorted(states)[-1]][:, 1].min() < -0.7


@dataclass(frozen=True)
class Ball:
    """A run of the half ball, its stored steps, mesh and displacements."""

    out: Path
    degree: int
    stored: list[int]
    points: np.ndarray
    tetrahedra: np.ndarray
    displacement: list[np.ndarray]


@pytest.fixture(scope="module", params=((1, 1), (1, 3), (2, 2)), ids=lambda case: "degree {}, {} ranks".format(*case))
def ball(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Ball:
    (degree, ranks), out = request.param, tmp_path_factory.mktemp("ball") / "out"
    signorini("optimize", HALF_BALL, out, ranks, mesh__size=4, mesh__degree=degree, time__step=2.5e-4, output__every=10,
              optimizer__max_iterations=0, control__initial=["0", "0", "-1"])  # fmt: skip
    stored = sorted({0, 10, 20, 30, int(table(out / "steps.csv")["normal_force"].argmax())})
    with h5py.File(out / "state.h5") as file:
        points, tetrahedra = file["Mesh/mesh/geometry"][:], file["Mesh/mesh/topology"][:]
        states = file["Function/displacement"]
        displacement = [states[key][:] for key in sorted(states, key=lambda key: float(key.replace("_", ".")))]
    return Ball(out, degree, stored, points, tetrahedra, displacement)


def test_columns_and_times_in_space(ball: Ball) -> None:
    assert header(ball.out / "steps.csv") == STEPS_IN_SPACE + ",tracking_error" + LAST
    assert header(ball.out / "contact.csv") == CONTACT_IN_SPACE
    times = [2.5e-4 * step for step in ball.stored]
    near(grids(ball.out / "state.xdmf")["displacement"], times, 1e-12)
    near(grids(ball.out / "control.xdmf")["control"], times[1:], 1e-12)


def test_mesh_in_space(ball: Ball) -> None:
    topology, cells = xml.parse(ball.out / "state.xdmf").find(".//Topology"), manifest(ball.out)["cells"]
    assert topology.get("TopologyType") == "Tetrahedron" and int(topology.get("NumberOfElements")) == cells
    volume = abs(np.linalg.det(ball.points[ball.tetrahedra[:, 1:]] - ball.points[ball.tetrahedra[:, :1]])).sum() / 6
    assert len(ball.tetrahedra) == cells and 0.96 < volume / (2 * np.pi / 3 * 15**3) < 1


def test_gaps_and_forces_in_space(ball: Ball) -> None:
    contact, steps = table(ball.out / "contact.csv"), table(ball.out / "steps.csv")
    now = contact["step"] == 10
    assert (contact["force"][now] > 0).any(), "no contact at step 10: the comparison says little"
    places = np.column_stack([contact[axis][now] for axis in "xyz"])
    distance = np.linalg.norm(ball.points[:, None] - places, axis=2)
    vertex, node = distance.min(axis=0) < 1e-9, distance.argmin(axis=0)  # degree 2 has candidates between vertices
    assert vertex.any() and (vertex.all() if ball.degree == 1 else not vertex.all())
    gap = ball.points[node, 2] + ball.displacement[ball.stored.index(10)][node, 2] + 15.75
    assert gap[vertex] == pytest.approx(contact["gap"][now][vertex], rel=0, abs=1e-9)
    near(contact["force"][now].sum(), steps["contact_force_z"][10], 1e-12)


def test_clamp_in_space_does_not_move(ball: Ball) -> None:
    assert abs(ball.displacement[-1][ball.points[:, 2] > -1e-9]).max() < 1e-14  # MUMPS and interpolation round


# --- [output] ---------------------------------------------------------------------------------------------------------

STATE = {"state.xdmf", "state.h5", "state.vtkhdf", "surfaces.h5", "obstacles.vtkhdf"}
ASKED = (  # one after the other in one folder
    ("simulate", [], [], set()),
    ("simulate", ["velocity", "control"], ["contact", "history"], STATE | {"contact.csv"}),
    ("optimize", ["control"], ["history"], {"control.xdmf", "control.h5", "control.vtkhdf", "history.csv", "checkpoint.h5"}),
    ("optimize", ["adjoint", "displacement"], ["steps"], STATE | {"adjoint.xdmf", "adjoint.h5", "adjoint.vtkhdf", "steps.csv", "checkpoint.h5"}),
    ("optimize", ["stress", "von_mises", "strain", "pressure"], [], STATE | {"checkpoint.h5"}),
    ("simulate", ["pressure"], [], STATE | {"checkpoint.h5"}),  # the search's, which stays
)


@pytest.mark.parametrize("number", range(len(ASKED)))
def test_only_what_is_asked_for(number: int, tmp_path: Path) -> None:
    """A field or table that is left out is not written, and none are for a timing run; those of the run before are gone."""
    out = tmp_path / "out"
    for verb, fields, tables, expected in ASKED[number - 1 if number else 0 : number + 1]:
        signorini(verb, HALF_DISC, out, mesh__size=3, optimizer__max_iterations=1, output__fields=fields, output__tables=tables)
    assert {path.name for path in out.iterdir()} == {"scene.toml", "run.json"} | expected
    if "state.xdmf" in expected:
        assert set(grids(out / "state.xdmf")) == set(fields) - {"control", "adjoint"}
    output = tomllib.loads((out / "scene.toml").read_text())["output"]
    assert set(output["fields"]) == set(fields) and set(output["tables"]) == set(tables)
    if verb == "optimize":  # the adjoint states cost one more sweep, where they are wanted
        run = manifest(out)
        assert run["counters"]["adjoint sweeps"] == run["optimizer"]["adjoint_sweeps"] + ("adjoint" in fields)


TABLES = ("steps", "contact", "obstacles", "probes", "history")


def tables_of(out: Path, **tables: object) -> dict[str, list[dict[str, str]]]:
    """The tables that a search writes, by name, without seconds."""
    output = {"fields": [], "probe": [{"name": "body", "body": True}]}
    signorini("optimize", BLOCK, out, optimizer__max_iterations=1, output=output | tables)
    rows = {file.stem: list(csv.DictReader(file.read_text().splitlines())) for file in out.glob("*.csv")}
    return {name: [{key: text for key, text in row.items() if key != "seconds"} for row in ones] for name, ones in rows.items()}


@pytest.fixture(scope="module")
def every_table(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[dict[str, str]]]:
    return tables_of(tmp_path_factory.mktemp("tables") / "out")


def test_every_table(every_table: dict) -> None:
    assert set(every_table) == set(TABLES) and all(every_table.values())


@pytest.mark.parametrize("name", TABLES)
def test_one_table(every_table: dict, name: str, tmp_path: Path) -> None:
    """It is what it is where all are written, and no other is there."""
    assert tables_of(tmp_path / "out", tables=[name]) == {name: every_table[name]}
