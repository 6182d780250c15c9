# SPDX-License-Identifier: GPL-3.0-or-later
"""signorini.post without the compiled module: it draws the page and the figures of a run, and neither it nor the package starts MPI."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, signorini  # noqa: E402

DRAWS = """
import sys
import signorini
from signorini.post import report
from signorini.post.run_folder import RunFolder

run = RunFolder(report.Path(sys.argv[1]))
assert run.touches and run.contact.touches.any() and not run.contact.touches.all()
assert "page" in report.page_of.__doc__ and report.page_of(run.path).sections
assert "mpi4py" not in sys.modules and "signorini._signorini" not in sys.modules, "MPI was started"
assert "Scene" in dir(signorini)
try:
    signorini.Scene
    raise AssertionError("a scene without the compiled module")
except ImportError:
    pass
try:
    signorini.none
    raise AssertionError("a name that it has not")
except AttributeError:
    pass
"""


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        package, out = folder / "site" / "signorini", folder / "out"
        package.mkdir(parents=True)
        for module in (SOURCE / "python" / "signorini").glob("*.py"):
            (package / module.name).symlink_to(module)
        (package / "post").symlink_to(SOURCE / "postprocess")
        signorini("simulate", SOURCE / "tests" / "data" / "block.toml", out, time__end=0.3)
        alone = os.environ | {"PYTHONPATH": str(package.parent)}
        for words in (["-c", DRAWS, out], ["-m", "signorini.post.report", out], ["-m", "signorini.post.figures", out],
                      [SOURCE / "postprocess" / "report.py", out], [package / "post" / "energy.py", out]):  # fmt: skip
            (out / "report.html").unlink(missing_ok=True)
            done = subprocess.run([sys.executable, *words], env=alone, cwd=folder, capture_output=True, text=True)
            assert done.returncode == 0 and not done.stderr, (words, done.stdout + done.stderr)
            assert (out / "report.html").is_file() == ("report" in str(words[:2]) and "-c" not in words), words
        assert (out / "figures" / "energy.png").is_file() and (out / "figures" / "contact_force.png").is_file()
    print("signorini.post draws pages and figures without the compiled module, by its name and by its files")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
