# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction by each scheme: Coulomb's law at each node and step, tables that agree with the account, a frame that moves along, the order of
a stopping distance. docs/verification.py has the closed forms."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table
from studies import study

SCHEMES = {
    "contact-implicit": {},
    "contact-stabilized": {"time__scheme": "contact-stabilized"},
    "massless": {"contact__mass": "massless"},
    "contact-stabilized without tangential mass": {"time__scheme": "contact-stabilized", "contact__mass": "massless-tangential"},
}
each_scheme = pytest.mark.parametrize("scheme", SCHEMES)
BOUNCE = """
[mesh]
file = "{mesh}"
size = {size}
[time]
end = {end}
step = {step}
[material]
density = 1000.0
young = 1e7
poisson = 0.3
rayleigh = {{ beta = 1e-5 }}
[contact]
on = "contact"
friction = 0.5
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
[initial]
velocity = {velocity}
[output]
every = 1
fields = []
[[output.probe]]
name = "body"
body = true
"""
# A disc and a ball whose nodes stick and slip while they bounce: x or z is normal to the plane.
BODIES = {
    2: {"mesh": "thrown-disc.geo", "size": 0.05, "end": 0.03, "step": 1e-4, "point": [0.50125, 0], "normal": [-1, 0],
        "velocity": ["1", "0.7"]},
    3: {"mesh": "ball.geo", "size": 0.004, "end": 2e-3, "step": 1e-5, "point": [0, 0, -0.020125], "normal": [0, 0, 1],
        "velocity": ["0.6", "0.4", "-1"]},
}  # fmt: skip
BLOCK = """
[mesh]
file = "{mesh}"
size = 0.25
[time]
end = {end}
step = {step}
[material]
density = 1000.0
young = {young}
poisson = 0.3
rayleigh = {{ beta = {beta} }}
[contact]
on = "bottom"
friction = 0.3
obstacle = {{ shape = "half-space", point = {point}, normal = [0, 1]{surface} }}
[load]
gravity = [0, -10]
[initial]
velocity = ["{speed}", "0"]
[output]
every = 1
fields = []
[[output.probe]]
name = "block"
body = true
"""


def bounce(dim: int, scheme: str, out: Path, ranks: int = 1, **overrides: object) -> Path:
    body = BODIES[dim]
    text = BOUNCE.format(**body | {"mesh": SOURCE / "meshes" / body["mesh"], "velocity": json.dumps(body["velocity"])})
    scene = out.parent / "bounce.toml"
    scene.write_text(text)
    signorini("simulate", scene, out, ranks, **SCHEMES[scheme] | overrides)
    return out


def block(folder: Path, name: str, scheme: str = "contact-implicit", **values: object) -> Path:
    """Runs a block on a floor, in a folder of this name."""
    default = {"end": 0.5, "step": 2e-3, "young": 1e8, "beta": 5e-3, "point": "[0, 0]", "surface": "", "speed": 0}
    (folder / f"{name}.toml").write_text(BLOCK.format(mesh=SOURCE / "meshes" / "block.geo", **default | values))
    signorini("simulate", folder / f"{name}.toml", folder / name, **SCHEMES[scheme])
    return folder / name


def by_step(contact: dict[str, np.ndarray], name: str) -> np.ndarray:
    """The columns of a vector in contact.csv: steps × nodes × components."""
    columns = [contact[f"{name}_{axis}"] for axis in "xyz" if f"{name}_{axis}" in contact]
    return np.stack(columns, axis=-1).reshape(len(np.unique(contact["step"])), -1, len(columns))


def check_law(dim: int, contact: dict[str, np.ndarray], bound: np.ndarray, rounding: float) -> None:
    """The bound of the friction force of each row of contact.csv holds to `rounding` (N), sharply where the node slips, and no node
    slips otherwise."""
    force, slip = by_step(contact, "tangential_force"), by_step(contact, "slip_velocity")
    shape = force.shape[:2]
    motion, bound = contact["motion"].reshape(shape), bound.reshape(shape)
    size, speed = np.linalg.norm(force, axis=-1), np.linalg.norm(slip, axis=-1)
    stuck, slipping = motion == "stick", motion == "slip"
    assert (size - bound).max() <= rounding
    assert speed[stuck].max() <= 1e-9 * speed[slipping].max()
    assert size[slipping] == pytest.approx(bound[slipping], abs=rounding)
    assert (force * slip).sum(axis=-1)[slipping] == pytest.approx(-(size * speed)[slipping], rel=1e-9)
    normal_direction = np.array(BODIES[dim]["normal"])
    assert abs(force @ normal_direction).max() <= 1e-12 * size.max() and abs(slip @ normal_direction).max() <= 1e-12 * speed.max()


def check_account(dim: int, out: Path) -> None:
    """The tables agree with one another and with the account."""
    contact, steps, run = table(out / "contact.csv"), table(out / "steps.csv"), json.loads((out / "run.json").read_text())
    force, slip = by_step(contact, "tangential_force"), by_step(contact, "slip_velocity")
    motion = contact["motion"].reshape(force.shape[:2])
    step = BODIES[dim]["step"]
    assert all(np.array_equal((motion == name).sum(axis=1), steps[name]) for name in ("stick", "slip"))
    works = step * (force * slip).sum(axis=(1, 2))
    assert works == pytest.approx(steps["friction_work"], abs=1e-12 * -steps["friction_work"].sum())
    assert not steps["belt_work"].any()
    start = run["energy"]["kinetic_at_start"]
    never_gained = [steps["contact_work"], steps["friction_work"], steps["contact_work"] - steps["friction_work"]]
    assert np.max(never_gained) <= 1e-13 * start
    impulse = np.array(run["impact"]["all"]["friction_impulse"])
    assert step * force.sum(axis=(0, 1)) == pytest.approx(impulse, abs=1e-12 * np.linalg.norm(impulse))
    probe = table(out / "probes.csv")
    momentum = np.stack([probe[f"body.momentum_{axis}"] for axis in "xyz"[:dim]])
    change = momentum[:, -1] - momentum[:, 0]
    assert change == pytest.approx(np.array(run["impact"]["all"]["impulse"]), abs=1e-11 * np.linalg.norm(momentum[:, 0]))
    energy = run["energy"]
    gained = energy["kinetic_at_end"] + energy["elastic_at_end"] - start
    assert gained == pytest.approx(energy["contact_work"] - energy["viscous_dissipation"], abs=1e-12 * start)


