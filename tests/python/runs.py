# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs: tables and fields are those of the files, scratch folders go with their runs, the page is made."""

import csv
import gc
import html
import json
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from common import SCENES, half_disc

import signorini

FIELDS = ["displacement", "velocity", "control", "adjoint", "stress"]


@pytest.fixture(scope="module")
def scene() -> signorini.Scene:
    return half_disc(3, control__initial=["0", "-0.9"], output__fields=FIELDS, optimizer__max_iterations=3)


@pytest.fixture(scope="module")
def run(scene: signorini.Scene, tmp_path_factory: pytest.TempPathFactory) -> signorini.Run:
    return scene.optimize(tmp_path_factory.mktemp("run") / "out")


def test_manifest(scene: signorini.Scene, run: signorini.Run) -> None:
    assert run.folder.name == "out" and run.manifest["verb"] == "optimize" and run.scene["mesh"]["size"] == 3
    assert run.manifest == json.loads((run.folder / "run.json").read_text())
    assert (run.folder / "scene.toml").read_text() == scene.text, "the scene as text is the run's"


def test_tables(run: signorini.Run) -> None:
    """Columns and values of every table are the file's."""
    names = [file.stem for file in run.folder.glob("*.csv")]
    assert {"steps", "contact", "history", "obstacles"} <= set(names)
    for name in names:
        with open(run.folder / f"{name}.csv") as lines:
            rows = list(csv.reader(lines))
        table = run.table(name)
        assert list(table.columns) == rows[0] and len(table) == len(rows) - 1
        for column, text in zip(rows[0], rows[1]):
            found = table[column].iloc[0]
            assert str(found) == text or (text == "" and np.isnan(found)) or float(found) == float(text), (name, column)
    assert run.steps["time"].iloc[-1] > 0 and (run.contact["force"] >= 0).all() and len(run.history) == 4
    assert run.objective == run.history["objective"].iloc[-1]


