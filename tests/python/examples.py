# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples run, on one rank and, the quickest of them, on two."""

import re
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "python" / "examples"
EXPECTED = {"scipy_optimize": (r"J = ([0-9.]+)", 0.00992), "scipy_least_squares": (r"misfit ([0-9.]+)", 1.2), "own_optimizer": (r"24  J = ([0-9.]+)", 0.02)}


def last(name: str, ranks: int) -> str:
    script = EXAMPLES / f"{name}.py"
    command = [sys.executable, script] if ranks == 1 else ["mpirun", "--oversubscribe", "-n", str(ranks), sys.executable, "-m", "mpi4py", script]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def main() -> None:
    assert {file.stem for file in EXAMPLES.glob("*.py")} == set(EXPECTED)
    for name, (pattern, most) in EXPECTED.items():
        for ranks in (1, 2) if name == "own_optimizer" else (1,):
            found = float(re.search(pattern, last(name, ranks)).group(1))
            print(f"{name} on {ranks} ranks: {found:.6g}")
            assert found < most


main()
