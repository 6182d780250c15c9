# SPDX-License-Identifier: GPL-3.0-or-later
"""Tresca friction by each scheme: a block stops as its closed form does, on the floor and above it, in the plane and in space; the law at
each node and step of a bounce; ranks."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, captured, signorini, table

pytest.register_assert_rewrite("regression.friction")
from regression.friction import BODIES, SCHEMES, bounce, by_step, check_account, check_law, each_scheme  # noqa: E402

# A block of 1000 kg and 1 m², or 1 m per metre of depth, that slides at 1 m/s: it stops after 1/3 s and 1/6 m.
MASS, BOUND = 1000, 3000
DECELERATION = BOUND / MASS
SLIDE = """
[mesh]
file = "{mesh}"
size = 0.34
degree = {degree}
[time]
end = {end}
step = {step}
[material]
density = 1000.0
young = 1e12
poisson = 0.3
[contact]
on = "bottom"
friction = {{ bound = {bound} }}
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
[initial]
velocity = {velocity}
[output]
every = 1
fields = []
[[output.probe]]
name = "block"
body = true
"""
ON_THE_FLOOR = "[load]\ngravity = {gravity}\n"
IN_FLIGHT = '[[clamp]]\non = "top"\ncomponents = ["{up}"]\n'  # so that it does not turn
BLOCKS = {
    2: {"mesh": SOURCE / "meshes" / "block.geo", "normal": [0, 1], "gravity": [0, -10], "velocity": ["1", "0"], "up": "y"},
    3: {"mesh": SOURCE / "tests" / "data" / "cube.geo", "normal": [0, 0, 1], "gravity": [0, 0, -10], "velocity": ["0.6", "-0.8", "0"],
        "up": "z"},
}  # fmt: skip
# Bounds by which nodes of the disc and of the ball stick and slip, Pa.
BOUNDS = {2: 3e4, 3: 3e4}


def slide(dim: int, folder: Path, scheme: str, height: float = 0, count: float = 8.25, ranks: int = 1, **values: object) -> Path:
    """Runs a block at a height above the floor by steps, `count` of which take it to its stop."""
    block, step = BLOCKS[dim], DECELERATION**-1 / count
    keys = {"degree": 1, "bound": BOUND, "step": step, "end": step * np.ceil(count + 2), "point": [-height * n for n in block["normal"]]}
    text = (SLIDE + (IN_FLIGHT if height else ON_THE_FLOOR)).format(**block | keys | {"velocity": json.dumps(block["velocity"])} | values)
    folder.mkdir()
    (folder / "slide.toml").write_text(text)
    signorini("simulate", folder / "slide.toml", folder / "out", ranks, **SCHEMES[scheme])
    return folder / "out"


def along(dim: int, columns: dict[str, np.ndarray], name: str) -> np.ndarray:
    """The part of a vector in the columns along the block's first velocity."""
    return sum(float(v) * columns[f"{name}_{axis}"] for v, axis in zip(BLOCKS[dim]["velocity"], "xyz"))


@each_scheme
@pytest.mark.parametrize("height", (0, 0.01), ids=("on the floor", "in flight"))
@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("dim", BLOCKS)
def test_stopping(dim: int, degree: int, height: float, scheme: str, tmp_path: Path) -> None:
    """While it slides the force is the bound times the area, in contact or not. Its path after the last whole step is the error."""
    out = slide(dim, tmp_path / "block", scheme, height, degree=degree)
    steps, probe = table(out / "steps.csv"), table(out / "probes.csv")
    slides = steps["time"] < 1 / DECELERATION
    t = steps["time"][slides]
    assert slides.sum() == 9 and (steps["active"].max() > 0) == (height == 0) == (steps["normal_force"].max() > 0)
    rounding = {2: 1e-6, 3: 1e-6}[dim]  # in space nodes slip in slightly different directions, since the block deforms
    force = along(dim, steps, "contact_force")
    assert force[slides][1:] == pytest.approx(-BOUND, rel=rounding)
    assert along(dim, probe, "block.momentum")[slides] == pytest.approx(MASS * (1 - DECELERATION * t), abs=rounding * MASS)
    path = along(dim, probe, "block.center")
    path -= path[0]
    assert path[slides] == pytest.approx(t - DECELERATION * t**2 / 2, abs=rounding)
    missing = DECELERATION * (t[1] / 4) ** 2 / 2
    assert path[-1] == pytest.approx(1 / (2 * DECELERATION) - missing, abs=1e-2 * missing)
    assert steps["stick"][slides].max() == 0 < steps["stick"][slides.sum()]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_bound_in_place_and_time(scheme: str, tmp_path: Path) -> None:
    """The bound is taken at the nodes at the end of each step."""
    out = slide(2, tmp_path / "block", scheme, 0.01, bound='"1000*(1 + x)*(1 + t)"')
    contact = table(out / "contact.csv")
    slips = (contact["motion"] == "slip") & (contact["step"] > 0)
    expected = 1000 * (1 + contact["x"]) * (1 + contact["time"]) * contact["area"]
    assert slips.sum() > 20
    assert -contact["tangential_force_x"][slips] == pytest.approx(expected[slips], rel=1e-9)


@each_scheme
@pytest.mark.parametrize("dim", BODIES)
def test_tresca(dim: int, scheme: str, tmp_path: Path) -> None:
    out = bounce(dim, scheme, tmp_path / "out", contact__friction={"bound": BOUNDS[dim]})
    contact = {name: column[table(out / "contact.csv")["step"] > 0] for name, column in table(out / "contact.csv").items()}
    closed = contact["status"] == "strong"
    counts = {(motion, bool(touches)): int(((contact["motion"] == motion) & (closed == touches)).sum())
              for motion in ("stick", "slip") for touches in (False, True)}  # fmt: skip
    print(counts)
    assert np.min(list(counts.values())) > 20, "a kind of motion hardly occurs: the case says nothing"
    assert sum(counts.values()) == len(closed), "all candidates stick or slip"
    assert not contact["force"][~closed].any() and (contact["force"][closed] > 0).all()
    bound = BOUNDS[dim] * contact["area"]
    check_law(dim, contact, bound, 1e-9 * bound.max())  # docs/method.md section 4: what slips is at its bound to 1e-9
    check_account(dim, out)


@each_scheme
@pytest.mark.parametrize("dim", BODIES)
def test_ranks(dim: int, scheme: str, tmp_path: Path) -> None:
    bound = {"contact__friction": {"bound": BOUNDS[dim]}}
    one, two = (bounce(dim, scheme, tmp_path / str(ranks), ranks, **bound) for ranks in (1, 2))
    steps = [table(out / "steps.csv") for out in (one, two)]
    contact = [table(out / "contact.csv") for out in (one, two)]
    for name in ("slip", "stick", "active"):
        assert np.array_equal(steps[0][name], steps[1][name]), name
    for name in ("friction_work", "contact_force_x", "kinetic_energy"):
        assert steps[1][name] == pytest.approx(steps[0][name], abs=1e-7 * abs(steps[0][name]).max()), name
    for name in ("tangential_force", "slip_velocity"):
        found = [by_step(columns, name) for columns in contact]
        assert np.sort(found[1], axis=1) == pytest.approx(np.sort(found[0], axis=1), abs=1e-7 * abs(found[0]).max()), name


def test_report(tmp_path: Path) -> None:
    """The page of a run whose friction has a bound."""
    signorini("simulate", SOURCE / "tests" / "data" / "block.toml", tmp_path / "out", contact__friction={"bound": 0.3})
    done = captured([str(SIGNORINI), "report", str(tmp_path / "out")])
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000
