# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored fields in VTKHDF: VTK's reader finds the bits that the HDF5 file has, at every time, and obstacles where they are."""

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest
from harness import SOURCE, attempt, grids, signorini, stored, table

from signorini.post.run_folder import RunFolder

DATA = SOURCE / "tests" / "data"
BLOCK, CUBE = DATA / "block.toml", DATA / "cube.toml"
ONE = ["vtkhdf"]
CELLS = ["strain", "stress", "von_mises"]
NODES = ["displacement", "velocity", "pressure"]
FIELDS = {"output__fields": [*NODES, *CELLS, "control", "adjoint"], "output__every": 7}
WAVE = {"shape": "signed-distance", "distance": "y + 0.12 + 0.05*sin(3*x + 40*t)"}
TIP = {"shape": "half-space", "point": [0, "-0.1 + 0.2*t"], "normal": [0.3, 1]}


@dataclass
class Read:
    """What a reader found in a file."""

    times: np.ndarray
    arrays: dict[str, np.ndarray]

    def __call__(self, name: str, time: int) -> np.ndarray:
        return self.arrays[f"{time}.{name}"]

    @property
    def names(self) -> set[str]:
        return {key.partition(".")[2] for key in self.arrays if key.startswith("0.")}


def attempt_to_read(file: Path, out: Path, *tool: str) -> subprocess.CompletedProcess:
    script = SOURCE / "tests" / "vtk_reader.py"
    return subprocess.run([sys.executable, script, file, out, *tool], capture_output=True, text=True)


def read(file: Path, scratch: Path, *tool: str) -> Read:
    out = scratch / f"{file.stem}-{len(list(scratch.iterdir()))}.npz"
    done = attempt_to_read(file, out, *tool)
    assert done.returncode == 0 and not done.stderr, done.stderr
    with np.load(out) as data:
        arrays = dict(data)
    return Read(arrays.pop("times"), arrays)


RUNS = {
    "plane": ("optimize", BLOCK, 1, FIELDS),
    "space": ("optimize", SOURCE / "scenes" / "half-ball.toml", 1, FIELDS | {"mesh__size": 2.5, "optimizer__max_iterations": 1}),
    "two ranks": ("optimize", BLOCK, 2, FIELDS),
    "one file": ("optimize", BLOCK, 1, FIELDS | {"output__format": ONE}),
}


@pytest.fixture(scope="module", params=RUNS)
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bool]:
    """Folder of a run with contact, and whether its VTKHDF files have their own values."""
    verb, scene, ranks, settings = RUNS[request.param]
    out = tmp_path_factory.mktemp("run") / "out"
    signorini(verb, scene, out, ranks, **settings)
    assert table(out / "steps.csv")["active"].max() > 0
    return out, "output__format" in settings


@pytest.mark.parametrize("name", ("state", "control", "adjoint"))
def test_every_value_is_that_of_the_run(name: str, run: tuple[Path, bool], tmp_path: Path) -> None:
    out, whole = run
    assert (out / f"{name}.h5").exists() == (out / f"{name}.xdmf").exists() != whole
    found = read(out / f"{name}.vtkhdf", tmp_path)
    data = out / f"{name}.{'vtkhdf' if whole else 'h5'}"
    fields = [*NODES, *CELLS] if name == "state" else [name]
    assert found.names == {"points", "cells", "offsets", "types", *(f"{'cell' if field in CELLS else 'point'}.{field}" for field in fields)}
    with h5py.File(data) as file:
        points, cells, times = file["Mesh/mesh/geometry"][:], file["Mesh/mesh/topology"][:], file["times"][:]
        values = {field: [file[f"Function/{field}/{number}"][:] for number in sorted(file[f"Function/{field}"])] for field in fields}
    assert len(times) > 4 and np.array_equal(found.times, times)
    for k in range(len(times)):
        assert np.array_equal(found("points", k)[:, : points.shape[1]], points) and not found("points", k)[:, points.shape[1] :].any()
        assert np.array_equal(found("cells", k), cells.ravel()) and set(found("types", k)) == {5 if points.shape[1] == 2 else 10}
        assert np.array_equal(np.diff(found("offsets", k)), np.full(len(cells), cells.shape[1]))
        for field, series in values.items():
            here = found(f"{'cell' if field in CELLS else 'point'}.{field}", k)
            assert np.array_equal(here.reshape(len(here), -1), series[k].reshape(len(here), -1)), (field, k)
    assert any(np.abs(series).max() > 0 for series in values.values())


