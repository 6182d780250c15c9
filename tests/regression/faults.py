# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever call fails while a run writes, or kills it, its folder has the earlier results or the new ones, whole, and the next run works.

FAULTS (tests/faults/fail_nth.c) lets the n-th call fail, all from the n-th on, or kills the process there. The tests called "sample"
take some calls of each kind and file, those called "all", which take minutes, every call."""

import hashlib
import json
import os
import random
import shutil
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import pytest
from harness import FAULTS, HALF_DISC, SIGNORINI, captured, preloadable

ENOSPC, EIO = 28, 5
EARLY = {"history.csv", "checkpoint.h5"}  # appear before a search has ended
LOCK = ".signorini-lock"
STEPS = 20
SMALL = ("mesh.size=6", f"time.end={STEPS * 5e-5}", "output.every=10", "optimizer.max_iterations=2", "optimizer.checkpoint=1")
Results = dict[str, str]


def read_all(file: Path) -> str:
    """The values of all datasets; HDF5's own bytes contain times."""
    found = []
    with h5py.File(file) as data:
        data.visititems(lambda name, item: found.append((name, item[()].tobytes())) if isinstance(item, h5py.Dataset) else None)
    return repr(sorted((name, hashlib.sha256(values).hexdigest()) for name, values in found))


def without_seconds(text: str) -> str:
    rows = [line.split(",") for line in text.splitlines()]
    at = rows[0].index("seconds")
    return repr([row[:at] + row[at + 1 :] for row in rows])


def results(folder: Path) -> Results:
    """The files of a folder and what they say, but for times; fails where one is damaged."""
    found = {}
    for path in folder.iterdir() if folder.exists() else ():
        if path.name.startswith("."):
            continue
        if path.suffix in (".h5", ".vtkhdf"):
            found[path.name] = read_all(path)
        elif path.name == "run.json":
            run = json.loads(path.read_text())
            found[path.name] = repr([(key, run[key]) for key in sorted(run) if key not in ("finished", "timings", "peak_memory_bytes")])
        elif path.name == "history.csv":
            assert path.read_text().endswith("\n"), "half a line"
            found[path.name] = without_seconds(path.read_text())
        else:
            found[path.name] = path.read_text()
    return found


def hidden(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.name.startswith(".")} if folder.exists() else set()


@dataclass
class Outcome:
    status: int
    stderr: str
    calls: list[str]  # "kind path"

    def failed_at(self, n: int) -> str:
        return self.calls[n - 1]


@dataclass
class Run:
    """A verb that writes to a folder, with one of two parameters by which its results differ from earlier ones."""

    verb: str
    root: Path
    sets: tuple[str, ...] = ()
    ranks: int = 1
    expected: dict[float, Results] = field(default_factory=dict)

    @property
    def out(self) -> Path:
        return self.root / "out"

    def __call__(self, young: float, at: int = 0, error: object = ENOSPC, onwards: bool = False, under: str = "",
                 options: tuple[str, ...] = ()) -> Outcome:  # fmt: skip
        log = self.root / "log"
        log.unlink(missing_ok=True)
        (self.root / "scratch").mkdir(exist_ok=True)
        env = {"TMPDIR": str(self.root / "scratch"), "LD_PRELOAD": preloadable(FAULTS, self.root),
               "SIGNORINI_FAIL_UNDER": str(self.root / under), "SIGNORINI_FAIL_AT": str(at),
               "SIGNORINI_FAIL_ERROR": str(error), "SIGNORINI_FAIL_LOG": str(log)}  # fmt: skip
        if onwards:
            env["SIGNORINI_FAIL_FROM"] = "1"
        command = [str(SIGNORINI), self.verb, str(HALF_DISC), "--quiet", "--out", str(self.out)]
        for assignment in (*SMALL, *self.sets, f"material.young={young}"):
            command += ["--set", assignment]
        command += options
        if self.ranks > 1:  # mpirun itself is left in peace
            command = ["mpirun", "--oversubscribe", "-n", str(self.ranks), "env", *(f"{k}={v}" for k, v in env.items()), *command]
            env = {}
        done = captured(command, timeout=120, env=os.environ | env)
        calls = [line.split(" ", 1)[1] for line in log.read_text().splitlines()] if log.exists() else []
        return Outcome(done.returncode, done.stderr, calls)

    def afresh(self, young: float) -> None:
        """Runs in an empty folder."""
        shutil.rmtree(self.out, ignore_errors=True)
        done = self(young)
        assert done.status == 0 and not hidden(self.out), done.stderr

    def whole(self, *allowed: Results) -> Results:
        """Which of the sets of results there is in the folder, and nothing of the others but what a search shows early."""
        found = results(self.out)
        for one in allowed:
            if set(found) | EARLY == set(one) | EARLY and all(found[name] == one[name] for name in set(one) - EARLY):
                return one
        names = {name: [found.get(name) == one.get(name) for one in allowed] for name in sorted(set(found).union(*allowed))}
        raise AssertionError(f"a mixture: {names}")