@each_scheme
@pytest.mark.parametrize("dim", BODIES)
def test_coulomb(dim: int, scheme: str, tmp_path: Path) -> None:
    out = bounce(dim, scheme, tmp_path / "out")
    contact = table(out / "contact.csv")
    counts = {motion: int((contact["motion"] == motion).sum()) for motion in ("open", "stick", "slip")}
    print(counts)
    assert np.min(list(counts.values())) > 20, "a kind of motion hardly occurs: the case says nothing"

    open_ = contact["motion"] == "open"
    assert np.isin(contact["motion"], ("stick", "slip", "open")).all()
    assert not contact["force"][open_].any() and (contact["force"][~open_] > 0).all()
    assert not any(contact[f"tangential_force_{axis}"][open_].any() for axis in "xyz"[:dim])
    check_law(dim, contact, 0.5 * contact["force"], 1e-10 * contact["force"].max())
    check_account(dim, out)


@each_scheme
def test_moving_frame(scheme: str, tmp_path: Path) -> None:
    """A block on a belt moves like one on a resting floor, seen from the belt. A plane that moves along itself is a belt too."""
    belt = block(tmp_path, "belt", scheme, surface=', surface_velocity = ["1", "0"]')
    plane = block(tmp_path, "plane", scheme, point='["t", "0"]')
    rest = block(tmp_path, "rest", scheme, speed=-1)
    runs = [table(out / "steps.csv") for out in (belt, plane, rest)]
    for steps in runs:
        assert steps["slip"].sum() > 100 and steps["stick"].sum() > 100 and steps["stick"][-1] > 0 == steps["slip"][-1]
    t = runs[0]["time"]
    path = [table(out / "probes.csv")["block.center_x"] - 0.5 for out in (belt, plane, rest)]
    assert path[1] == pytest.approx(path[0], abs=1e-12)
    assert path[2] + t == pytest.approx(path[0], abs=1e-11)
    for name in ("friction_work", "normal_force", "contact_force_x", "slip", "stick"):
        for steps in runs[1:]:
            assert steps[name] == pytest.approx(runs[0][name], abs=1e-8 * abs(runs[0][name]).max()), name
    for out, steps in zip((belt, plane), runs):
        push = by_step(table(out / "contact.csv"), "tangential_force")[:, :, 0].sum(axis=1)
        assert steps["belt_work"] == pytest.approx(2e-3 * push, abs=1e-12 * steps["belt_work"].max())
        assert steps["contact_work"] - steps["belt_work"] == pytest.approx(steps["friction_work"], abs=1e-9)
        assert (steps["contact_work"] - steps["belt_work"]).max() <= 1e-12 * steps["belt_work"].max()
    assert not runs[2]["belt_work"].any()


def test_study(tmp_path: Path) -> None:
    """Displacements of a block that slides converge with the steps."""
    values = {"end": 0.2, "young": 1e6, "beta": 1e-3, "point": "[0, 0]", "surface": "", "speed": 1}
    scene = tmp_path / "slides.toml"
    scene.write_text(BLOCK.format(mesh=SOURCE / "meshes" / "block.geo", step=2e-3, **values))
    study(scene, tmp_path / "study", "--sizes", "0.25", "--steps", "8e-3,4e-3,2e-3,1e-3", "--quantity", "displacement")
    rows = table(tmp_path / "study" / "study.csv")
    assert len(rows["step"]) == 4 and (rows["scheme"] == "contact-implicit").all()
    errors = rows["displacement_error"]
    print(errors)
    assert errors[0] > 2 * errors[1] > 0
    slipping = table(block(tmp_path, "run", **values | {"step": 1e-3}) / "steps.csv")
    assert slipping["slip"].sum() > 100


@each_scheme
def test_order_of_the_stopping_distance(scheme: str, tmp_path: Path) -> None:
    """A stiff block slides 1/6 m by steps of which it needs 4.25 and 21.25: the error is of the second order, its path after the last
    whole step."""
    errors = []
    for count in (4.25, 21.25):
        step = 1 / (3 * count)
        out = block(tmp_path, f"steps-{count}", scheme, step=step, end=step * np.ceil(count + 2), young=1e12, beta=0, speed=1)
        steps, probe = table(out / "steps.csv"), table(out / "probes.csv")
        assert (steps["slip"] == 5).sum() == int(count) and steps["stick"][int(count) + 1] > 0
        errors.append(1 / 6 - probe["block.center_x"][-1] + 0.5)
        assert errors[-1] == pytest.approx(3 * (step / 4) ** 2 / 2, rel=1e-2), "the path of the last quarter of a step"
    order = np.log(errors[0] / errors[1]) / np.log(5)
    print(f"errors {errors[0]:.3e}, {errors[1]:.3e} m: order {order:.4f}")
    assert order == pytest.approx(2, abs=0.02)
