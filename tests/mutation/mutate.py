# SPDX-License-Identifier: GPL-3.0-or-later
"""How many mistakes the tests notice: changes single tokens of the sources, each in turn, and runs the tests.

    mutate.py CHECKOUT BUILD COUNT SEED    draws that many mutants of the parts below
    mutate.py CHECKOUT BUILD FILE.diff…    tries again what an earlier call wrote

All is done in copies below BUILD. A mutant is drawn from all tokens alike (sites.py says which, and what becomes of them)
and counts if it compiles. It meets the unit tests of its part, the derivative tests and the unit tests of what is built on the part, on
one rank and then on two, until one fails, ends by a signal or takes too long. Those that none of them notices are printed at the
end and left in BUILD/survivors. Each test must pass with the sound code before it judges a mutant. The exit status is 1 if fewer than 90 % were noticed.
"""

import collections
import filecmp
import hashlib
import itertools
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from sites import Source

# The parts, and what is tested beside a part's own unit tests: by `check`, and by the unit tests of what is built on it.
BESIDE = {
    "contact": [r"derivative\.", r"unit\.forward\.", r"unit\.(adjoint|control)\."],
    "forward": [r"derivative\.", r"unit\.(contact|adjoint|control)\."],  # the tests of contact make steps
    "adjoint": [r"derivative\.", r"unit\.control\."],
    "control": [r"derivative\.", r"unit\.adjoint\."],
    "linalg": [r"unit\.(base|optimize|contact)\."],  # its tests are among those of base
    "optimize": [],
}
MOST_RANKS = 2
PROGRAMS = ["signorini", "signorini-unit"]
COPIED = ["CMakeLists.txt", "cpp", "forms", "meshes", "scenes", "tests"]
ENOUGH = 0.9
PATIENCE = 10  # times the seconds of the sound code, and seconds beside: other work on the machine makes no mutant


@dataclass
class Test:
    name: str
    command: list[str]
    environment: dict[str, str]

    @property
    def ranks(self) -> int:
        return int(self.command[self.command.index("-n") + 1]) if "-n" in self.command else 1


class Copy:
    """The sources in a folder of their own, where they are changed, built and tested."""

    def __init__(self, checkout: Path, build: Path):
        self.checkout, self.build, self.source = checkout, build, build / "source"
        self.passed = build / "passed.json"  # the seconds of the tests that the sound code has passed, and the sources' hash

    def refresh(self) -> None:
        """Makes the copy like the checkout, whatever an earlier call left, and builds it."""
        self.source.mkdir(parents=True, exist_ok=True)
        for name in COPIED:
            place(self.checkout / name, self.source / name)
        if not (self.build / "build.ninja").exists():
            # Less optimization than a release's: what is compiled is run for a few seconds.
            run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-Wno-dev", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG",
                 "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache", "-DCMAKE_C_COMPILER_LAUNCHER=ccache"])
        run(["cmake", "--build", self.build, "--target", *PROGRAMS])
        (self.build / "sound").mkdir(exist_ok=True)
        for program in PROGRAMS:
            shutil.copy2(self.build / program, self.build / "sound" / program)
        digest = hashlib.sha256()
        for file in sorted(path for name in COPIED for path in [self.source / name, *(self.source / name).rglob("*")] if path.is_file()):
            digest.update(file.read_bytes())
        self.sources = digest.hexdigest()
        kept = json.loads(self.passed.read_text()) if self.passed.exists() else {}
        self.seconds = kept["seconds"] if kept.get("sources") == self.sources else {}

    def tests(self, part: str) -> list[Test]:
        """The tests that a mutant of the part meets, in this order."""
        listed = json.loads(run(["ctest", "--test-dir", self.build, "--show-only=json-v1"]))
        which = [rf"unit\.{part}\."] + BESIDE[part]
        found = []
        for test in listed["tests"]:
            place_in_order = next((i for i, name in enumerate(which) if re.match(name, test["name"])), None)
            if place_in_order is None:
                continue
            properties = {p["name"]: p["value"] for p in test["properties"]}
            variables = dict(v.split("=", 1) for v in properties.get("ENVIRONMENT", []) if v)
            one = Test(test["name"], test["command"], variables)
            if one.ranks == 1 and "signorini-unit" in one.command[-2]:
                one.command.append("--abort")  # after the first failure; on several ranks the others would wait for it
            found.append((one.ranks, place_in_order, one))
        return [test for ranks, _, test in sorted(found, key=lambda entry: entry[:2]) if ranks <= MOST_RANKS]

    def attempt(self, test: Test, limit: float | None, sound: bool = False) -> tuple[str, str]:
        """How a test ends, "" if well, and what it printed."""
        folder = self.build / "sound" if sound else self.build
        command = [str(folder / Path(word).name) if is_program(word) else word for word in test.command]
        process = subprocess.Popen(command, cwd=self.build, env=os.environ | test.environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True)
        try:
            printed, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            stop(process)
            return "time-out", ""
        except BaseException:
            stop(process)
            raise
        if not process.returncode:
            return "", printed
        # mpirun hands a signal's number on as 128 + n, and Catch reports the signal.
        by_signal = process.returncode < 0 or process.returncode > 128 or "SIGSEGV" in printed or "SIGABRT" in printed
        return "crash" if by_signal else "test failed", printed

    def patience(self, test: Test) -> float:
        """The seconds that a mutant may take for a test, from those of the sound code, which must pass it."""
        if test.name not in self.seconds:
            begin = time.monotonic()
            end, printed = self.attempt(test, None, sound=True)
            if end:
                raise SystemExit(f"the sound code fails {test.name} ({end}):\n{printed}")
            self.seconds[test.name] = time.monotonic() - begin
            self.passed.write_text(json.dumps({"sources": self.sources, "seconds": self.seconds}))
        return PATIENCE * (self.seconds[test.name] + 1)

    def outcome(self, file: Path, mutated: str, tests: list[Test]) -> tuple[str, str] | None:
        """How a mutant ends and by which test, "" if by none; nothing if it does not compile."""
        sound = file.read_text()
        programs = sorted({Path(word).name for test in tests for word in test.command if is_program(word)})
        file.write_text(mutated)
        try:
            if subprocess.run(["cmake", "--build", self.build, "--target", *programs], capture_output=True).returncode:
                return None
            for test in tests:
                end, _ = self.attempt(test, self.patience(test))
                if end:
                    return end, test.name
            return "", ""
        finally:
            file.write_text(sound)


