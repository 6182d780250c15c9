# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors are Python's, with the program's sentences; Ctrl-C stops a sweep, and the interpreter goes on; a rank that fails ends all."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
from common import PUSHED, SCENES, direction, half_disc, raised, show

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
    shapes(problem)
    raised(IndexError, lambda: problem.displacement(problem.zero(), 10**6))
    assert "found nan or inf" in raised(ValueError, lambda: problem.value(problem.zero() + np.nan))
    assert "the solution is not finite" in raised(signorini.SolverFailure, lambda: problem.value(problem.zero() + 1e308))
    assert problem.value(problem.zero()) > 0, "the problem is of use after a failure"


def shapes(problem: signorini.Problem) -> None:
    """Controls have their shape, not only as many entries: another order of axes is another control."""
    u, n = direction(problem), problem.size
    flat, other = problem.replicated(), u.T
    assert other.shape != u.shape
    for call in (problem.value, problem.value_and_gradient, problem.representative, problem.parts, problem.states, problem.active,
                 problem.riesz, problem.metric.apply, problem.metric.apply_inverse, problem.gather, problem.scatter, flat.vector,
                 lambda w: problem.hessian_product(u, w), lambda w: problem.metric.product(w, u), lambda w: problem.metric.product(u, w),
                 lambda w: problem.pairing(u, w), lambda w: problem.pairing(w, u)):  # fmt: skip
        call(u)
        for wrong in (other, np.ascontiguousarray(other), u.ravel(), u[None], u[:-1]):
            assert str(problem.shape) in raised(ValueError, lambda: call(wrong)), call
    x = flat.vector(u)
    for call in (flat.value, flat.value_and_gradient, flat.control, lambda w: flat.hessian_product(w, x), lambda w: flat.hessian_product(x, w)):
        call(x)
        for wrong in (x[None], x[:, None], u, x[:-1]):
            assert str(n) in raised(ValueError, lambda: call(wrong)), call
    fit = signorini.Scene(SCENES / "find-the-wall.toml", {"mesh.size": 8e-3}).fit()
    for wrong in (fit.start[None], fit.start[:, None], fit.start[:1]):
        assert "(2)" in raised(ValueError, lambda: fit.residuals(wrong))


def attributes_are_read_only() -> None:
    """Bounds, lengths, places and data are what later calls compute with: a change in place is refused, and they can be passed on."""
    problem = half_disc(4, control__lower=-2, control__upper=1).problem()
    fit = signorini.Scene(SCENES / "find-the-wall.toml", {"mesh.size": 8e-3}).fit()
    for owner, names in ((problem, ("lower", "upper", "times", "lengths", "points", "step_times", "nodes")), (problem.metric, ("weights", "diagonal")),
                         (fit, ("start", "lower", "upper", "times", "measured", "deviations"))):  # fmt: skip
        for name in names:
            assert getattr(owner, name).size > 0
            assert "read-only" in raised(ValueError, lambda: getattr(owner, name).__imul__(1e3)), name
    assert problem.value(problem.lower) == problem.value(problem.lower.copy()) and fit.residuals(fit.start).shape == fit.measured.shape
    assert half_disc(4).problem().lower is None


def threads() -> None:
    """Products, Riesz representatives and the ends of objects in other threads leave gradients as they are."""
    options = {"control__initial": PUSHED, "objective__desired": {"displacement": ["0", "0"]}}
    problem = half_disc(4, **options).problem()
    d, controls = direction(problem), [problem.first_guess() * (1 + 1e-3 * k) for k in range(8)]
    product, g, expected = problem.metric.product(d, d), problem.metric.apply_inverse(d), [problem.gradient(u) for u in controls]
    off, rounds, done = [], 0, threading.Event()

    def others() -> None:
        nonlocal rounds
        while not done.is_set():
            off.append(abs(problem.metric.product(d, d) - product) + np.abs(problem.metric.apply_inverse(d) - g).max())
            other = half_disc(4, **options).problem()
            other.first_guess(), other.metric.weights, other.sweeps, other.timings  # noqa: B018 - computed, or waited for
            rounds += 1

    workers = [threading.Thread(target=others) for _ in range(2)]
    for worker in workers:
        worker.start()
    while rounds < 4:
        found = [problem.gradient(u) for u in controls]
        assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=True))
    done.set()
    for worker in workers:
        worker.join()
    assert len(off) > 4 and np.max(off) == 0, off


