# SPDX-License-Identifier: GPL-3.0-or-later
"""signorini.post without the compiled module: it draws the page and the figures of a run, and neither it nor the package starts MPI."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from harness import SOURCE, signorini

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
PAGE, ENERGY, FORCE = "report.html", "figures/energy.png", "figures/contact_force.png"
# What Python runs, and the files that it writes.
CASES = {
    "imports": (("-c", DRAWS), set()),
    "report by its name": (("-m", "signorini.post.report"), {PAGE}),
    "figures by their name": (("-m", "signorini.post.figures"), {ENERGY, FORCE}),
    "report by its file": ((SOURCE / "postprocess" / "report.py",), {PAGE}),
    "a figure by its file": (("site/signorini/post/energy.py",), {ENERGY}),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run, and with the package in a folder for PYTHONPATH, without the compiled module."""
    folder = tmp_path_factory.mktemp("post")
    package = folder / "site" / "signorini"
    package.mkdir(parents=True)
    for module in (SOURCE / "python" / "signorini").glob("*.py"):
        (package / module.name).symlink_to(module)
    (package / "post").symlink_to(SOURCE / "postprocess")
    signorini("simulate", SOURCE / "tests" / "data" / "block.toml", folder / "out", time__end=0.3)
    return folder


@pytest.mark.parametrize("words, written", CASES.values(), ids=CASES)
def test_draws(folder: Path, words: tuple[str | Path, ...], written: set[str]) -> None:
    out = folder / "out"
    (out / PAGE).unlink(missing_ok=True)
    shutil.rmtree(out / "figures", ignore_errors=True)
    done = subprocess.run([sys.executable, *words, out], env=os.environ | {"PYTHONPATH": str(folder / "site")}, cwd=folder,
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0 and not done.stderr, done.stdout + done.stderr
    assert {name for name in (PAGE, ENERGY, FORCE) if (out / name).exists()} == written
