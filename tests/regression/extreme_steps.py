# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps in which a body would fall through itself a million times, and a touch exactly at the end of a step.

A block at rest on its support: the support's impulse is its weight's, by every solver, however long the steps.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import attempt, signorini, stored, table
from soft_scenes import soft

HALF_SPACE = """
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
"""
WEIGHT = 9.81 * 1000  # N/m, in space N, of a body of 1 m
DEFLECTION = WEIGHT / 1e7  # m, at most
STEPS, EPS, WAVE = 6, np.finfo(float).eps, 116  # m/s
ELEMENT = {2: 0.25, 3: 0.5}  # m


def resting(folder: Path, dim: int) -> Path:
    scene = folder / f"resting-{dim}.toml"
    up, mesh = [0] * (dim - 1) + [1], "square.geo" if dim == 2 else "cube.geo"
    scene.write_text(soft(mesh, ELEMENT[dim], 1.0, 0.1).replace("density = 1.0", "density = 1000.0").replace(
        "young = 50.0", "young = 1e7").replace("viscosity = { bulk = 0.05, shear = 0.05 }", "") + HALF_SPACE.format(point=[0] * dim, normal=up)
        + f"[load]\ngravity = {[0.0] * (dim - 1) + [-9.81]}\n")  # fmt: skip
    return scene


@pytest.mark.parametrize("step", (1e-3, 10.0, 1e3, 1e5))
@pytest.mark.parametrize("dim", (2, 3))
def test_at_rest(dim: int, step: float, tmp_path: Path) -> None:
    """Among them steps in which the free fall, g τ²/2, is up to 5e10 times the body."""
    found = {}
    for solver, ranks, overrides in (("condensed", 1, {}), ("ranks", 2, {}), ("full", 1, {"solver__vi": "full"})):
        out = tmp_path / solver
        signorini("simulate", resting(tmp_path, dim), out, ranks, time__step=step, time__end=STEPS * step, output__every=1, **overrides)
        steps, contact = table(out / "steps.csv"), table(out / "contact.csv")
        assert (contact["force"] > 0).sum() > STEPS, "hardly any contact: the case says nothing"
        force = steps[f"contact_force_{'xyz'[dim - 1]}"][1:]
        assert contact["gap"].min() > -2e-10, solver
        if step > 1:  # long beside the vibration, of which the body's momentum alternates
            assert force / WEIGHT == pytest.approx(1, abs=1e-6 + 8 * STEPS * DEFLECTION / (9.81 * step**2)), solver
        nodes, _, moved = stored(out, "state", "displacement")
        found[solver] = moved[:, np.lexsort(nodes.T.round(9)), dim - 1]  # nothing holds it sideways
    size = abs(found["full"]).max()
    for solver in ("condensed", "ranks"):
        off = abs(found[solver] - found["full"]).max() / size
        print(f"{solver} off by {off:.1e} of {size:.1e} m")
        # In D = M + τ²/4 A the mass is known to ε C² of itself, C being the Courant number.
        assert off < 1e-12 + 10 * EPS * (WAVE * step / ELEMENT[dim]) ** 2, solver


@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("scheme", ("contact-implicit", "contact-stabilized"))
def test_exact_touch(scheme: str, degree: int, tmp_path: Path) -> None:
    """A block that falls freely at 1 m/s by 0.05 m, in five steps of 0.01 s: what is left of its first touch is rounding."""
    scene, out = tmp_path / "touch.toml", tmp_path / "touch"
    scene.write_text(soft("square.geo", 0.1, 0.2, 0.01).replace("young = 50.0", "young = 1000.0").replace("0.05, shear = 0.05", "1.0, shear = 1.0")
                     + HALF_SPACE.format(point=[0, -0.05], normal=[0, 1]) + '[initial]\nvelocity = ["0", "-1"]\n')  # fmt: skip
    done = attempt("simulate", scene, out, time__scheme=scheme, mesh__degree=degree, run__invariants="stop")
    assert done.returncode == 0, done.stdout + done.stderr
    steps = table(out / "steps.csv")
    touch = int(np.flatnonzero(steps["contact_force_y"])[0])
    worst = json.loads((out / "run.json").read_text())["invariants"]["adhesion / force scale"]
    assert touch in (5, 6) and steps["contact_force_y"].max() > 10 and worst["worst"] < 1e-10
