# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever call fails while a run writes, or kills it, its folder has the earlier results or the new ones, whole, and the next run works.

    faults.py SIGNORINI SOURCE LIBRARY [--all]

LIBRARY (tests/faults/fail_nth.c) lets the n-th call fail, all from the n-th on, or kills the process there. Some calls of each
kind and file; --all: every call."""

import hashlib
import json
import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, captured, preloadable  # noqa: E402

import h5py  # noqa: E402

LIBRARY = Path(sys.argv[3]).resolve()
EVERY = "--all" in sys.argv[4:]
ENOSPC, EIO = 28, 5
EARLY = {"history.csv", "checkpoint.h5"}  # appear while a search goes on
LOCK = ".signorini-lock"
STEPS = 20
SMALL = ("mesh.size=6", f"time.end={STEPS * 5e-5}", "output.every=10", "optimizer.max_iterations=2", "optimizer.checkpoint=1")
Results = dict[str, str]


def read_all(file: Path) -> str:
    """The values of all datasets; HDF5's own bytes hold times."""
    found = []
    with h5py.File(file) as data:
        data.visititems(lambda name, item: found.append((name, item[()].tobytes())) if isinstance(item, h5py.Dataset) else None)
    return repr(sorted((name, hashlib.sha256(values).hexdigest()) for name, values in found))


def without_seconds(text: str) -> str:
    rows = [line.split(",") for line in text.splitlines()]
    at = rows[0].index("seconds")
    return repr([row[:at] + row[at + 1 :] for row in rows])


def results(folder: Path) -> Results:
    """What files there are and what they say, but for times; fails where one is damaged."""
    found = {}
    for path in folder.iterdir() if folder.exists() else ():
        if path.name.startswith("."):
            continue
        if path.suffix == ".h5":
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


@dataclass
class Outcome:
    status: int
    stderr: str
    calls: list[str]  # "kind path"

    def failed_at(self, n: int) -> str:
        return self.calls[n - 1]


@dataclass
class Run:
    """A verb that writes to a folder, with one of two parameters so that its results can be told from earlier ones."""

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
        env = {"TMPDIR": str(self.root / "scratch"), "LD_PRELOAD": preloadable(LIBRARY, self.root),
               "SIGNORINI_FAIL_UNDER": str(self.root / under), "SIGNORINI_FAIL_AT": str(at),
               "SIGNORINI_FAIL_ERROR": str(error), "SIGNORINI_FAIL_LOG": str(log)} | ({"SIGNORINI_FAIL_FROM": "1"} if onwards else {})  # fmt: skip
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

    def expect(self) -> None:
        for young in (1e8, 2e8):
            shutil.rmtree(self.out, ignore_errors=True)
            done = self(young)
            assert done.status == 0, done.stderr
            assert not [path for path in self.out.iterdir() if path.name.startswith(".")]
            self.expected[young] = results(self.out)
        assert self.expected[1e8] != self.expected[2e8]

    def whole(self, *allowed: Results) -> Results:
        """Which of the sets of results there is in the folder, and nothing of the others but what a search shows early."""
        found = results(self.out)
        for one in allowed:
            if set(found) | EARLY == set(one) | EARLY and all(found[name] == one[name] for name in set(one) - EARLY):
                return one
        names = {name: [found.get(name) == one.get(name) for one in allowed] for name in sorted(set(found).union(*allowed))}
        raise AssertionError(f"a mixture: {names}")


def one_sentence(done: Outcome, ranks: int) -> None:
    own = [line for line in done.stderr.splitlines() if line.startswith("signorini: ")]
    assert done.status == 2 and len(own) == 1, (done.status, done.stderr)
    assert ranks > 1 or len(done.stderr.splitlines()) == 1, done.stderr
    assert ".unfinished" not in own[0], own[0]


