# SPDX-License-Identifier: GPL-3.0-or-later
"""How many mistakes the tests notice: changes single tokens of the sources, each in turn, and runs the tests.

    mutate.py CHECKOUT BUILD COUNT SEED [PARTS]    draws that many mutants of the parts below: solvers, or outputs
    mutate.py CHECKOUT BUILD FILE.diff…            tries again what an earlier call wrote

All is done in copies below BUILD. A mutant is drawn from all tokens alike (sites.py and python_sites.py say which, and what becomes
of them) and counts if it compiles. It meets the tests that watch its part, on one rank and then on two, until one fails, ends by a
signal or takes too long. Those that none of them notices are printed at the end and left in BUILD/survivors. Each test must pass with
the sound code before it judges a mutant. The exit status is 1 if fewer than 90 % were noticed.
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

from python_sites import PythonSource
from sites import Source

# The parts, and the tests that watch them, in the order in which a mutant meets them.
SOLVERS = {
    "contact": [r"unit\.contact\.", r"derivative\.", r"unit\.forward\.", r"unit\.(adjoint|control)\."],
    "step": [r"unit\.forward\.", r"derivative\.", r"unit\.(contact|adjoint|control)\."],  # the tests of contact make steps
    "trajectory": [r"unit\.forward\.", r"derivative\.", r"unit\.(contact|adjoint|control)\."],
    "diagnostics": [r"unit\.(forward|study|io)\."],
    "adjoint": [r"unit\.adjoint\.", r"derivative\.", r"unit\.control\.", r"verification\.fit-derivatives"],
    "control": [r"unit\.control\.", r"derivative\.", r"unit\.adjoint\.", r"verification\.fit-derivatives"],
    "fem": [r"unit\.(fem|mesh)\.", r"unit\.(forward|contact)\.", r"derivative\."],
    "linalg": [r"unit\.(base|optimize|contact)\."],  # its tests are among those of base
    "optimize": [r"unit\.optimize\."],
}
RUNS = [r"regression\.values", r"regression\.(outputs|measure|tables|definitions|time-series|desired-run)$"]
OUTPUTS = {
    "io": [r"unit\.io\.", *RUNS, r"regression\.(docs$|resume$|bad-input|keys|study$|replay$)", r"verification\.fit-(linear|recovery)",
           r"python\.(runs|fits)"],
    **dict.fromkeys(("problem", "drivers", "accuracy", "app"), [r"unit\.(study|io)\.", *RUNS, r"unit\.control\.np", r"regression\.(command-line|docs|plausibility|check-refuses|weak-contact|watch)$", r"verification\.fit-linear",
            r"python\.(runs|fits)", r"regression\.(resume$|study|keys\.|bad-input|coarse-start$|accuracy$)",
            r"verification\.fit-(derivatives|recovery|with-control)"]),  # fmt: skip
    "postprocess": [r"regression\.(geometry$|values)", r"regression\.(postprocess|report-batch|watch|command-line)$", r"verification\.fit-linear", r"python\.runs",
                    r"regression\.(figures|pages|report|accuracy)$"],
    "python": [r"python\.(fits|runs|derivatives|errors)", r"python\.(optimizers)"],
}  # fmt: skip
# What takes long meets those alone that all others let through.
SLOW = re.compile(r"regression\.(resume$|study|keys\.|bad-input|coarse-start$|accuracy$|figures$|pages$|report$|replay$)|verification\.fit-(derivatives|recovery|with-control)|python\.(optimizers)")
GROUPS = {"solvers": SOLVERS, "outputs": OUTPUTS}
WATCHED_BY = SOLVERS | OUTPUTS
MOST_RANKS = 2
PROGRAMS = ["signorini", "signorini-unit"]
COPIED = ["CHANGELOG.md", "CITATION.cff", "CMakeLists.txt", "CONTRIBUTING.md", "LICENSE", "README.md", "cpp", "docs", "forms", "meshes", "packaging", "postprocess", "python", "scenes", "tests"]
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

    @property
    def slow(self) -> bool:
        return self.ranks > 1 or SLOW.match(self.name) is not None


class Copy:
    """The sources in a folder of their own, where they are changed, built and tested."""

    def __init__(self, checkout: Path, root: Path):
        # Sources are compiled one by one, so that a mutant costs one of them.
        self.checkout, self.source, self.build = checkout, root / "source", root / "source" / "build"
        self.passed = root / "passed.json"  # the seconds of the tests that the sound code has passed, and the sources' hash

    def refresh(self) -> None:
        """Makes the copy like the checkout, whatever an earlier call left, and builds it."""
        self.source.mkdir(parents=True, exist_ok=True)
        for name in COPIED:
            place(self.checkout / name, self.source / name)
        if not (self.build / "build.ninja").exists():
            run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-Wno-dev", "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache",
                 "-DCMAKE_C_COMPILER_LAUNCHER=ccache"])
        run(["cmake", "--build", self.build])
        digest = hashlib.sha256()
        for file in sorted(path for name in COPIED for path in [self.source / name, *(self.source / name).rglob("*")] if path.is_file()):
            digest.update(file.read_bytes())
        self.sources = digest.hexdigest()
        kept = json.loads(self.passed.read_text()) if self.passed.exists() else {}
        self.seconds = kept["seconds"] if kept.get("sources") == self.sources else {}

    def tests(self, part: str) -> list[Test]:
        """The tests that a mutant of the part meets, in this order."""
        listed = json.loads(run(["ctest", "--test-dir", self.build, "--show-only=json-v1"]))
        which, found = WATCHED_BY[part], []
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

    def attempt(self, test: Test, limit: float | None) -> tuple[str, str]:
        """How a test ends, "" if well, and what it printed."""
        command = [str(self.build / Path(word).name) if is_program(word) else word for word in test.command]
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

    def measure(self, test: Test) -> None:
        """The seconds of the sound code, which must pass the test."""
        begin = time.monotonic()
        end, printed = self.attempt(test, None)
        if end:
            raise SystemExit(f"the sound code fails {test.name} ({end}):\n{printed}")
        self.seconds[test.name] = time.monotonic() - begin
        self.passed.write_text(json.dumps({"sources": self.sources, "seconds": self.seconds}))

    def compiles(self, test: Test) -> bool:
        """Builds what a test runs."""
        words = {Path(word).name for word in test.command}
        targets = [name for name in PROGRAMS if name in words] or ["signorini_python"]
        return not subprocess.run(["cmake", "--build", self.build, "--target", *targets], capture_output=True).returncode

    def outcome(self, file: Path, mutated: str, tests: list[Test]) -> tuple[str, str] | None:
        """How a mutant ends and by which test, "" if by none; nothing if it does not compile."""
        sound = file.read_text()
        try:
            for test in tests:
                if test.name not in self.seconds:
                    file.write_text(sound)
                    self.compiles(test)
                    self.measure(test)
                file.write_text(mutated)
                if not self.compiles(test):
                    return None
                if end := self.attempt(test, PATIENCE * (self.seconds[test.name] + 1))[0]:
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


def files_of(source: Path, part: str) -> list[Path]:
    """The sources of a part, of the Python module without its examples."""
    folders = [source / "cpp" / part] if (source / "cpp" / part).is_dir() else [source / part]
    if part == "python":
        folders = [source / part / "bindings", source / part / "signorini"]
    return [file for folder in folders for file in sorted(folder.rglob("*")) if file.suffix in (".h", ".cpp", ".py")]


def drawn(source: Path, group: str, seed: int):
    """Mutants without end of the draw: each token's at most once, all tokens alike."""
    files = [file for part in sorted(GROUPS[group]) for file in files_of(source, part)]
    sites = [site for file in files for site in
             (PythonSource(file) if file.suffix == ".py" else Source(file, printed=group == "outputs")).mutants()]  # fmt: skip
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
    part: str
    where: str
    diff: Path
    change: str
    end: str = ""
    by: str = ""