def test_tables_without_pandas(run: signorini.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same as structured arrays."""
    steps = run.steps
    monkeypatch.setitem(sys.modules, "pandas", None)
    plain = run.table("steps")
    assert plain.dtype.names == tuple(steps.columns) and np.array_equal(plain["time"], steps["time"])


@pytest.mark.parametrize("file, name", (("state", "displacement"), ("state", "velocity"), ("control", "control"), ("adjoint", "adjoint")))
def test_field_of_the_file(run: signorini.Run, file: str, name: str) -> None:
    """Values are those that h5py reads."""
    field = run.field(name)
    with h5py.File(run.folder / f"{file}.h5") as data:
        keys = sorted(data[f"Function/{name}"], key=lambda key: float(key.replace("_", ".")))
        stored = np.array([data[f"Function/{name}"][key][:] for key in keys])
        assert np.array_equal(field.mesh.points, data["Mesh/mesh/geometry"][:])
        assert np.array_equal(run.mesh.cells, data["Mesh/mesh/topology"][:])
    # Every step is stored, the adjoint state and the control of all but the initial state.
    steps = run.steps["time"].to_numpy()
    assert np.allclose(field.times, steps if file == "state" else steps[1:], rtol=1e-9, atol=0), "a table has ten digits"
    assert np.array_equal(field.values, stored[..., :2]) and np.array_equal(field[-1], stored[-1, :, :2])
    assert field.values.shape == (len(field), len(run.mesh.points), 2) and not field.cellwise


def nearest(run: signorini.Run, points: np.ndarray) -> list[int]:
    return [int(np.argmin(np.linalg.norm(run.mesh.points - point, axis=1))) for point in points]


def test_field_of_the_problem(scene: signorini.Scene, run: signorini.Run) -> None:
    """Values are those that the problem computes."""
    problem = scene.problem()
    u = problem.scatter(problem.gather(run.field("control").values[:, nearest(run, problem.points)].reshape(problem.shape)))
    last = run.field("displacement")[-1]
    off = np.abs(problem.states(u)[-1] - last[nearest(run, problem.nodes)]).max()
    assert off < 1e-9 * np.abs(last).max()
    assert abs(problem.value(u) / run.objective - 1) < 1e-10


def test_what_a_run_lacks(run: signorini.Run) -> None:
    with pytest.raises(signorini.SceneError, match="no field"):
        run.field("no field")
    with pytest.raises(signorini.SceneError, match="parameters"):
        run.parameters  # noqa: B018 - read


def test_page(run: signorini.Run) -> None:
    page = signorini.read(run.folder).show()
    assert (run.folder / "report.html").is_file() and page._repr_html_().startswith("<iframe")
    assert "files" not in sys.modules and "mesh" not in sys.modules, "names of scripts are not taken from users"


def test_replace(scene: signorini.Scene, run: signorini.Run, tmp_path: Path) -> None:
    """A search is not overwritten by a motion unless that is asked for."""
    shutil.copytree(run.folder, tmp_path / "out")
    with pytest.raises(signorini.SceneError, match="replace"):
        scene.simulate(tmp_path / "out")
    assert scene.simulate(tmp_path / "out", replace=True).manifest["verb"] == "simulate"


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    """Two folders with a ring that falls, in the second with less gravity."""
    for name, gravity in (("first", -9.81), ("second", -5.0)):
        place = tmp_path / name
        place.mkdir()
        shutil.copy(SCENES.parent / "meshes" / "dropped-ring.geo", place)
        (place / "s.toml").write_text((SCENES / "drop-ring.toml").read_text().replace("../meshes/", "").replace("-9.81", str(gravity)))
    return tmp_path.resolve() / "first", tmp_path.resolve() / "second"


RING = {"mesh.size": 8e-3, "time.end": 0.05}


def test_change_of_folder(two: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene is that of the time when it was read, a run that of its folder then, wherever one goes later."""
    first, second = two
    monkeypatch.chdir(first)
    scene = signorini.Scene("s.toml", RING)
    run = scene.simulate("out")
    expected = signorini.read("out").steps
    monkeypatch.chdir(second)
    assert not np.array_equal(signorini.Scene("s.toml", RING).simulate("out").steps.to_numpy(), expected.to_numpy())
    again = scene.simulate()
    assert run.folder == first / "out" and scene.file == first / "s.toml"
    assert np.array_equal(run.steps.to_numpy(), expected.to_numpy()) and np.array_equal(again.steps.to_numpy(), expected.to_numpy())
    # Edited, it is run as it was read; read again, as edited.
    before = scene.text
    shutil.copy(second / "s.toml", first)
    assert scene.simulate().scene == again.scene and scene.text == before and "-9.81" in before
    assert "-9.81" not in signorini.Scene(first / "s.toml").text


def test_another_run_in_its_place(two: tuple[Path, Path]) -> None:
    """It takes nothing from what the first has read, and gives it nothing."""
    first, second = two
    run = signorini.Scene(first / "s.toml", RING).simulate(first / "out")
    steps, old = run.steps, signorini.read(first / "out")
    field, warnings = old.field("displacement"), run.warnings
    shorter = signorini.Scene(second / "s.toml", {**RING, "time.end": 0.025}).simulate(first / "out")
    assert len(shorter.steps) < len(steps) == len(run.steps) and run.manifest["steps"]["done"] == len(steps) - 1
    assert old.warnings == warnings
    for late in (lambda: old.steps, lambda: old.scene, lambda: field[0], lambda: old.mesh, lambda: old.report(),
                 lambda: old.table("contact")):  # fmt: skip
        with pytest.raises(signorini.SceneError, match="another run"):
            late()


def test_scratch_folder_of_a_field() -> None:
    """A field keeps the scratch folder of its run."""
    field = signorini.Scene(SCENES / "drop-ring.toml", RING).simulate().field("displacement")
    gc.collect()
    assert field[0].shape == (len(field.mesh.points), 2)


def test_scratch_folder_of_a_run(scene: signorini.Scene) -> None:
    run = scene.simulate()
    folder = run.folder
    assert folder.is_dir() and len(run.steps) == 151
    del run
    gc.collect()
    assert not folder.exists(), "a scratch folder goes with its run"


def test_check() -> None:
    assert half_disc(3).check()


def test_warnings() -> None:
    ring = signorini.Scene(SCENES / "drop-ring.toml", {**RING, "time.end": 0.25}).simulate()
    assert ring.warnings == [one["message"] for one in ring.manifest["warnings"]] and ring.warnings, "nothing to be warned of"
    assert all(f"warning: {text}" in repr(ring) for text in ring.warnings)
    assert all(text in html.unescape(ring._repr_html_()) for text in ring.warnings)


def test_tables_of_a_fit() -> None:
    fit = signorini.Scene(SCENES / "find-the-wall.toml", {"mesh.size": 8e-3, "optimizer.max_iterations": 2}).optimize()
    assert len(fit.parameters) == 2 and len(fit.measurements) > 10