FULL = """
import resource, signal, sys
sys.path.insert(0, {folder!r})
import signorini
from common import half_disc, raised
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
short = {{"time__step": 2.5e-4, "optimizer__max_iterations": 1}}
scene, tables = half_disc(4, **short), half_disc(4, **short, output__fields=[])
calls = [lambda: scene.simulate("motion"), lambda: tables.simulate("motion")]
if signorini.ranks == 1:
    stored = half_disc(4, **short, trajectory__storage="disk").problem()
    calls += [lambda: scene.optimize("search"), lambda: stored.gradient(stored.zero())]
if signorini.rank == 0:  # which writes the results
    resource.setrlimit(resource.RLIMIT_FSIZE, (1500, resource.RLIM_INFINITY))
for call in calls:
    print(raised(OSError, call))
"""


def full_disk() -> None:
    """What cannot be written is an OSError; of results, on every rank."""
    for ranks in (1, 2):
        with tempfile.TemporaryDirectory() as folder:
            done = started(FULL.format(folder=str(Path(__file__).parent)), ranks, cwd=folder)
            assert done.returncode == 0, done.stderr
            found = done.stdout.splitlines()
            assert len(found) == 4 and all("written" in line for line in found), found
            assert not Path(folder, "motion").exists(), "nothing is left half written"


def started(script: str, ranks: int = 1, mpi4py: bool = True, **options: object) -> subprocess.CompletedProcess:
    """Python on a script, in a world of its own. Raises TimeoutExpired where it never ends."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "script.py"
        file.write_text(script)
        command = ["mpirun", "--oversubscribe", "-n", str(ranks)] * (ranks > 1) + [sys.executable] + ["-m", "mpi4py"] * mpi4py + [file]
        return subprocess.run(command, capture_output=True, text=True, timeout=400, env=own_world(), **options)


ALONE = """
import sys
sys.path.insert(0, {folder!r})
import numpy as np, signorini
from common import half_disc
problem = half_disc(4, time__step=2.5e-4).problem() if {problem} else None
if signorini.rank == 1:
    {failure}
elif problem:
    problem.value(problem.zero())
else:
    signorini.world.wait()
"""


def alone() -> None:
    """A rank that fails alone ends all, with its message; none waits for it."""
    for failure, sentence, mpi4py, problem in (
        ("raise RuntimeError('of rank 1 alone')", "RuntimeError: of rank 1 alone", True, False),
        ("signorini.read('no-such-folder')", "SceneError", False, False),
        ("sys.exit('gone from rank 1')", "gone from rank 1", True, True),
        ("problem.value(np.zeros(3))", "found an array of shape (3)", False, True),
        ("problem.value(problem.zero())", None, True, True),
    ):
        done = started(ALONE.format(folder=str(Path(__file__).parent), failure=failure, problem=problem), 2, mpi4py)
        if sentence:
            assert done.returncode != 0 and sentence in done.stderr, (failure, done.returncode, done.stderr)
        else:
            assert done.returncode == 0 and done.stderr == "", done.stderr


OPTIONS = """
import ctypes, sys, signorini
signorini.rank  # starts MPI and PETSc
name = ctypes.create_string_buffer({name!r}.encode())
petsc = ctypes.CDLL({petsc!r})
found = ctypes.c_int(0)
petsc.PetscOptionsHasName(None, None, name, ctypes.byref(found))
print(found.value)
"""


def no_petscrc() -> None:
    """PETSc reads its options from PETSC_OPTIONS, and from no file of the current folder, which could load code."""
    petsc = next(line.split()[-1] for line in Path("/proc/self/maps").read_text().splitlines() if "libpetsc" in line)
    with tempfile.TemporaryDirectory() as folder:
        for name in (".petscrc", "petscrc"):
            (Path(folder) / name).write_text(f"-of_a_file 1\n-log_view :{folder}/written\n")
        script = OPTIONS.format(name="-of_a_file", petsc=petsc)
        assert started(script, cwd=folder).stdout.split() == ["0"]
        assert not (Path(folder) / "written").exists()
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=folder, env=own_world() | {"PETSC_OPTIONS": "-of_a_file 1"})
        assert done.stdout.split() == ["1"], "an option that is given is not seen: the case says nothing"


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
attributes_are_read_only()
threads()
full_disk()
alone()
no_petscrc()
