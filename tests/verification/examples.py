# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes that show what a user of a contact program asks, beside statics, free fall and momentum."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, stored, table

SCENES = SOURCE / "scenes"


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def warnings(out: Path) -> set[str]:
    return {one["name"] for one in manifest(out)["warnings"]}


def test_gripper(out: Path) -> None:
    """Uniform strain between smooth jaws that rest since 0.1 s: the slowest shear wave of the block has died by then."""
    signorini("simulate", SCENES / "gripper.toml", out)
    rows = table(out / "obstacles.csv")
    statics = 1e7 / (1 - 0.3**2) * 2e-3
    for name in ("left jaw", "right jaw"):
        force = rows["normal_force"][rows["obstacle"] == name]
        assert force[0] == 0 < force[-1]
        assert force[-1] / statics == pytest.approx(1, abs=0.01), name


def test_incline(out: Path) -> None:
    signorini("simulate", SCENES / "incline.toml", out, output__every=1, contact__friction=0)
    steps, body = table(out / "steps.csv"), table(out / "probes.csv")
    assert (steps["active"][200:] == 11).all(), "the block does not lie on the plane"
    slid = body["block.center_x"][-1] - body["block.center_x"][0]
    assert slid / (3.355218 * 0.5**2 / 2) == pytest.approx(1, abs=1e-9), "g sin(20°) t²/2"
    force = steps["contact_force_y"][200:].mean()
    assert force / (1000 * 9.218385) == pytest.approx(1, abs=0.01), "m g cos(20°)"


def test_ring(out: Path) -> None:
    signorini("simulate", SCENES / "ring.toml", out)
    impact, body, steps = manifest(out)["impact"], table(out / "probes.csv"), table(out / "steps.csv")
    assert impact["all"]["impulse"][1] > 0 and impact["ended"], "the ring does not bounce"
    pushed = np.flatnonzero(steps["contact_force_y"])
    mass, before, after = impact["mass"], impact["velocity_before"][1], impact["velocity_after"][1]
    weight = mass * 9.81 * 1e-4 * (pushed[-1] - pushed[0] + 1)
    restitution = -after / before
    by_impulse = (impact["all"]["impulse"][1] - weight) / (mass * -before) - 1
    assert by_impulse == pytest.approx(restitution, abs=1e-6)
    assert restitution >= 0.1
    assert warnings(out) <= {"few nodes in contact", "stress of the mesh"}
    assert body["ring.momentum_y"][0] == pytest.approx(-0.2 * mass, rel=1e-12, abs=0)


def test_beam(out: Path) -> None:
    """The ball goes down by 0.6 mm from 0.1 mm above the beam, where the mesh is fine enough for it."""
    signorini("simulate", SCENES / "beam.toml", out, output__every=50, mesh__scale=2)
    rows, probes = table(out / "obstacles.csv"), table(out / "probes.csv")
    assert rows["normal_force"].max() > 0 == rows["normal_force"][0]
    assert warnings(out) <= {"stress of the mesh"}
    assert -probes["middle.displacement_z"].min() / 0.5e-3 >= 0.9, "the beam's middle goes down as the ball does"
    assert stored(out, "state", "von_mises")[2].max() / 1e6 >= 10, "MPa"


def test_hammered_bar(out: Path) -> None:
    """The bar is left where the hammer pushed it, at rest: the wave has gone through the absorbing end."""
    signorini("simulate", SCENES / "hammered-bar.toml", out)
    steps = table(out / "steps.csv")
    assert manifest(out)["impact"]["all"]["impulse"][1] == pytest.approx(-0.9, rel=1e-3)
    assert np.abs(stored(out, "state", "displacement")[2][-1][:, 1] + 0.03).max() < 1e-3 * 0.03
    assert steps["foundation_dissipation"].sum() / steps["contact_work"].sum() == pytest.approx(1, abs=1e-4)
    assert not warnings(out)


def test_bar_on_springs(out: Path) -> None:
    """After two periods the bar is where it was, but for Newmark's error of phase, 0.004."""
    signorini("simulate", SCENES / "bar-on-springs.toml", out)
    displacement = stored(out, "state", "displacement")[2][:, :, 1]
    assert np.abs(displacement[5]).max() < 0.01 * np.abs(displacement[0]).max(), "a quarter of a period"
    assert np.abs(displacement[-1] - displacement[0]).max() < 1e-4 * np.abs(displacement[0]).max()
    assert not warnings(out)


def test_buffer(out: Path, tmp_path: Path) -> None:
    """The relaxation time found throws the disc back less than times half or twice as long do, and much less than the first."""

    def restitution(time: float) -> float:
        signorini("simulate", SCENES / "buffer.toml", tmp_path / "drop", material__0__prony=[{"g": 0.6, "time": time}])
        return manifest(tmp_path / "drop")["impact"]["restitution"]

    signorini("optimize", SCENES / "buffer.toml", out)
    best = float(np.atleast_1d(table(out / "parameters.csv")["value"])[0])
    first, least = restitution(5e-5), restitution(best)
    # The loss tangent of the branch is largest at ω τ = √(1 − g), ω that of half a swing in the time of contact.
    impact = manifest(tmp_path / "drop")["impact"]
    swing = np.pi / impact["all"]["contact_time"]
    print(f"relaxation time {best:.4g} s, restitution {least:.4f} (first {first:.4f}), ω τ/√(1 − g) {best * swing / np.sqrt(0.4):.3f}")
    assert not warnings(tmp_path / "drop") - {"stress of the mesh"}
    assert least < restitution(best / 2) and least < restitution(2 * best)
    assert first > 0.8 and least < 0.6
    assert best * swing / np.sqrt(0.4) == pytest.approx(1, abs=0.1)
    assert impact["all"]["sustained_over"] >= 2 * 5e-5 * (1 - 1e-9), "a mean over one step"


def test_block(out: Path) -> None:
    signorini("optimize", SCENES / "block.toml", out, optimizer__tolerance=1e-6)
    history = table(out / "history.csv")
    assert manifest(out)["stop_reason"] == "gradient norm below tolerance" and warnings(out) <= {"energy lost in contact"}
    assert (table(out / "steps.csv")["active"] > 0).sum() > 10
    assert history["gradient_norm"][-1] / history["gradient_norm"][0] <= 1e-6
