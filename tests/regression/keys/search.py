# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of the objective and the optimizer: the effect of each on a small scene is that of docs/reference/keys.md."""

import numpy as np
import pytest
from harness import table
from regression.keys.runs import ONE_AWAY, ROUNDING, Run, Runner, T, near, optimize_in


@pytest.mark.key("objective.desired.displacement", "objective.tracking", "objective.gamma")
@pytest.mark.parametrize("overrides, tracking, terminal", (
    ({}, T / 2, 1e-2),
    ({"objective__desired": {"displacement": ["0", "2"]}}, 4 * T / 2, 4e-2),
    ({"objective__tracking": 3}, 3 * T / 2, 1e-2),
    ({"objective__tracking": 0}, 0, 1e-2),
    ({"objective__gamma": 0.5}, T / 2, 0.5),
    ({"objective__gamma": 0}, T / 2, 0),
), ids=str)  # fmt: skip
def test_parts_of_the_objective(overrides: dict[str, object], tracking: float, terminal: float, optimize: Runner) -> None:
    found = optimize(**ONE_AWAY | overrides).history
    near(found["tracking"][0], tracking)
    near(found["terminal"][0], terminal)
    near(found["objective"][0], tracking + terminal)


@pytest.mark.key("objective.on")
@pytest.mark.parametrize("group, measure", (("body", 1), ("top", 1), ("rest", 3)))
def test_objective_on(group: str, measure: float, optimize: Runner) -> None:
    found = optimize(objective__on=group, **ONE_AWAY).history
    near(found["tracking"][0], measure * T / 2)
    near(found["terminal"][0], measure * 1e-2)


@pytest.mark.key("objective.on")
@pytest.mark.parametrize("on, tracking", (({"objective__on": "top"}, T / 2), ({}, T / 2 / 3)), ids=("top", "body"))
def test_desired_displacement_on_a_part(on: dict[str, str], tracking: float, optimize: Runner) -> None:
    near(optimize(**on, **ONE_AWAY | {"objective__desired": {"displacement": ["0", "y"]}}).history["tracking"][0], tracking)


@pytest.mark.key("objective.alpha")
@pytest.mark.parametrize("overrides, weight", (({}, 1e-2), ({"objective__alpha": 3}, 3), ({"objective__alpha": 0}, 0)), ids=str)
def test_alpha(overrides: dict[str, float], weight: float, optimize: Runner) -> None:
    near(optimize(control__initial=["3", "4"], **overrides).history["control_cost"][0], weight / 2 * 25 * T)


@pytest.mark.key("scenario.name", "scenario.weight", "scenario.set", "objective.exponent")
@pytest.mark.parametrize("exponent", (1, 3))
def test_scenarios(exponent: float, optimize: Runner) -> None:
    """J is the weighted mean of separate J, and the table has each of them."""
    common = {"objective__desired": {"displacement": ["0", "-0.1*t"]}, "time__scheme": "contact-stabilized"}
    fast, low = {"initial.velocity": ["0", "-1.5"]}, {"contact.obstacle.point": [0, -0.2]}
    J = [optimize(**common, **{key.replace(".", "__"): value for key, value in one.items()}).history["objective"][0] for one in ({}, fast, low)]
    assert np.ptp(J) > 0.1 * np.max(J)
    scenarios = [{"weight": 2.0}, {"name": "fast", "set": fast}, {"name": "low", "weight": 0.5, "set": low}]
    mean = {} if exponent == 1 else {"objective__exponent": float(exponent)}
    done = optimize(**common, **mean, scenario=scenarios)
    found = table(done.folder / "scenarios.csv")
    near(found["objective"], J, 1e-9)
    assert list(found["scenario"]) == ["scenario 1", "fast", "low"] == [one["name"] for one in done.manifest["scenarios"]]
    weights = np.array([2, 1, 0.5]) / 3.5
    near(found["weight"], weights)
    near(done.history["objective"][0], (weights @ np.power(J, exponent)) ** (1 / exponent), 1e-9)
    near(found["share"] @ found["objective"], done.history["objective"][0])


@pytest.mark.key("objective.desired.control", "objective.desired.run")
@pytest.mark.parametrize("by", ("control", "run"))
def test_desired_motion(by: str, simulate: Runner, optimize: Runner) -> None:
    """At the control that makes the desired motion, and nowhere else, J is only the cost of the control."""
    there = {"control__initial": ["0.2", "-0.5"]}
    motion = simulate(**there)
    assert motion.steps["active"].max() > 0
    desired = {"control": ["0.2", "-0.5"]} if by == "control" else {"run": str(motion.folder)}
    at, off = (optimize(objective__desired=desired, **start).history for start in (there, {}))
    assert at["tracking"][0] + at["terminal"][0] < ROUNDING * off["tracking"][0]
    assert off["tracking"][0] > 1e-5 and off["terminal"][0] > 1e-5


