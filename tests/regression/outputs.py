# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run leaves in its folder is what the documentation promises."""

import csv
import json
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import xml.etree.ElementTree as xml
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, HALF_DISC, SIGNORINI, SOURCE, attempt, captured, grids, signorini, table, toml  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

STEPS = ("step,time,kinetic_energy,elastic_energy,viscous_dissipation,external_work,contact_work,energy_residual,"
         "contact_force_x,contact_force_y,active,weak,min_gap,vi_iterations,momentum_residual,complementarity")  # fmt: skip
LAST = ",normal_force,load_work"
CONTACT = "step,time,x,y,gap,force,obstacle,normal_x,normal_y,area,pressure,status"
STEPS_IN_SPACE = STEPS.replace("contact_force_y,", "contact_force_y,contact_force_z,")
CONTACT_IN_SPACE = "step,time,x,y,z,gap,force,obstacle,normal_x,normal_y,normal_z,area,pressure,status"
HISTORY = ("iteration,objective,tracking,terminal,control_cost,gradient_norm,step_length,forward_sweeps,adjoint_sweeps,"
           "seconds,relative_distance_to_reference")  # fmt: skip


def header(file: Path) -> str:
    return file.read_text().splitlines()[0]


def optimize_folder(out: Path) -> None:
    signorini("optimize", HALF_DISC, out, mesh__size=2, optimizer__max_iterations=4, output__every=50)
    assert header(out / "steps.csv") == STEPS + ",tracking_error" + LAST
    assert header(out / "contact.csv") == CONTACT and header(out / "history.csv") == HISTORY
    peak = int(table(out / "steps.csv")["normal_force"].argmax())
    stored = 5e-5 * np.array(sorted({0, 50, 100, 150, peak}))  # the step of the largest force too
    assert {k: np.allclose(v, stored, rtol=1e-12, atol=0) for k, v in grids(out / "state.xdmf").items()} == {"displacement": True, "velocity": True}
    for name in ("control", "adjoint"):
        assert np.allclose(grids(out / f"{name}.xdmf")[name], stored[1:], rtol=1e-12, atol=0)
    run = json.loads((out / "run.json").read_text())
    contact, steps, history = (table(out / f"{name}.csv") for name in ("contact", "steps", "history"))
    assert len(contact["step"]) == len(stored) * run["candidates"] and len(steps["step"]) == 151
    assert run["stop_reason"] == "iteration limit" and len(history["iteration"]) == 5
    assert np.isclose(run["objective"]["value"], history["objective"][-1], rtol=1e-15, atol=0)
    assert np.allclose(history["tracking"] + history["terminal"] + history["control_cost"], history["objective"], rtol=1e-14, atol=0)
    assert (np.diff(history["objective"]) < 0).all()
    for phase in ("mesh", "assembly", "forward", "adjoint", "output"):
        assert run["timings"][phase]["seconds"] > 0 and run["timings"][phase]["calls"] >= 1
    assert run["timings"]["adjoint"]["calls"] == run["optimizer"]["adjoint_sweeps"] == history["adjoint_sweeps"][-1]
    tracking = 5e-5 * (steps["tracking_error"][1:-1] ** 2).sum() / 2 + 5e-5 / 4 * steps["tracking_error"][-1] ** 2
    assert np.isclose(tracking, history["tracking"][-1], rtol=1e-10, atol=0)
    print("optimize: tables, fields and run.json agree with each other")


def echoed_scene_repeats_the_run(out: Path) -> None:
    again = out.parent / "again"
    signorini("optimize", out / "scene.toml", again)
    a, b = table(out / "history.csv"), table(again / "history.csv")
    assert np.allclose(a["objective"], b["objective"], rtol=1e-12, atol=0)
    assert tomllib.loads((out / "scene.toml").read_text()) == tomllib.loads((again / "scene.toml").read_text())
    print("the echoed scene repeats the run")


