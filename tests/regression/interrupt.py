# SPDX-License-Identifier: GPL-3.0-or-later
"""SIGINT and SIGTERM leave complete files and exit status 130; a run that is stopped before it has anything leaves none."""

import contextlib
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness import HALF_DISC, SIGNORINI, SOURCE, grids, signorini, table

OPTIMIZE_FILES = {"scene.toml", "run.json", "steps.csv", "contact.csv", "obstacles.csv", "history.csv", "surfaces.h5", "obstacles.vtkhdf",
                  "checkpoint.h5"}  # fmt: skip
FIELD_FILES = {name: {f"{name}.{ending}" for ending in ("xdmf", "h5", "vtkhdf")} for name in ("state", "control", "adjoint")}
OPTIMIZE_FILES = OPTIMIZE_FILES.union(*FIELD_FILES.values())
SIMULATE_FILES = OPTIMIZE_FILES - {"history.csv", "checkpoint.h5"} - FIELD_FILES["control"] - FIELD_FILES["adjoint"]


def interrupted(verb: str, out: Path, which: signal.Signals, when: str, *options: str, ranks: int = 1) -> int:
    """Sends a signal after the first line of progress that begins with `when`; returns the exit status."""
    mpirun = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    process = subprocess.Popen([*mpirun, str(SIGNORINI), verb, str(HALF_DISC), "--out", str(out), *options],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # fmt: skip
    for line in process.stdout:
        if line.startswith(when):
            break
    assert process.poll() is None, f"{verb} ended before it could be interrupted"
    process.send_signal(which)
    process.communicate(timeout=60)
    return process.returncode


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def signal_name(value: int) -> str | None:
    return value.name if isinstance(value, signal.Signals) else None


# mpirun kills its ranks at SIGINT and SIGTERM, and passes SIGUSR1 on.
@pytest.mark.parametrize("ranks, which", ((1, signal.SIGINT), (2, signal.SIGUSR1)), ids=signal_name)
def test_files_of_optimize_are_complete(ranks: int, which: signal.Signals, tmp_path: Path) -> None:
    out = tmp_path / "optimize"
    assert interrupted("optimize", out, which, "iterations", "--set", f"optimizer.max_iterations={1000 // ranks}",
                       "--set", "mesh.size=1", "--set", 'optimizer.method="projected-gradient"', ranks=ranks) == 130  # fmt: skip
    assert content(out).keys() == OPTIMIZE_FILES
    run = json.loads((out / "run.json").read_text())
    history = table(out / "history.csv")
    assert run["stop_reason"] == "interrupted" and run["steps"]["done"] == 150
    assert len(history["iteration"]) > 2 and run["objective"]["value"] == history["objective"][-1]
    with h5py.File(out / "control.h5") as file:
        assert len(file["Function/control"]) == 150


@pytest.mark.parametrize("ranks, which", ((1, signal.SIGTERM), (2, signal.SIGUSR1)), ids=signal_name)
def test_files_of_simulate_are_complete(ranks: int, which: signal.Signals, tmp_path: Path) -> None:
    out = tmp_path / "simulate"
    assert interrupted("simulate", out, which, "steps", "--set", "time.end=0.4", "--set", "mesh.size=0.25",
                       "--set", "output.every=1000", "--set", 'load.body=["0", "-1e6"]', ranks=ranks) == 130  # fmt: skip
    assert content(out).keys() == SIMULATE_FILES
    run, steps = json.loads((out / "run.json").read_text()), table(out / "steps.csv")
    done = run["steps"]["done"]
    assert 0 < done < run["steps"]["asked"] and steps["step"][-1] == done
    force = steps["normal_force"]
    times = {*range(0, done, 1000), done, *np.flatnonzero(force >= (1 - 1e-9) * force.max())[:1]}
    with h5py.File(out / "state.h5") as file:
        assert len(file["Function/displacement"]) == len(file["Function/velocity"]) == len(times)
    index = grids(out / "state.xdmf")  # which is written at the end, this one too
    assert set(index) == {"displacement", "velocity"} and all(abs(times[-1] - steps["time"][-1]) < 1e-9 for times in index.values())


def test_earlier_results_survive(tmp_path: Path) -> None:
    """Interrupted while the desired state is computed: the folder keeps what it had."""
    signorini("optimize", HALF_DISC, tmp_path, mesh__size=4, optimizer__max_iterations=1)
    before = content(tmp_path)
    status = interrupted("optimize", tmp_path, signal.SIGINT, "desired state", "--set", "time.end=0.4", "--set", "mesh.size=0.25")
    assert status == 130 and content(tmp_path) == before


@pytest.mark.parametrize("ranks, which", ((1, signal.SIGINT), (1, signal.SIGTERM), (2, signal.SIGUSR1)), ids=signal_name)
def test_meshing_stops(ranks: int, which: signal.Signals, tmp_path: Path) -> None:
    """gmsh, and what its script started, end at once and not after the ten minutes that they would take."""
    number = f"600.{which:d}{os.getpid()}"  # by which others' commands differ
    geo, scene, started, out = (tmp_path / name for name in ("slow.geo", "slow.toml", "started", "slow"))
    mesh = (SOURCE / "meshes" / "half-disc.geo").read_text()
    geo.write_text(f'SystemCall "touch {started}; sleep {number}";\n{mesh}')
    scene.write_text(HALF_DISC.read_text().replace("../meshes/half-disc.geo", str(geo)))

    def running() -> bool:
        found = False
        for process in Path("/proc").glob("[0-9]*/cmdline"):
            with contextlib.suppress(OSError):  # it has ended
                found |= number.encode() in process.read_bytes()
        return found

    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    process = subprocess.Popen([*mpirun, str(SIGNORINI), "simulate", str(scene), "--out", str(out)],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
    while not (started.exists() and running()):
        assert process.poll() is None, "ended before gmsh began"
        time.sleep(0.01)
    process.send_signal(which)
    stdout, stderr = process.communicate(timeout=120)
    assert process.returncode == 130 and stdout == "" and "interrupted before" in stderr
    assert not running() and not out.exists()
