"""How many mistakes the tests notice: changes single tokens of the sources, each in turn, and runs the tests.

    mutate.py CHECKOUT BUILD COUNT SEED    draws that many mutants of the parts below
    mutate.py CHECKOUT BUILD FILE.diff…    tries again what an earlier call wrote

All is done in copies below BUILD. A mutant is drawn from all tokens alike (sites.py says which, and what becomes of them)
and counts if it compiles. It meets the unit tests of its part, those of the parts that are built on it, and the derivative tests,
the quickest first, until one fails, ends by a signal or takes too long. Those that none of them notices are printed at the
end and left in BUILD/survivors. The exit status is 1 if fewer than 90 % were noticed.
"""

import collections
import filecmp
import hashlib
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

# The parts, each with what is built on it among those whose tests are run for it, and whether `check` goes through it.
TESTED_BY = {
    "contact": ["contact", "forward", "adjoint", "control"],
    "forward": ["forward", "contact", "adjoint", "control"],  # the tests of contact make steps
    "adjoint": ["adjoint", "control"],
    "control": ["control", "adjoint"],
    "optimize": ["optimize"],
}
WITHOUT_DERIVATIVE = ["optimize"]
COPIED = ["CMakeLists.txt", "cpp", "forms", "meshes", "scenes", "tests"]
ENOUGH = 0.9
PATIENCE = 10  # times the seconds of the sound code, and seconds beside: other work on the machine makes no mutant


@dataclass
class Test:
    name: str
    command: list[str]
    environment: dict[str, str]
    seconds: float = 0.0


class Copy:
    """The sources in a folder of their own, where they are changed, built and tested."""

    def __init__(self, checkout: Path, build: Path):
        self.checkout, self.build, self.source = checkout, build, build / "source"

    def refresh(self) -> None:
        """Makes the copy like the checkout, whatever an earlier call left, and builds it."""
        self.source.mkdir(parents=True, exist_ok=True)
        for name in COPIED:
            place(self.checkout / name, self.source / name)
        if not (self.build / "build.ninja").exists():
            # Less optimization than a release's: what is compiled is run for a few seconds.
            run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-Wno-dev", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG",
                 "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache", "-DCMAKE_C_COMPILER_LAUNCHER=ccache"])
        run(["cmake", "--build", self.build, "--target", "signorini", "signorini-unit"])

    def tests(self, part: str) -> list[Test]:
        """The tests that a mutant of the part meets."""
        listed = json.loads(run(["ctest", "--test-dir", self.build, "--show-only=json-v1"]))
        named = "|".join(TESTED_BY[part])
        which = re.compile(rf"unit\.({named})\." if part in WITHOUT_DERIVATIVE else rf"unit\.({named})\.|derivative\.")
        found = []
        for test in listed["tests"]:
            if not which.match(test["name"]):
                continue
            properties = {p["name"]: p["value"] for p in test["properties"]}
            variables = dict(v.split("=", 1) for v in properties.get("ENVIRONMENT", []) if v)
            found.append(Test(test["name"], test["command"], variables))
        return found

    def attempt(self, test: Test, limit: float | None) -> tuple[str, str]:
        """How a test ends, "" if well, and what it printed."""
        process = subprocess.Popen(test.command, cwd=self.build, env=os.environ | test.environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True)
        try:
            printed, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            stop(process)
            return "time-out", ""
        except BaseException:
            stop(process)
            raise
        # mpirun hands a signal's number on as 128 + n.
        ways = {True: "crash", False: "test failed"}
        by_signal = process.returncode < 0 or process.returncode > 128 or "SIGSEGV" in printed or "SIGABRT" in printed
        return ways[by_signal] if process.returncode else "", printed

    def measure(self, parts: list[str]) -> dict[str, list[Test]]:
        """The tests of the parts, quickest first, which must pass."""
        seconds = self.passed()
        tests = {part: self.tests(part) for part in parts}
        for test in {test.name: test for part in parts for test in tests[part] if test.name not in seconds}.values():
            begin = time.monotonic()
            end, printed = self.attempt(test, None)
            if end:
                raise SystemExit(f"the sound code fails {test.name} ({end}):\n{printed}")
            seconds[test.name] = time.monotonic() - begin
            self.passed(seconds)
        print(f"the sound code passes its {len(seconds)} tests, in {sum(seconds.values()):.0f} s", flush=True)
        for test in (test for part in parts for test in tests[part]):
            test.seconds = seconds[test.name]
        return {part: sorted(tests[part], key=lambda test: test.seconds) for part in parts}

    def passed(self, seconds: dict[str, float] | None = None) -> dict[str, float]:
        """The seconds of the tests that the sound code has passed, kept for the next call with the same sources."""
        file, digest = self.build / "passed.json", hashlib.sha256()
        for source in sorted(path for name in COPIED for path in [self.source / name, *(self.source / name).rglob("*")] if path.is_file()):
            digest.update(source.read_bytes())
        if seconds is not None:
            file.write_text(json.dumps({"sources": digest.hexdigest(), "seconds": seconds}))
            return seconds
        kept = json.loads(file.read_text()) if file.exists() else {}
        return kept["seconds"] if kept.get("sources") == digest.hexdigest() else {}

    def compiles(self, part: str) -> bool:
        targets = ["signorini-unit"] + ([] if part in WITHOUT_DERIVATIVE else ["signorini"])
        return subprocess.run(["cmake", "--build", self.build, "--target", *targets], capture_output=True).returncode == 0

    def outcome(self, file: Path, mutated: str, tests: list[Test]) -> tuple[str, str] | None:
        """How a mutant ends and by which test, "" if by none; nothing if it does not compile."""
        sound = file.read_text()
        file.write_text(mutated)
        try:
            if not self.compiles(file.parent.name):
                return None
            for test in tests:
                end, _ = self.attempt(test, PATIENCE * (test.seconds + 1))
                if end:
                    return end, test.name
            return "", ""
        finally:
            file.write_text(sound)


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
    files = [file for part in sorted(TESTED_BY) for file in sorted((cpp / part).iterdir()) if file.suffix in (".h", ".cpp")]
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


