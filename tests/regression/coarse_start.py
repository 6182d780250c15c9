# SPDX-License-Identifier: GPL-3.0-or-later
"""A search that starts on coarse meshes ends where one from the first guess does, with fewer sweeps; it can be interrupted, resumed and
does without a level that cannot be meshed. And a control that an earlier run left is a first guess on another mesh."""

import functools
import json
import shutil
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, SIGNORINI, SOURCE, attempt, captured, signorini, table

BLOCK, FIXED = SOURCE / "tests" / "data" / "block.toml", SOURCE / "tests" / "data" / "fixed-density.geo"
NEAR = 1e-6  # of J near its minimum, which is about 1e-2
ROUNDING, RANKS = 1e-12, 1e-8  # on other ranks sums are in another order, and contact multiplies that
# Of 800 cells: one level of 200 cells is coarse enough.
DISC = {"mesh__size": 1, "output__fields": [], "output__tables": ["history"], "optimizer__max_iterations": 38}


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def sweeps_to(out: Path, value: float) -> int:
    history = table(out / "history.csv")
    row = (history["objective"] <= value).argmax()
    assert history["objective"][row] <= value, f"{history['objective'].min()} is above {value}"
    return int(history["forward_sweeps"][row] + history["adjoint_sweeps"][row])


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("whole") / "out"
    signorini("optimize", HALF_DISC, out, **DISC | {"optimizer__max_iterations": 12})
    return out


SEARCHES = {
    "lbfgs": {"optimizer__method": "lbfgs"},
    "newton-cg": {"optimizer__method": "newton-cg", "optimizer__max_iterations": 9},
    "bounds": {"optimizer__method": "lbfgs", "control__lower": -0.9, "control__upper": 0.5, "mesh__degree": 2, "mesh__size": 1.5},
}


@pytest.mark.parametrize("name", SEARCHES)
def test_same_optimum(name: str, tmp_path: Path) -> None:
    outs = [tmp_path / start for start in ("guess", "coarse")]
    for out in outs:
        done = signorini("optimize", HALF_DISC, out, **DISC | {"optimizer__start": out.name} | SEARCHES[name])
    J = [table(out / "history.csv")["objective"] for out in outs]
    least = np.minimum(J[0].min(), J[1].min())
    assert abs(J[0][-1] - J[1][-1]) < NEAR
    if name == "lbfgs":
        direct, coarse = (sweeps_to(out, least + NEAR) for out in outs)
        print(f"to J* + 1e-6 {direct} sweeps from the first guess, {coarse} from coarse meshes")
        assert coarse < 0.75 * direct
    *_, level = manifest(outs[1])["optimizer"]["coarse_levels"]
    assert manifest(outs[0])["optimizer"]["coarse_levels"] == []
    if name != "bounds":
        assert level["size"] == 2 and level["steps"] == 75 and abs(level["step"] / 1e-4 - 1) < ROUNDING and level["iterations"] > 3
        assert level["forward_sweeps"] >= level["adjoint_sweeps"] > 3 and level["seconds"] > 0 and abs(level["objective"] - least) < 1e-3
        (line,) = (line for line in done.stdout.splitlines() if line.startswith("coarse mesh of size 2 m, "))
        assert "75 steps of 0.0001 s" in line and level["stop_reason"] in line
    assert J[1][0] < 0.05 * J[0][0] and table(outs[1] / "history.csv")["iteration"][0] == 0


def test_default(tmp_path: Path) -> None:
    done = signorini("optimize", HALF_DISC, tmp_path, **DISC | {"optimizer__max_iterations": 1})
    assert "coarse mesh" in done.stdout and 'start = "coarse"' in (tmp_path / "scene.toml").read_text()


def test_ranks(tmp_path: Path) -> None:
    J = []
    for ranks in (1, 2):
        signorini("optimize", HALF_DISC, tmp_path, ranks, **DISC | {"optimizer__max_iterations": 4})
        J.append(table(tmp_path / "history.csv")["objective"])
    assert J[1] == pytest.approx(J[0], rel=1e-6)


def test_resumed(whole: Path, tmp_path: Path) -> None:
    """To the last bit, from the checkpoint alone, without coarse meshes; without a checkpoint with them."""
    signorini("optimize", HALF_DISC, tmp_path, **DISC | {"optimizer__max_iterations": 5})
    command = [str(SIGNORINI), "optimize", str(tmp_path / "scene.toml"), "--out", str(tmp_path), "--resume", "--set",
               "optimizer.max_iterations=12"]  # fmt: skip
    done = captured(command)
    assert done.returncode == 0 and "resumed after iteration 5" in done.stdout and "coarse mesh" not in done.stdout, done.stderr
    a, b = (table(out / "history.csv") for out in (whole, tmp_path))
    assert all((a[key] == b[key]).all() for key in a if key != "seconds"), "the result differs from that of an uninterrupted run"
    (tmp_path / "checkpoint.h5").unlink()
    done = captured(command)
    assert done.returncode == 0 and "no checkpoint in" in done.stdout and "coarse mesh of size" in done.stdout, done.stderr


