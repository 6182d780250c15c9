# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of studies share."""

import subprocess
from pathlib import Path

import numpy as np
from harness import SIGNORINI, SOURCE, captured, table
from patch_scene import PRESSURE, patch

DATA = SOURCE / "tests" / "data"
IMPACT = SOURCE / "scenes" / "bar-impact.toml"


def study(scene: Path, out: Path | None, *options: object, ranks: int = 1, status: int = 0) -> subprocess.CompletedProcess:
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [str(SIGNORINI), "study", str(scene), *(["--out", str(out)] if out else []), *map(str, options)]
    done = captured(command, timeout=300)  # where none takes minutes
    assert done.returncode == status, done.stdout + done.stderr
    return done


def pressure(folder: Path, ranks: int = 1) -> None:
    """The uniform pressure of the patch test, of both degrees; see tests/verification/hard/discs.py."""
    for name, dim in (("plane", 2), ("space", 3)):
        scene = folder / f"patch-{name}.toml"
        scene.write_text(patch(dim, size=0.5, step=0.02) + f'[exact]\npressure = "{PRESSURE}"\n')
        out = folder / f"patch-{name}-{ranks}"
        study(scene, out, "--sizes", "0.5", "--steps", "0.02", "--degrees", "1,2", "--quantity", "pressure", ranks=ranks)
        rows = table(out / "study.csv")
        print(f"uniform pressure, {name}, {ranks} ranks: off by", *(f"{error:.0e}" for error in rows["pressure_error"]))
        assert sorted(rows["degree"]) == [1, 2] and np.max(rows["pressure_error"]) < 1e-10  # 500 steps, each to about 1e-14 of the stiffest