def prepared(verb: str, root: Path, sets: tuple[str, ...] = (), ranks: int = 1) -> Run:
    """A run that knows the results of both parameters; those of 2e8 are in its folder."""
    run = Run(verb, root, sets, ranks)
    for young in (1e8, 2e8):
        run.afresh(young)
        run.expected[young] = results(run.out)
    assert run.expected[1e8] != run.expected[2e8]
    return run


def one_sentence(done: Outcome, ranks: int) -> None:
    own = [line for line in done.stderr.splitlines() if line.startswith("signorini: ")]
    assert done.status == 2 and len(own) == 1, (done.status, done.stderr)
    assert ranks > 1 or len(done.stderr.splitlines()) == 1, done.stderr
    assert ".unfinished" not in own[0]


def chosen(calls: list[str], most: int | None, start: int = 1) -> list[int]:
    """Numbers of calls from `start` on: all, or at most so many, of all kinds and files; those that move files come first. Open MPI's
    own folder for temporary files is left in peace: without it, MPI does not start."""
    groups: dict[str, list[int]] = {}
    for n, call in list(enumerate(calls, 1))[start - 1 :]:
        kind, path = call.split(" ", 1)
        if path.startswith("scratch/ompi."):
            continue
        of_a_file = kind in ("open", "write", "create")
        groups.setdefault(str(n) if kind == "rename" else kind + Path(path).name if of_a_file else kind, []).append(n)
    if most is None:
        return sorted(n for numbers in groups.values() for n in numbers)
    first = [random.choice(numbers) for numbers in groups.values()]
    random.shuffle(first)
    first.sort(key=lambda n: not calls[n - 1].startswith("rename"))
    return sorted(first[:most])


@pytest.fixture(autouse=True)
def same_calls_each_time() -> None:
    random.seed(1)


def sampled(*cases: tuple) -> list:
    """Each case, whose last value is how many calls its sample has, and besides with every call."""
    return [pytest.param(*case, id="-".join(map(str, (*case[:-1], "sample")))) for case in cases] + [
        pytest.param(*case[:-1], None, id="-".join(map(str, (*case[:-1], "all"))), marks=pytest.mark.long) for case in cases
    ]


@pytest.mark.parametrize("verb, ranks, most", sampled(("optimize", 1, 10), ("optimize", 2, 2), ("simulate", 1, 4)))
def test_failed_call_in_an_empty_folder(verb: str, ranks: int, most: int | None, tmp_path: Path) -> None:
    """Exit status 2, one sentence and no results, or it did not matter."""
    run, states = prepared(verb, tmp_path, ranks=ranks), Counter()
    shutil.rmtree(run.out)
    calls = run(1e8).calls
    for n in chosen(calls, most):
        shutil.rmtree(run.out, ignore_errors=True)
        done = run(1e8, n, random.choice((ENOSPC, EIO)))
        if done.status:
            one_sentence(done, ranks)
            found = results(run.out)
            left = {path.name for path in run.out.iterdir()} if run.out.exists() else set()
            assert not set(found) - EARLY and left <= EARLY | {LOCK}, done.failed_at(n)
            assert found or LOCK not in left, done.failed_at(n)
        else:
            assert run.whole(run.expected[1e8])
        states["none" if done.status else "new"] += 1
    print(f"{sum(states.values())} of {len(calls)} calls failed: {dict(states)}")


@pytest.mark.parametrize("verb, ranks, most", sampled(("optimize", 1, 40), ("optimize", 2, 8), ("simulate", 1, 16)))
def test_failed_call_over_results(verb: str, ranks: int, most: int | None, tmp_path: Path) -> None:
    """Exit status 2, one sentence and the earlier results, or it did not matter."""
    run, states = prepared(verb, tmp_path, ranks=ranks), Counter()
    run.afresh(1e8)
    calls = run(2e8).calls
    there, next_one = 2e8, 1e8
    for n in chosen(calls, most):
        done = run(next_one, n, random.choice((ENOSPC, EIO)))
        try:
            if done.status:
                one_sentence(done, ranks)
            found = run.whole(run.expected[next_one if done.status == 0 else there])
            # What could not be removed after the new results had come to their places is in nobody's way.
            tidying = done.status == 0 and (done.failed_at(n).startswith("remove") or ".finished" in done.failed_at(n))
            assert not hidden(run.out) or tidying
        except (AssertionError, OSError) as problem:
            raise AssertionError(f"call {n}, {done.failed_at(n)}: exit status {done.status}: {problem}") from problem
        if found is run.expected[next_one]:
            there, next_one = next_one, there
        states["new" if done.status == 0 else "old"] += 1
    assert run(next_one).status == 0 and run.whole(run.expected[next_one])
    assert not hidden(run.out)
    print(f"{sum(states.values())} of {len(calls)} calls failed: {dict(states)}")


