# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors are Python's, with the program's sentences; Ctrl-C stops a sweep, and the interpreter goes on."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from common import SCENES, half_disc, raised, show

import signorini

LONG = """
import os, signal, sys, threading, time
sys.path.insert(0, {folder!r})
from common import half_disc
handler = signal.getsignal(signal.SIGINT)
clock = time.pthread_getcpuclockid(threading.main_thread().ident)

def interrupt_after(seconds):  # of the main thread's own work, which a busy machine does not change
    start = time.clock_gettime(clock)
    def wait():
        while time.clock_gettime(clock) < start + seconds:
            time.sleep(1e-4)
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=wait, daemon=True).start()

problem = half_disc(4, time__step=1e-7).problem()  # 75000 steps, of a second or more
u = problem.zero()
for delay in (0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 5e-2):  # before the sweep, at its start, within
    try:
        interrupt_after(delay)
        problem.value(u)
    except KeyboardInterrupt:
        assert problem.sweeps.forward == 0, "the sweep was not stopped"
        print("interrupted", flush=True)
assert signal.getsignal(signal.SIGINT) is handler
short = half_disc(4)
problem = short.problem()
print("after", problem.value(problem.zero()) > 0, problem.sweeps.forward)
long_run = half_disc(4, time__step=1e-7)
try:
    interrupt_after(0.1)
    long_run.simulate()
except KeyboardInterrupt:
    print("run interrupted")
print("run", short.simulate().manifest["stop_reason"])
try:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5)
except KeyboardInterrupt:
    print("outside")
"""


def sentences() -> None:
    """What the program says of the same mistakes."""
    assert issubclass(signorini.SceneError, ValueError) and issubclass(signorini.SolverFailure, RuntimeError)
    wrong = raised(signorini.SceneError, lambda: half_disc(mesh__sise=1))
    show(wrong)
    assert "mesh.sise" in wrong and "did you mean" in wrong and "size" in wrong
    assert "-1" in raised(signorini.SceneError, lambda: half_disc(-1))
    assert "no-such.toml" in raised(signorini.SceneError, lambda: signorini.Scene("no-such.toml"))
    assert "lower" in raised(signorini.SceneError, lambda: half_disc(control__lower="much"))
    assert "[control]" in raised(signorini.SceneError, lambda: signorini.Scene(SCENES / "disc-drop.toml").problem())
    assert "[[unknown]]" in raised(signorini.SceneError, lambda: half_disc(4).fit())
    assert "no-such-folder" in raised(signorini.SceneError, lambda: signorini.read("no-such-folder"))
    assert "override" in raised(TypeError, lambda: half_disc(control=None))
    problem = half_disc(4).problem()
    size = raised(ValueError, lambda: problem.value(np.zeros(3)))
    assert "3 entries" in size and str(problem.shape[0]) in size, size
    raised(IndexError, lambda: problem.displacement(problem.zero(), 10**6))
    # A number that is none is no control.
    raised(signorini.SolverFailure, lambda: problem.value(problem.zero() + np.nan))
    assert problem.value(problem.zero()) > 0, "the problem is of use after a failure"


def overrides() -> None:
    """Values of every kind arrive in the scene."""
    scene = half_disc(np.float64(3), control__lower=np.array([-2, -3]), output={"fields": [], "every": 7}, control__initial=("0.5*t", "x"),
                      contact__obstacle__point=[0, -16], optimizer__checkpoint=np.int64(0))  # fmt: skip
    text = scene.text
    for line in ("size = 3.0", "every = 7", "lower = [", "0.5*t", "checkpoint = 0", "fields = []"):
        assert line in text, (line, text)
    with tempfile.TemporaryDirectory(prefix="ümlaut and \"quote\" ") as folder:
        copy = Path(folder) / "half-disc.toml"
        copy.write_text((SCENES / "half-disc.toml").read_text())
        assert signorini.Scene(copy, {"mesh.file": SCENES.parent / "meshes/half-disc.geo", "mesh.size": 4}).problem().size > 0


def interrupts() -> None:
    """In a process of its own."""
    done = subprocess.run([sys.executable, "-c", LONG.format(folder=str(Path(__file__).parent))], capture_output=True, text=True, timeout=300,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler), env=own_world())  # fmt: skip
    show(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines() == ["interrupted"] * 7 + ["after True 1", "run interrupted", "run end of time", "outside"], done.stdout


def own_world() -> dict[str, str]:
    """The environment without what MPI, which this process has started, left in it."""
    return {key: value for key, value in os.environ.items() if not key.startswith(("PMIX_", "PRTE_MCA_ess", "OMPI_COMM_WORLD"))}


interrupts()
sentences()
overrides()
