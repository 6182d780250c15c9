# SPDX-License-Identifier: GPL-3.0-or-later
"""The mass of a ball that a block catches, and mass and stiffness of a load cell that a block falls on, from records of the force."""

import json
from pathlib import Path

import numpy as np
import pytest
from fit_runs import fitted, measure, unknowns
from harness import SOURCE, signorini

HEAD = f"""
[mesh]
file = "{SOURCE / "meshes" / "block.geo"}"
size = 0.25
[time]
end = {{end}}
step = 5e-3
scheme = "contact-stabilized"
[material]
density = 1.0
young = 100.0
poisson = 0.3
viscosity = {{{{ bulk = 0.5, shear = 0.5 }}}}
[contact]
on = "{{on}}"
obstacle = {{{{ name = "{{name}}", {{obstacle}} }}}}
[output]
fields = []
[[measurement]]
of = "force"
component = "y"
noise = 0.02
file = "{{folder}}/record.csv"
"""
BALL = {"end": 0.8, "on": "top", "name": "ball",
        "obstacle": 'shape = "ball", center = [0.5, 2.02], radius = 1.0, mass = 0.8, velocity = [0, -1], components = ["y"]'}  # fmt: skip
HELD = '[[foundation]]\non = "bottom"\nstiffness = { normal = 50.0, tangential = 50.0 }\n'
CELL = {"end": 0.8, "on": "bottom", "name": "cell",
        "obstacle": 'shape = "half-space", point = [0, -0.02], normal = [0, 1], mass = 0.1, stiffness = 40.0, damping = 0.2, components = ["y"]'}  # fmt: skip
FALLS = '[initial]\nvelocity = ["0", "-1"]\n'
CASES = {"ball": (BALL, HELD, {"mass": 0.8}), "load cell": (CELL, FALLS, {"mass": 0.1, "stiffness": 40.0})}


def scene(folder: Path, name: str, times: float) -> Path:
    case, more, true = CASES[name]
    file = folder / "scene.toml"
    file.write_text(HEAD.format(folder=folder, **case) + more + unknowns([{"of": of, "start": times * value} for of, value in true.items()]))
    return file


def touched(folder: Path) -> bool:
    found = json.loads((folder / "made" / "run.json").read_text())["impact"]["all"]
    return found["contact_time"] > 0.1


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("times", (2.0, 0.5))
def test_comes_back(tmp_path: Path, name: str, times: float) -> None:
    """From a record without noise, from twice and half the values."""
    file = scene(tmp_path, name, times)
    measure(file, tmp_path / "made", {})
    assert touched(tmp_path)
    signorini("optimize", file, tmp_path / "fit")
    found = fitted(tmp_path / "fit")
    for of, value in CASES[name][2].items():
        off = found[f"{of} of {CASES[name][0]['name']}"][0] / value - 1
        print(f"{of} from {times:g} times off to {off:.1e}")
        assert abs(off) <= 1e-6


@pytest.mark.parametrize("name", CASES)
def test_deviations(tmp_path: Path, name: str) -> None:
    """Of 40 records with 2 % noise each value is within two of its deviations for at least 33, as for 95 % of all records."""
    file = scene(tmp_path, name, 1.2)
    off = []
    for seed in range(1, 41):
        measure(file, tmp_path / "made", {}, seed)
        signorini("optimize", file, tmp_path / "fit")
        found = fitted(tmp_path / "fit")
        off.append([(found[f"{of} of {CASES[name][0]['name']}"][0] - value) / found[f"{of} of {CASES[name][0]['name']}"][1]
                    for of, value in CASES[name][2].items()])  # fmt: skip
    within = np.sum(np.abs(off) <= 2, axis=0)
    print(f"{within} of {len(off)} within two deviations; mean {np.mean(off, axis=0)}, standard deviation {np.std(off, axis=0)}")
    assert np.min(within) >= 33 and np.min(np.std(off, axis=0)) > 0.5
