# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing that is compiled or written as a test is left out of ctest: every test case, every unit test's file, every Python test."""

import json
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from compiled_units import compiled_units
from harness import BUILD, SOURCE

TESTS = SOURCE / "tests"
UNIT = BUILD / "signorini-unit"


@pytest.fixture(scope="module")
def commands(tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    """What ctest runs, by a copy of its lists: even to show them it begins the log of a run anew, and one is going on."""
    copy = tmp_path_factory.mktemp("lists")
    for lists in BUILD.glob("**/CTestTestfile.cmake"):
        place = copy / lists.relative_to(BUILD)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(lists, place)
    shown = subprocess.run(["ctest", "--test-dir", copy, "--show-only=json-v1"], capture_output=True, text=True, check=True)
    return [test["command"] for test in json.loads(shown.stdout)["tests"]]


def cases(specification: str) -> set[str]:
    """The names of the test cases that a specification picks."""
    listed = subprocess.run([UNIT, specification, "--list-tests", "--reporter", "XML"], capture_output=True, text=True, check=True)
    return {case.findtext("Name") for case in ElementTree.fromstring(listed.stdout).iter("TestCase")}


def test_every_test_case(commands: list[list[str]]) -> None:
    picked = sorted({word for command in commands for program, word in zip(command, command[1:]) if Path(program) == UNIT})
    every = cases("*,[.]")
    assert picked and len(every) > 50, "hardly any test was found"
    assert every - cases(",".join(picked)) == set()


def test_every_unit_test_is_compiled() -> None:
    compiled = {Path(unit["file"]) for unit in compiled_units(BUILD)}
    assert [file for file in sorted(TESTS.glob("unit/*.cpp")) if file not in compiled] == []


def collected(folders: list[Path], marker: str) -> set[str]:
    """The Python tests below folders that a marker picks: file::test, without parameters."""
    listed = subprocess.run([sys.executable, "-m", "pytest", "-o", "addopts=--import-mode=importlib -p no:cacheprovider", "--rootdir", TESTS,
                             "--collect-only", "-q", "-m", marker, *folders], capture_output=True, text=True)  # fmt: skip
    assert listed.returncode == 0, listed.stdout + listed.stderr
    return {line.split("[")[0] for line in listed.stdout.splitlines() if "::" in line}


def test_every_python_test(commands: list[list[str]]) -> None:
    words = [(str(Path(word.split("::")[0]).relative_to(TESTS)) + word[len(word.split("::")[0]) :], "long" in command)
             for command in commands for word in command if "pytest" in command and ".py" in word]  # fmt: skip
    parts = ["regression", "verification", *(["python"] if any(word.startswith("python/") for word, _ in words) else [])]  # where it is built
    for marker, is_long in (("not long", False), ("long", True)):
        run = {word for word, long in words if long == is_long}
        every = collected([TESTS / part for part in parts], marker)
        assert len(every) > (3 if is_long else 100), "hardly any test was found"
        assert {test for test in every if not run & {test, test.split("::")[0]}} == set()
