# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input: whatever is wrong, the program says so in one sentence, exits with status 2 and leaves nothing behind.

usage: python3 bad_input.py PATH_TO_SIGNORINI PATH_TO_SOURCE_DIR [PATTERN]

Every case starts from a small scene that runs, spoils it in one way and asserts that the exit status is 2, that stderr is
one line which begins with "signorini: " and contains what the case expects, that nothing else is printed, and that the
folder of the case, results of an earlier run included, holds afterwards exactly what it held before.
PATTERN, a regular expression, picks cases by name.
"""

import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2]))
from case import GEO, SCENE, SPACE_GEO, TO_SPACE, Case, Expected, cube2, square2, square4, write
from cases import all_cases
import resident

WRONG_INPUT = 2
TIME_LIMIT = 120  # s; a case takes a fraction of a second unless the program hangs
WORKERS = 2

# --- The folder of a case -----------------------------------------------------------------------------------------------

EARLIER = {"run.json": '{ "versions": { "signorini": "0" }, "files": ["run.json", "state.h5"] }\n', "state.h5": "earlier fields", "notes.txt": "keep me\n"}


def scene_of(case: Case) -> str:
    """The case's scene."""
    text = SCENE
    for old, new in case.edits:
        if old not in text:
            raise ValueError(f"{case.name}: the scene has no {old!r}")
        text = text.replace(old, new, 1)
    return text


def fill(folder: Path, case: Case) -> None:
    """Writes the scene, the mesh and whatever else the case has."""
    write(folder / "scene.toml", scene_of(case) if case.scene is None else case.scene)
    write(folder / case.mesh_file, square2() if case.mesh is None else case.mesh)
    if case.earlier:
        (folder / "results").mkdir()
        for name, text in EARLIER.items():
            write(folder / "results" / name, text)
    if case.prepare:
        case.prepare(folder)


def content(folder: Path) -> dict[str, bytes | None]:
    """Every file below a folder with its bytes, hidden ones included; None stands for a folder or a dead link."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")
    }


# --- Running and judging ------------------------------------------------------------------------------------------------

NOISE = re.compile(
    r"PETSC ERROR|HDF5-DIAG|Traceback|terminate called|MPI_ABORT|MPI_ERR|Segmentation|Process received signal|"
    r"^(Error|Warning|Info) +:",
    re.MULTILINE,
)
# A library's or the program's own insides say nothing to the user.
INSIDES = re.compile(r"\.unfinished|std::|vector::|\(\)|\bPETSc failed|\bbasic_|\bunknown error\b")
HEADLINE = re.compile(r"(scene: \d+ free unknowns, .*\nbody: .*\n(warning: .*\n)*effects: .*\nsolver: .*\n)?")


@dataclass(frozen=True)
class Outcome:
    """What a run printed and what it did to its folder."""

    command: list[str]
    status: int | None  # None: it did not end
    stdout: str
    stderr: str
    changes: list[str]

    def message(self) -> str:
        """The program's sentence, without its name."""
        lines = [line for line in self.stderr.splitlines() if line.startswith("signorini: ")]
        return lines[0].removeprefix("signorini: ") if lines else self.stderr.strip()[:200]


def command_of(case: Case, program: str) -> list[str]:
    """The command line of a case."""
    words = case.command
    if words is None:
        words = (case.verb, "scene.toml", "--out", case.out, *case.options)
    launcher = ["mpirun", "-n", str(case.ranks)] if case.ranks > 1 else []
    return [*launcher, program, *words]


def full_disk(size: int) -> Callable[[], None]:
    """Limits the files that a child process can write: beyond the limit write() fails as it does on a full disk."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


def environment(case: Case) -> dict[str, str]:
    """The caller's environment; Open MPI may run as root and on fewer cores than ranks, and fills no files itself."""
    defaults = {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "PRTE_MCA_mapby": ":oversubscribe",
        "OMP_NUM_THREADS": "1",
    }
    return {**defaults, **os.environ, **({"OMPI_MCA_btl": "self"} if case.largest_file else {})}


def run(case: Case, program: str, folder: Path) -> Outcome:
    """Runs a case in its folder."""
    fill(folder, case)
    held = content(folder)
    command = command_of(case, program)
    status: int | None = None
    stdout = stderr = b""
    try:
        if case.ranks == 1 and case.largest_file is None:
            done = resident.run(command, cwd=folder, env=environment(case), timeout=TIME_LIMIT)
        else:
            done = subprocess.run(
                command,
                cwd=folder,
                env=environment(case),
                stdin=subprocess.DEVNULL,
                capture_output=True,
                restore_signals=case.largest_file is None,
                preexec_fn=full_disk(case.largest_file) if case.largest_file else None,
                timeout=TIME_LIMIT,
            )
        status, stdout, stderr = done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired:
        pass
    return Outcome(command, status, stdout.decode(errors="replace"), stderr.decode(errors="replace"),
                   differences(held, content(folder)))


def differences(old: dict[str, bytes | None], new: dict[str, bytes | None]) -> list[str]:
    """What became of the files of a folder."""
    return (
        [f"{name} is left over" for name in sorted(new.keys() - old.keys())]
        + [f"{name} is gone" for name in sorted(old.keys() - new.keys())]
        + [f"{name} has changed" for name in sorted(old.keys() & new.keys()) if old[name] != new[name]]
    )


def complaints(case: Case, outcome: Outcome) -> list[str]:
    """What is wrong with the way the program took the bad input."""
    return [*wrong_end(outcome), *wrong_output(case, outcome), *wrong_message(case, outcome.message()),
            *outcome.changes]