def simulate_replaces_optimize(out: Path) -> None:
    """A folder describes one run: what the earlier one left and this one does not write is gone, if --replace says so."""
    (out / "notes.txt").write_text("mine")
    before = {path: path.read_bytes() for path in out.iterdir() if path.is_file()}
    refused = captured([str(SIGNORINI), "simulate", str(HALF_DISC), "--out", str(out), "--set", "mesh.size=2"])
    assert refused.returncode == 2 and refused.stdout == "" and len(refused.stderr.splitlines()) == 1, refused.stderr
    assert all(text in refused.stderr for text in ("history, control and adjoint", f"--out {out}-simulate", "--replace"))
    assert {path: path.read_bytes() for path in out.iterdir() if path.is_file()} == before
    done = captured([str(SIGNORINI), "simulate", str(HALF_DISC), "--out", str(out), "--replace", "--set", "mesh.size=2", "--set",
                     'control.initial=["0", "-1"]'])  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not (out / "history.csv").exists() and not (out / "control.h5").exists()
    assert (out / "notes.txt").read_text() == "mine", "a file that is not the program's was touched"
    assert header(out / "steps.csv") == STEPS + LAST
    assert "adjoint" not in json.loads((out / "run.json").read_text())["timings"]
    print("simulate: no adjoint, no history, nothing left of the earlier run")


def no_old_page_stays(folder: Path) -> None:
    """The next run removes the page and the figures that were made of the earlier one, and what is the user's stays."""
    page = '<!DOCTYPE html>\n<html><head><meta name="generator" content="signorini report"></head></html>'
    picture = b"\x89PNG\r\n\x1a\n....tEXtComment\0signorini report...."
    own = {"figures/own.png": picture.replace(b"signorini", b"another"), "figures/notes.txt": b"mine", "other.html": page.encode()}
    for verb, kept in (("simulate", own), ("optimize", {})):
        out = folder / f"page-{verb}"
        signorini("optimize", HALF_DISC, out, mesh__size=3, optimizer__max_iterations=0)
        (out / "figures").mkdir()
        for name, content in ({"report.html": page.encode(), "comparison.html": page.encode(), "figures/energy.png": picture} | kept).items():
            (out / name).write_bytes(content)
        done = captured([str(SIGNORINI), verb, str(HALF_DISC), "--out", str(out), "--set", "mesh.size=3", "--set",
                         "optimizer.max_iterations=0", *(["--replace"] if verb == "simulate" else [])])  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert not any((out / name).exists() for name in ("report.html", "comparison.html", "figures/energy.png"))
        assert {name: (out / name).read_bytes() for name in kept} == kept and (out / "figures").exists() == bool(kept)
        assert not [path for path in out.iterdir() if path.name.startswith(".")]
    (out / "report.html").write_text(page.replace("signorini report", "my own"))
    signorini("optimize", HALF_DISC, out, mesh__size=3, optimizer__max_iterations=0)
    assert (out / "report.html").exists()
    print("the page and figures of the earlier run are gone, and the user's stay")


def nodal_force_is_the_resultant(out: Path) -> None:
    contact, steps = table(out / "contact.csv"), table(out / "steps.csv")
    total = np.bincount(contact["step"].astype(int), contact["force"])
    assert total.max() > 0 and np.allclose(total, steps["contact_force_y"], rtol=1e-12, atol=0)
    print("nodal contact forces sum to the resultant")


