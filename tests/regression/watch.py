# SPDX-License-Identifier: GPL-3.0-or-later
"""history.csv grows by whole lines while a run goes on, and postprocess/watch.py draws it again and again until the run ends."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SIGNORINI, SOURCE, table  # noqa: E402


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "run"
        out.mkdir()
        watcher = subprocess.Popen([sys.executable, str(SOURCE / "postprocess" / "watch.py"), str(out), "--every", "0.2"],
                                   stdout=subprocess.PIPE, text=True)  # fmt: skip
        run = subprocess.Popen([str(SIGNORINI), "optimize", str(HALF_DISC), "--out", str(out), "--quiet", "--set", "mesh.size=1",
                                "--set", 'optimizer.method="projected-gradient"', "--set", "output.fields=[]",
                                "--set", "optimizer.max_iterations=200"])  # fmt: skip
        lengths = set()
        while run.poll() is None:
            if (out / "history.csv").exists():
                text = (out / "history.csv").read_text()
                assert text.endswith("\n"), "half a line"
                lengths.add(text.count("\n"))
            time.sleep(0.05)
        assert run.returncode == 0
        said = watcher.communicate(timeout=30)[0].splitlines()
        assert watcher.returncode == 0
        drawn = [line for line in said if line.startswith("iteration")]
        print(f"{len(lengths)} lengths of history.csv seen, {len(drawn)} drawings")
        assert len(lengths) > 5 and len(drawn) > 3 and drawn[-1].startswith("iteration 200:")
        assert len(table(out / "history.csv")["iteration"]) == 201
        assert (out / "figures" / "convergence.png").stat().st_size > 5000
        missing = subprocess.run([sys.executable, str(SOURCE / "postprocess" / "watch.py"), str(out / "no")], capture_output=True, text=True)
        assert missing.returncode == 2 and "there is no such folder" in missing.stderr
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