def is_program(word: str) -> bool:
    """Whether a word of a test's command is one of the programs, by its name alone or with the build folder."""
    return Path(word).name in PROGRAMS


def run(command: list) -> str:
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def stop(process: subprocess.Popen) -> None:
    """Ends a test; mpirun is asked first, since it ends its ranks then."""
    for how in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, how)
            process.wait(10)
        except (ProcessLookupError, subprocess.TimeoutExpired):
            pass


def place(original: Path, copy: Path) -> None:
    """Makes a file or folder like another one; what is the same already keeps its time, so that it is not built again."""
    if original.is_dir():
        copy.mkdir(parents=True, exist_ok=True)
        names = {child.name for child in original.iterdir() if child.name != "__pycache__"}
        for child in copy.iterdir():
            if child.name not in names:
                shutil.rmtree(child) if child.is_dir() else child.unlink()
        for name in names:
            place(original / name, copy / name)
    elif not copy.exists() or not filecmp.cmp(original, copy, shallow=False):
        shutil.copyfile(original, copy)
        shutil.copymode(original, copy)


def drawn(cpp: Path, seed: int):
    """Mutants without end of the draw: each token's at most once, all tokens alike."""
    files = [file for part in sorted(BESIDE) for file in sorted((cpp / part).rglob("*")) if file.suffix in (".h", ".cpp")]
    sites = [site for file in files for site in Source(file).mutants()]
    print(f"{len(sites)} tokens of {len(files)} files may change", flush=True)
    generator = random.Random(seed)
    generator.shuffle(sites)
    for choices in sites:
        mutant = generator.choice(choices)
        yield mutant.file, mutant.applied(), mutant.kind


def read_again(source: Path, diffs: list[str]):
    """Mutants of earlier calls."""
    for diff in diffs:
        text = Path(diff).read_text()
        kind, name = re.match(r"(\w+).*\n--- (\S+)", text).groups()
        before, after = ("".join(line[1:] for line in text.splitlines(True)[4:] if line[0] == sign) for sign in "-+")
        sound = (source / name).read_text()
        line = int(re.search(r"^@@ -(\d+)", text, re.MULTILINE).group(1))
        starts = [m.start() for m in re.finditer("^" + re.escape(before), sound, re.MULTILINE)]
        if not starts:
            raise SystemExit(f"{diff}: {name} has no such lines any more")
        # Others may have moved the lines, and they may occur twice.
        at = min(starts, key=lambda start: abs(sound.count("\n", 0, start) + 1 - line))
        yield source / name, sound[:at] + after + sound[at + len(before):], kind


