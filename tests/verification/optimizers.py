# SPDX-License-Identifier: GPL-3.0-or-later
"""The three optimizers on the half disc at h = 1: sweeps that each needs to come as far as 400 iterations of projected-gradient,
and, where a third of the control is at its bounds and J is smooth at the minimiser, the same minimiser from all. The sweeps of
lbfgs alone on finer meshes, the finest of them in the long test.
"""

import functools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, signorini, stored, table

# Iterations that are more than enough, and the part of projected-gradient's sweeps that may be needed. Measured: 1/21 and 1/14 (of
# 1000 iterations 1/27 and 1/24); the search among kinks is as irregular as a few kinks, hence the room.
FASTER = {"lbfgs": (60, 1 / 15), "newton-cg": (9, 1 / 10)}
STEP_OF_FIGURES = 35  # t = 0.00175 s, in the middle of the first contact
METHODS = ("projected-gradient", *FASTER)

# Pressed against the plane harder than the bounds allow, for as long as it takes to touch it and stay: no candidate is in weak
# contact, and with this alpha projected gradient steps converge too.
LOWER, UPPER = -1.2, 0.1
PRESSED = {"objective__desired": {"control": ["0", "-2"]}, "objective__alpha": 0.1, "time__end": 2.5e-3, "control__lower": LOWER,
           "control__upper": UPPER, "optimizer__tolerance": 1e-6, "optimizer__max_iterations": 5000}  # fmt: skip


def optimize(out: Path, method: str, fields: list[str], **overrides: object) -> tuple[dict, dict]:
    """history.csv and run.json."""
    signorini("optimize", HALF_DISC, out, mesh__size=1, optimizer__method=method, optimizer__start="guess", output__fields=fields,
              **overrides)
    return table(out / "history.csv"), json.loads((out / "run.json").read_text())


def sweeps(history: dict) -> np.ndarray:
    return history["forward_sweeps"] + history["adjoint_sweeps"]


@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """history.csv of 400 iterations of projected-gradient."""
    out = tmp_path_factory.mktemp("slow") / "out"
    return optimize(out, "projected-gradient", [], optimizer__max_iterations=400, optimizer__tolerance=0)[0]


@pytest.mark.parametrize("method", FASTER)
def test_faster_than_projected_gradient(slow: dict, method: str, tmp_path: Path) -> None:
    iterations, part = FASTER[method]
    history, _ = optimize(tmp_path / "out", method, [], optimizer__max_iterations=iterations, optimizer__tolerance=0)
    assert (np.diff(history["objective"]) < 0).all(), "J rose"
    reached = history["objective"] <= slow["objective"][-1]
    assert reached.any(), "not as far in all iterations"
    first = reached.argmax()
    print(f"to J = {slow['objective'][-1]:.7f} of {sweeps(slow)[-1]:.0f} sweeps: {first} iterations, {sweeps(history)[first]:.0f} sweeps")
    assert sweeps(slow)[-1] / sweeps(history)[first] >= 1 / part


@pytest.fixture(scope="module")
def bounded(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Path, dict, dict]]:
    """The folder, history.csv and run.json of the search with bounds, by method; each is made once."""

    @functools.cache
    def search(method: str) -> tuple[Path, dict, dict]:
        out = tmp_path_factory.mktemp("bounded") / "out"
        return out, *optimize(out, method, ["control"], **PRESSED)

    return search


