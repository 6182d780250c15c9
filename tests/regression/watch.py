# SPDX-License-Identifier: GPL-3.0-or-later
"""history.csv grows by whole lines while a run goes on, and postprocess/watch.py draws it again and again until the run ends."""

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, table  # noqa: E402

DRAWINGS = 5


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "run"
        out.mkdir()
        watcher = subprocess.Popen([sys.executable, str(SOURCE / "postprocess" / "watch.py"), str(out), "--every", "0.2"],
                                   stdout=subprocess.PIPE, text=True)  # fmt: skip
        # Interrupted once a few drawings are there. On this mesh it takes a minute and a half to end by itself.
        run = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--out", str(out), "--quiet", "--set", "mesh.size=0.5",
                                "--set", 'optimizer.method="projected-gradient"', "--set", "optimizer.tolerance=0", "--set", "output.fields=[]",
                                "--set", "optimizer.max_iterations=100000"])  # fmt: skip
        drawn = []
        for line in watcher.stdout:
            if line.startswith("iteration"):
                drawn.append(int(line.split()[1].rstrip(":")))
            if (out / "history.csv").exists():
                assert (out / "history.csv").read_text().endswith("\n"), "half a line"
            if len(drawn) == DRAWINGS and run.poll() is None:
                run.send_signal(signal.SIGINT)
        assert run.wait() == 130 and watcher.wait() == 0
        last = table(out / "history.csv")["iteration"][-1]
        print(f"drawn after iterations {', '.join(map(str, drawn))}; the last is {last:.0f}")
        assert len(drawn) >= DRAWINGS and drawn == sorted(drawn) and drawn[-1] == last
        assert (out / "figures" / "convergence.png").stat().st_size > 5000
        missing = subprocess.run([sys.executable, str(SOURCE / "postprocess" / "watch.py"), str(out / "no")], capture_output=True, text=True)
        assert missing.returncode == 2 and "there is no such folder" in missing.stderr
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