@pytest.mark.parametrize("there", (True, False), ids=("replaced", "new"))
def test_interrupted_between_two_levels(whole: Path, there: bool, tmp_path: Path) -> None:
    """What was there stays, and nothing is left."""
    out = tmp_path / "out"
    if there:
        shutil.copytree(whole, out)

    def content() -> dict[str, bytes] | None:
        return {path.name: path.read_bytes() for path in out.iterdir()} if out.exists() else None

    before = content()
    process = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--out", str(out), "--set", "mesh.size=0.25"],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # fmt: skip
    for line in process.stdout:
        if line.startswith("coarse mesh of size 1 m"):
            break
    assert process.poll() is None, "ended before it could be interrupted"
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130 and content() == before


def test_mesh_of_its_own_density(tmp_path: Path) -> None:
    """A .geo whose cells are as many at any size has no coarse meshes."""
    fixed = {"mesh__file": str(FIXED), "mesh__size": 0.01, "time__step": 0.012, "optimizer__max_iterations": 1, "output__fields": []}
    done = signorini("optimize", BLOCK, tmp_path, **fixed)
    assert done.stdout.count("m is left out: it has 9800 cells, more than half of the 9800 cells of the scene's mesh") == 2, done.stdout
    assert manifest(tmp_path)["optimizer"]["coarse_levels"] == []


@pytest.mark.parametrize("changes", ({"mesh__size": 0.25, "optimizer__start": "coarse", "optimizer__max_iterations": 1},
                                     {"mesh__size": 0.05, "optimizer__max_iterations": 0}), ids=("small", "no iterations"))  # fmt: skip
def test_no_coarse_meshes(changes: dict[str, object], tmp_path: Path) -> None:
    assert "coarse mesh" not in signorini("optimize", BLOCK, tmp_path, **changes).stdout


LINEAR = {"control__initial": ["0.5 + x - y", "t*y - 1"]}


@pytest.fixture(scope="module")
def linear(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Path]:
    """By the mesh's degree, a run that left a linear control on a coarse mesh."""

    @functools.cache
    def of(degree: int) -> Path:
        out = tmp_path_factory.mktemp("linear") / "out"
        ranks = 2 if degree == 1 else 1
        signorini("optimize", BLOCK, out, ranks, **LINEAR, mesh__degree=degree, optimizer__max_iterations=0)
        return out

    return of


HERE = {
    "fine": ({"mesh__size": 0.13}, 1),
    "coarse, degree 2": ({"mesh__size": 0.4, "mesh__degree": 2}, 2),
    "cellwise": ({"mesh__size": 0.13, "control__space": "cellwise"}, 1),
}


@pytest.mark.parametrize("name", HERE)
@pytest.mark.parametrize("degree", (1, 2))
def test_linear_control(linear: Callable[[int], Path], degree: int, name: str, tmp_path: Path) -> None:
    """It is itself on any other mesh."""
    (here, ranks), found = HERE[name], []
    for start in ({"control__initial": {"run": str(linear(degree))}}, LINEAR):
        signorini("simulate", BLOCK, tmp_path, ranks, **start, **here)
        found.append(manifest(tmp_path)["objective"])
    a, b = found
    assert b["control_cost"] > 0 and a == pytest.approx(b, rel=0, abs=RANKS * b["value"])


def from_optimum(whole: Path) -> dict[str, object]:
    """Half the step, with which the control is repeated."""
    return {"mesh__size": 0.7, "time__step": 2.5e-5, "control__initial": {"run": str(whole)}, "output__fields": []}


@pytest.mark.parametrize("ranks", (1, 2))
def test_optimum_on_another_mesh(whole: Path, ranks: int, tmp_path: Path) -> None:
    """J is near its own."""
    signorini("simulate", HALF_DISC, tmp_path, ranks, **from_optimum(whole))
    assert abs(manifest(tmp_path)["objective"]["value"] / manifest(whole)["objective"]["value"] - 1) < 0.02


def test_search_from_an_optimum(whole: Path, tmp_path: Path) -> None:
    """It starts there, not on coarse meshes."""
    done = signorini("optimize", HALF_DISC, tmp_path, **from_optimum(whole) | {"optimizer__max_iterations": 1})
    assert "coarse mesh" not in done.stdout and table(tmp_path / "history.csv")["objective"][0] < 0.011


def test_mesh_file_of_an_earlier_run(tmp_path: Path) -> None:
    """Its mesh is generated from its file, which must be what it was."""
    geo, scene = tmp_path / "square.geo", tmp_path / "moved"
    shutil.copy(SOURCE / "tests" / "data" / "square.geo", geo)
    signorini("optimize", BLOCK, scene, **LINEAR, mesh__file=str(geo), optimizer__max_iterations=0)
    geo.write_text(geo.read_text().replace("{1, 1, 0}", "{1, 1.1, 0}"))
    for text in ("whose file has changed since", "cannot be regenerated"):
        refused = attempt("simulate", BLOCK, tmp_path / "again", control__initial={"run": str(scene)}, mesh__size=0.13)
        assert refused.returncode == 2 and "control.initial.run: " in refused.stderr and text in refused.stderr
        geo.unlink(missing_ok=True)


def test_control_of_another_group_is_refused(linear: Callable[[int], Path], tmp_path: Path) -> None:
    refused = attempt("simulate", BLOCK, tmp_path, mesh__size=0.13, control__initial={"run": str(linear(2))}, control__on="top")
    assert refused.returncode == 2 and 'found a control on the body, but this scene\'s control acts on "top"' in refused.stderr
