# SPDX-License-Identifier: GPL-3.0-or-later
"""SciPy's search takes the same steps on two ranks as on one."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

SCRIPT = Path(__file__).parent / "optimizers.py"
SAME = 1e-6  # of J, as rounding grows over the iterations; 1e-10 is usual
ITERATIONS = 8


def main() -> None:
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for ranks in (1, 2):
            file = Path(folder) / f"{ranks}.json"
            subprocess.run(["mpirun", "--oversubscribe", "-n", str(ranks), sys.executable, "-m", "mpi4py", SCRIPT,
                            "--iterations", str(ITERATIONS), "--found", file], check=True)  # fmt: skip
            found[ranks] = json.loads(file.read_text())
    assert len(found[1]) == len(found[2]) == ITERATIONS
    worst = np.max([abs(two / one - 1) for one, two in zip(found[1], found[2])])
    print(f"J of {ITERATIONS} iterations differs by {worst:.1e} at most")
    assert worst < SAME


main()
