# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes with obstacles that have mass."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

SCENES = SOURCE / "scenes"


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def keeps_energy(out: Path) -> None:
    """The energy law of each step, to 1e-12 of the energy beyond the rounding of its sums."""
    (law,) = (one for name, one in manifest(out)["invariants"].items() if name.startswith("energy law"))
    assert law["worst"] < 1e-12


def test_ram(tmp_path: Path) -> None:
    """The ram goes m v/Z deep, less what is still to come, and nothing comes back from the toe."""
    signorini("simulate", SCENES / "ram.toml", tmp_path)
    probe, steps = table(tmp_path / "probes.csv"), table(tmp_path / "steps.csv")
    exact = 4 * 2e-3 * (1 - np.exp(-probe["time"] / 2e-3))
    assert abs(probe["ram.displacement_y"] + exact).max() < 1e-3 * exact[-1]
    assert steps["foundation_dissipation"].sum() > 0.99 * steps["rigid_energy"][0]
    keeps_energy(tmp_path)


def test_hammer(tmp_path: Path) -> None:
    """The hammer goes m v/Z deep, and the energy leaves by the foot, but for what viscosity takes."""
    signorini("simulate", SCENES / "hammer.toml", tmp_path)
    probe, steps = table(tmp_path / "probes.csv"), table(tmp_path / "steps.csv")
    constant = 0.4 / (np.sqrt(2.1e11 * 7800) * np.pi * 1e-4)
    exact = 2 * constant * (1 - np.exp(-probe["time"] / constant))
    assert abs(probe["hammer.displacement_y"] + exact).max() < 0.01 * exact[-1]
    assert steps["foundation_dissipation"].sum() + steps["viscous_dissipation"].sum() > 0.9 * 0.8
    keeps_energy(tmp_path)


def test_load_cell(tmp_path: Path) -> None:
    """The spring's and the dashpot's force less the plate's inertia is the force on the ball, in each step; momentum is that of the bounce."""
    signorini("simulate", SCENES / "load-cell.toml", tmp_path)
    probe, found = table(tmp_path / "probes.csv"), manifest(tmp_path)
    q, v, force = (probe[f"cell.{name}_z"] for name in ("displacement", "velocity", "force"))
    # The projection of each step moves the plate too: forces agree in the mean over the bounce, not step by step.
    shown = 1e8 * (q[1:] + q[:-1]) / 2 + 600 * np.diff(q) / np.diff(probe["time"])
    inertia = 0.1 * np.diff(v) / np.diff(probe["time"])
    weight = 0.1 * 9.81
    assert np.sum(shown + inertia + weight + force[1:]) == pytest.approx(0, abs=2e-3 * np.sum(force))
    assert found["impact"]["all"]["peak"] == pytest.approx(1464, rel=0.02) and found["impact"]["ended"]
    peaks = {(one["name"], one["quantity"]): one for one in found["probe_peaks"]}
    assert peaks["cell", "force"]["filtered_peak"] < 0.7 * peaks["cell", "force"]["peak"]
    mass = found["impact"]["mass"]
    assert peaks["ball", "acceleration"]["peak"] == pytest.approx(peaks["cell", "force"]["peak"] / mass - 9.81, rel=2e-3)


def test_ball_on_beam(tmp_path: Path) -> None:
    """The beam hits the ball several times; the ball's momentum is what the forces and its weight gave it."""
    signorini("simulate", SCENES / "ball-on-beam.toml", tmp_path)
    probe, found = table(tmp_path / "probes.csv"), manifest(tmp_path)
    assert len(found["impact"]["bounces"]) >= 3
    momentum = 6 * (probe["ball.velocity_z"] - probe["ball.velocity_z"][0])
    given = -probe["ball.impulse_z"] - 6 * 9.81 * probe["time"]
    assert abs(momentum - given).max() < 1e-10 * abs(momentum).max()
    assert probe["ball.velocity_z"][-1] > 0.5, "the ball goes up again"
    assert "linearised gap" not in {one["name"] for one in found["warnings"]}


def test_throw(tmp_path: Path) -> None:
    """The control throws the ball to its height, in several pushes and flights, with less effort than at first."""
    signorini("optimize", SCENES / "throw.toml", tmp_path)
    probe, found = table(tmp_path / "probes.csv"), manifest(tmp_path)
    assert abs(probe["ball.displacement_y"][-1] - 0.5) < 2e-3
    flies = probe["ball.force_y"] == 0
    assert flies.mean() > 0.3 and np.sum(np.diff(flies.astype(int)) == 1) >= 2
    assert found["objective"]["control_cost"] < 1e-3 and found["objective"]["value"] < 2e-3 * 0.25


def test_saint_venants_energy(tmp_path: Path) -> None:
    """In the manual's runs momentum and energy are exact, whatever the fronts do."""
    signorini("simulate", SOURCE / "docs" / "verification" / "saint-venant.toml", tmp_path)
    steps = table(tmp_path / "steps.csv")
    keeps_energy(tmp_path)
    assert steps["contact_work"].max() < 1e-13 * steps["rigid_energy"][0]