def index_of_many_times(folder: Path) -> None:
    """The index of a long run says of each time what that of a short one says, and the values are the same."""
    for ranks in (1, 2):
        runs, texts, fields = {1: {}, 75: {}}, {}, {}
        for every in runs:
            out = folder / f"index-{ranks}-{every}"
            signorini("simulate", HALF_DISC, out, ranks, mesh__size=3, control__initial=["0", "-1"], output__every=every,
                      output__fields=["displacement", "velocity", "stress", "von_mises", "pressure"])  # fmt: skip
            runs[every] = grids(out / "state.xdmf")
            texts[every] = (out / "state.xdmf").read_text()
            with h5py.File(out / "state.h5") as file:
                fields[every] = {name: [values[:] for values in group.values()] for name, group in file["Function"].items()}
        whole, part = folder / f"index-{ranks}-1", folder / f"index-{ranks}-75"
        force = table(whole / "steps.csv")["normal_force"]
        peak = int(force.argmax())
        assert force[peak] > (1 + 1e-6) * np.delete(force, peak).max() and peak not in (0, 75, 150), "the largest force is stored anyway"
        stored = sorted((0, 75, 150, peak))
        assert {len(times) for times in runs[1].values()} == {151} and {len(times) for times in runs[75].values()} == {4}
        assert set(runs[1]) == set(runs[75]) == set(fields[75]) and len(runs[1]) == 5
        for name, values in fields[75].items():
            assert [runs[1][name][step] for step in stored] == runs[75][name] and abs(values[-1]).max() > 0, name
            rounding = 0 if ranks == 1 else 1e-10 * np.max([abs(value).max() for value in values])  # MUMPS adds in the order in which messages come
            assert all(np.abs(fields[1][name][step] - b).max() <= rounding for step, b in zip(stored, values)), name
        head, *every_time = re.split(r"(?=      <Grid )", re.sub(r"/\d{8}<", "<", texts[1]))
        head_of_few, *few_times = re.split(r"(?=      <Grid )", re.sub(r"/\d{8}<", "<", texts[75]))
        assert head == head_of_few and len(every_time) == 151 and set(few_times) <= set(every_time)
        all_rows, rows = table(whole / "contact.csv"), table(part / "contact.csv")
        own = np.isin(all_rows["step"], stored)
        assert json.loads((part / "run.json").read_text())["steps"]["stored"] == 4 and list(dict.fromkeys(rows["step"])) == stored
        for column in ("step", "x", "y", "gap", "force", "pressure"):
            off = np.abs(all_rows[column][own] - rows[column])
            assert np.max(off) <= (0 if ranks == 1 else 1e-10 * np.abs(rows[column]).max()), column
    print("the index of 151 times says of four what that of four does, with the step of the largest force, on one rank and two")


def largest_force_after_restart(folder: Path) -> None:
    """A search that stopped and went on stores what one without a stop does, the step of the largest force too, in all files."""
    given = {"mesh__size": 3, "output__every": 75, "optimizer__method": "lbfgs", "control__initial": ["0", "-1"]}
    once, twice = folder / "once", folder / "twice"
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
        assert np.allclose(grids(out / "state.xdmf")["displacement"], steps["time"][stored], rtol=1e-9, atol=0)
        for name in ("control", "adjoint"):
            assert np.allclose(grids(out / f"{name}.xdmf")[name], steps["time"][stored[1:]], rtol=1e-9, atol=0)
    assert (once / "contact.csv").read_bytes() == (twice / "contact.csv").read_bytes()
    print("the step of the largest force is stored, after a restart too")


def degree_two(folder: Path) -> None:
    out = folder / "degree2"
    signorini("simulate", HALF_DISC, out, mesh__size=3, mesh__degree=2, control__initial=["0", "-1"], output__every=150)
    with h5py.File(out / "state.h5") as file:
        nodes = file["Mesh/mesh/geometry"].shape[0]
        states = file["Function/displacement"]
        assert all(states[name].shape == (nodes, 3) for name in states)
        low = states[sorted(states)[-1]][:, 1].min()
    assert -0.9 < low < -0.7, f"lowest displacement {low}"
    print("degree 2: fields at the mesh's own nodes")


