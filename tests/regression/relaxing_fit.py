# SPDX-License-Identifier: GPL-3.0-or-later
"""A rubber ball with one branch of a Prony series is dropped on a plate, and its force is recorded: a fit finds the branch.

A viscosity fitted to the same record reproduces it, but not the force at another speed: a slower ball is in contact longer, and the
damping of a branch falls with the frequency above 1/time, where that of a viscosity grows.
"""

from pathlib import Path

import numpy as np
import pytest
from fit_runs import check_printed, fitted, measure, unknowns
from harness import SOURCE, signorini, table

YOUNG, BRANCH = 4e6, {"g": 0.5, "k": 0.0, "time": 2e-3}  # Pa, s
SPEEDS = (5.0, 0.5)  # m/s, of the fit and of the prediction
BALL = f"""
[mesh]
file = "{SOURCE / "meshes" / "ball.geo"}"
size = 5e-3
[time]
end = 8e-3
step = 1e-4
scheme = "contact-stabilized"
[material]
density = 1100.0
young = {YOUNG}
poisson = 0.45
{{damping}}
[contact]
on = "contact"
obstacle = {{{{ shape = "half-space", point = [0, 0, -0.02005], normal = [0, 0, 1] }}}}
[initial]
velocity = ["0", "0", "-{SPEEDS[0]}"]
[output]
fields = []
[[measurement]]
of = "force"
component = "z"
noise = 0.02
file = "{{data}}"
"""
PRONY = "prony = [ { g = 0.5, k = 0.0, time = 2e-3 } ]"
VISCOUS = "viscosity = { bulk = 0.0, shear = 100.0 }"
BY_BRANCH = [{"of": "prony.g", "start": 0.3}, {"of": "prony.time", "start": 5e-3}]
BY_VISCOSITY = [{"of": "young", "start": 3e6}, {"of": "shear", "start": 300.0}]


def scene(folder: Path, name: str, damping: str, wanted: list[dict]) -> Path:
    """The dropped ball; all scenes of a folder have the same data."""
    file = folder / f"{name}.toml"
    file.write_text(BALL.format(damping=damping, data=folder / "force.csv") + unknowns(wanted))
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the record, without noise."""
    made = tmp_path_factory.mktemp("ball")
    measure(scene(made, "record", PRONY, BY_BRANCH), made / "made", {})
    return made


def test_branch_comes_back(folder: Path) -> None:
    """g and time from the record, to 1e-6."""
    done = signorini("optimize", scene(folder, "branch", PRONY, BY_BRANCH), folder / "branch")
    found = {name: value for name, (value, _) in fitted(folder / "branch").items()}
    off = [found[f"prony.{name}"] / BRANCH[name] - 1 for name in ("g", "time")]
    iterations = len(table(folder / "branch" / "history.csv")["iteration"]) - 1
    print(f"{iterations} iterations, g off by {off[0]:.1e}, time by {off[1]:.1e}")
    assert np.max(np.abs(off)) <= 1e-6 and iterations <= 20
    check_printed(folder / "branch", done.stdout)


def force(file: Path, out: Path, speed: float, **overrides: object) -> np.ndarray:
    signorini("simulate", file, out, initial__velocity=["0", "0", f"-{speed}"], **overrides)
    return table(out / "steps.csv")["contact_force_z"]


def test_two_speeds(folder: Path, tmp_path: Path) -> None:
    """Both models are fitted at one speed and predict the other."""
    branch = scene(folder, "young and branch", PRONY, [{"of": "young", "start": 3e6}, *BY_BRANCH])
    viscous = scene(folder, "viscosity", VISCOUS, BY_VISCOSITY)
    off: dict[str, list[float]] = {}
    for model, file in (("branch", branch), ("viscosity", viscous)):
        signorini("optimize", file, tmp_path / model)
        value = {name: found for name, (found, _) in fitted(tmp_path / model).items()}
        fit = {"material__young": value["young"]} | (
            {"material__prony": [{"g": value["prony.g"], "k": 0.0, "time": value["prony.time"]}]} if model == "branch"
            else {"material__viscosity": {"bulk": 0.0, "shear": value["shear"]}})  # fmt: skip
        off[model] = []
        for speed in SPEEDS:
            exact = force(branch, tmp_path / f"exact-{speed}", speed)
            assert (exact > 0).sum() > 20, "hardly any contact: the case says nothing"
            off[model].append(np.linalg.norm(force(file, tmp_path / f"{model}-{speed}", speed, **fit) - exact) / np.linalg.norm(exact))
    for model, (own, other) in off.items():
        print(f"{model}: force off by {100 * own:.2g} % at {SPEEDS[0]:g} m/s, by {100 * other:.2g} % at {SPEEDS[1]:g} m/s")
    assert off["branch"][1] < 1e-5
    assert off["viscosity"][1] > 2 * off["viscosity"][0] and off["viscosity"][1] > 0.05
