# SPDX-License-Identifier: GPL-3.0-or-later
"""--accuracy: what is asked is met, within the budget, and what is on disk is whole whatever ends the run."""

import functools
import json
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, signorini, stored, table

BLOCK = SOURCE / "tests" / "data" / "block.toml"
DROP = SOURCE / "scenes" / "disc-drop.toml"
FILES = {"scene.toml", "run.json", "steps.csv", "contact.csv", "obstacles.csv", "history.csv", "surfaces.h5", "obstacles.vtkhdf",
         "checkpoint.h5", "indicators.csv"}  # fmt: skip
FILES |= {f"{name}.{ending}" for name in ("state", "control", "adjoint") for ending in ("xdmf", "h5", "vtkhdf")}


def command(verb: str, scene: Path, out: Path, *options: str, ranks: int = 1) -> list[str]:
    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    return [*mpirun, str(SIGNORINI), verb, str(scene), "--out", str(out), *options]


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def to_accuracy(verb: str, scene: Path, out: Path, *options: str, status: int = 0, ranks: int = 1) -> tuple[dict, str]:
    """run.json and the standard output."""
    done = captured(command(verb, scene, out, *options, ranks=ranks))
    assert done.returncode == status, (done.args, done.returncode, done.stdout, done.stderr)
    return manifest(out), done.stdout


def touched(out: Path) -> bool:
    return bool((table(out / "steps.csv")["active"] > 0).any())


# The half disc's optimum: with sizes of elements that vary, or one.
OPTIMA = {
    "auto": ("--accuracy", "1e-3", "--set", "mesh.size=auto"),
    "coarse": ("--accuracy", "8e-3", "--set", "mesh.size=auto"),
    "finer": ("--accuracy", "2e-3", "--set", "time.step=1e-4"),
    "asked": ("--accuracy", "1e-2"),
}
Optimum = Callable[..., tuple[Path, dict, str]]


@pytest.fixture(scope="module")
def optimum(tmp_path_factory: pytest.TempPathFactory) -> Optimum:
    """Folder, run.json and standard output of an optimum; each runs once."""

    @functools.cache
    def of(name: str, ranks: int = 1) -> tuple[Path, dict, str]:
        out = tmp_path_factory.mktemp(name) / "out"
        return out, *to_accuracy("optimize", HALF_DISC, out, *OPTIMA[name], ranks=ranks)

    return of


