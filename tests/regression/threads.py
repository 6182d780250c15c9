# SPDX-License-Identifier: GPL-3.0-or-later
"""The same results to the last bit on any number of threads; one sentence where there is no such number."""

import json
import os
import subprocess
from pathlib import Path

import pytest
from harness import HALF_BALL, HALF_DISC, SIGNORINI

# Large enough for the factor to be supernodal and products to be divided.
CASES = {
    "disc": ("optimize", HALF_DISC, "mesh.size=0.2", "optimizer.max_iterations=2", "time.end=2.5e-3", 'control.initial=["0", "-0.9"]'),
    "ball": ("simulate", HALF_BALL, "mesh.size=1.6", "time.end=3.5e-3", 'control.initial=["0", "0", "-1"]', "solver.linear=direct"),
}


def run(verb: str, scene: Path, *more: str, **environment: str) -> subprocess.CompletedProcess:
    return subprocess.run([SIGNORINI, verb, scene, *more], env={**os.environ, **environment}, capture_output=True, text=True, stdin=subprocess.DEVNULL)


def without_seconds(table: str) -> list[list[str]]:
    """A table's rows but for the column of what the machine took."""
    rows = [line.split(",") for line in table.splitlines()]
    dropped = rows[0].index("seconds") if "seconds" in rows[0] else len(rows[0])
    return [row[:dropped] + row[dropped + 1 :] for row in rows]


def tables(folder: Path) -> dict[str, list[list[str]]]:
    return {file.name: without_seconds(file.read_text()) for file in folder.glob("*.csv")}


@pytest.mark.parametrize("case", CASES)
def test_same_to_the_last_bit(case: str, tmp_path: Path) -> None:
    verb, scene, *settings = CASES[case]
    options = [word for setting in settings for word in ("--set", setting)]
    found = {}
    for number in (1, 2, 3):
        out = tmp_path / str(number)
        done = run(verb, scene, "--out", str(out), "--threads", str(number), *options)
        assert done.returncode == 0, done.stderr
        manifest = json.loads((out / "run.json").read_text())
        assert manifest["host"]["threads"] == number and "CHOLMOD" in manifest["solver"]
        assert (f" of {number} threads" in done.stdout) == (number > 1)
        found[number] = tables(out)
    assert any(float(row[found[1]["steps.csv"][0].index("active")]) > 0 for row in found[1]["steps.csv"][1:]), "no contact"
    assert found[1] == found[2] == found[3]


@pytest.mark.parametrize("number", ("0", "-1", "two"))
def test_no_such_number(number: str) -> None:
    done = run("info", HALF_DISC, "--threads", number)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "--threads" in done.stderr


@pytest.mark.parametrize("number", (1, 3))
def test_number_of_the_environment(number: int, tmp_path: Path) -> None:
    few = ("--set", "mesh.size=4", "--set", "time.end=5e-4", "--quiet")
    assert run("simulate", HALF_DISC, "--out", str(tmp_path), "--replace", *few, OMP_NUM_THREADS=str(number)).returncode == 0
    assert json.loads((tmp_path / "run.json").read_text())["host"]["threads"] == number