def chosen(calls: list[str], most: int, start: int = 1) -> list[int]:
    """Numbers of calls from `start` on: at most so many, of all kinds and files; those that move files come first. Open MPI's own folder
    for temporary files is left in peace: without it, MPI does not start."""
    groups: dict[str, list[int]] = {}
    for n, call in list(enumerate(calls, 1))[start - 1 :]:
        kind, path = call.split(" ", 1)
        if path.startswith("scratch/ompi."):
            continue
        groups.setdefault(str(n) if kind == "rename" else kind + Path(path).name if kind in ("open", "write", "create") else kind, []).append(n)
    if EVERY:
        return sorted(n for numbers in groups.values() for n in numbers)
    first = [random.choice(numbers) for numbers in groups.values()]
    random.shuffle(first)
    first.sort(key=lambda n: not calls[n - 1].startswith("rename"))
    return sorted(first[:most])


def fails_once(run: Run, most: int) -> str:
    """A call fails: exit status 2, one sentence and the earlier results, or it did not matter. In an empty folder and over results."""
    count, states = 0, Counter()
    shutil.rmtree(run.out, ignore_errors=True)
    over_nothing = run(1e8).calls
    for n in chosen(over_nothing, most // 4):
        shutil.rmtree(run.out, ignore_errors=True)
        done = run(1e8, n, random.choice((ENOSPC, EIO)))
        if done.status:
            one_sentence(done, run.ranks)
            found = results(run.out)
            assert not set(found) - EARLY, (found.keys(), done.failed_at(n))
            left = {path.name for path in run.out.iterdir()} if run.out.exists() else set()
            assert left <= EARLY | {LOCK}, (left, done.failed_at(n))
            assert found or LOCK not in left
        else:
            assert run.whole(run.expected[1e8])
        count += 1
        states["none" if done.status else "new"] += 1
    there, next_one = 1e8, 2e8
    shutil.rmtree(run.out, ignore_errors=True)
    assert run(there).status == 0
    over_results = run(next_one).calls
    there, next_one = next_one, there
    for n in chosen(over_results, most):
        done = run(next_one, n, random.choice((ENOSPC, EIO)))
        try:
            if done.status:
                one_sentence(done, run.ranks)
            found = run.whole(run.expected[next_one if done.status == 0 else there])
            hidden = {path.name for path in run.out.iterdir() if path.name.startswith(".")}
            # What could not be removed after the new results had come to their places is in nobody's way.
            tidying = done.status == 0 and (done.failed_at(n).startswith("remove") or ".finished" in done.failed_at(n))
            assert not hidden or tidying, hidden
        except (AssertionError, OSError) as problem:
            raise AssertionError(f"call {n}, {done.failed_at(n)}: exit status {done.status}: {problem}") from problem
        if found is run.expected[next_one]:
            there, next_one = next_one, there
        states["new" if done.status == 0 else "old"] += 1
        count += 1
    assert run(next_one).status == 0 and run.whole(run.expected[next_one])
    assert not [path for path in run.out.iterdir() if path.name.startswith(".")]
    return f"{run.verb} on {run.ranks}: {count} of {len(over_nothing) + len(over_results)} calls failed: {dict(states)}"


def comes_next(run: Run) -> None:
    """A run that fails as soon as it has its folder, which it tidies up before."""
    done = Run(run.verb, run.root, (*run.sets, "contact.on=nothing"))(1e8)
    assert done.status == 2 and "contact.on" in done.stderr, done.stderr
    left = {path.name for path in run.out.iterdir() if path.name.startswith(".")} - {LOCK}
    assert not left, left


def ends_there(run: Run, most: int, error: object) -> str:
    """The process is killed at a call, or from there on none goes through: the next run makes the folder whole."""
    count, states = 0, Counter()
    shutil.rmtree(run.out, ignore_errors=True)
    assert run(1e8).status == 0
    calls = run(2e8).calls
    publishes = next(n for n, call in enumerate(calls, 1) if call.endswith("/replaced"))
    numbers = chosen(calls[: publishes - 1], most // 5) + chosen(calls, most, publishes)
    there, next_one = 2e8, 1e8
    for n in numbers:
        done = run(next_one, n, error, onwards=error != "kill")
        try:
            assert done.status in ((-9, 0) if error == "kill" else (2, 0)), done.stderr
            waits = (run.out / ".finished" / "replaced").exists()
            if not waits:
                run.whole(run.expected[there], run.expected[next_one])
            comes_next(run)
            found = run.whole(run.expected[there], run.expected[next_one])
            assert found is run.expected[next_one] or not waits
        except (AssertionError, OSError) as problem:
            raise AssertionError(f"{error} at {n}, {done.failed_at(n)}: exit status {done.status}: {problem}") from problem
        states["new by the next run" if waits else "new" if found is run.expected[next_one] else "old"] += 1
        if found is run.expected[next_one]:
            there, next_one = next_one, there
        count += 1
    return f"{run.verb}: {count} of {len(calls)} calls {'killed' if error == 'kill' else 'failed with all that followed'}: {dict(states)}"


def interrupted(run: Run, most: int) -> str:
    """SIGINT before there is anything leaves the earlier results, SIGINT while the new ones are written does not keep them off."""
    shutil.rmtree(run.out, ignore_errors=True)
    assert run(1e8).status == 0
    calls = run(2e8).calls
    writes = next(n for n, call in enumerate(calls, 1) if call.startswith("create") and call.endswith("/steps.csv"))
    for n in range(1, 4):
        done = run(1e8, n, "interrupt")
        assert done.status == 130 and "interrupted" in done.stderr, (done.status, done.failed_at(n))
        run.whole(run.expected[2e8])
    numbers, young = chosen(calls, most, writes), 2e8
    for n in numbers:
        young = 3e8 - young
        done = run(young, n, "interrupt")
        assert done.status == 0, (done.status, done.stderr, done.failed_at(n))
        run.whole(run.expected[young])
    return f"{run.verb}: SIGINT at 3 calls of the set-up: old; at {len(numbers)} while results are written: new"


def first_sweep(run: Run) -> str:
    """SIGINT while the first state of all is computed, from the first guess or from a checkpoint, leaves everything as it was.
    States are on disk, so that the calls that write them tell how far the sweep is."""
    scratch = run.root / "scratch"
    none = ("--set", "optimizer.max_iterations=0")

    def go(at: int, *options: str) -> Outcome:
        return run(1e8, at, "interrupt", under=scratch.name, options=options)

    def content() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in run.out.iterdir()} if run.out.exists() else {}

    shutil.rmtree(run.out)
    writes = [n for n, call in enumerate(go(0, *none).calls, 1) if call.startswith("write") and "signorini-" in call]
    middle = writes[STEPS // 2]  # of the first sweep: from the first guess a linearised one follows, whose states are written too
    before = content()
    assert len(writes) > STEPS and "checkpoint.h5" in before
    for options in ((), ("--resume",)):
        done = go(middle, *options)
        assert done.status == 130 and len(done.stderr.splitlines()) <= 1 + 8 * (run.ranks > 1), (done.status, done.stderr)
        assert content() == before, "earlier results were replaced by those of no sweep"
    assert go(0, "--resume").status == 0 and content() != before
    shutil.rmtree(run.out)
    assert go(middle).status == 130 and not run.out.exists(), "something was left of nothing"
    return f"optimize on {run.ranks}: SIGINT in the first sweep leaves all as it was"


def main() -> int:
    random.seed(1)
    with tempfile.TemporaryDirectory() as name:

        def work(number_and_part: tuple[int, tuple]) -> str:
            number, (verb, sets, ranks, part, *more) = number_and_part
            root = Path(name).resolve() / str(number)
            root.mkdir()
            run = Run(verb, root, sets, ranks)
            run.expect()
            return part(run, *more)

        on_disk = ('trajectory.storage="disk"', 'objective.desired={ displacement = ["0", "-t"] }')
        parts = [("optimize", (), 1, fails_once, 40), ("optimize", (), 1, ends_there, 16, "kill"), ("simulate", (), 1, fails_once, 16),
                 ("optimize", (), 1, ends_there, 8, EIO), ("simulate", (), 1, ends_there, 8, "kill"), ("optimize", (), 1, interrupted, 6),
                 ("optimize", (), 2, fails_once, 8), ("optimize", on_disk, 1, first_sweep), ("optimize", on_disk, 2, first_sweep)]  # fmt: skip
        with ThreadPoolExecutor(2) as workers:
            for said in workers.map(work, enumerate(parts)):
                print(said, flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
