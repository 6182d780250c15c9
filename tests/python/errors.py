# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors are Python's, with the program's sentences; Ctrl-C stops a sweep, and the interpreter continues; a rank that fails ends all."""

import signal
import threading
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
from common import PUSHED, SCENES, direction, half_disc, started

import signorini

SENTENCES = {
    "misspelt key": (lambda: half_disc(mesh__sise=1), ("mesh.sise", "did you mean", "size")),
    "value": (lambda: half_disc(-1), ("-1",)),
    "file": (lambda: signorini.Scene("no-such.toml"), ("no-such.toml",)),
    "type": (lambda: half_disc(control__lower="much"), ("lower",)),
    "no control": (lambda: signorini.Scene(SCENES / "disc-drop.toml").problem(), ("[control]",)),
    "no unknown": (lambda: half_disc(4).fit(), ("[[unknown]]",)),
    "folder": (lambda: signorini.read("no-such-folder"), ("no-such-folder",)),
}


@pytest.mark.parametrize("call, texts", SENTENCES.values(), ids=SENTENCES)
def test_sentence(call: Callable, texts: tuple[str, ...]) -> None:
    """What the program says of the same mistakes."""
    with pytest.raises(signorini.SceneError) as raised:
        call()
    assert all(text in str(raised.value) for text in texts)


def test_kinds() -> None:
    assert issubclass(signorini.SceneError, ValueError) and issubclass(signorini.SolverFailure, RuntimeError)
    with pytest.raises(TypeError, match="override"):
        half_disc(control=None)


@pytest.fixture(scope="module")
def problem() -> signorini.Problem:
    return half_disc(4).problem()


@pytest.fixture(scope="module")
def fit() -> signorini.Fit:
    return signorini.Scene(SCENES / "find-the-wall.toml", {"mesh.size": 8e-3}).fit()


def test_failures_of_a_problem(problem: signorini.Problem) -> None:
    with pytest.raises(IndexError):
        problem.displacement(problem.zero(), 10**6)
    with pytest.raises(ValueError, match="found nan or inf"):
        problem.value(problem.zero() + np.nan)
    with pytest.raises(signorini.SolverFailure, match="the solution is not finite"):
        problem.value(problem.zero() + 1e308)
    assert problem.value(problem.zero()) > 0, "the problem is of use after a failure"


UNARY = ("value", "value_and_gradient", "representative", "parts", "states", "active", "riesz", "metric.apply", "metric.apply_inverse",
         "gather", "scatter")  # fmt: skip
OF_A_CONTROL = {name: lambda problem, u, w, name=name: attrgetter(name)(problem)(w) for name in UNARY} | {
    "replicated().vector": lambda problem, u, w: problem.replicated().vector(w),
    "hessian_product(u, w)": lambda problem, u, w: problem.hessian_product(u, w),
    "metric.product(w, u)": lambda problem, u, w: problem.metric.product(w, u),
    "metric.product(u, w)": lambda problem, u, w: problem.metric.product(u, w),
    "pairing(u, w)": lambda problem, u, w: problem.pairing(u, w),
    "pairing(w, u)": lambda problem, u, w: problem.pairing(w, u),
}
OF_A_VECTOR = {
    "value": lambda flat, x, w: flat.value(w),
    "value_and_gradient": lambda flat, x, w: flat.value_and_gradient(w),
    "control": lambda flat, x, w: flat.control(w),
    "hessian_product(w, x)": lambda flat, x, w: flat.hessian_product(w, x),
    "hessian_product(x, w)": lambda flat, x, w: flat.hessian_product(x, w),
}


@pytest.mark.parametrize("call", OF_A_CONTROL.values(), ids=OF_A_CONTROL)
def test_shape_of_a_control(problem: signorini.Problem, call: Callable) -> None:
    """Controls have their shape, not only as many entries: another order of axes is another control."""
    u = direction(problem)
    other = u.T
    assert other.shape != u.shape
    call(problem, u, u)
    for wrong in (other, np.ascontiguousarray(other), u.ravel(), u[None], u[:-1]):
        with pytest.raises(ValueError) as raised:
            call(problem, u, wrong)
        assert str(problem.shape) in str(raised.value)


@pytest.mark.parametrize("call", OF_A_VECTOR.values(), ids=OF_A_VECTOR)
def test_shape_of_a_vector(problem: signorini.Problem, call: Callable) -> None:
    u, flat = direction(problem), problem.replicated()
    x = flat.vector(u)
    call(flat, x, x)
    for wrong in (x[None], x[:, None], u, x[:-1]):
        with pytest.raises(ValueError, match=str(problem.size)):
            call(flat, x, wrong)


def test_shape_of_unknowns(fit: signorini.Fit) -> None:
    for wrong in (fit.start[None], fit.start[:, None], fit.start[:1]):
        with pytest.raises(ValueError) as raised:
            fit.residuals(wrong)
        assert "(2)" in str(raised.value)


ATTRIBUTES = {
    "problem": ("lower", "upper", "times", "lengths", "points", "step_times", "nodes", "metric.weights", "metric.diagonal"),
    "fit": ("start", "lower", "upper", "times", "measured", "deviations"),
}


@pytest.mark.parametrize("owner, name", [(owner, name) for owner, names in ATTRIBUTES.items() for name in names])
def test_attribute_is_read_only(fit: signorini.Fit, owner: str, name: str) -> None:
    """Bounds, lengths, places and data are what later calls compute with: a change in place is refused."""
    array = attrgetter(name)(fit if owner == "fit" else half_disc(4, control__lower=-2, control__upper=1).problem())
    assert array.size > 0
    with pytest.raises(ValueError, match="read-only"):
        array *= 1e3


