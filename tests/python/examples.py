# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples run, on one rank and, the quickest of them, on two."""

import re
from pathlib import Path

import pytest
from common import started

EXAMPLES = Path(__file__).resolve().parents[2] / "python" / "examples"
EXPECTED = {  # a printed number, and what it is less than
    "scipy_optimize": (r"J = ([0-9.]+)", 0.00992),
    "scipy_least_squares": (r"misfit ([0-9.]+)", 1.2),
    "own_optimizer": (r"24  J = ([0-9.]+)", 0.02),
    "torch_throw": (r"0.50 m wanted: missed by ([0-9.]+) mm, not seen", 20.0),
}


def test_all_are_here() -> None:
    assert {file.stem for file in EXAMPLES.glob("*.py")} == set(EXPECTED)


@pytest.mark.parametrize("name, ranks", [*((name, 1) for name in EXPECTED), ("own_optimizer", 2)])
def test_example(name: str, ranks: int) -> None:
    done = started(EXAMPLES / f"{name}.py", ranks=ranks, mpi4py=ranks > 1)
    assert done.returncode == 0, done.stderr
    pattern, most = EXPECTED[name]
    assert float(re.search(pattern, done.stdout).group(1)) < most
