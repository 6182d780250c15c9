# SPDX-License-Identifier: GPL-3.0-or-later
"""A search that was stopped goes on to the last bit: after SIGINT, after kill -9 at random moments, with each method; on another
number of ranks to rounding; and not from a damaged checkpoint or one of another problem.

    resume.py SIGNORINI SOURCE [--kills N | --ranks]

--ranks: on other numbers of ranks, and what is refused there, alone.
"""

import argparse
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, captured, table  # noqa: E402

import numpy as np  # noqa: E402

# Iterations enough to be among the kinks for a while.
USUAL = {"mesh.size": "3", "time.end": "4e-3", "output.fields": "[]", "optimizer.checkpoint": "1", "optimizer.max_iterations": "80"}


def command(out: Path, *options: str, ranks: int = 1, scene: Path = HALF_DISC, **overrides: str) -> list[str]:
    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    sets = USUAL | {key.replace("__", "."): value for key, value in overrides.items()}
    return [*mpirun, str(SIGNORINI), "optimize", str(scene), "--out", str(out), *options,
            *(word for key, value in sets.items() for word in ("--set", f"{key}={value}"))]  # fmt: skip


def run(out: Path, *options: str, **more: object) -> subprocess.CompletedProcess:
    return captured(command(out, *options, **more))


def complete(out: Path, *options: str, **more: object) -> str:
    done = run(out, *options, **more)
    assert done.returncode == 0, f"{done.args} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
    return done.stdout


def results(out: Path) -> list[str]:
    """What must not depend on interruptions: history.csv but for the seconds, and the motion."""
    rows = [line.split(",") for line in (out / "history.csv").read_text().splitlines()]
    seconds = rows[0].index("seconds")
    return [",".join(row[:seconds] + row[seconds + 1 :]) for row in rows] + (out / "steps.csv").read_text().splitlines()


