# SPDX-License-Identifier: GPL-3.0-or-later
"""SIGINT and SIGTERM leave complete files and exit status 130; a run that is stopped before it has anything leaves none."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, grids, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

OPTIMIZE_FILES = {"scene.toml", "run.json", "steps.csv", "contact.csv", "obstacles.csv", "history.csv", "surfaces.h5", "state.xdmf", "state.h5",
                  "control.xdmf", "control.h5", "adjoint.xdmf", "adjoint.h5", "checkpoint.h5"}  # fmt: skip
SIMULATE_FILES = OPTIMIZE_FILES - {"history.csv", "checkpoint.h5", "control.xdmf", "control.h5", "adjoint.xdmf", "adjoint.h5"}


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


def optimize_is_complete(folder: Path, ranks: int) -> None:
    out = folder / f"optimize-{ranks}"
    # mpirun kills its ranks at SIGINT and SIGTERM, and passes SIGUSR1 on.
    which = signal.SIGINT if ranks == 1 else signal.SIGUSR1
    status = interrupted("optimize", out, which, "iterations", "--set", f"optimizer.max_iterations={1000 // ranks}",
                         "--set", "mesh.size=1", "--set", 'optimizer.method="projected-gradient"', ranks=ranks)  # fmt: skip
    assert status == 130, f"exit status {status}"
    assert {p.name for p in out.iterdir()} == OPTIMIZE_FILES
    run = json.loads((out / "run.json").read_text())
    history = table(out / "history.csv")
    assert run["stop_reason"] == "interrupted" and run["steps"]["done"] == 150
    assert len(history["iteration"]) > 2 and run["objective"]["value"] == history["objective"][-1]
    with h5py.File(out / "control.h5") as file:
        assert len(file["Function/control"]) == 150
    print(f"optimize on {ranks} ranks: stopped after iteration {history['iteration'][-1]:.0f}, {len(OPTIMIZE_FILES)} whole files")


def simulate_is_complete(folder: Path, ranks: int) -> None:
    out = folder / f"simulate-{ranks}"
    which = signal.SIGTERM if ranks == 1 else signal.SIGUSR1
    status = interrupted("simulate", out, which, "steps", "--set", "time.end=0.4", "--set", "mesh.size=0.25",
                         "--set", "output.every=1000", "--set", 'load.body=["0", "-1e6"]', ranks=ranks)  # fmt: skip
    assert status == 130, f"exit status {status}"
    assert {p.name for p in out.iterdir()} == SIMULATE_FILES
    run, steps = json.loads((out / "run.json").read_text()), table(out / "steps.csv")
    done = run["steps"]["done"]
    assert 0 < done < run["steps"]["asked"] and steps["step"][-1] == done
    force = steps["normal_force"]
    times = {*range(0, done, 1000), done, *np.flatnonzero(force >= (1 - 1e-9) * force.max())[:1]}
    with h5py.File(out / "state.h5") as file:
        assert len(file["Function/displacement"]) == len(file["Function/velocity"]) == len(times)
    index = grids(out / "state.xdmf")  # which is written at the end, this one too
    assert set(index) == {"displacement", "velocity"} and all(abs(times[-1] - steps["time"][-1]) < 1e-9 for times in index.values())
    print(f"simulate on {ranks} ranks: stopped after step {done}, {len(SIMULATE_FILES)} whole files")


def earlier_results_survive(folder: Path) -> None:
    """Interrupted while the desired state is computed: the folder keeps what it had."""
    out = folder / "early"
    signorini("optimize", HALF_DISC, out, mesh__size=4, optimizer__max_iterations=1)
    before = content(out)
    status = interrupted("optimize", out, signal.SIGINT, "desired state", "--set", "time.end=0.4",
                         "--set", "mesh.size=0.25")  # fmt: skip
    assert status == 130, f"exit status {status}"
    assert content(out) == before
    print("early: nothing was written, nothing was lost")


def meshing_stops_too(folder: Path, ranks: int) -> None:
    """gmsh, and what its script started, end at once and not after the ten minutes that they would take."""
    number = f"600.{ranks}{os.getpid()}"  # told apart from others' commands
    geo, scene = folder / f"slow-{ranks}.geo", folder / f"slow-{ranks}.toml"
    mesh = (SOURCE / "meshes" / "half-disc.geo").read_text()
    geo.write_text(f'SystemCall "touch {folder}/started-{ranks}; sleep {number}";\n{mesh}')
    scene.write_text(HALF_DISC.read_text().replace("../meshes/half-disc.geo", str(geo)))

    def running() -> bool:
        found = False
        for process in Path("/proc").glob("[0-9]*/cmdline"):
            with contextlib.suppress(OSError):  # it has ended
                found |= number.encode() in process.read_bytes()
        return found

    for which in (signal.SIGINT, signal.SIGTERM) if ranks == 1 else (signal.SIGUSR1,):
        mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        process = subprocess.Popen([*mpirun, str(SIGNORINI), "simulate", str(scene), "--out", str(folder / "slow")],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
        started = folder / f"started-{ranks}"
        while not (started.exists() and running()):
            assert process.poll() is None, "ended before gmsh began"
            time.sleep(0.01)
        process.send_signal(which)
        said = process.communicate(timeout=120)
        assert process.returncode == 130 and said[0] == "" and "interrupted before" in said[1], (process.returncode, said)
        assert not running() and not (folder / "slow").exists()
        started.unlink()
    print(f"meshing on {ranks} ranks: stopped, with all that gmsh had started")


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        optimize_is_complete(Path(folder), ranks=1)
        optimize_is_complete(Path(folder), ranks=2)
        simulate_is_complete(Path(folder), ranks=1)
        simulate_is_complete(Path(folder), ranks=2)
        earlier_results_survive(Path(folder))
        meshing_stops_too(Path(folder), ranks=1)
        meshing_stops_too(Path(folder), ranks=2)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
