# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes with friction: against closed forms, and the optimal control of a slider against the controls that do without friction."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

SCENES = SOURCE / "scenes"
GRAVITY, FRICTION, SLOPE = 9.81, 0.3, np.radians(20)
MASS = 1000.0  # of the block, kg/m
NEEDED = GRAVITY * (np.sin(SLOPE) - FRICTION * np.cos(SLOPE))  # acceleration of the block that slides down, m/s²


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def last(out: Path, first: int) -> dict[str, int]:
    """Sums of the candidates that slip and stick, from a step on."""
    steps = table(out / "steps.csv")
    return {motion: int(steps[motion][first:].sum()) for motion in ("slip", "stick")}


def test_incline_below(out: Path) -> None:
    signorini("simulate", SCENES / "incline.toml", out)
    velocity = table(out / "probes.csv")["block.momentum_x"] / MASS
    assert last(out, 50)["slip"] > 4000 and last(out, 50)["stick"] == 0
    assert (velocity[500] - velocity[250]) / 0.25 == pytest.approx(NEEDED, rel=1e-4)


def test_incline_at(out: Path) -> None:
    """The speed of the first slip stays."""
    signorini("simulate", SCENES / "incline.toml", out, contact__friction=np.tan(SLOPE))
    velocity = table(out / "probes.csv")["block.momentum_x"] / MASS
    assert 0.005 < velocity[500] < 0.02 and velocity[500] == pytest.approx(velocity[250], rel=1e-2)


def test_incline_above(out: Path) -> None:
    """The block creeps no further than the viscosity lets it settle."""
    signorini("simulate", SCENES / "incline.toml", out, contact__friction=0.4)
    body = table(out / "probes.csv")
    assert body["block.center_x"][-1] - body["block.center_x"][0] < 1e-3
    assert abs(body["block.momentum_x"][-1]) < 1e-6 * MASS and last(out, 400)["stick"] > 0


def test_incline_hold(out: Path, tmp_path: Path) -> None:
    """The least force that holds the block is in the direction (1, μ) against its motion: F (1 + μ²) = m g (sin 20° − μ cos 20°)."""
    signorini("optimize", SCENES / "incline-hold.toml", out)
    signorini("simulate", SCENES / "incline-hold.toml", tmp_path / "free")
    held, free = (table(folder / "probes.csv")["block.center_x"] for folder in (out, tmp_path / "free"))
    steps, body = table(out / "steps.csv"), table(out / "probes.csv")
    window = slice(100, 150)  # from 0.2 to 0.3 s

    def force(axis: str, gravity: float) -> float:
        change = body[f"block.momentum_{axis}"][window.stop] - body[f"block.momentum_{axis}"][window.start]
        contact = steps[f"contact_force_{axis}"][window.start + 1 : window.stop + 1].mean()
        return change / 0.1 - MASS * gravity - contact

    along, across = force("x", 3.355218), force("y", -9.218385)
    run = manifest(out)
    print(f"{run['stop_reason']}; force {along:.1f}, {across:.1f} N/m; slid {held[-1] - held[0]:.2e} m, free {free[-1] - free[0]:.2e} m")
    assert free[-1] - free[0] == pytest.approx(NEEDED * 0.5**2 / 2, rel=0.05)
    assert held[-1] - held[0] < 0.05 * (free[-1] - free[0])
    assert across / along == pytest.approx(FRICTION, rel=0.02)
    assert along == pytest.approx(-MASS * NEEDED / (1 + FRICTION**2), rel=0.02)


def test_oblique_disc(out: Path, tmp_path: Path) -> None:
    """A disc that slides through gets μ times the normal impulse; a slow one is gripped."""
    signorini("simulate", SCENES / "oblique-disc.toml", out)
    signorini("simulate", SCENES / "oblique-disc.toml", tmp_path / "slow", initial__velocity=["0.3", "-0.3"])
    fast, slow = (manifest(folder)["impact"]["all"]["impulse"] for folder in (out, tmp_path / "slow"))
    assert last(out, 0)["slip"] > 100 and last(out, 0)["stick"] == 0
    assert fast[0] / fast[1] == pytest.approx(-FRICTION, rel=1e-12)
    assert last(tmp_path / "slow", 0)["stick"] > 100
    assert 0.5 * FRICTION < -slow[0] / slow[1] < 0.95 * FRICTION
    body, mass = table(out / "probes.csv"), manifest(out)["impact"]["mass"]
    assert body["disc.momentum_y"][-1] / mass == pytest.approx(0.3, rel=0.02), "friction changes the bounce"
    assert body["disc.momentum_x"][-1] == pytest.approx(1.2 * mass + fast[0], rel=1e-9)


def test_belt(out: Path) -> None:
    """Speed, slip path and the halves of the belt's work."""
    signorini("simulate", SCENES / "belt.toml", out, output__every=1)
    steps, body, speed = table(out / "steps.csv"), table(out / "probes.csv"), 0.5
    sticks = steps["time"][np.flatnonzero(steps["stick"] > 5)]
    starts = sticks[sticks > 0.05][0]
    assert starts == pytest.approx(speed / (FRICTION * GRAVITY), rel=0.05)
    assert body["block.momentum_x"][-1] == pytest.approx(MASS * speed, rel=1e-3)
    path = speed * 0.4 - (body["block.center_x"][-1] - body["block.center_x"][0])
    assert path == pytest.approx(speed**2 / (2 * FRICTION * GRAVITY), rel=0.02)
    assert steps["belt_work"].sum() == pytest.approx(MASS * speed**2, rel=1e-3)
    assert steps["friction_work"].sum() == pytest.approx(-MASS * speed**2 / 2, rel=0.02)


def test_slider(out: Path, tmp_path: Path) -> None:
    """Only the force that makes the slider swing carries it. The best constant one does not, nor does the best one without friction."""
    scene, limits = SCENES / "slider.toml", {"on": "top", "scale": 353.0, "lower": -0.2, "upper": 0.2}
    constant, smooth, replay = (tmp_path / name for name in ("constant", "smooth", "replay"))
    signorini("optimize", scene, out)
    signorini("optimize", scene, constant, control=limits | {"constant_in_time": True})
    signorini("optimize", scene, smooth, contact__friction=0, control__initial=["0", "0"])
    signorini("simulate", scene, replay, control__initial={"run": str(smooth)})

    def end(folder: Path) -> tuple[float, float]:
        """J, and the way in the second half of the time, m."""
        x = table(folder / "probes.csv")["slider.center_x"]
        return manifest(folder)["objective"]["value"], x[-1] - x[200]

    values = {folder.name: end(folder) for folder in (out, constant, smooth, replay)}
    print(f"{manifest(out)['stop_reason']}; " + ", ".join(f"{name}: J {J:.4g}, {1e3 * way:.3f} mm" for name, (J, way) in values.items()))
    assert last(out, 0)["slip"] > 500 and last(out, 0)["stick"] > 500
    assert values["out"][0] < 0.013 and values["out"][1] == pytest.approx(0.5e-3, rel=0.15)
    assert values["constant"][0] > 0.2 and abs(values["constant"][1]) < 0.05e-3
    assert values["smooth"][0] < 0.016 and values["replay"][0] > 0.5
    assert abs(values["replay"][1]) < 0.05e-3
