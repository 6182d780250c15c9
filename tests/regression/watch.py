# SPDX-License-Identifier: GPL-3.0-or-later
"""history.csv grows by whole lines while a run lasts, and postprocess/watch.py draws it again and again until the run ends."""

import signal
import subprocess
import sys
from pathlib import Path

from harness import HALF_DISC, SIGNORINI, SOURCE, table

WATCH = [sys.executable, str(SOURCE / "postprocess" / "watch.py")]
DRAWINGS = 5
# On this mesh it takes a minute and a half to end by itself.
SETTINGS = ("mesh.size=0.5", 'optimizer.method="projected-gradient"', "optimizer.tolerance=0", "optimizer.max_iterations=100000",
            "output.fields=[]")  # fmt: skip


def test_draws_until_the_run_ends(tmp_path: Path) -> None:
    out = tmp_path / "run"
    out.mkdir()
    history, drawn = out / "history.csv", []
    watcher = subprocess.Popen([*WATCH, str(out), "--every", "0.2"], stdout=subprocess.PIPE, text=True)
    run = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--out", str(out), "--quiet",
                            *(word for setting in SETTINGS for word in ("--set", setting))])  # fmt: skip
    try:
        for line in watcher.stdout:
            if line.startswith("iteration"):
                drawn.append(int(line.split()[1].rstrip(":")))
            if history.exists():
                assert history.read_text().endswith("\n"), "half a line"
            if len(drawn) == DRAWINGS and run.poll() is None:
                run.send_signal(signal.SIGINT)
        assert run.wait() == 130 and watcher.wait() == 0
    finally:
        watcher.kill(), run.kill()
    assert len(drawn) >= DRAWINGS and drawn == sorted(drawn) and drawn[-1] == table(history)["iteration"][-1]
    assert (out / "figures" / "convergence.png").stat().st_size > 5000


def test_no_such_folder(tmp_path: Path) -> None:
    missing = subprocess.run([*WATCH, str(tmp_path / "no")], capture_output=True, text=True)
    assert missing.returncode == 2 and "there is no such folder" in missing.stderr
