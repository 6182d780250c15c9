# SPDX-License-Identifier: GPL-3.0-or-later
"""Editing a form and rebuilding regenerates its C code and relinks what uses it."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

A = "elasticity = ufl.inner(isotropic(lmbda, mu, eps(y)), eps(phi))"


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def rebuild(build: Path) -> tuple[float, str]:
    """The probe's number after a build, and what the build printed."""
    log = run("cmake", "--build", str(build))
    return float(run(str(build / "probe"))), log


def main() -> int:
    source = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        forms, build = Path(folder) / "forms", Path(folder) / "build"
        shutil.copytree(source / "forms", forms, ignore=shutil.ignore_patterns("__pycache__"))
        run("cmake", "-S", str(source / "tests/regression/forms"), "-B", str(build), "-G", "Ninja", f"-DFORMS_DIR={forms}")
        before, _ = rebuild(build)
        same, idle = rebuild(build)
        page = forms / "viscoelasticity.py"
        text = page.read_text()
        assert text.count(A) == 1, "the form a is not where this test edits it"
        page.write_text(text.replace(A, A.replace("elasticity = ", "elasticity = 3 * ")))
        os.utime(page)
        after, log = rebuild(build)
    print(f"a on the reference triangle: {before}, rebuilt {same}, edited to three times {after}")
    # E = 1, nu = 0: mu = 1/2, lambda = 0, so a = (1 + 1/2)/2 for the first basis function.
    assert abs(before - 0.75) < 1e-14 and same == before
    assert "no work to do" in idle, "nothing was edited, and something was rebuilt"
    assert abs(after - 3 * before) < 1e-13, "the edit did not reach the program"
    for cell in ("triangle", "tetrahedron"):
        for degree in (1, 2):
            assert f"Compiling forms for {cell}, degree {degree}" in log
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
