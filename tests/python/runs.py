# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs: tables and fields are those of the files, scratch folders go with their runs, the page is made."""

import csv
import gc
import html
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from common import SCENES, half_disc, raised, show

import signorini

KEPT = {"control.initial": ["0", "-0.9"], "output.fields": ["displacement", "velocity", "control", "adjoint", "stress"]}


def tables(run: signorini.Run) -> None:
    """Columns and values of every table are the file's."""
    names = [file.stem for file in run.folder.glob("*.csv")]
    assert {"steps", "contact", "history", "obstacles"} <= set(names), names
    for name in names:
        with open(run.folder / f"{name}.csv") as lines:
            rows = list(csv.reader(lines))
        table = run.table(name)
        assert list(table.columns) == rows[0] and len(table) == len(rows) - 1
        for column, text in zip(rows[0], rows[1]):
            found = table[column].iloc[0]
            assert str(found) == text or (text == "" and np.isnan(found)) or float(found) == float(text), (name, column, found, text)
    assert run.steps["time"].iloc[-1] > 0 and (run.contact["force"] >= 0).all() and len(run.history) == 4
    assert run.objective == run.history["objective"].iloc[-1]
    # Without pandas the same as structured arrays.
    pandas, sys.modules["pandas"] = sys.modules["pandas"], None
    try:
        plain = run.table("steps")
    finally:
        sys.modules["pandas"] = pandas
    assert plain.dtype.names == tuple(run.steps.columns) and np.array_equal(plain["time"], run.steps["time"])


def fields(run: signorini.Run, problem: signorini.Problem) -> None:
    """Values are those that h5py reads, and those that the problem computes."""
    for file, name in (("state", "displacement"), ("state", "velocity"), ("control", "control"), ("adjoint", "adjoint")):
        field = run.field(name)
        with h5py.File(run.folder / f"{file}.h5") as data:
            keys = sorted(data[f"Function/{name}"], key=lambda key: float(key.replace("_", ".")))
            stored = np.array([data[f"Function/{name}"][key][:] for key in keys])
        # Every step is stored, the adjoint state and the control of all but the initial state.
        steps = run.steps["time"].to_numpy()
        assert np.allclose(field.times, steps if file == "state" else steps[1:], rtol=1e-9, atol=0), name  # a table has ten digits
        with h5py.File(run.folder / f"{file}.h5") as data:
            assert np.array_equal(field.values, stored[..., :2]) and np.array_equal(field[-1], stored[-1, :, :2]), name
            assert np.array_equal(field.mesh.points, data["Mesh/mesh/geometry"][:]) and np.array_equal(run.mesh.cells, data["Mesh/mesh/topology"][:])
        assert field.values.shape == (len(field), len(run.mesh.points), 2) and not field.cellwise
    u = problem.gather(run_control(run, problem))
    states = problem.states(problem.scatter(u))
    last = run.field("displacement")[-1]
    nearest = [int(np.argmin(np.linalg.norm(run.mesh.points - point, axis=1))) for point in problem.nodes]
    off = np.abs(states[-1] - last[nearest]).max()
    show(f"the last displacement differs from the file's by {off:.1e} of {np.abs(last).max():.3g}")
    assert off < 1e-9 * np.abs(last).max()
    assert abs(problem.value(problem.scatter(u)) / run.objective - 1) < 1e-10
    assert "no field" in raised(signorini.SceneError, lambda: run.field("no field"))


