# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with contact between parts of the body, and such contact beside that with an obstacle."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, stored, table

SCENES = SOURCE / "scenes"
SQUARES = SOURCE / "tests" / "data" / "two-squares.toml"


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def keeps_its_laws(out: Path) -> None:
    """Energy and momentum law of each step, to 1e-12 of the largest energy and forces, and contact that takes no energy to give."""
    worst = {name.split(",")[0]: one["worst"] for name, one in manifest(out)["invariants"].items()}
    assert worst["energy law"] < 1e-12 and worst["momentum law"] < 1e-12
    steps = table(out / "steps.csv")
    assert steps["contact_work"].max() < 1e-12 * steps["kinetic_energy"].max() and steps["active"].max() > 0


def bodies(out: Path) -> dict[str, np.ndarray]:
    """The columns of bodies.csv, steps × bodies."""
    found = table(out / "bodies.csv")
    names = list(dict.fromkeys(found["body"]))
    return {name: column.reshape(-1, len(names)) for name, column in found.items()}


def velocity_at_end(out: Path) -> dict[str, np.ndarray]:
    return {one["name"]: np.array(one["velocity_at_end"]) for one in manifest(out)["impact"]["bodies"]}


def test_cradle(tmp_path: Path) -> None:
    """The first disc stops and the last one leaves with its speed, less the energy of the vibrations; momentum stays."""
    signorini("simulate", SCENES / "cradle.toml", tmp_path)
    left = velocity_at_end(tmp_path)
    assert abs(left["disc 1"][0]) < 0.02 and abs(left["disc 2"][0]) < 0.02 and 0.97 < left["disc 3"][0] < 1
    momentum = bodies(tmp_path)["momentum_x"]
    assert abs(momentum.sum(axis=1) - momentum[0].sum()).max() < 1e-11 * momentum[0].sum()
    times = [one["start"] for one in manifest(tmp_path)["impact"]["obstacles"]]
    assert times[0] == pytest.approx(0.02, abs=2e-3) and times[1] > times[0] + 0.03, "one impact after the other"
    keeps_its_laws(tmp_path)


def test_restitution_depends_on_no_frame_and_order(tmp_path: Path) -> None:
    """Guides across the impact, as symmetry planes and the axis are, hold no body against the other one."""
    guides = [{"on": end, "components": ["y"]} for end in ("left end", "right end")]
    found = []
    for on, against, shift in (("left end", "right end", 0), ("right end", "left end", 0), ("left end", "right end", 3)):
        signorini("simulate", SCENES / "two-bars.toml", tmp_path, contact__on=on, contact__against=against, clamp=guides,
                  initial__velocity=[f"x < 0.005 ? {5 + shift} : {-5 + shift}", "0"])  # fmt: skip
        found.append(manifest(tmp_path)["impact"]["restitution"])
    assert 0.95 < found[0] < 1 and found[1:] == pytest.approx([found[0]] * 2, rel=1e-3)


def test_two_discs(tmp_path: Path) -> None:
    """They exchange their velocities along the normal; friction moves the right one along it, with opposite impulses."""
    signorini("simulate", SCENES / "two-discs.toml", tmp_path)
    left, impact = velocity_at_end(tmp_path), manifest(tmp_path)["impact"]
    assert left["right"][0] == pytest.approx(1, abs=0.02) and abs(left["left"][0]) < 0.02
    assert 0.95 < impact["restitution"] < 1
    mass = {one["name"]: one["mass"] for one in impact["bodies"]}
    assert mass["right"] * left["right"][1] == pytest.approx(-impact["all"]["impulse"][1], rel=1e-9) and left["right"][1] > 0.02
    keeps_its_laws(tmp_path)


def test_as_on_a_wall(tmp_path: Path) -> None:
    """Two equal discs at ±v push each other as one disc at v pushes a wall in the plane of symmetry, up to the meshes, which do not match."""
    apart = []
    for scale in (1.0, 0.5):
        common = {"mesh__scale": scale, "time__step": 5e-4 * scale, "time__end": 0.2}
        two, wall = (tmp_path / f"{name}-{scale}" for name in ("two", "wall"))
        signorini("simulate", SCENES / "two-discs.toml", two, initial__velocity=["x < 0.51 ? 1 : -1", "0"], contact__friction=0.0, **common)
        signorini("simulate", SCENES / "two-discs.toml", wall, initial__velocity=["x < 0.51 ? 1 : 0", "0"], **common,
                  contact={"on": "right side", "obstacle": {"shape": "half-space", "point": [0.51, 0], "normal": [-1, 0]}})  # fmt: skip
        pushed, held = (abs(table(out / "obstacles.csv")["force_x"]) for out in (two, wall))
        assert held.max() > 20
        assert pushed.sum() == pytest.approx(held.sum(), rel=2e-3)
        apart.append(np.sqrt(((pushed - held) ** 2).sum() / (held**2).sum()))
    assert apart[0] < 0.04 and apart[1] < 0.6 * apart[0]


