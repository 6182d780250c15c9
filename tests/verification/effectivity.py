# SPDX-License-Identifier: GPL-3.0-or-later
"""Effectivity of the estimate of J's error: estimate over true error, signs included, between 0.5 and 2 in nine of ten runs.

Scenes that differ in physics: a half disc, also as half section of a ball, on springs and as plate, pushed onto a plane that rests or moves; a block with a bumpy initial velocity, clamped
or thrown onto a tilted plane; a cube whose initial and desired motions are bumpy. A few runs of each, and in the long test 100. A
block without bumps that hits with a corner is not among them: there the error is that of a point contact, which the estimate
does not see. The true error is that to J of functions of degree 2 on a mesh and with steps much finer, extrapolated from a mesh
twice as wide and steps twice as long as if of order 2; the corrections' moduli are the reference's own uncertainty. A run counts
whose true error is five times that. Controls are functions of the mesh's own space on any mesh, since the estimate takes
the control as given.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, captured, table, toml

LEAST, LARGEST, SHARE = 0.5, 2, 0.9
CERTAIN = 5  # times the reference's uncertainty
ALL = ("contact-implicit", "contact-stabilized", "massless")
PARTS = ("space", "time", "initial", "desired")
BUMPS = "sin(8*x)*cos(8*y)*(1-y)"


@dataclass
class Case:
    title: str
    scene: str
    overrides: dict[str, object]
    runs: list[tuple[tuple[float, ...], tuple[float, ...], tuple[str, ...]]]  # sizes, steps, schemes: all combinations
    few: tuple[tuple[float, ...], tuple[float, ...], tuple[str, ...]]
    reference: tuple[float, float]  # size and step
    coarse_reference: tuple[float, float] = field(default=(0, 0))


CASES = (
    Case("half disc", "scenes/half-disc.toml", {"check.control": ["0.2+0.02*x", "-0.8"]},
         [((3, 2, 1.5, 1), (2e-4, 1e-4), ALL[:1]), ((2, 1.5, 1), (1e-4,), ALL[1:]), ((1,), (5e-5,), ALL[:1])],
         ((3, 2, 1.5), (2e-4,), ALL[:1]), (0.35, 2.5e-5), (0.75, 1e-4)),
    Case("block, clamped", "tests/data/block.toml",
         {"contact.obstacle.point": [0, -9], "clamp": [{"on": "top"}], "initial.velocity": [f"4*{BUMPS}", "0"], "load.body": ["0", "0"],
          "control": {"scale": 1.0}, "check": {"control": ["0.5*y", "0.3-x"]}, "time.end": 0.5,
          "objective": {"desired": {"displacement": ["0.1*(1-y)", "0"]}, "alpha": 1e-2, "gamma": 1e-2}},
         [((0.15, 0.1, 0.07, 0.05), (0.01, 0.005, 0.0025, 0.00125), ALL[:1])],
         ((0.15, 0.1), (0.01, 0.005), ALL[:1]), (0.02, 3.125e-4), (0.04, 1.25e-3)),
    Case("block, thrown", "tests/data/block.toml", {"initial.velocity": [BUMPS, BUMPS], "check": {"control": ["0.5*y", "0.5-x"]}},
         [((0.25, 0.2, 0.15, 0.1, 0.07), (0.02, 0.01, 0.005), ALL[:1]), ((0.2, 0.15, 0.1, 0.07), (0.01, 0.005), ALL[1:])],
         ((0.25, 0.15), (0.01,), ALL[:1]), (0.02, 1.25e-3), (0.05, 2.5e-3)),
    Case("half disc, hit", "scenes/half-disc.toml",
         {"check.control": ["0.2+0.02*x", "-0.8"],
          "contact.obstacle": {"shape": "half-space", "point": [0, "-15.75 + 0.6*sin(800*t)"], "normal": [0, 1]}},
         [((3, 2, 1.5, 1), (2e-4, 1e-4), ALL[:1]), ((2, 1.5, 1), (1e-4, 5e-5), ALL[1:]), ((2, 1.5, 1), (5e-5,), ALL[:1])],
         ((2, 1.5), (2e-4,), ALL[:1]), (0.35, 2.5e-5), (0.75, 1e-4)),
    Case("half ball, revolved", "scenes/half-disc.toml",
         {"mesh.file": str(SOURCE / "meshes" / "half-ball-section.geo"), "mesh.model": "axisymmetric", "check.control": ["0.02*x", "-0.8"]},
         [((3, 2, 1.5, 1), (2e-4, 1e-4), ALL[:1]), ((1.5, 1), (1e-4,), ALL[1:])],
         ((3, 2, 1.5), (2e-4,), ALL[:1]), (0.35, 2.5e-5), (0.75, 1e-4)),
    Case("half disc on springs", "scenes/half-disc.toml",
         {"check.control": ["0.2+0.02*x", "-0.8"],
          "foundation": [{"on": "side", "stiffness": {"normal": 1e6, "tangential": 1e6}, "damping": {"normal": 1e3}}]},
         [((3, 2, 1.5, 1), (2e-4,), ALL[:1])], ((3, 2), (2e-4,), ALL[:1]), (0.35, 2.5e-5), (0.75, 1e-4)),
    Case("plate", "scenes/half-disc.toml",
         {"mesh.model": "plane-stress", "check.control": ["0.2+0.02*x", "-0.8"], "material.viscosity": {"bulk": 13e4 / 6, "shear": 1e4}},
         [((3, 2, 1.5, 1), (2e-4,), ALL[:1])], ((3, 2), (2e-4,), ALL[:1]), (0.35, 2.5e-5), (0.75, 1e-4)),
    Case("cube", "tests/data/cube.toml",
         {"contact.obstacle.point": [0, 0, -9], "time.end": 0.4, "control": {"scale": 1.0}, "check": {"control": ["0.5*y", "0.3-x", "0"]},
          "load.body": ["0", "0", "0"],
          "initial": {"velocity": ["sin(4*x)*cos(3*y)*(1-z)", "0.5*cos(3*z)", "0.5*sin(4*y)*z"],
                      "displacement": ["0", "0.02*sin(4*x)*z", "0.01*cos(3*x)"]},
          "objective": {"desired": {"displacement": ["0.1*sin(3*y)*t", "0.05*cos(4*x)", "-0.1*sin(3*z)*t"]}, "alpha": 1e-2, "gamma": 1e-2}},
         [((0.5, 0.4, 0.34, 0.25, 0.2), (0.02, 0.01, 0.005), ALL[:1])],
         ((0.5, 0.34), (0.02, 0.01), ALL[:1]), (0.125, 0.005), (0.25, 0.01)),
)  # fmt: skip


def study(case: Case, out: Path, sizes: tuple, steps: tuple, schemes: tuple, degree: int) -> dict:
    """study.csv of all combinations. Each has a folder of its own: a study compares with its finest rung, which is of no use here."""
    command = [str(SIGNORINI), "study", str(SOURCE / case.scene), "--out", str(out), "--quantity", "J", "--degrees", str(degree)]
    for option, values in (("--sizes", sizes), ("--steps", steps), ("--schemes", schemes)):
        if option != "--schemes" or len(values) > 1 or values != ALL[:1]:
            command += [option, ",".join(map(str, values))]
    for key, value in case.overrides.items():
        command += ["--set", f"{key}={toml(value)}"]
    done = captured(command)
    assert done.returncode == 0, f"{command}:\n{done.stdout}{done.stderr}"
    return table(out / "study.csv")


def reference(case: Case, out: Path, finest: tuple[float, float]) -> tuple[float, float]:
    """J and its uncertainty."""
    size, step = finest
    fine = study(case, out / "fine", (size,), (step, 2 * step), ALL[:1], 2)
    wide = study(case, out / "wide", (2 * size,), (2 * step,), ALL[:1], 2)
    by_steps = dict(zip(fine["steps"], fine["J"]))
    best, longer = by_steps[np.max(list(by_steps))], by_steps[np.min(list(by_steps))]
    corrections = (best - longer) / 3, (longer - wide["J"][0]) / 3
    return best + sum(corrections), sum(map(abs, corrections))


def rows(case: Case, out: Path, full: bool) -> list[tuple]:
    """Of each run the scheme, the mass, size and step, J, and the parts of its estimate relative to J."""
    found = []
    for i, (sizes, steps, schemes) in enumerate(case.runs if full else [case.few]):
        columns = study(case, out / str(i), sizes, steps, schemes, 1)
        names = ("scheme", "mass", "size", "step", "J", *(f"J_estimate_{part}" for part in PARTS))
        found += zip(*(columns[name] for name in names), strict=True)
    return found


def check(folder: Path, full: bool) -> None:
    effectivities, dropped = [], 0
    print("scene          scheme               size      step  true error   estimate  effectivity  parts", PARTS)
    for case in CASES:
        out = folder / case.title.replace(" ", "-").replace(",", "")
        J, uncertainty = reference(case, out, case.reference if full else case.coarse_reference)
        print(f"{case.title}: J = {J:.6e}, to {uncertainty / abs(J):.1e}")
        for scheme, mass, size, step, found, *parts in rows(case, out, full):
            error, estimate = J - found, sum(parts) * abs(found)
            certain = abs(error) >= CERTAIN * uncertainty
            dropped += not certain
            if certain:
                effectivities.append(estimate / error)
            shown = f"{estimate / error:11.2f}" if certain else "          -"
            print(f"{'':14} {mass if mass == 'massless' else scheme:18} {size:6.3g} {step:9.3g} {error / abs(J):+11.2e} "
                  f"{estimate / abs(J):+10.2e}  {shown}  {' '.join(f'{part * abs(found / J):+.1e}' for part in parts)}")  # fmt: skip
    good = sum(LEAST <= e <= LARGEST for e in effectivities)
    print(f"{good} of {len(effectivities)} runs between {LEAST} and {LARGEST}; the error of {dropped} is within the reference's own")
    assert len(effectivities) >= 3 * np.maximum(dropped, 1), "hardly any run counts"
    assert good >= SHARE * len(effectivities)


def test_few(tmp_path: Path) -> None:
    check(tmp_path, full=False)


@pytest.mark.long
def test_full(tmp_path: Path) -> None:
    check(tmp_path, full=True)