def wrong_end(outcome: Outcome) -> list[str]:
    """A status other than 2."""
    if outcome.status is None:
        return [f"still running after {TIME_LIMIT} s"]
    return [] if outcome.status == WRONG_INPUT else [f"exit status {outcome.status}, not {WRONG_INPUT}"]


def wrong_output(case: Case, outcome: Outcome) -> list[str]:
    """Anything but the program's one line; mpirun may add its own."""
    lines = outcome.stderr.splitlines()
    own = [line for line in lines if line.startswith("signorini: ")]
    found = []
    if not lines or lines[0] not in own:
        found.append('stderr does not begin with "signorini: "')
    if len(own) > 1:
        found.append(f"{len(own)} lines of stderr are the program's")
    if case.ranks == 1 and len(lines) > 1:
        found.append(f"{len(lines)} lines on stderr:\n" + start_of(lines))
    if NOISE.search(outcome.stderr) or NOISE.search(outcome.stdout):
        found.append("a library speaks")
    if not HEADLINE.fullmatch(outcome.stdout):
        found.append("stdout is not empty:\n" + start_of(outcome.stdout.splitlines()))
    return found


def start_of(lines: list[str], most: int = 8) -> str:
    """The first lines of what was printed."""
    return "\n".join(lines[:most] + (["..."] if len(lines) > most else []))


def wrong_message(case: Case, message: str) -> list[str]:
    """What the sentence lacks, and what it should not contain."""
    expected: list[Expected] = list(case.expect)
    if case.at:
        expected.append(f"scene.toml:{line_of(case)}: ")
    return [f"no {shown(e)} in the message" for e in expected if not contains(message, e)] + [
        f"{shown(e)} in the message" for e in (*case.never, INSIDES) if contains(message, e)
    ]


def line_of(case: Case) -> int:
    """Number of the line of the scene that the message must name."""
    text = scene_of(case)
    return text[: text.index(case.at)].count("\n") + 1


def contains(message: str, expected: Expected) -> bool:
    """Whether a message has a fragment or matches a pattern."""
    return expected in message if isinstance(expected, str) else bool(expected.search(message))


def shown(expected: Expected) -> str:
    """A fragment or pattern, for a human."""
    return repr(expected) if isinstance(expected, str) else f"/{expected.pattern}/"


def sound(program: str, folder: Path, source: Path) -> str:
    """Runs what all cases start from; returns why that does not work, or nothing."""
    geo = {"edits": (('file = "square.msh"', 'file = "square.geo"\nsize = 4'),), "mesh": GEO, "mesh_file": "square.geo"}
    half_disc = ("simulate", str(source / "scenes" / "half-disc.toml"), "--out", "results", "--set", "mesh.size=4",
                 "--set", "time.end=1.5e-4")
    good = [
        Case("square in format 2.2", (), mesh=square2()),
        Case("square in format 4.1", (), mesh=square4(), verb="optimize"),
        Case("square of a geometry", (), **geo),  # type: ignore[arg-type]
        Case("square on two ranks", (), ranks=2),
        Case("cube", (), edits=TO_SPACE, mesh=cube2(), mesh_file="cube.msh", verb="optimize"),
        Case("cube of a geometry, three ranks", (), edits=(*TO_SPACE, ('file = "cube.msh"', 'file = "cube.geo"\nsize = 4'), (
            'on = "top"', 'on = "side"')), mesh=SPACE_GEO + 'Physical Volume("body") = {1}; Physical Surface("side") = {26};\n',
             mesh_file="cube.geo", ranks=3),
        Case("half disc", (), command=half_disc),
    ]
    for number, case in enumerate(good):
        place = folder / f"good-{number}"
        place.mkdir()
        outcome = run(case, program, place)
        if outcome.status != 0 or not (place / "results" / "run.json").is_file():
            return f"{case.name} should run: exit status {outcome.status}, {outcome.message()}"
    return ""


def report(case: Case, outcome: Outcome) -> bool:
    """Prints the line of a case, and below it what is wrong; returns whether nothing is."""
    found = complaints(case, outcome)
    print(f"{'FAILED' if found else 'passed'}  {case.name}: {outcome.message()}")
    for complaint in found:
        print("        " + complaint.replace("\n", "\n          "))
    if found:
        print("        by " + " ".join(repr(word) if " " in word or not word else word for word in outcome.command))
    sys.stdout.flush()
    return not found


def main(program: str, source: str, pattern: str = "") -> int:
    """Runs all cases; 0 if every bad input is taken as it should be."""
    program = str(Path(program).resolve())
    cases = [case for case in all_cases() if re.search(pattern, case.name)]
    with tempfile.TemporaryDirectory(prefix="signorini-bad-input-") as name:
        root = Path(name).resolve()
        if problem := sound(program, root, Path(source).resolve()):
            print(f"FAILED  {problem}")
            return 1

        def outcome_of(numbered: tuple[int, Case]) -> Outcome:
            place = root / f"case-{numbered[0]}"
            place.mkdir()
            return run(numbered[1], program, place)

        with ThreadPoolExecutor(WORKERS) as workers:
            outcomes = workers.map(outcome_of, enumerate(cases))
            passed = sum([report(case, outcome) for case, outcome in zip(cases, outcomes, strict=True)])
    print(f"{passed} passed, {len(cases) - passed} failed")
    return 0 if passed == len(cases) else 1


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