@pytest.fixture(scope="module")
def searches(tmp_path_factory: pytest.TempPathFactory) -> dict[str | None, Run]:
    """The first iterations by each method, and by none that is named."""
    folder = tmp_path_factory.mktemp("searches")
    return {method: optimize_in(folder, iterations=3, **({"optimizer__method": method} if method else {}))
            for method in ("lbfgs", "newton-cg", "projected-gradient", None)}  # fmt: skip


@pytest.mark.key("optimizer.method")
@pytest.mark.parametrize("method", ("lbfgs", "newton-cg", "projected-gradient"))
def test_each_method_decreases_the_objective(method: str, searches: dict[str | None, Run]) -> None:
    history = searches[method].history
    assert len(history["iteration"]) == 4 and (np.diff(history["objective"]) < 0).all()


@pytest.mark.key("optimizer.method")
def test_products_are_those_of_newton_cg(searches: dict[str | None, Run]) -> None:
    """Hessian products are taken by the first iterations of newton-cg alone; projected-gradient moves along the gradient."""
    sweeps = {method: done.history["adjoint_sweeps"][1] for method, done in searches.items()}
    assert sweeps["newton-cg"] > sweeps["lbfgs"] == sweeps["projected-gradient"] == 3  # one determines the units


@pytest.mark.key("optimizer.method")
def test_lbfgs_is_the_default(searches: dict[str | None, Run]) -> None:
    near(searches[None].history["objective"], searches["lbfgs"].history["objective"], 0)


@pytest.mark.key("optimizer.start")
def test_optimizer_start(optimize: Runner) -> None:
    """From coarse meshes a search is near the optimum before its first step; the usual start of a .geo with a size."""
    fine = {"mesh__size": 0.06, "time__step": 0.03}
    guess = optimize(**fine).history["objective"][0]

    def first(**start: object) -> tuple[float, int]:
        done = optimize(iterations=3, **fine, **start)
        return done.history["objective"][0] / guess, len(done.manifest["optimizer"]["coarse_levels"])

    usual = first()
    assert usual == first(optimizer__start="coarse") and usual[0] < 0.9 and usual[1] == 1
    assert first(optimizer__start="guess") == (1, 0)


@pytest.mark.key("optimizer.max_iterations")
@pytest.mark.parametrize("most", (0, 1, 3))
def test_max_iterations(most: int, optimize: Runner) -> None:
    done = optimize(iterations=most)
    assert len(done.history["iteration"]) == most + 1 and done.manifest["stop_reason"] == "iteration limit"


@pytest.mark.key("optimizer.tolerance")
def test_tolerance(optimize: Runner) -> None:
    steady = {"iterations": 5, "optimizer__method": "projected-gradient"}  # whose gradients shrink from the start
    norms = optimize(**steady, optimizer__tolerance=0).history["gradient_norm"]
    assert len(norms) == 6 and (np.diff(norms) < 0).all()
    between = float(np.sqrt(norms[2] * norms[3]) / norms[0])
    done = optimize(**steady, optimizer__tolerance=between)
    assert len(done.history["iteration"]) == 4 and done.manifest["stop_reason"] == "gradient norm below tolerance"


@pytest.mark.key("optimizer.checkpoint")
@pytest.mark.parametrize("every, written", ((2, 4), (5, 2), (0, 0)))
def test_checkpoints(every: int, written: int, optimize: Runner) -> None:
    """Written as often as asked for, and at the end; none without."""
    done = optimize(iterations=5, optimizer__tolerance=0, optimizer__checkpoint=every)
    assert done.manifest["timings"].get("checkpoint", {"calls": 0})["calls"] == written
    assert (done.folder / "checkpoint.h5").exists() == (written > 0)


@pytest.mark.key("optimizer.memory")
def test_optimizer_memory(plain: Run, optimize: Runner) -> None:
    """A search with room for 16 controls keeps the last eight pairs of steps and gradients: its iterates are those of twenty
    until there are nine, then others, and its checkpoint is that much smaller."""
    control = 8 * plain.manifest["unknowns"] * len(plain.steps["step"][1:])  # bytes, of the whole body
    usual, little = (optimize(iterations=16, objective__alpha=1e-6, **more) for more in ({}, {"optimizer__memory": 16 * control / 2}))
    assert usual.manifest["optimizer"]["iterations"] == 16  # and it does not end before
    differences = abs(little.history["objective"] / usual.history["objective"] - 1)
    assert differences[:10].max() == 0 and differences[10:].max() > 1e-6
    sizes = [(run.folder / "checkpoint.h5").stat().st_size for run in (usual, little)]
    assert sizes[0] - sizes[1] > 12 * control