@pytest.fixture(scope="module")
def again(optimum: Optimum, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The motion of the scene that a run with elements of one size wrote."""
    out = tmp_path_factory.mktemp("again") / "out"
    signorini("simulate", optimum("finer")[0] / "scene.toml", out)
    return out


@pytest.mark.parametrize("ranks", (1, 2))
def test_optimum(optimum: Optimum, ranks: int) -> None:
    """J's error, beside a run to a tenth of it, is below what is asked and as estimated."""
    best, (out, run, said) = optimum("auto")[1], optimum("asked", ranks)
    error, found = abs(run["objective"]["value"] / best["objective"]["value"] - 1), run["accuracy"]
    print(f"asked 1e-2, estimated {found['estimated']:.1e}, found {error:.1e}")
    assert found["asked"] == 1e-2 and abs(found["estimated"] - sum(found[k] for k in ("space", "time", "search"))) < 1e-12
    assert error < found["asked"] and error / 3 < found["estimated"] < 3 * error
    assert touched(out)
    assert re.search(r"^relative error of J: 0.01 requested, .* estimated .*: met; .* half of the estimated error would take about", said, re.MULTILINE), said
    assert best["accuracy"]["estimated"] <= 1e-3 and len(best["optimizer"]["coarse_levels"]) >= 2


def test_more_rounds(optimum: Optimum) -> None:
    """On elements of one size."""
    (out, run, _), coarser = optimum("finer"), optimum("asked")[1]
    assert len(run["optimizer"]["coarse_levels"]) >= 1 and run["unknowns"] > 3 * coarser["unknowns"]
    assert {p.name for p in out.iterdir()} == FILES
    steps = [level["steps"] for level in run["optimizer"]["coarse_levels"]] + [run["steps"]["done"]]
    assert steps == sorted(steps) and steps[-1] > 1.5 * steps[0]


def test_scene_is_that_of_the_last_round(optimum: Optimum, again: Path) -> None:
    """It has its mesh and steps."""
    first, second = optimum("finer")[1], manifest(again)
    assert (second["unknowns"], second["steps"]["done"]) == (first["unknowns"], first["steps"]["done"])


def spread(folder: Path) -> tuple[int, float]:
    """Number of cells, and the ratio of the largest area to the smallest."""
    nodes, cells, _ = stored(folder, "state", "displacement")
    a, b, c = (nodes[cells[:, i], :2] for i in range(3))
    area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return len(cells), float(area.max() / area.min())


def test_sizes_vary(optimum: Optimum, again: Path, tmp_path: Path) -> None:
    """With mesh.size = "auto" elements differ by more than their factor in a uniform mesh, and the mesh is kept."""
    out, run, _ = optimum("auto")
    assert {p.name for p in out.iterdir()} == FILES | {"mesh.msh"}
    indicators = table(out / "indicators.csv")["indicator"]
    assert len(indicators) == run["cells"] and run["accuracy"]["space"] < indicators.sum() < 100 * run["accuracy"]["space"]
    signorini("simulate", out / "scene.toml", tmp_path)  # which names the mesh that was kept
    (cells, largest), (uniform_cells, uniform) = spread(tmp_path), spread(again)
    print(f"{cells} cells whose areas differ {largest:.0f} times, in a uniform mesh of {uniform_cells} {uniform:.1f} times")
    assert cells == run["cells"] and largest > 3 * uniform


def test_control_on_varying_sizes_is_a_first_guess(optimum: Optimum, tmp_path: Path) -> None:
    out, run, _ = optimum("auto")
    signorini("optimize", HALF_DISC, tmp_path, control__initial={"run": str(out)}, mesh__size=1, optimizer__max_iterations=0)
    assert abs(manifest(tmp_path)["objective"]["value"] / run["objective"]["value"] - 1) < 0.01


@pytest.mark.parametrize("ranks", (1, 2))
def test_given_mesh_is_refined(optimum: Optimum, ranks: int, tmp_path: Path) -> None:
    """A mesh of which nothing else is known is refined where it matters: its own error is above what is asked."""
    best, (there, coarse, _) = optimum("auto")[1], optimum("coarse")
    asked, mesh = 0.8 * coarse["accuracy"]["space"], f'mesh={{file="{there / "mesh.msh"}"}}'
    finer, _ = to_accuracy("optimize", HALF_DISC, tmp_path, "--accuracy", repr(asked), "--set", mesh, ranks=ranks)
    assert finer["accuracy"]["estimated"] <= asked and len(finer["optimizer"]["coarse_levels"]) >= 1
    assert finer["cells"] > 1.2 * coarse["cells"]
    assert abs(finer["objective"]["value"] / best["objective"]["value"] - 1) < 2e-3 + asked
    assert {p.name for p in tmp_path.iterdir()} == FILES | {"mesh.msh"}


PAGES = {"auto": ("The mesh, and each cell", "relative error of J: 0.001 requested"), "lengths": ("Length of the steps over time",)}


@pytest.mark.parametrize("name", PAGES)
def test_page(optimum: Optimum, name: str, tmp_path: Path) -> None:
    """It shows where sizes and lengths are small, and every figure has what it needs."""
    out = tmp_path / "out"
    if name == "auto":
        shutil.copytree(optimum("auto")[0], out)
    else:
        signorini("optimize", BLOCK, out, time__step="auto", time__tolerance=1e-2)
    for script in ("report.py", "figures.py"):
        done = subprocess.run([sys.executable, SOURCE / "postprocess" / script, out], capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr, (script, done.stderr)
    page = (out / "report.html").read_text()
    assert all(text in page for text in PAGES[name])


QUICK = ("--quantity", "contact_time", "--set", "mesh.size=4", "--set", "time.step=0.04")


@pytest.mark.parametrize("verb, scene, more", (("optimize", HALF_DISC, ()), ("simulate", DROP, QUICK)), ids=("optimize", "simulate"))
def test_budget(verb: str, scene: Path, more: tuple[str, ...], tmp_path: Path) -> None:
    """It is some first answers long, however busy the machine is."""
    start = time.perf_counter()
    to_accuracy(verb, scene, tmp_path, "--accuracy", "0.5", *more)
    seconds = 5 * (time.perf_counter() - start)
    found, said = to_accuracy(verb, scene, tmp_path, "--accuracy", "1e-7", "--budget", f"{seconds:.2f}s", *more, status=1)
    print(f"budget of {seconds:.1f} s, estimated {found['accuracy']['estimated']:.1e}")
    assert "budget" in said and not found["accuracy"]["met"]
    assert found["steps"]["done"] == found["steps"]["asked"], "what the budget cut off stands in place of a whole answer"
    # What was asked is far beyond it; that the run ends is what keeping it means.
    assert "budget is spent" in said or "would exceed the budget" in said, said
    assert found["accuracy"]["estimated"] > 10 * 1e-7, "the budget would have been enough"
    assert not list(tmp_path.glob(".unfinished*")) and (tmp_path / "state.h5").is_file()
    if verb == "optimize":  # whose error is known from the first round on
        assert float(re.search(r"the requested error would take about (\S+) s", said)[1]) > seconds, said


@pytest.mark.parametrize("ranks, which", ((1, signal.SIGINT), (2, signal.SIGUSR1)))
def test_interrupted_keeps_the_best(ranks: int, which: signal.Signals, tmp_path: Path) -> None:
    """That of the second round."""
    asked = command("optimize", BLOCK, tmp_path, "--accuracy", "1e-7", "--set", "mesh.size=0.5", ranks=ranks)
    process = subprocess.Popen(asked, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    for line in process.stdout:
        if line.startswith("round 2"):
            break
    content = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    process.send_signal(which)
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 130 and "not met, interrupted" in said
    assert FILES == {path.name for path in tmp_path.iterdir()}
    assert all((tmp_path / name).read_bytes() == content[name] for name in ("run.json", "control.h5", "steps.csv"))
    assert len(manifest(tmp_path)["optimizer"]["coarse_levels"]) == 1


def impulse(out: Path) -> float:
    return np.hypot(*manifest(out)["impact"]["all"]["impulse"])


@pytest.fixture(scope="module")
def drop(tmp_path_factory: pytest.TempPathFactory) -> float:
    """The impulse of the disc that drops, on a fine mesh."""
    out = tmp_path_factory.mktemp("drop") / "out"
    signorini("simulate", DROP, out, mesh__size=1, time__step=2.5e-3)
    return impulse(out)


def test_motion(drop: float, tmp_path: Path) -> None:
    found, said = to_accuracy("simulate", DROP, tmp_path, "--accuracy", "1e-2", "--quantity", "impulse")
    print(f"impulse: asked 1e-2, estimated {found['accuracy']['estimated']:.1e}, found {abs(impulse(tmp_path) / drop - 1):.1e}")
    assert found["accuracy"]["quantity"] == "impulse" and found["accuracy"]["estimated"] <= 1e-2 and "met;" in said
    assert touched(tmp_path)
    assert impulse(tmp_path) == pytest.approx(drop, rel=1e-2)


def test_motion_on_varying_sizes(drop: float, tmp_path: Path) -> None:
    out, there = tmp_path / "graded", tmp_path / "on-graded"
    found, said = to_accuracy("simulate", DROP, out, "--accuracy", "1e-2", "--quantity", "impulse", "--set", "mesh.size=auto")
    print(f"impulse: asked 1e-2, found {abs(impulse(out) / drop - 1):.1e}")
    assert found["accuracy"]["estimated"] <= 1e-2 and "element sizes graded by the error of the stress" in said and (out / "mesh.msh").is_file()
    least, largest, cells = re.findall(r"^element sizes graded by the error of the stress: from (\S+) to (\S+) m, (\d+) elements$", said, re.MULTILINE)[-1]
    assert float(least) < float(largest) and int(cells) == found["cells"]
    took, half = map(float, re.search(r"(\S+) s for this run, \S+ s in all; half of the estimated error would take about (\S+) s", said).groups())
    assert half > 1.5 * took  # order 2 in space: twice the cells, and no fewer steps
    signorini("simulate", out / "scene.toml", there)  # which names the mesh that was kept
    assert manifest(there)["cells"] == found["cells"]
    assert impulse(out) == pytest.approx(drop, rel=1e-2)


REFUSED = {
    "simulate --set mesh.size=auto": ("mesh.size", '"auto"', "--accuracy"),
    "study --set mesh.size=auto": ("mesh.size", '"auto"', "--accuracy"),
    "optimize --budget 5s": ("--budget", "--accuracy"),
    "optimize --accuracy 1e-2 --resume": ("--accuracy", "--resume"),
    "optimize --accuracy 0": ("--accuracy",),
    "optimize --accuracy 1e-2 --set mesh.degree=2": ("--accuracy", "mesh.degree = 2", "set it to 1"),
    "simulate --accuracy 1e-2": ("--accuracy", "--quantity"),
    "simulate --accuracy 1e-2 --quantity impuls": ("--quantity", '"impulse"'),
    "simulate --accuracy 1e-2 --quantity J": ("--quantity", "impulse"),
}


@pytest.mark.parametrize("words", REFUSED)
def test_refused(words: str, tmp_path: Path) -> None:
    verb, *options = words.split()
    done = captured(command(verb, HALF_DISC, tmp_path / "out", *options))
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert all(word in done.stderr for word in REFUSED[words])
    assert not (tmp_path / "out").exists()


def test_mesh_that_no_size_changes_is_refused(tmp_path: Path) -> None:
    fixed = f'mesh={{file="{SOURCE / "tests" / "data" / "fixed-density.geo"}", size=0.25}}'
    done = captured(command("optimize", BLOCK, tmp_path / "out", "--accuracy", "1e-2", "--set", fixed))
    assert done.returncode == 2 and "mesh.size: " in done.stderr and "Transfinite" in done.stderr
