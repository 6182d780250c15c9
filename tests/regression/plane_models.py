# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in axial symmetry and in plane stress: ranks, stores, restart, solvers, steps, accuracy, studies."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, attempt, captured, signorini, table
from soft_scenes import soft

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


# Bodies that fall freely onto a floor.
FALL = """
[mesh]
file = "{mesh}"
size = 1.25
model = "{model}"
[time]
end = {end}
step = {step}
scheme = "contact-stabilized"
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = {bulk}, shear = 1e4 }}
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, {floor}], normal = [0, 1] }}
[initial]
velocity = ["0", "-5"]
[load]
gravity = [0, -9.81]
"""


def fall(model: str, folder: Path, step: str, end: float, floor: float) -> Path:
    mesh, bulk = MODELS[model]
    file = folder / "fall.toml"
    file.write_text(FALL.format(mesh=SOURCE / "meshes" / mesh, model=model, bulk=bulk, step=step, end=end, floor=floor))
    return file


@pytest.mark.parametrize("model", MODELS)
def test_free_fall(model: str, tmp_path: Path) -> None:
    """Chosen steps of a free fall: the time of the touch is exact, and the impulse is that of short equal steps."""
    short, chosen = tmp_path / "equal", tmp_path / "chosen"
    signorini("simulate", fall(model, tmp_path, "1.5625e-5", 0.15, -15.5), short)
    signorini("simulate", fall(model, tmp_path, '"auto"', 0.15, -15.5), chosen, time__tolerance=1e-2)
    impulse = [run(out)["impact"]["all"]["impulse"][1] for out in (short, chosen)]
    gap = table(chosen / "steps.csv")["min_gap"][0]
    touch, exact = run(chosen)["impact"]["all"]["start"], (np.sqrt(25 + 2 * 9.81 * gap) - 5) / 9.81
    print(f"{model}: impulses {impulse}, touch at {touch:.6f} s, exactly {exact:.6f} s, {run(chosen)['steps']['done']} steps")
    assert run(chosen)["steps"]["done"] < run(short)["steps"]["done"] / 10
    assert impulse[1] == pytest.approx(impulse[0], rel=0.01) and touch == pytest.approx(exact, rel=1e-3)
    assert run(short)["impact"]["ended"] and run(chosen)["impact"]["ended"], "contact lasts to the end"


@pytest.mark.parametrize("model", MODELS)
def test_accuracy_of_an_impulse(model: str, tmp_path: Path) -> None:
    signorini("simulate", fall(model, tmp_path, "3.125e-5", 0.05, -15.05), tmp_path / "fine", mesh__size=0.6, mesh__degree=2)
    exact = run(tmp_path / "fine")["impact"]["all"]["impulse"][1]
    out = tmp_path / "found"
    scene = fall(model, tmp_path, "5e-4", 0.05, -15.05)
    done = captured([str(SIGNORINI), "simulate", str(scene), "--out", str(out), "--accuracy", "0.1", "--quantity", "impulse"])
    assert done.returncode == 0, done.stdout + done.stderr
    found = run(out)
    print(f"{model}: estimated {found['accuracy']['estimated']:.1e}, found {abs(found['impact']['all']['impulse'][1] / exact - 1):.1e}")
    assert found["accuracy"]["met"] and found["accuracy"]["estimated"] <= 0.1
    assert found["impact"]["all"]["impulse"][1] == pytest.approx(exact, rel=found["accuracy"]["estimated"])


# --- The half section --------------------------------------------------------------------------------------------------

CYLINDER = soft("../../meshes/block.geo", 0.25, 0.6, 0.02).replace("\nsize", '\nmodel = "axisymmetric"\nsize')
RING = """
Point(1) = {1, 0, 0};  Point(2) = {2, 0, 0};  Point(3) = {2, 1, 0};  Point(4) = {1, 1, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("outside") = {2};
"""


