# SPDX-License-Identifier: GPL-3.0-or-later
"""The linear solver is chosen by time: for few steps of a body in space no factor is made, and the motion is the same."""

import json
from pathlib import Path

import pytest
from harness import HALF_BALL, signorini


def test_few_steps_are_solved_without_a_factor(tmp_path: Path) -> None:
    runs = {}
    for linear in ("auto", "direct"):
        # A factor takes as long as some tens of solves by conjugate gradients.
        signorini("simulate", HALF_BALL, tmp_path / linear, mesh__size=0.9, time__end=2.5e-4, control__initial=["0", "0", "-0.9"],
                  solver__linear=linear, output__fields=[])  # fmt: skip
        runs[linear] = json.loads((tmp_path / linear / "run.json").read_text())
    chosen = runs["auto"]["solver"]
    assert runs["direct"]["solver"].startswith("CHOLMOD")
    assert chosen.startswith("CG") and "time of 4 solves" in chosen  # two of the motion, two of the desired one
    by_choice, direct = (run["objective"]["value"] for run in runs.values())
    assert direct > 0 and by_choice == pytest.approx(direct, rel=1e-8, abs=0)  # of the iterations
