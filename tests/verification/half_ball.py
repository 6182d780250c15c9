# SPDX-License-Identifier: GPL-3.0-or-later
"""The half ball at sizes that matter: derivatives, and the same J, gradient norm and contact on one, two and three ranks."""

import json
from pathlib import Path

import pytest
from agreeing import optimize_on_ranks
from harness import HALF_BALL, signorini

# By the number of free unknowns. Finer elements call for shorter steps; the largest run ends well within contact.
SIZES = {8_000: {"mesh__size": 1.3},
         20_000: {"mesh__size": 0.92},
         140_000: {"mesh__size": 0.465, "time__step": 5e-5, "time__end": 2.5e-3}}  # fmt: skip
# MUMPS, on several ranks, first solves for each of the largest run's 1,120 candidates, and that takes ten minutes.
SOLVERS = {8_000: "direct", 20_000: "direct", 140_000: "iterative"}
of_each_size = pytest.mark.parametrize("unknowns", (8_000, *(pytest.param(size, marks=pytest.mark.long) for size in (20_000, 140_000))))


@of_each_size
def test_derivatives(unknowns: int) -> None:
    print(signorini("check", HALF_BALL, **SIZES[unknowns]).stdout)


@of_each_size
def test_ranks(unknowns: int, tmp_path: Path) -> None:
    optimize_on_ranks(tmp_path, HALF_BALL, iterations=0, control__initial=["0", "0", "-0.9"],
                      solver__linear=SOLVERS[unknowns], **SIZES[unknowns])  # fmt: skip
    for ranks in (1, 2, 3):
        run = json.loads((tmp_path / f"ranks-{ranks}" / "run.json").read_text())
        print(f"{ranks} ranks: {run['free_unknowns']} free unknowns, {run['solver'].partition(' (')[0]}, "
              f"{run['peak_memory_bytes'] / 1e9:.2f} GB at most; seconds: "
              + ", ".join(f"{phase} {run['timings'][phase]['seconds']:.2f}" for phase in ("solver", "forward", "adjoint")))  # fmt: skip
        # The mesher's next version may make a few elements more.
        assert abs(run["free_unknowns"] / unknowns - 1) < 0.1
