# SPDX-License-Identifier: GPL-3.0-or-later
"""J, its parts, its gradient and the distances of a search's last iterate are recomputed, by its control, its adjoint state and a run."""

import numpy as np
import pytest
from harness import stored
from recomputed import TABLE, near
from regression.values.runs import SEARCH, SceneRun

TAU = 0.02
ALPHA, GAMMA, SCALE, TRACKING = (SEARCH[key] for key in ("objective__alpha", "objective__gamma", "control__scale", "objective__tracking"))
SEARCHED = pytest.mark.parametrize("run", ("search",), indirect=True)


def flat(field: np.ndarray) -> np.ndarray:
    return field.reshape(len(field), -1)


def nodal(run: SceneRun, name: str) -> np.ndarray:
    """The control or the adjoint state, steps × unknowns."""
    return flat(stored(run.path, name, name)[2][..., :2])


def squared(run: SceneRun, field: np.ndarray) -> float:
    """The integral of the square over time and the body."""
    return TAU * np.einsum("ki,ij,kj->", field, run.body.W, field)


@pytest.fixture
def tracking_error(run: SceneRun, run_of: object) -> np.ndarray:
    """The distance to the motion of the wanted control, at each time."""
    off = flat(run.y - run_of("wanted").y)
    return np.sqrt(np.einsum("ki,ij,kj->k", off, run.body.W, off))


@SEARCHED
def test_tracking_error(run: SceneRun, tracking_error: np.ndarray) -> None:
    near("tracking error", run.steps["tracking_error"], tracking_error, TABLE)


@SEARCHED
def test_objective(run: SceneRun, tracking_error: np.ndarray) -> None:
    history = run.table("history")
    parts = {"tracking": TRACKING * TAU / 4 * (tracking_error[1:] ** 2 + tracking_error[:-1] ** 2).sum(),
             "terminal": GAMMA * tracking_error[-1] ** 2, "control_cost": ALPHA / 2 * squared(run, nodal(run, "control"))}  # fmt: skip
    for name, value in (parts | {"value": sum(parts.values())}).items():
        near(f"J: {name}", run.manifest["objective"][name], value, TABLE)
        near(f"the last row's {name}", history["objective" if name == "value" else name][-1], value, TABLE)
        assert value > 1e-6, name
    near("J is the sum of its parts", history["objective"], history["tracking"] + history["terminal"] + history["control_cost"])


@SEARCHED
def test_gradient(run: SceneRun) -> None:
    gradient = ALPHA * nodal(run, "control") + SCALE * TAU / 2 * nodal(run, "adjoint")
    near("norm of the gradient", run.table("history")["gradient_norm"][-1], np.sqrt(squared(run, gradient)), TABLE)


@SEARCHED
def test_distance_to_the_reference(run: SceneRun) -> None:
    u, points = nodal(run, "control"), run.body.points
    wanted = np.stack([np.full(len(points), 0.3), points[:, 0] - 1], axis=1).ravel()
    distance = np.sqrt(squared(run, u - wanted)) / (np.sqrt(TAU * len(u)) * np.sqrt(wanted @ run.body.W @ wanted))
    near("distance to the reference", run.table("history")["relative_distance_to_reference"][-1], distance, TABLE)


@SEARCHED
def test_work_of_the_control(run: SceneRun) -> None:
    work = np.einsum("ki,ki->k", SCALE * nodal(run, "control") @ run.body.W, np.diff(flat(run.y), axis=0))
    near("work of the control", (run.steps["external_work"] - run.steps["load_work"])[1:], work, TABLE)


@SEARCHED
def test_iterations_and_sweeps(run: SceneRun) -> None:
    history, found = run.table("history"), run.manifest["optimizer"]
    near("iterations", history["iteration"], np.arange(4))
    assert found["iterations"] == 3 and history["step_length"][0] == 0 and (history["step_length"][1:] > 0).all()
    for kind in ("forward_sweeps", "adjoint_sweeps"):
        assert found[kind] == history[kind][-1] and (np.diff(history[kind]) > 0).all()