def half_ball(folder: Path) -> None:
    """In space: columns of three components, tetrahedra, and fields that are where their nodes are."""
    for degree, ranks in ((1, 1), (1, 3), (2, 2)):
        out = folder / f"ball-{degree}-{ranks}"
        signorini("optimize", HALF_BALL, out, ranks, mesh__size=4, mesh__degree=degree, time__step=2.5e-4, output__every=10,
                  optimizer__max_iterations=0, control__initial=["0", "0", "-1"])  # fmt: skip
        assert header(out / "steps.csv") == STEPS_IN_SPACE + ",tracking_error" + LAST
        assert header(out / "contact.csv") == CONTACT_IN_SPACE
        force = table(out / "steps.csv")["normal_force"]
        kept = sorted({0, 10, 20, 30, int(force.argmax())})
        stored = [2.5e-4 * step for step in kept]
        assert np.allclose(grids(out / "state.xdmf")["displacement"], stored, rtol=1e-12, atol=0)
        assert np.allclose(grids(out / "control.xdmf")["control"], stored[1:], rtol=1e-12, atol=0)
        topology = xml.parse(out / "state.xdmf").find(".//Topology")
        cells = json.loads((out / "run.json").read_text())["cells"]
        assert topology.get("TopologyType") == "Tetrahedron" and int(topology.get("NumberOfElements")) == cells
        contact, steps = table(out / "contact.csv"), table(out / "steps.csv")
        with h5py.File(out / "state.h5") as file:
            points, tetrahedra = file["Mesh/mesh/geometry"][:], file["Mesh/mesh/topology"][:]
            states = file["Function/displacement"]
            fields = [states[key][:] for key in sorted(states, key=lambda key: float(key.replace("_", ".")))]
        volume = abs(np.linalg.det(points[tetrahedra[:, 1:]] - points[tetrahedra[:, :1]])).sum() / 6
        assert len(tetrahedra) == cells and 0.96 < volume / (2 * np.pi / 3 * 15**3) < 1
        now = contact["step"] == 10
        assert (contact["force"][now] > 0).any(), "no contact at step 10: the comparison says little"
        places = np.column_stack([contact[axis][now] for axis in "xyz"])
        distance = np.linalg.norm(points[:, None] - places, axis=2)
        vertex, node = distance.min(axis=0) < 1e-9, distance.argmin(axis=0)  # degree 2 has candidates between vertices
        assert vertex.any() and (vertex.all() if degree == 1 else not vertex.all())
        gap = points[node, 2] + fields[kept.index(10)][node, 2] + 15.75
        assert np.allclose(gap[vertex], contact["gap"][now][vertex], rtol=0, atol=1e-9)
        assert abs(fields[-1][points[:, 2] > -1e-9]).max() < 1e-14, "the clamp moved"  # MUMPS and interpolation round
        assert np.isclose(contact["force"][now].sum(), steps["contact_force_z"][10], rtol=1e-12, atol=0)
    print("in space: z columns, tetrahedra, fields at their nodes, on several ranks and with degree 2 too")


def only_what_is_asked_for(folder: Path) -> None:
    """[output]: a field or table that is left out is not written, and none are for a timing run."""
    always, out = {"scene.toml", "run.json"}, folder / "part"
    for verb, fields, tables, files in (
        ("simulate", [], [], set()),
        ("simulate", ["velocity", "control"], ["contact", "history"], {"state.xdmf", "state.h5", "contact.csv", "surfaces.h5"}),
        ("optimize", ["control"], ["history"], {"control.xdmf", "control.h5", "history.csv", "checkpoint.h5"}),
        ("optimize", ["adjoint", "displacement"], ["steps"],
         {"adjoint.xdmf", "adjoint.h5", "state.xdmf", "state.h5", "surfaces.h5", "steps.csv", "checkpoint.h5"}),
        ("optimize", ["stress", "von_mises", "strain", "pressure"], [], {"state.xdmf", "state.h5", "surfaces.h5", "checkpoint.h5"}),
        ("simulate", ["pressure"], [], {"state.xdmf", "state.h5", "surfaces.h5", "checkpoint.h5"}),  # the search's, which stays
    ):  # fmt: skip
        signorini(verb, HALF_DISC, out, mesh__size=3, optimizer__max_iterations=1, output__fields=fields, output__tables=tables)
        assert {path.name for path in out.iterdir()} == always | files, f"{verb} {fields} {tables}: {list(out.iterdir())}"
        if "state.xdmf" in files:
            assert set(grids(out / "state.xdmf")) == set(fields) - {"control", "adjoint"}
        output = tomllib.loads((out / "scene.toml").read_text())["output"]
        assert set(output["fields"]) == set(fields) and set(output["tables"]) == set(tables)
        run = json.loads((out / "run.json").read_text())
        if verb == "optimize":  # the adjoint states cost one more sweep, where they are wanted
            assert run["counters"]["adjoint sweeps"] == run["optimizer"]["adjoint_sweeps"] + ("adjoint" in fields)
    print("[output]: fields and tables as asked for, or none")


