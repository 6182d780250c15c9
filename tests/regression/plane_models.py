# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run can be asked for, in axial symmetry and in plane stress: ranks, stores, restart, solvers, steps, accuracy, studies."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, attempt, captured, signorini, table

SCENE = """
[mesh]
file = "{mesh}"
size = 2.5
model = "{model}"
[time]
end = 7.5e-3
step = 1.25e-4
{time}
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = {bulk}, shear = 1e4 }}
[[clamp]]
on = "top"
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -15.3], normal = [0, 1] }}
[control]
scale = 1e6
initial = ["0", "-0.5"]
[objective]
desired = {{ control = ["0", "-1"] }}
alpha = 1e-2
gamma = 7.5e-4
[optimizer]
start = "guess"
checkpoint = 1
[output]
every = 1
"""
MODELS = {"axisymmetric": ("half-ball-section.geo", 1e4), "plane-stress": ("half-disc.geo", 13e4 / 6)}


def scene(model: str, folder: Path, time: str = "") -> Path:
    mesh, bulk = MODELS[model]
    file = folder / "scene.toml"
    file.write_text(SCENE.format(mesh=SOURCE / "meshes" / mesh, model=model, bulk=bulk, time=time))
    return file


def run(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def forces(out: Path) -> np.ndarray:
    force = table(out / "steps.csv")["contact_force_y"]
    assert (force > 0).sum() > 10, "hardly any contact: the case says nothing"
    return force


@pytest.mark.parametrize("model", MODELS)
def test_ranks_and_solvers(model: str, tmp_path: Path) -> None:
    file = scene(model, tmp_path, 'scheme = "contact-stabilized"')
    signorini("simulate", file, tmp_path / "one")
    one = forces(tmp_path / "one")
    others = {"two": (2, "direct", 1e-9), "three": (3, "direct", 1e-9), "iterative": (1, "iterative", 1e-6)}
    for name, (ranks, linear, tolerance) in others.items():
        signorini("simulate", file, tmp_path / name, ranks, solver__linear=linear)
        assert abs(forces(tmp_path / name) - one).max() / one.max() <= tolerance, name
    assert run(tmp_path / "one")["body"]["model"] == model


@pytest.mark.parametrize("model", MODELS)
def test_stores_and_restart(model: str, tmp_path: Path) -> None:
    """The same search with states in memory, on disk and from checkpoints, and stopped after two iterations."""
    file = scene(model, tmp_path)

    def search(name: str, iterations: int, *options: str, **more: object) -> np.ndarray:
        overrides = {"optimizer.max_iterations": iterations} | more
        command = [str(SIGNORINI), "optimize", str(file), "--out", str(tmp_path / name), *options]
        done = captured([*command, *(word for key, value in overrides.items() for word in ("--set", f"{key}={value}"))])
        assert done.returncode in (0, 1), done.stdout + done.stderr
        return table(tmp_path / name / "history.csv")["objective"]

    J = search("memory", 4)
    assert len(J) == 5 and J[-1] < 0.9 * J[0]
    for storage in ("disk", "checkpoints"):
        assert abs(search(storage, 4, **{"trajectory.storage": f'"{storage}"'}) / J - 1).max() <= 1e-12, storage
    search("stopped", 2)
    assert abs(search("stopped", 4, "--resume") / J - 1).max() <= 1e-12


def test_another_model_is_another_problem(tmp_path: Path) -> None:
    file = scene("plane-stress", tmp_path)
    signorini("optimize", file, tmp_path / "out", optimizer__max_iterations=1)
    done = captured([str(SIGNORINI), "optimize", str(file), "--out", str(tmp_path / "out"), "--resume", "--set", "mesh.model=plane-strain"])
    assert done.returncode == 2 and "mesh.model" in done.stderr, done.stderr


@pytest.mark.parametrize("model", MODELS)
def test_chosen_steps(model: str, tmp_path: Path) -> None:
    """Steps that the motion chooses give the impulse of short equal ones, and keep the laws of energy and momentum."""
    file = scene(model, tmp_path, 'scheme = "contact-stabilized"')
    signorini("simulate", file, tmp_path / "equal", time__step=7.8125e-6)
    signorini("simulate", file, tmp_path / "chosen", time__step="auto", time__tolerance=1e-2)
    equal, chosen = (run(tmp_path / name) for name in ("equal", "chosen"))
    impulse = [one["impact"]["all"]["impulse"][1] for one in (equal, chosen)]
    assert chosen["steps"]["done"] < equal["steps"]["done"] / 2
    assert impulse[1] == pytest.approx(impulse[0], rel=0.01)
    for law in chosen["invariants"].values():
        if isinstance(law, dict) and "worst" in law:
            assert law["worst"] <= 1e-10


@pytest.mark.parametrize("model", MODELS)
def test_accuracy(model: str, tmp_path: Path) -> None:
    """The least J to a requested accuracy, on meshes of one size and on graded ones, against a finer mesh of degree 2."""
    file = scene(model, tmp_path)
    signorini("optimize", file, tmp_path / "fine", mesh__size=1.0, mesh__degree=2, time__step=3.125e-5, optimizer__start="coarse")
    exact = run(tmp_path / "fine")["objective"]["value"]
    for name, more in (("even", {}), ("graded", {"mesh.size": "auto"})):
        out = tmp_path / name
        command = [str(SIGNORINI), "optimize", str(file), "--out", str(out), "--accuracy", "0.03"]
        done = captured([*command, *(word for key, value in more.items() for word in ("--set", f"{key}={value}"))])
        assert done.returncode == 0, done.stdout + done.stderr
        assert abs(run(out)["objective"]["value"] / exact - 1) <= 0.03, name


def test_study_has_units_of_the_whole_body(tmp_path: Path) -> None:
    done = captured([str(SIGNORINI), "study", str(scene("axisymmetric", tmp_path)), "--out", str(tmp_path / "study"), "--sizes", "5,2.5",
                     "--steps", "2.5e-4,1.25e-4", "--quantity", "impulse"])  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "N s" in done.stdout and "N s/m" not in done.stdout


def test_what_is_computed_is_said(tmp_path: Path) -> None:
    info = {model: attempt("info", scene(model, tmp_path)).stdout for model in MODELS}
    assert "in the half section of a body of revolution" in info["axisymmetric"] and "kg/m" not in info["axisymmetric"]
    assert "in plane stress" in info["plane-stress"] and "kg/m" in info["plane-stress"]
    quadratic = attempt("info", scene("axisymmetric", tmp_path), mesh__degree=2).stdout
    assert "the axis has no contact candidate" in quadratic