def table(ends: dict[str, collections.Counter]) -> str:
    ways = ["test failed", "crash", "time-out"]
    lines = [f"{'part':10}{'killed/tried':>14}" + "".join(f"{way:>13}" for way in ways)]
    ends = ends | {"all": sum(ends.values(), collections.Counter())}
    for part, count in ends.items():
        killed = sum(count[way] for way in ways)
        lines.append(f"{part:10}{f'{killed}/{count.total()}':>14}" + "".join(f"{count[way]:13}" for way in ways))
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
    count, mutants = ((len(rest), read_again(copy.source, rest)) if again
                      else (int(rest[0]), drawn(copy.source / "cpp", int(rest[1]))))
    mutants = list(mutants)
    parts = sorted({file.parent.name for file, _, _ in mutants})
    tests = copy.measure(parts)
    left = Path(build) / "survivors"
    left.mkdir(exist_ok=True)
    ends = collections.defaultdict(collections.Counter)
    survivors, tried, not_compiled = [], 0, 0
    for number, (file, mutated, kind) in enumerate(mutants, 1):
        if tried == count:
            break
        part, change = file.parent.name, difference(file, mutated, copy.source)
        since = time.monotonic()
        outcome = copy.outcome(file, mutated, tests[part])
        if outcome is None:
            not_compiled += 1
            continue
        tried += 1
        end, by = outcome
        ends[part][end or "survived"] += 1
        line = re.search(r"^@@ -(\d+)", change, re.MULTILINE).group(1)
        where = f"{file.relative_to(copy.source)}:{line}"
        print(f"{tried:3}/{count} {kind:10} {where:40} {f'{end}: {by}' if end else 'SURVIVED'} ({time.monotonic() - since:.0f} s)", flush=True)
        if not end:
            name = left / (Path(rest[number - 1]).name if again else f"{rest[1]}-{number}.diff")
            name.write_text(f"{kind} {where}\n{change}")
            survivors.append(name)
    killed = tried - len(survivors)
    print(f"\n{table(dict(sorted(ends.items())))}\n{not_compiled} more did not compile; {(time.monotonic() - begin) / 60:.0f} min")
    for name in survivors:
        print(f"\nsurvived: {name}\n{name.read_text()}", end="")
    return 0 if killed >= ENOUGH * tried else 1


if __name__ == "__main__":
    raise SystemExit(main())