def test_other_readers_find_the_same(run: tuple[Path, bool], tmp_path: Path) -> None:
    """PyVista the first time of the VTKHDF file, and meshio all times of the XDMF file."""
    out, whole = run
    by_vtk, by_pyvista = read(out / "state.vtkhdf", tmp_path), read(out / "state.vtkhdf", tmp_path, "pyvista")
    assert by_pyvista.names == by_vtk.names
    for name in by_vtk.names:
        assert np.array_equal(by_pyvista(name, 0), by_vtk(name, 0)), name
    if whole:
        return
    with meshio.xdmf.TimeSeriesReader(out / "state.xdmf") as reader:
        points, _ = reader.read_points_cells()
        assert reader.num_steps == len(by_vtk.times) and np.array_equal(points, by_vtk("points", 0)[:, : points.shape[1]])
        for k in range(reader.num_steps):
            time, at_points, in_cells = reader.read_data(k)
            assert time == by_vtk.times[k]
            for name, values in [*((f"point.{name}", one) for name, one in at_points.items()), *((f"cell.{name}", one[0]) for name, one in in_cells.items())]:
                here = by_vtk(name, k)
                assert np.array_equal(values.reshape(len(here), -1), here.reshape(len(here), -1)), (name, k)


def surface(out: Path, number: int, k: int) -> np.ndarray:
    """Points of an obstacle at a stored time, as surfaces.h5 has them."""
    with h5py.File(out / "surfaces.h5") as file:
        group = file[str(number)]
        points = group["points"][:]
        if "first_point" in group:
            first, end = group["first_point"][k : k + 2]
            return (points + group["displacement"][:])[first:end]
        return points + group["displacement"][k] if "displacement" in group else points


@pytest.mark.parametrize("scene, obstacles, kinds", (
    (BLOCK, {}, "rests"),
    (BLOCK, {"contact__obstacle": TIP}, "moves"),
    (BLOCK, {"contact__obstacle": WAVE}, "changes"),
    (CUBE, {}, "rests"),
    (DATA / "block.toml", {"contact": [{"on": "bottom", "obstacle": TIP}, {"on": "top", "obstacle": WAVE | {"distance": "1.3 - y + 0.05*sin(3*x + 40*t)"}},
                                       {"on": "left", "obstacle": {"shape": "half-space", "point": [-0.1, 0], "normal": [1, 0]}}]}, "all"),
), ids=("plane", "moving", "changing", "space", "all"))  # fmt: skip
def test_obstacles_are_where_they_are(scene: Path, obstacles: dict, kinds: str, tmp_path: Path) -> None:
    out, scratch = tmp_path / "out", tmp_path / "scratch"
    scratch.mkdir()
    signorini("simulate", scene, out, output__every=5, output__fields=["displacement"], **obstacles)
    found = read(out / "obstacles.vtkhdf", scratch)
    state = read(out / "state.vtkhdf", scratch)
    assert np.array_equal(found.times, state.times)
    count = len(obstacles.get("contact", [0]))
    moved = []
    for k in range(len(found.times)):
        points, number = found("points", k), found("cell.obstacle", k)
        expected = [surface(out, i + 1, k) for i in range(count)]
        dim = expected[0].shape[1]
        assert np.array_equal(points[:, :dim], np.concatenate(expected))
        assert set(number) == set(range(1, count + 1)) and set(found("types", k)) == {3 if dim == 2 else 5}
        facets, starts = found("cells", k).reshape(-1, dim), np.cumsum([0, *map(len, expected)])
        for i in range(count):
            own = facets[number == i + 1]
            assert own.min() == starts[i] and own.max() == starts[i + 1] - 1, "facets of an obstacle join its own points"
        moved.append(points)
    same = [len(one) == len(moved[0]) and np.array_equal(one, moved[0]) for one in moved]
    assert all(same) == (kinds == "rests")