def tidied_by_a_run_that_fails(run: Run) -> None:
    """A run that fails as soon as it has its folder, which it tidies up before."""
    done = Run(run.verb, run.root, (*run.sets, "contact.on=nothing"))(1e8)
    assert done.status == 2 and "contact.on" in done.stderr, done.stderr
    assert not hidden(run.out) - {LOCK}


@pytest.mark.parametrize("verb, error, most", sampled(("optimize", "kill", 16), ("optimize", EIO, 8), ("simulate", "kill", 8)))
def test_next_run_makes_the_folder_whole(verb: str, error: object, most: int | None, tmp_path: Path) -> None:
    """The process is killed at a call, or from there on all calls fail."""
    run, states = prepared(verb, tmp_path), Counter()
    run.afresh(1e8)
    calls = run(2e8).calls
    publishes = next(n for n, call in enumerate(calls, 1) if call.endswith("/replaced"))
    there, next_one = 2e8, 1e8
    for n in chosen(calls[: publishes - 1], most and most // 5) + chosen(calls, most, publishes):
        done = run(next_one, n, error, onwards=error != "kill")
        try:
            assert done.status in ((-9, 0) if error == "kill" else (2, 0)), done.stderr
            waits = (run.out / ".finished" / "replaced").exists()
            if not waits:
                run.whole(run.expected[there], run.expected[next_one])
            tidied_by_a_run_that_fails(run)
            found = run.whole(run.expected[there], run.expected[next_one])
            assert found is run.expected[next_one] or not waits
        except (AssertionError, OSError) as problem:
            raise AssertionError(f"call {n}, {done.failed_at(n)}: exit status {done.status}: {problem}") from problem
        states["new by the next run" if waits else "new" if found is run.expected[next_one] else "old"] += 1
        if found is run.expected[next_one]:
            there, next_one = next_one, there
    print(f"{sum(states.values())} of {len(calls)} calls: {dict(states)}")


def test_interrupt_before_there_are_results(tmp_path: Path) -> None:
    """It leaves the earlier ones."""
    run = prepared("optimize", tmp_path)
    for n in range(1, 4):
        done = run(1e8, n, "interrupt")
        assert done.status == 130 and "interrupted" in done.stderr, done.failed_at(n)
        run.whole(run.expected[2e8])


@pytest.mark.parametrize("verb, most", sampled(("optimize", 6)))
def test_interrupt_while_results_are_written(verb: str, most: int | None, tmp_path: Path) -> None:
    """It does not keep them off."""
    run, young = prepared(verb, tmp_path), 2e8
    run.afresh(1e8)
    calls = run(young).calls
    writes = next(n for n, call in enumerate(calls, 1) if call.startswith("create") and call.endswith("/steps.csv"))
    for n in chosen(calls, most, writes):
        young = 3e8 - young
        done = run(young, n, "interrupt")
        assert done.status == 0, (done.stderr, done.failed_at(n))
        run.whole(run.expected[young])


@pytest.mark.parametrize("ranks", (1, 2))
def test_interrupt_in_the_first_sweep(ranks: int, tmp_path: Path) -> None:
    """While the first state of all is computed, from the first guess or from a checkpoint, it leaves everything as it was. States are on
    disk, so that the calls that write them show the progress of the sweep."""
    run = prepared("optimize", tmp_path, ('trajectory.storage="disk"', 'objective.desired={ displacement = ["0", "-t"] }'), ranks)

    def go(at: int, *options: str) -> Outcome:
        return run(1e8, at, "interrupt", under="scratch", options=options)

    def content() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in run.out.iterdir()} if run.out.exists() else {}

    shutil.rmtree(run.out)
    first = go(0, "--set", "optimizer.max_iterations=0")
    writes = [n for n, call in enumerate(first.calls, 1) if call.startswith("write") and "signorini-" in call]
    middle = writes[STEPS // 2]  # of the first sweep: from the first guess a linearised one follows, whose states are written too
    before = content()
    assert len(writes) > STEPS and "checkpoint.h5" in before
    for options in ((), ("--resume",)):
        done = go(middle, *options)
        assert done.status == 130 and len(done.stderr.splitlines()) <= 1 + 8 * (ranks > 1), (options, done.stderr)
        assert content() == before, "earlier results were replaced by those of no sweep"
    assert go(0, "--resume").status == 0 and content() != before
    shutil.rmtree(run.out)
    assert go(middle).status == 130 and not run.out.exists(), "something was left of nothing"