def tables_one_by_one(folder: Path) -> None:
    """Each is what it is where all are written, and no other is there."""
    block, probe = SOURCE / "tests" / "data" / "block.toml", [{"name": "body", "body": True}]

    def run(out: Path, **tables: object) -> dict[str, list[dict[str, str]]]:
        signorini("optimize", block, out, optimizer__max_iterations=1, output={"fields": [], "probe": probe} | tables)
        return {file.stem: [{key: text for key, text in row.items() if key != "seconds"} for row in csv.DictReader(file.read_text().splitlines())]
                for file in out.glob("*.csv")}  # fmt: skip

    every = run(folder / "every-table")
    assert set(every) == {"steps", "contact", "obstacles", "probes", "history"} and all(every.values())
    for name in every:
        assert run(folder / f"table-{name}", tables=[name]) == {name: every[name]}, name
    print(f"[output]: {', '.join(every)} one by one")


def silence_and_plain_lines(folder: Path) -> None:
    quiet = attempt("simulate", HALF_DISC, folder / "q", mesh__size=3)
    assert "\r" not in quiet.stdout + quiet.stderr and "\033" not in quiet.stdout + quiet.stderr
    silent = captured([str(SIGNORINI), "simulate", str(HALF_DISC), "--quiet", "--out", str(folder / "s"), "--set", "mesh.size=3"])
    assert silent.returncode == 0 and silent.stdout == silent.stderr == ""
    info = signorini("info", HALF_DISC, mesh__size=3).stdout
    assert "viscosity" in info and "candidates: 7" in info
    block = signorini("info", SOURCE / "tests/data/block.toml").stdout
    on, off = block.split("\noff:")
    assert "initial velocity" in on and "traction" in off.splitlines()[0]
    parts = signorini("info", SOURCE / "tests/data/two-materials.toml").stdout
    assert "several materials" in parts.split("\noff:")[0] and "several materials" in off.splitlines()[0]
    timed = captured([str(SIGNORINI), "info", str(SOURCE / "tests/data/block.toml"), "--time", "30"]).stdout
    assert "30 steps timed:" in timed and "in contact" in timed and "adjoint" in timed
    print("piped output is plain, --quiet says nothing, info names the effects")


def nobody_reads(folder: Path) -> None:
    """Behind `| head` the program goes on without a word: a run writes its results."""
    command = f"'{SIGNORINI}' %s | head -n 1; echo ${{PIPESTATUS[0]}}"
    for words, status in ((f"info '{HALF_DISC}' --set mesh.size=3", 0), ("keys", 0), ("keys --json", 0),
                          (f"simulate '{HALF_DISC}' --set mesh.size=3 --out '{folder}/head'", 0),
                          (f"simulate '{HALF_DISC}' --set mesh.size=nothing 2>&1", 2)):  # fmt: skip
        done = captured(["bash", "-c", command % words])
        assert done.returncode == 0 and done.stderr == "" and done.stdout.splitlines()[-1] == str(status), (words, done)
        assert len(done.stdout.splitlines()) == 2, done.stdout
    assert json.loads((folder / "head" / "run.json").read_text())["stop_reason"] == "end of time"
    print("a pipe that is closed ends no run and is no error")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        out = folder / "out"
        optimize_folder(out)
        echoed_scene_repeats_the_run(out)
        simulate_replaces_optimize(out)
        nodal_force_is_the_resultant(out)
        no_old_page_stays(folder)
        index_of_many_times(folder)
        largest_force_after_restart(folder)
        degree_two(folder)
        half_ball(folder)
        only_what_is_asked_for(folder)
        tables_one_by_one(folder)
        silence_and_plain_lines(folder)
        nobody_reads(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