def try_all(copy: Copy, mutants, count: int, diffs) -> tuple[list[Trial], int]:
    """The first `count` mutants that compile, and how many did not. All meet the quick tests on one rank first, and what they let through
    those that are slow and those on two."""
    trials, not_compiled = [], 0
    tests = {part: copy.tests(part) for part in WATCHED_BY}
    for diff, (file, mutated, kind) in zip(diffs, mutants):
        change = difference(file, mutated, copy.source)
        line = re.search(r"^@@ -(\d+)", change, re.MULTILINE).group(1)
        name = file.relative_to(copy.source)
        trial = Trial(file, mutated, name.parts[name.parts[0] == "cpp"], f"{kind} {name}:{line}", diff, change)
        if attempt(copy, trial, [test for test in tests[trial.part] if not test.slow]):
            trials.append(trial)
            report(len(trials), count, trial)
            if len(trials) == count:
                break
        else:
            not_compiled += 1
    for number, trial in enumerate(trials, 1):
        if not trial.end:
            attempt(copy, trial, [test for test in tests[trial.part] if test.slow])
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
    lines = [f"{'part':12}{'killed/tried':>14}" + "".join(f"{way:>13}" for way in ways)]
    for part in sorted({trial.part for trial in trials}) + ["all"]:
        ends = collections.Counter(trial.end for trial in trials if part in (trial.part, "all"))
        lines.append(f"{part:12}{f'{ends.total() - ends[str()]}/{ends.total()}':>14}" + "".join(f"{ends[way]:13}" for way in ways))
    return "\n".join(lines)


def main() -> int:
    checkout, build, *rest = sys.argv[1:]
    copy = Copy(Path(checkout), Path(build))
    again = bool(rest) and all(name.endswith(".diff") for name in rest)
    group = rest.pop() if len(rest) == 3 and rest[2] in GROUPS else "solvers"
    if not again and not (len(rest) == 2 and all(re.fullmatch(r"\d+", number) for number in rest) and int(rest[0]) > 0):
        print(f"mutate: found '{' '.join(rest)}'; give COUNT SEED [{' | '.join(GROUPS)}] (whole numbers, COUNT above 0) or FILE.diff…",
              file=sys.stderr)  # fmt: skip
        return 2
    begin = time.monotonic()
    copy.refresh()
    survivors = Path(build) / "survivors"
    survivors.mkdir(exist_ok=True)
    if again:
        trials, not_compiled = try_all(copy, list(read_again(copy.source, rest)), len(rest), [survivors / Path(name).name for name in rest])
    else:
        numbered = (survivors / f"{group}-{rest[1]}-{number}.diff" for number in itertools.count(1))
        trials, not_compiled = try_all(copy, drawn(copy.source, group, int(rest[1])), int(rest[0]), numbered)
    survived = [trial for trial in trials if not trial.end]
    print(f"\n{table(trials)}\n{not_compiled} more did not compile; {(time.monotonic() - begin) / 60:.0f} min")
    for trial in survived:
        print(f"\nsurvived: {trial.diff}\n{trial.diff.read_text()}", end="")
    return 0 if len(trials) - len(survived) >= ENOUGH * len(trials) else 1


if __name__ == "__main__":
    raise SystemExit(main())