def test_ball_on_plate(tmp_path: Path) -> None:
    """What the ball loses, contact takes, beside the reactions of the clamps; friction turns and brakes it, with at most μ times the normal force."""
    signorini("simulate", SCENES / "ball-on-plate.toml", tmp_path)
    momentum = bodies(tmp_path)
    ball = np.stack([momentum[f"momentum_{c}"][:, 0] for c in "xyz"], axis=1)
    impact = manifest(tmp_path)["impact"]
    assert ball[-1] - ball[0] == pytest.approx(impact["all"]["impulse"], rel=1e-9, abs=1e-11 * abs(ball).max())
    force = table(tmp_path / "obstacles.csv")
    along, normal = np.hypot(force["force_x"], force["force_y"]), force["force_z"]
    assert normal.max() > 100 and (along <= 0.3 * 1.05 * force["normal_force"] + 1e-9 * normal.max()).all() and along.max() > 0.05 * normal.max()
    assert 0.9 < impact["restitution"] < 1
    keeps_its_laws(tmp_path)


def test_billiard(tmp_path: Path) -> None:
    """The shot brings the last disc to its place through two impacts, and no direction lowers J."""
    done = signorini("optimize", SCENES / "billiard.toml", tmp_path)
    displacement = bodies(tmp_path)["displacement_x"][-1]
    assert displacement[2] == pytest.approx(0.3, abs=2e-3)
    assert table(tmp_path / "history.csv")["objective"][-1] < 7e-5  # without a control 0.705
    assert "stationary at a kink" in done.stdout or "gradient norm below tolerance" in done.stdout
    contact = manifest(tmp_path)["impact"]["obstacles"]
    assert contact[0]["normal_impulse"] > 0.1 and contact[1]["normal_impulse"] > 0.1


@pytest.mark.parametrize("scheme, stiffness_alone", (("contact-implicit", 1e-4), ("contact-stabilized", None), ("massless", 1e-5)))
def test_stiff_body_as_obstacle(scheme: str, stiffness_alone: float | None, tmp_path: Path) -> None:
    """A body 1e6 times as stiff and as heavy is an obstacle. With its stiffness alone the projection of contact-stabilized steps moves its surface too."""
    upright = SQUARES.read_text()
    scene = tmp_path / "scene.toml"
    scene.write_text(upright[: upright.index("[control]")].replace("two-squares.geo", str(SQUARES.parent / "two-squares.geo"))
                     .replace("[material]", '[[material]]\non = "upper"'))  # fmt: skip
    common = {"time__scheme": scheme} if scheme != "massless" else {}
    mass = {"mass": "massless"} if scheme == "massless" else {}
    still = ["y > 1.02 ? 0.3 - 0.1*(y - 1.55) : 0", "y > 1.02 ? -0.3 + 0.1*(x - 0.5) : 0"]
    soft = {"on": "upper", "density": 1.0, "young": 50.0, "poisson": 0.3, "viscosity": {"bulk": 0.1, "shear": 0.1}}

    def motion(name: str, density: float, contact: dict) -> np.ndarray:
        signorini("simulate", scene, tmp_path / name, clamp=[{"on": "floor"}], initial__velocity=still, output__every=1, **common,
                  material=[soft, {"on": "lower", "density": density, "young": 50e6, "poisson": 0.3}],
                  contact={"on": "above", "friction": 0.3} | mass | contact)  # fmt: skip
        assert table(tmp_path / name / "steps.csv")["active"].max() > 2
        nodes, _, y = stored(tmp_path / name, "state", "displacement")
        return y[:, nodes[:, 1] > 1.02]

    rigid = motion("obstacle", 1.0, {"obstacle": {"shape": "half-space", "point": [0, 1], "normal": [0, 1]}})
    size = abs(rigid).max()
    assert abs(motion("heavy", 1e6, {"against": "below"}) - rigid).max() < 1e-5 * size
    if stiffness_alone:
        assert abs(motion("stiff", 1.0, {"against": "below"}) - rigid).max() < stiffness_alone * size