def test_one_file_can_be_moved_and_a_link_alone_fails_loudly(tmp_path: Path) -> None:
    for name, settings in (("one", {"output__format": ONE}), ("two", {})):
        signorini("simulate", BLOCK, tmp_path / name, output__fields=["displacement"], **settings)
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copy(tmp_path / "one" / "state.vtkhdf", alone / "one.vtkhdf")
    shutil.copy(tmp_path / "two" / "state.vtkhdf", alone / "two.vtkhdf")
    here, there = read(alone / "one.vtkhdf", tmp_path), read(tmp_path / "two" / "state.vtkhdf", tmp_path)
    for name, values in there.arrays.items():
        assert np.array_equal(here.arrays[name], values)
    lost = attempt_to_read(alone / "two.vtkhdf", tmp_path / "lost.npz")
    assert lost.returncode != 0 and not (tmp_path / "lost.npz").exists()


def test_files_of_the_formats(tmp_path: Path) -> None:
    """One format alone has no files of the other, and the values are stored once."""
    found = {}
    for name, formats in (("xdmf", ["xdmf"]), ("vtkhdf", ONE), ("both", ["xdmf", "vtkhdf"])):
        out = tmp_path / name
        signorini("simulate", BLOCK, out, output__fields=["displacement", "velocity"], output__format=formats)
        found[name] = {file.name: file.stat().st_size for file in out.iterdir() if file.suffix in (".h5", ".xdmf", ".vtkhdf")}
    assert set(found["xdmf"]) == {"state.h5", "state.xdmf", "surfaces.h5"}
    assert set(found["vtkhdf"]) == {"state.vtkhdf", "obstacles.vtkhdf", "surfaces.h5"}
    assert set(found["both"]) == set(found["xdmf"]) | set(found["vtkhdf"])
    assert found["both"]["state.vtkhdf"] < 4096, "a link"
    values = 2 * 8 * 3 * stored(tmp_path / "both", "state", "displacement")[2].shape[0] * len(stored(tmp_path / "both", "state", "displacement")[0])
    assert all(size < found["xdmf"]["state.h5"] + values / 2 for size in (found["both"]["state.h5"], found["vtkhdf"]["state.vtkhdf"]))
    assert grids(tmp_path / "both" / "state.xdmf") == grids(tmp_path / "xdmf" / "state.xdmf")


def test_later_runs_and_pages_read_one_file(tmp_path: Path) -> None:
    """A run that is wanted, a first guess, the folder's reader and its page need no XDMF file."""
    for name, settings in (("one", {"output__format": ONE}), ("two", {})):
        out = tmp_path / name
        signorini("optimize", BLOCK, out, optimizer__checkpoint=0, output__every=1, **settings)
        again = {"objective__desired": {"run": str(out)}, "control__initial": {"run": str(out)}, "optimizer__max_iterations": 0}
        signorini("optimize", BLOCK, tmp_path / f"{name} again", **again)
    one, two = (RunFolder(tmp_path / name) for name in ("one", "two"))
    for file, field in (("state", "displacement"), ("control", "control"), ("adjoint", "adjoint")):
        a, b = one.field(file, field), two.field(file, field)
        assert np.array_equal(a.times, b.times)
        assert all(np.array_equal(a.components(k), b.components(k)) for k in range(len(a.times)))
    again = [table(tmp_path / f"{name} again" / "history.csv") for name in ("one", "two")]
    assert np.array_equal(again[0]["objective"], again[1]["objective"])
    done = attempt("report", tmp_path / "one")
    assert done.returncode == 0 and 'id="body"' in (tmp_path / "one" / "report.html").read_text()