def killed(out: Path, after: float, which: signal.Signals = signal.SIGKILL) -> bool:
    """Lets a run go on for a while; whether it was still at it when it was stopped."""
    process = subprocess.Popen(command(out, "--resume"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(after)
    if process.poll() is not None:
        assert process.returncode == 0, f"ended with {process.returncode}"
        return False
    process.send_signal(which)
    process.wait(timeout=60)
    return True


def kills(folder: Path, whole: list[str], seconds: float, count: int) -> None:
    out, done, completed, from_checkpoint = folder / "killed", 0, 0, 0
    while done < count:
        had = (out / "checkpoint.h5").exists()
        if killed(out, random.uniform(0.05, 0.45 * seconds)):
            done += 1
            from_checkpoint += had
            rows = (out / "history.csv").read_text() if (out / "history.csv").exists() else "\n"
            assert rows.endswith("\n"), "half a line"
            continue
        assert results(out) == whole, "the result differs from that of a run in one piece"
        completed += 1
        shutil.rmtree(out)
    said = complete(out, "--resume") # what the last kill left
    assert ("resumed after iteration" in said) == had or not had
    assert results(out) == whole, "the result differs from that of a run in one piece"
    left = [path.name for path in out.iterdir() if path.name.startswith(".")]
    assert not left, f"{left} were left behind"
    assert from_checkpoint >= np.maximum(1, count // 4), f"{from_checkpoint} of {count} killed runs had a checkpoint to go on from"
    print(f"kill -9: {count} times, {from_checkpoint} of them in a run that had been resumed; {completed + 1} runs came to their end, "
          "all with the results of a run in one piece")  # fmt: skip


def methods(folder: Path) -> None:
    """Stopped in smooth parts of the search and among kinks, where an iteration gathers many gradients."""
    gathered = np.diff(table(folder / "lbfgs" / "history.csv")["adjoint_sweeps"])  # by iterations 1, 2, …
    kink = int(np.argmax(gathered > 10)) + 1
    assert gathered[kink - 1] > 10 and gathered[:15].max() < 3, gathered
    for method, most, steps in (("lbfgs", 80, (15, kink)), ("newton-cg", 25, (2, 12)), ("projected-gradient", 20, (10,))):
        whole, choice = folder / method, {"optimizer__method": f'"{method}"'}
        if method != "lbfgs":  # which is there already
            complete(whole, **choice, optimizer__max_iterations=str(most))
        for step in steps:
            out = folder / f"{method}-{step}"
            complete(out, **choice, optimizer__max_iterations=str(step))
            said = complete(out, "--resume", **choice, optimizer__max_iterations=str(most))
            assert f"resumed after iteration {step}" in said, said
            assert results(out) == results(whole), f"{method} after {step} iterations"
        print(f"{method}: the same to the last bit when resumed after {', '.join(map(str, steps))} iterations")


def interrupted(folder: Path, whole: list[str]) -> None:
    """SIGINT in the middle of an iteration, with no periodic checkpoint."""
    out = folder / "interrupted"
    process = subprocess.Popen(command(out, optimizer__checkpoint="1000"), stdout=subprocess.DEVNULL)
    while not (out / "history.csv").exists() or (out / "history.csv").read_text().count("\n") < 25:
        assert process.poll() is None, "ended too early"
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    rows = len(table(out / "history.csv")["iteration"])
    assert 24 <= rows < 45
    complete(out, "--resume", optimizer__checkpoint="1000")
    assert results(out) == whole
    print(f"SIGINT after iteration {rows - 1}: the same to the last bit when resumed")


def chosen(folder: Path) -> None:
    """Steps that the motion chose stay: those of the checkpoint."""
    auto = {"time__step": '"auto"', "time__tolerance": "1e-2", "time__end": "7.5e-3", "mesh__size": "2"}
    whole, out = folder / "chosen", folder / "chosen-resumed"
    complete(whole, **auto, optimizer__max_iterations="12")
    complete(out, **auto, optimizer__max_iterations="5")
    assert "resumed after iteration 5" in complete(out, "--resume", **auto, optimizer__max_iterations="12")
    assert results(out) == results(whole)
    lengths = np.diff(table(whole / "steps.csv")["time"])
    assert np.max(lengths) > 1.5 * np.min(lengths), "all are of one length"
    print(f"chosen steps: {len(lengths)} of two lengths or more, the same to the last bit when resumed")


def ranks(folder: Path) -> None:
    """From one rank to two and back: J as that of the run in one piece, until kinks magnify the rounding."""
    whole, out = folder / "whole", folder / "ranks"
    complete(whole, optimizer__max_iterations="20")
    complete(out, optimizer__max_iterations="8")
    complete(out, "--resume", optimizer__max_iterations="12", ranks=2)
    complete(out, "--resume", optimizer__max_iterations="16", ranks=3)
    complete(out, "--resume", optimizer__max_iterations="20")
    there, here = (table(folder_ / "history.csv")["objective"] for folder_ in (whole, out))
    difference = np.abs(here / there[: len(here)] - 1)
    assert len(here) == 21 and difference[:9].max() == 0
    assert difference.max() < 1e-9, difference
    good = (out / "checkpoint.h5").read_bytes()
    refuses_other_problems(out, 2)
    (out / "checkpoint.h5").write_bytes(good[:-1])
    refuses(out, "damaged", ranks=2)
    print(f"8 iterations on 1 rank, 4 on 2, 4 on 3, 4 on 1: J differs by {difference.max():.1e} at most")


def refuses(out: Path, *texts: str, ranks: int = 1, scene: Path = HALF_DISC, **overrides: str) -> None:
    done = run(out, "--resume", ranks=ranks, scene=scene, **overrides)
    lines = done.stderr.split("\n---")[0].strip().splitlines()  # of several ranks mpirun says something too
    assert done.returncode == 2 and len(lines) == 1, f"{done.returncode}: {done.stdout}{done.stderr}"
    assert "checkpoint.h5" in lines[0] and all(text in lines[0] for text in texts), lines[0]
    assert (out / "checkpoint.h5").exists()
    print("  " + lines[0].replace(str(out), "…"))


def refuses_other_problems(out: Path, ranks: int = 1) -> None:
    refuses(out, "objective.alpha = 0.01", "objective.alpha = 0.1;", objective__alpha="0.1", ranks=ranks)
    refuses(out, "mesh.size", mesh__size="1.5", ranks=ranks)
    refuses(out, "optimizer.method", optimizer__method='"newton-cg"', ranks=ranks)
    # The same keys name another mesh, or one whose groups have other elements, even where nothing touches.
    for i, (old, new) in enumerate((("radius = 15", "radius = 15.001"), ('"side") = {2, 4}', '"side") = {2}'))):
        other = out.parent / f"{out.name}-other-{i}" / "scenes" / HALF_DISC.name
        if not other.exists():
            other.parent.mkdir(parents=True)
            shutil.copytree(SOURCE / "meshes", other.parents[1] / "meshes")
            shutil.copy(HALF_DISC, other)
            geo = other.parents[1] / "meshes" / "half-disc.geo"
            text = geo.read_text()
            assert old in text
            geo.write_text(text.replace(old, new))
        refuses(out, "on another mesh", scene=other, ranks=ranks)


def refused(folder: Path) -> None:
    out = folder / "refused"
    complete(out, optimizer__max_iterations="5")
    good = (out / "checkpoint.h5").read_bytes()
    refuses_other_problems(out)
    # What is known of the solution does not pose another problem.
    assert "resumed after" in complete(out, "--resume", optimizer__max_iterations="5", exact__impulse="1.0")
    (out / "checkpoint.h5").write_bytes(good)
    for damaged in (good[: len(good) // 2], b"", b"x" * 1000, good[:-1]):
        (out / "checkpoint.h5").write_bytes(damaged)
        refuses(out, "damaged")
    refuses_or_is_whole(folder, out, good)


def refuses_or_is_whole(folder: Path, out: Path, good: bytes) -> None:
    """One byte changed anywhere: either it is refused, or it was one that nobody reads."""
    (out / "checkpoint.h5").write_bytes(good)
    complete(out, "--resume", optimizer__max_iterations="6")
    whole, refusals = results(out), 0
    places = random.sample(range(len(good)), 20)
    for place in places:
        (out / "checkpoint.h5").write_bytes(good[:place] + bytes([good[place] ^ 0x40]) + good[place + 1 :])
        done = run(out, "--resume", optimizer__max_iterations="6")
        if done.returncode == 2:
            refusals += 1
        else:
            assert done.returncode == 0 and results(out) == whole, f"byte {place}: {done.returncode} {done.stderr}"
    assert refusals > 10
    print(f"one byte changed: {refusals} of {len(places)} checkpoints refused, the others unharmed")


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=6)
    parser.add_argument("--ranks", action="store_true")
    options = parser.parse_args(sys.argv[3:])
    random.seed(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.ranks:
            ranks(folder)
            return 0
        start = time.monotonic()
        complete(folder / "lbfgs")
        seconds, whole = time.monotonic() - start, results(folder / "lbfgs")
        options.kills and kills(folder, whole, seconds, options.kills)
        methods(folder)
        interrupted(folder, whole)
        chosen(folder)
        refused(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
