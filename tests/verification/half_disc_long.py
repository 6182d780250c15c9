# SPDX-License-Identifier: GPL-3.0-or-later
"""1000 iterations of Algorithm 1 on the half disc at h = 0.5, and the behaviour that the paper reports of them."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, signorini, stored, table

pytestmark = pytest.mark.long

STEP_OF_FIGURES = 35  # t = 0.00175 s
TRIALS = 1.5  # forward sweeps an iteration, for the line search; 1.38 found


@dataclass
class At:
    """Contact and fields after STEP_OF_FIGURES steps."""

    x: np.ndarray  # of the active candidates
    force: np.ndarray
    touching: np.ndarray  # nodes with an active candidate
    clamped: np.ndarray
    control: np.ndarray  # nodes × 2
    adjoint: np.ndarray


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("search") / "out"
    signorini("optimize", HALF_DISC, folder, optimizer__method="projected-gradient", optimizer__max_iterations=1000, optimizer__tolerance=0)
    return folder


@pytest.fixture(scope="module")
def at(out: Path) -> At:
    contact = table(out / "contact.csv")
    active = (contact["step"] == STEP_OF_FIGURES) & (contact["force"] > 0)
    assert active.sum() > 3, "no contact at t = 0.00175"
    points, _, control = stored(out, "control", "control")
    _, _, adjoint = stored(out, "adjoint", "adjoint")
    apart = np.linalg.norm(points[:, None] - np.column_stack([contact["x"], contact["y"]])[active][None], axis=2)
    clamped = np.isclose(points[:, 1], points[:, 1].max(), rtol=0, atol=1e-9)
    now = STEP_OF_FIGURES - 1
    return At(contact["x"][active], contact["force"][active], (apart < 1e-9).any(axis=1), clamped, control[now, :, :2], adjoint[now, :, :2])


def test_sweeps(out: Path) -> None:
    history, timings = table(out / "history.csv"), json.loads((out / "run.json").read_text())["timings"]
    for name in ("forward", "adjoint"):
        print(f"{history[f'{name}_sweeps'][-1]:.0f} {name} sweeps, {1e3 * timings[name]['seconds'] / timings[name]['calls']:.0f} ms each")
    assert len(history["iteration"]) == 1001
    assert 1000 < history["forward_sweeps"][-1] < TRIALS * 1000 and 1000 < history["adjoint_sweeps"][-1] <= 1002


def test_objective_falls(out: Path) -> None:
    history = table(out / "history.csv")
    J, distance = history["objective"], history["relative_distance_to_reference"]
    print(f"J: {J[0]:.5f}, {J[100]:.5f} (100), {J[600]:.6f} (600), {J[-1]:.6f}; distance to the reference control: "
          f"{distance[100]:.4f} (100), {distance[200]:.4f} (200), {distance[-1]:.4f}, least at {distance.argmin()}")  # fmt: skip
    assert (np.diff(J) < 0).all()
    assert J[100] < 0.0115 and J[600] < 0.01010


def test_no_control_on_the_clamp(at: At) -> None:
    """Seed, Fig. 5. u is a multiple of p plus the first guess, zero."""
    assert abs(at.control[at.clamped]).max() < 1e-12 * np.linalg.norm(at.control, axis=1).max()


def test_no_normal_adjoint_in_contact(at: At) -> None:
    """Seed, Fig. 5: no control normal to the plane where contact is active. There p·ν = 0, so that an iteration only
    shrinks u·ν by 1 - α/ω: slowly, to zero where J is stationary (optimizers.py)."""
    print(f"control: largest {np.linalg.norm(at.control, axis=1).max():.3f}, "
          f"normal at the {at.touching.sum()} active nodes {abs(at.control[at.touching, 1]).max():.1e}")  # fmt: skip
    assert abs(at.adjoint[at.touching, 1]).max() < 1e-12 * abs(at.adjoint).max()


def test_forces_are_symmetric(at: At) -> None:
    """Seed, Fig. 9."""
    left, right = at.force[at.x < -1e-6].sum(), at.force[at.x > 1e-6].sum()
    assert abs(left - right) < 0.02 * (left + right)


def test_hardly_any_weak_contact(out: Path) -> None:
    assert table(out / "steps.csv")["weak"].max() <= 3
