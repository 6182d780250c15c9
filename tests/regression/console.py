# SPDX-License-Identifier: GPL-3.0-or-later
"""What the program prints: plain lines into a pipe, nothing where it is quiet, the effects of a scene; a closed pipe ends no run."""

import json
from pathlib import Path

import pytest
from harness import HALF_DISC, SIGNORINI, SOURCE, attempt, captured, signorini

DATA = SOURCE / "tests" / "data"
SMALL = f"'{HALF_DISC}' --set mesh.size=3"
PIPED = {
    "info": (f"info {SMALL}", 0),
    "keys": ("keys", 0),
    "keys --json": ("keys --json", 0),
    "simulate": (f"simulate {SMALL} --out '{{}}'", 0),
    "error": (f"simulate '{HALF_DISC}' --set mesh.size=nothing 2>&1", 2),
}


def test_piped_output_is_plain(tmp_path: Path) -> None:
    done = attempt("simulate", HALF_DISC, tmp_path / "out", mesh__size=3)
    assert "\r" not in done.stdout + done.stderr and "\033" not in done.stdout + done.stderr


def test_quiet_run_prints_nothing(tmp_path: Path) -> None:
    done = captured([str(SIGNORINI), "simulate", str(HALF_DISC), "--quiet", "--out", str(tmp_path / "out"), "--set", "mesh.size=3"])
    assert done.returncode == 0 and done.stdout == done.stderr == ""


def test_effects_of_info() -> None:
    info = signorini("info", HALF_DISC, mesh__size=3).stdout
    assert "viscosity" in info and "candidates: 7" in info
    on, off = signorini("info", DATA / "block.toml").stdout.split("\noff:")
    assert "initial velocity" in on and "traction" in off.splitlines()[0] and "several materials" in off.splitlines()[0]
    assert "several materials" in signorini("info", DATA / "two-materials.toml").stdout.split("\noff:")[0]


def test_timed_steps_of_info() -> None:
    timed = captured([str(SIGNORINI), "info", str(DATA / "block.toml"), "--time", "30"]).stdout
    assert "30 steps timed:" in timed and "in contact" in timed and "adjoint" in timed


@pytest.mark.parametrize("words, status", PIPED.values(), ids=PIPED)
def test_closed_pipe_is_no_error(words: str, status: int, tmp_path: Path) -> None:
    """Behind `| head` the program continues without a message: a run writes its results."""
    done = captured(["bash", "-c", f"'{SIGNORINI}' {words.format(tmp_path / 'out')} | head -n 1; echo ${{PIPESTATUS[0]}}"])
    assert done.returncode == 0 and done.stderr == "" and done.stdout.splitlines()[1:] == [str(status)]
    if "--out" in words:
        assert json.loads((tmp_path / "out" / "run.json").read_text())["stop_reason"] == "end of time"
