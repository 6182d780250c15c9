# SPDX-License-Identifier: GPL-3.0-or-later
"""Editing a form and rebuilding regenerates its C code and relinks what uses it."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from harness import SOURCE

A = "elasticity = depth * ufl.inner(isotropic(in_plane * lmbda, mu, eps(y)), eps(phi))"


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}"
    return done.stdout


def rebuild(build: Path) -> tuple[float, str]:
    """The probe's number after a build, and what the build printed."""
    log = run("cmake", "--build", str(build))
    return float(run(str(build / "probe"))), log


def test_edit_reaches_the_program(tmp_path: Path) -> None:
    forms, build = tmp_path / "forms", tmp_path / "build"
    shutil.copytree(SOURCE / "forms", forms, ignore=shutil.ignore_patterns("__pycache__"))
    run("cmake", "-S", str(Path(__file__).parent), "-B", str(build), "-G", "Ninja", f"-DFORMS_DIR={forms}")
    before, _ = rebuild(build)
    # E = 1, nu = 0: mu = 1/2, lambda = 0, so a = (1 + 1/2)/2 for the first basis function.
    assert before == pytest.approx(0.75, rel=0, abs=1e-14)

    same, idle = rebuild(build)
    assert same == before and "no work to do" in idle, "nothing was edited, and something was rebuilt"

    page = forms / "viscoelasticity.py"
    text = page.read_text()
    assert text.count(A) == 1, "the form a is not where this test edits it"
    page.write_text(text.replace(A, A.replace("elasticity = ", "elasticity = 3 * ")))
    os.utime(page)
    after, log = rebuild(build)
    assert after == pytest.approx(3 * before, rel=0, abs=1e-13), "the edit did not reach the program"
    for cell in ("triangle", "tetrahedron"):
        for degree in (1, 2):
            assert f"Compiling forms for {cell}, degree {degree}" in log