@pytest.mark.parametrize("method", METHODS)
def test_minimiser_at_bounds(bounded: Callable, method: str) -> None:
    out, history, run = bounded(method)
    steps = table(out / "steps.csv")
    u = stored(out, "control", "control")[2][:, :, :2]
    at_bounds = ((u == LOWER) | (u == UPPER)).mean()
    residual = history["gradient_norm"][-1] / history["gradient_norm"][0]
    print(f"J {history['objective'][-1]:.10f}, {history['iteration'][-1]:.0f} iterations, {sweeps(history)[-1]:.0f} sweeps, "
          f"|g| by {residual:.1e}, {at_bounds:.2f} of the control at bounds, {(steps['active'] > 0).sum()} steps in contact; "
          + run["stop_reason"])  # fmt: skip
    assert u.min() == LOWER and u.max() <= UPPER
    assert (steps["active"] > 0).sum() >= 10, "hardly any contact: the case says nothing"
    assert steps["weak"].sum() == 0
    assert at_bounds >= 1 / 3
    assert residual <= 1e-6


def test_one_minimiser(bounded: Callable) -> None:
    values = [bounded(method)[1]["objective"][-1] for method in METHODS]
    assert np.ptp(values) / values[0] <= 1e-7


def normal_control(out: Path, step: int) -> tuple[int, float]:
    """How many nodes are in contact after `step` steps, and the largest control normal to the plane there, of the largest
    control. The half disc stands on a plane with the normal (0, 1)."""
    points, _, u = stored(out, "control", "control")
    contact = table(out / "contact.csv")
    pushed = (contact["step"] == step) & (contact["force"] > 0)
    apart = np.linalg.norm(points[:, None] - np.column_stack([contact["x"], contact["y"]])[pushed], axis=2)
    touching = (apart < 1e-9).any(axis=1)
    return int(touching.sum()), abs(u[step - 1][touching, 1]).max(initial=0) / np.linalg.norm(u[step - 1], axis=1).max()


@pytest.mark.parametrize("method", FASTER)
def test_certificate(method: str, tmp_path: Path) -> None:
    """At a kink the gradient norm stalls, and the shortest combination of gradients shows that J is stationary: g = α u + (τ s/2) p
    there, and p has no normal part where all branches of J are in contact, so neither has u (Fig. 5 of the paper)."""
    out = tmp_path / "out"
    history, run = optimize(out, method, ["control"], optimizer__tolerance=1e-6)
    first, last, kink = history["gradient_norm"][0], history["gradient_norm"][-1], run["kink"]
    print(f"{run['stop_reason']} after {run['optimizer']['iterations']} iterations, "
          f"{run['optimizer']['forward_sweeps'] + run['optimizer']['adjoint_sweeps']} sweeps; {kink['gradients']} gradients within "
          f"{kink['radius']:.1e}, contact weak {len(kink['weak_contact'])} times")  # fmt: skip
    assert run["stop_reason"] == "stationary at a kink" and kink["weak_contact"]
    assert last / (1e-6 * first) >= 10, "the gradient norm does not stall"
    assert kink["shortest_combination"] / first <= 1e-6
    nodes, normal = normal_control(out, STEP_OF_FIGURES)
    assert nodes >= 3, "hardly any contact at t = 0.00175: the case says nothing"
    # What is left of g, spread over T and the body, is α times that; on a single node of a step some hundred times the mean.
    assert normal <= 1e-3


@pytest.mark.parametrize("sizes", ((1, 0.5), pytest.param((1, 0.5, 0.25), marks=pytest.mark.long)), ids=str)
def test_mesh_independence(sizes: tuple[float, ...], tmp_path: Path) -> None:
    needed = []
    for size in sizes:
        out = tmp_path / "out"
        signorini("optimize", HALF_DISC, out, mesh__size=size, optimizer__start="guess", output__fields=[], optimizer__max_iterations=38)
        history = table(out / "history.csv")
        small = history["gradient_norm"] <= 1e-3 * history["gradient_norm"][0]
        assert small.any(), f"size {size}: {history['gradient_norm'][-1]}"
        needed.append(sweeps(history)[small.argmax()])
    print("lbfgs:", ", ".join(f"{n:.0f}" for n in needed), "sweeps to a thousandth of the first gradient norm")
    assert needed == pytest.approx([np.mean(needed)] * len(needed), rel=0.3, abs=0)