def folders() -> None:
    """A scene is that of the time when it was read, a run that of its folder then, wherever one goes later."""
    ring = {"mesh.size": 8e-3, "time.end": 0.05}
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        first, second = Path(folder, "first").resolve(), Path(folder, "second").resolve()
        for place, gravity in ((first, -9.81), (second, -5.0)):
            place.mkdir()
            shutil.copy(SCENES.parent / "meshes" / "dropped-ring.geo", place)
            (place / "s.toml").write_text((SCENES / "drop-ring.toml").read_text().replace("../meshes/", "").replace("-9.81", str(gravity)))
        try:
            os.chdir(first)
            scene = signorini.Scene("s.toml", ring)
            run = scene.simulate("out")
            expected = signorini.read("out").steps
            os.chdir(second)
            assert not np.array_equal(signorini.Scene("s.toml", ring).simulate("out").steps.to_numpy(), expected.to_numpy())
            again = scene.simulate()
            assert run.folder == first / "out" and scene.file == first / "s.toml"
            assert np.array_equal(run.steps.to_numpy(), expected.to_numpy()) and np.array_equal(again.steps.to_numpy(), expected.to_numpy())
            # Edited, it is run as it was read; read again, as edited.
            before = scene.text
            shutil.copy(second / "s.toml", first)
            assert scene.simulate().scene == again.scene and scene.text == before and "-9.81" in before
            assert "-9.81" not in signorini.Scene(first / "s.toml").text
            # Another run there takes nothing from what the first has read, and gives it nothing.
            old = signorini.read(first / "out")
            field, warnings = old.field("displacement"), run.warnings
            shorter = signorini.Scene(second / "s.toml", {**ring, "time.end": 0.025}).simulate(first / "out")
            assert len(shorter.steps) < len(expected) == len(run.steps) and run.manifest["steps"]["done"] == len(expected) - 1
            assert old.warnings == warnings
            for late in (lambda: old.steps, lambda: old.scene, lambda: field[0], lambda: old.mesh, lambda: old.report(), lambda: old.table("contact")):
                assert "another run" in raised(signorini.SceneError, late)
            # A field keeps the scratch folder of its run.
            field = scene.simulate().field("displacement")
            gc.collect()
            assert field[0].shape == (len(field.mesh.points), 2)
        finally:
            os.chdir(here)


def run_control(run: signorini.Run, problem: signorini.Problem) -> np.ndarray:
    """The control that a run stored, as the problem's."""
    nearest = [int(np.argmin(np.linalg.norm(run.mesh.points - point, axis=1))) for point in problem.points]
    return run.field("control").values[:, nearest].reshape(problem.shape)


def main() -> None:
    folders()
    scene = half_disc(3, **{key.replace(".", "__"): one for key, one in KEPT.items()}, optimizer__max_iterations=3)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        run = scene.optimize(out)
        assert run.folder == out and run.manifest["verb"] == "optimize" and run.scene["mesh"]["size"] == 3
        assert run.manifest == json.loads((out / "run.json").read_text())
        tables(run)
        fields(run, scene.problem())
        assert (out / "scene.toml").read_text() == scene.text, "the scene as text is the run's"
        page = signorini.read(out).show()
        assert (out / "report.html").is_file() and page._repr_html_().startswith("<iframe")
        assert "parameters" in raised(signorini.SceneError, lambda: run.parameters)
        # A search is not overwritten by a motion unless that is asked for.
        assert "replace" in raised(signorini.SceneError, lambda: scene.simulate(out))
        assert scene.simulate(out, replace=True).manifest["verb"] == "simulate"
    run = scene.simulate()
    folder = run.folder
    assert folder.is_dir() and len(run.steps) == 151
    del run
    gc.collect()
    assert not folder.exists(), "a scratch folder goes with its run"
    assert half_disc(3).check()
    ring = signorini.Scene(SCENES / "drop-ring.toml", {"mesh.size": 8e-3, "time.end": 0.25}).simulate()
    assert ring.warnings == [one["message"] for one in ring.manifest["warnings"]] and ring.warnings, "nothing to be warned of"
    assert all(f"warning: {text}" in repr(ring) for text in ring.warnings)
    assert all(text in html.unescape(ring._repr_html_()) for text in ring.warnings)
    assert "files" not in sys.modules and "mesh" not in sys.modules, "names of scripts are not taken from users"
    fit = signorini.Scene(SCENES / "find-the-wall.toml", {"mesh.size": 8e-3, "optimizer.max_iterations": 2}).optimize()
    assert len(fit.parameters) == 2 and len(fit.measurements) > 10


main()