def test_attributes_can_be_passed_on(fit: signorini.Fit) -> None:
    problem = half_disc(4, control__lower=-2, control__upper=1).problem()
    assert problem.value(problem.lower) == problem.value(problem.lower.copy()) and fit.residuals(fit.start).shape == fit.measured.shape
    assert half_disc(4).problem().lower is None


def test_threads() -> None:
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
    try:
        while rounds < 4:
            found = [problem.gradient(u) for u in controls]
            assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=True))
    finally:
        done.set()
        for worker in workers:
            worker.join()
    assert len(off) > 4 and np.max(off) == 0


FULL = """
import resource, signal
import signorini
from common import half_disc
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
short = {"time__step": 2.5e-4, "optimizer__max_iterations": 1}
scene, tables = half_disc(4, **short), half_disc(4, **short, output__fields=[])
calls = [lambda: scene.simulate("motion"), lambda: tables.simulate("motion")]
if signorini.ranks == 1:
    stored = half_disc(4, **short, trajectory__storage="disk").problem()
    calls += [lambda: scene.optimize("search"), lambda: stored.gradient(stored.zero())]
if signorini.rank == 0:  # which writes the results
    resource.setrlimit(resource.RLIMIT_FSIZE, (1500, resource.RLIM_INFINITY))
for call in calls:
    try:
        call()
    except OSError as error:
        print(error)
"""


@pytest.mark.parametrize("ranks", (1, 2))
def test_full_disk(ranks: int, tmp_path: Path) -> None:
    """What cannot be written is an OSError; of results, on every rank."""
    done = started("-c", FULL, ranks=ranks, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = done.stdout.splitlines()
    assert len(found) == 4 and all("written" in line for line in found)
    assert not (tmp_path / "motion").exists(), "a run is left half written"


ALONE = """
import sys
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


@pytest.mark.parametrize("failure, sentence, mpi4py, problem", (
    ("raise RuntimeError('of rank 1 alone')", "RuntimeError: of rank 1 alone", True, False),
    ("signorini.read('no-such-folder')", "SceneError", False, False),
    ("sys.exit('gone from rank 1')", "gone from rank 1", True, True),
    ("problem.value(np.zeros(3))", "found an array of shape (3)", False, True),
))  # fmt: skip
def test_a_rank_that_fails_alone(failure: str, sentence: str, mpi4py: bool, problem: bool) -> None:
    """It ends all, with its message; none waits for it."""
    done = started("-c", ALONE.format(failure=failure, problem=problem), ranks=2, mpi4py=mpi4py)
    assert done.returncode != 0 and sentence in done.stderr


def test_no_rank_fails() -> None:
    done = started("-c", ALONE.format(failure="problem.value(problem.zero())", problem=True), ranks=2)
    assert done.returncode == 0 and done.stderr == ""


OPTIONS = """
import ctypes, signorini
signorini.rank  # starts MPI and PETSc
petsc = ctypes.CDLL({petsc!r})
found = ctypes.c_int(0)
petsc.PetscOptionsHasName(None, None, ctypes.create_string_buffer(b"-of_a_file"), ctypes.byref(found))
print(found.value)
"""


def test_no_petscrc(tmp_path: Path) -> None:
    """PETSc reads its options from PETSC_OPTIONS, and from no file of the current folder, which could load code."""
    signorini.rank  # noqa: B018 - loads PETSc
    petsc = next(line.split()[-1] for line in Path("/proc/self/maps").read_text().splitlines() if "libpetsc" in line)
    for name in (".petscrc", "petscrc"):
        (tmp_path / name).write_text(f"-of_a_file 1\n-log_view :{tmp_path}/written\n")
    script = OPTIONS.format(petsc=petsc)
    assert started("-c", script, cwd=tmp_path).stdout.split() == ["0"]
    assert not (tmp_path / "written").exists()
    done = started("-c", script, mpi4py=False, cwd=tmp_path, env={"PETSC_OPTIONS": "-of_a_file 1"})
    assert done.stdout.split() == ["1"], "an option that is given is not seen: the case says nothing"


def test_overrides_of_every_kind() -> None:
    scene = half_disc(np.float64(3), control__lower=np.array([-2, -3]), output={"fields": [], "every": 7}, control__initial=("0.5*t", "x"),
                      contact__obstacle__point=[0, -16], optimizer__checkpoint=np.int64(0))  # fmt: skip
    for line in ("size = 3.0", "every = 7", "lower = [", "0.5*t", "checkpoint = 0", "fields = []"):
        assert line in scene.text


def test_path_with_a_quote(tmp_path: Path) -> None:
    copy = tmp_path / 'ümlaut and "quote" ' / "half-disc.toml"
    copy.parent.mkdir()
    copy.write_text((SCENES / "half-disc.toml").read_text())
    assert signorini.Scene(copy, {"mesh.file": SCENES.parent / "meshes/half-disc.geo", "mesh.size": 4}).problem().size > 0


LONG = """
import os, signal, threading, time
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


def test_interrupts() -> None:
    done = started("-c", LONG, mpi4py=False, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines() == ["interrupted"] * 7 + ["after True 1", "run interrupted", "run end of time", "outside"]
