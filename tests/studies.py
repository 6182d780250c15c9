# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of studies share."""

import signal
import subprocess
import time
from pathlib import Path

from harness import SIGNORINI, SOURCE, captured

DATA = SOURCE / "tests" / "data"
IMPACT = SOURCE / "scenes" / "bar-impact.toml"
# A study of the half disc with one rung, for searches beside it.
ONE_RUNG = ("--sizes", "2", "--steps", "1e-4", "--quantity", "J", "--set", "mesh.size=2", "--set", "time.step=1e-4")


def study(scene: Path, out: Path | None, *options: object, ranks: int = 1, status: int = 0) -> subprocess.CompletedProcess:
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [str(SIGNORINI), "study", str(scene), *(["--out", str(out)] if out else []), *map(str, options)]
    done = captured(command, timeout=300)  # where none takes minutes
    assert done.returncode == status, done.stdout + done.stderr
    return done


def interrupt(scene: Path, out: Path, *options: str, after: str, pause: float = 0) -> None:
    """Runs a study and sends SIGINT `pause` seconds after it printed a line that starts with `after`."""
    process = subprocess.Popen([str(SIGNORINI), "study", str(scene), "--out", str(out), *options], stdout=subprocess.PIPE, text=True)
    for line in process.stdout:
        if line.startswith(after):
            break
    time.sleep(pause)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 130