def difference(file: Path, mutated: str, source: Path) -> str:
    """The lines that differ, from the first to the last."""
    name = file.relative_to(source).as_posix()
    old, new = file.read_text().splitlines(True), mutated.splitlines(True)
    begin = next(i for i, (a, b) in enumerate(zip(old, new)) if a != b)
    same = next(i for i, (a, b) in enumerate(zip(reversed(old), reversed(new))) if a != b)
    return (f"--- {name}\n+++ {name}\n@@ -{begin + 1} @@\n" + "".join("-" + line for line in old[begin:len(old) - same])
            + "".join("+" + line for line in new[begin:len(new) - same]))


@dataclass
class Trial:
    """A mutant, and how it ended by which test: "" as long as none noticed it."""

    file: Path
    mutated: str
    where: str
    diff: Path
    change: str
    end: str = ""
    by: str = ""

    @property
    def part(self) -> str:
        return next(folder.name for folder in self.file.parents if folder.parent.name == "cpp")


def try_all(copy: Copy, mutants, count: int, diffs) -> tuple[list[Trial], int]:
    """The first `count` mutants that compile, and how many did not. All meet the tests on one rank first, and what they let through
    those on two: what is slow comes last."""
    trials, not_compiled = [], 0
    tests = {part: copy.tests(part) for part in BESIDE}
    for diff, (file, mutated, kind) in zip(diffs, mutants):
        change = difference(file, mutated, copy.source)
        line = re.search(r"^@@ -(\d+)", change, re.MULTILINE).group(1)
        trial = Trial(file, mutated, f"{kind} {file.relative_to(copy.source)}:{line}", diff, change)
        if attempt(copy, trial, [test for test in tests[trial.part] if test.ranks == 1]):
            trials.append(trial)
            report(len(trials), count, trial)
            if len(trials) == count:
                break
        else:
            not_compiled += 1
    for number, trial in enumerate(trials, 1):
        if not trial.end:
            attempt(copy, trial, [test for test in tests[trial.part] if test.ranks > 1])
            report(number, count, trial)
    return trials, not_compiled


def attempt(copy: Copy, trial: Trial, tests: list[Test]) -> bool:
    """Whether the mutant compiles; then it has met the tests. Its diff is there as long as none noticed it."""
    outcome = copy.outcome(trial.file, trial.mutated, tests)
    if outcome is None:
        return False
    trial.end, trial.by = outcome
    trial.diff.unlink(missing_ok=True)
    if not trial.end:
        trial.diff.write_text(f"{trial.where}\n{trial.change}")
    return True


def report(number: int, count: int, trial: Trial) -> None:
    print(f"{number:3}/{count} {trial.where:60} {f'{trial.end}: {trial.by}' if trial.end else 'let through'}", flush=True)


def table(trials: list[Trial]) -> str:
    ways = ["test failed", "crash", "time-out"]
    lines = [f"{'part':10}{'killed/tried':>14}" + "".join(f"{way:>13}" for way in ways)]
    for part in sorted({trial.part for trial in trials}) + ["all"]:
        ends = collections.Counter(trial.end for trial in trials if part in (trial.part, "all"))
        lines.append(f"{part:10}{f'{ends.total() - ends[str()]}/{ends.total()}':>14}" + "".join(f"{ends[way]:13}" for way in ways))
    return "\n".join(lines)


def main() -> int:
    checkout, build, *rest = sys.argv[1:]
    copy = Copy(Path(checkout), Path(build))
    again = bool(rest) and all(name.endswith(".diff") for name in rest)
    if not again and not (len(rest) == 2 and all(re.fullmatch(r"\d+", number) for number in rest) and int(rest[0]) > 0):
        print(f"mutate: found '{' '.join(rest)}', allowed are COUNT SEED (whole numbers, COUNT above 0) or FILE.diff…", file=sys.stderr)
        return 2
    begin = time.monotonic()
    copy.refresh()
    survivors = Path(build) / "survivors"
    survivors.mkdir(exist_ok=True)
    if again:
        trials, not_compiled = try_all(copy, list(read_again(copy.source, rest)), len(rest), [survivors / Path(name).name for name in rest])
    else:
        numbered = (survivors / f"{rest[1]}-{number}.diff" for number in itertools.count(1))
        trials, not_compiled = try_all(copy, drawn(copy.source / "cpp", int(rest[1])), int(rest[0]), numbered)
    survived = [trial for trial in trials if not trial.end]
    print(f"\n{table(trials)}\n{not_compiled} more did not compile; {(time.monotonic() - begin) / 60:.0f} min")
    for trial in survived:
        print(f"\nsurvived: {trial.diff}\n{trial.diff.read_text()}", end="")
    return 0 if len(trials) - len(survived) >= ENOUGH * len(trials) else 1


if __name__ == "__main__":
    raise SystemExit(main())
