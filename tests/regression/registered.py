# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing that is compiled or written as a test is left out of ctest: every test case, every unit test's file, every script.

    registered.py SIGNORINI-UNIT SOURCE CTEST BUILD
"""

import json
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from compiled_units import compiled_units  # noqa: E402

UNIT, SOURCE, CTEST = sys.argv[1:4]
BUILD = Path(sys.argv[4])
TESTS = Path(SOURCE).resolve() / "tests"
# Imported, or run by hand: of these no script is a test of its own.
SHARED = {"harness.py", "regression/bad_input/case.py", "regression/bad_input/cases.py", "verification/hard/table.py",
          "verification/hard/all.py", "python/common.py"}  # fmt: skip


def cases(specification: str) -> set[str]:
    """The names of the test cases that a specification picks."""
    listed = subprocess.run([UNIT, specification, "--list-tests", "--reporter", "XML"], capture_output=True, text=True, check=True)
    return {case.findtext("Name") for case in ElementTree.fromstring(listed.stdout).iter("TestCase")}


def commands() -> list[list[str]]:
    """What ctest runs, by a copy of its lists: even to show them it begins the log of a run anew, and one is going on."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for lists in BUILD.glob("**/CTestTestfile.cmake"):
            place = copy / lists.relative_to(BUILD)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(lists, place)
        shown = subprocess.run([CTEST, "--test-dir", copy, "--show-only=json-v1"], capture_output=True, text=True, check=True)
    return [test["command"] for test in json.loads(shown.stdout)["tests"]]


def main() -> int:
    run = commands()
    picked = sorted({word for command in run if not command[1].endswith(Path(__file__).name)
                     for program, word in zip(command, command[1:]) if Path(program) == Path(UNIT)})
    every = cases("*,[.]")
    forgotten = [f"the test case \"{name}\" is run by none of {', '.join(picked)}" for name in sorted(every - cases(",".join(picked)))]
    compiled = {Path(unit["file"]) for unit in compiled_units(BUILD)}
    forgotten += [f"{file} is not compiled" for file in sorted(TESTS.glob("unit/*.cpp")) if file not in compiled]
    scripts = {Path(word) for command in run for word in command if word.endswith(".py")}
    parts = {"regression", "verification"} | {"python" for script in scripts if script.parent == TESTS / "python"}  # where it is built
    own = {file for part in parts for file in TESTS.glob(f"{part}/**/*.py")}
    forgotten += [f"{file} is run by no test" for file in sorted(own - scripts) if file.relative_to(TESTS).as_posix() not in SHARED]
    print("\n".join(forgotten) or f"{len(every)} test cases by {len(picked)} specifications, {len(own & scripts)} scripts: all are run")
    assert picked and len(every) > 50 and len(own) > 30, "hardly anything was looked at"
    return 1 if forgotten else 0


if __name__ == "__main__":
    raise SystemExit(main())