@pytest.mark.parametrize("degree", (1, 2))
def test_signed_distance_at_the_axis(degree: int, tmp_path: Path) -> None:
    """The tip of a cone is symmetric without abs(x), and an expression may be undefined at negative radii."""

    def contact(name: str, distance: str) -> Path:
        scene, out = tmp_path / f"{name}.toml", tmp_path / name
        obstacle = f'{{ shape = "signed-distance", distance = "{distance}" }}'
        scene.write_text(f'{CYLINDER}[contact]\non = "bottom"\nobstacle = {obstacle}\n[initial]\nvelocity = ["0", "-1"]\n')
        signorini("simulate", scene, out, mesh__degree=degree, output__every=1)
        return out / "contact.csv"

    cone = contact("cone", "(y + 0.1 + x)/sqrt(2)")
    assert table(cone)["force"].max() > 0, "no contact: the case says nothing"
    assert cone.read_bytes() == contact("mirrored", "(y + 0.1 + abs(x))/sqrt(2)").read_bytes()
    if degree == 1:
        on_axis = table(cone)["x"] == 0
        assert on_axis.any() and (table(cone)["normal_y"][on_axis] == 1).all()
    assert table(contact("root", "y + 0.1 + sqrt(x)"))["force"].max() > 0


def test_ring_in_a_tube(tmp_path: Path) -> None:
    """A free ring that grows until it hits a tube: its radial forces have no resultant, hence no restitution."""
    (tmp_path / "ring.geo").write_text(RING)
    scene, out = tmp_path / "ring.toml", tmp_path / "ring"
    tube = '{ shape = "cylinder", point = [0, 0], radius = 2.05, side = "inside" }'
    text = CYLINDER.replace(str(SOURCE / "tests" / "data" / "../../meshes/block.geo"), str(tmp_path / "ring.geo"))
    scene.write_text(f'{text}[contact]\non = "outside"\nobstacle = {tube}\n[initial]\nvelocity = ["1", "0"]\n')
    said = signorini("simulate", scene, out).stdout
    impact = run(out)["impact"]
    assert impact["all"]["normal_impulse"] > 0 and impact["ended"], "the ring does not hit the tube and leave"
    assert impact["all"]["impulse"] == [0, 0] and impact["restitution"] is None
    assert "no restitution: radial forces have no resultant" in said


@pytest.mark.parametrize("model, unit, accepted", (("axisymmetric", "N", True), ("axisymmetric", "N/m", False),
                                                   ("plane-strain", "N/m", True), ("plane-strain", "N", True)))  # fmt: skip
def test_unit_of_measured_forces(model: str, unit: str, accepted: bool, tmp_path: Path) -> None:
    """Forces of a whole body are in N; per metre of depth, N stands for a body 1 m deep."""
    (tmp_path / "force.csv").write_text(f"time,value [{unit}]\n0,0\n0.3,1\n0.6,0\n")
    scene = tmp_path / "scene.toml"
    scene.write_text(f"""{CYLINDER}[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = [0, -0.1], normal = [0, 1] }}
[initial]
velocity = ["0", "-1"]
[[unknown]]
of = "young"
[[measurement]]
of = "force"
component = "y"
file = "force.csv"
deviation = 1.0
[optimizer]
max_iterations = 1
""")
    done = attempt("optimize", scene, tmp_path / "out", mesh__model=model)
    if accepted:
        assert done.returncode in (0, 1), done.stdout + done.stderr
    else:
        assert done.returncode == 2 and f'"value [{unit}]"' in done.stderr and "cannot be converted to N" in done.stderr, done.stderr


def test_study_has_units_of_the_whole_body(tmp_path: Path) -> None:
    done = captured([str(SIGNORINI), "study", str(scene("axisymmetric", tmp_path)), "--out", str(tmp_path / "study"), "--sizes", "5,2.5",
                     "--steps", "2.5e-4,1.25e-4", "--quantity", "impulse"])  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "N s" in done.stdout and "N s/m" not in done.stdout


def test_info_names_the_model(tmp_path: Path) -> None:
    info = {model: attempt("info", scene(model, tmp_path)).stdout for model in MODELS}
    assert "in the half section of a body of revolution" in info["axisymmetric"] and "kg/m" not in info["axisymmetric"]
    assert "in plane stress" in info["plane-stress"] and "kg/m" in info["plane-stress"]
    quadratic = attempt("info", scene("axisymmetric", tmp_path), mesh__degree=2).stdout
    assert "the axis has no contact candidate" in quadratic
