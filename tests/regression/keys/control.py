# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of loads, the initial state and the control: the effect of each on a small scene is that of docs/reference/keys.md."""

import numpy as np
import pytest
from regression.keys.runs import FREE, ONE_AWAY, Run, Runner, T, near


@pytest.mark.key("load.body")
def test_body_load(simulate: Runner) -> None:
    near(simulate(**FREE | {"load__body": ["0.3", "2*t"]}).momentum(), [0.3 * T, T**2])


@pytest.mark.key("load.gravity")
def test_gravity(simulate: Runner) -> None:
    near(simulate(**FREE | {"load__gravity": [0.3, "2*t"], "material__density": 1.0}).momentum(), [0.3 * T, T**2])


@pytest.mark.key("load.gravity")
def test_weight_of_a_heavy_body(simulate: Runner) -> None:
    """Gravity acts by the density; the weight of the whole is its momentum's rate."""
    heavy = simulate(**FREE | {"load__gravity": [0, -2], "material__density": 3.0})
    near(heavy.field("velocity")[-1], np.tile([0, -2 * T], (len(heavy.points), 1)))
    near(heavy.steps["external_work"].sum(), 3 * (2 * T) ** 2 / 2)


@pytest.mark.key("load.traction.on", "load.traction.value")
@pytest.mark.parametrize("group, length", (("top", 1), ("rest", 3), ("boundary", 4)))
def test_traction(group: str, length: float, simulate: Runner) -> None:
    done = simulate(load__traction=[{"on": group, "value": ["0.3", "2*t"]}], **FREE)
    near(done.momentum(), [0.3 * T * length, T**2 * length])


@pytest.mark.key("initial.displacement")
def test_initial_displacement(plain: Run, simulate: Runner) -> None:
    after = simulate(initial__displacement=["0.1", "0.25"])
    near(after.start["gap"], plain.start["gap"] + (0.3 * 0.1 + 0.25) / np.hypot(0.3, 1))


@pytest.mark.key("initial.velocity")
def test_initial_velocity(simulate: Runner) -> None:
    done = simulate(**FREE | {"initial__velocity": ["3", "x"]})
    near(done.steps["kinetic_energy"][0], (9 + 1 / 3) / 2)
    near(done.momentum(), [3, 0.5])


@pytest.mark.key("control.step")
@pytest.mark.parametrize("step, every", ((0.02, 1), (0.06, 3)))
def test_control_step(step: float, every: int, optimize: Runner) -> None:
    u = optimize(iterations=1, control__step=step, output__every=1).field("control", "control")
    changes = 1 + np.flatnonzero(abs(np.diff(u, axis=0)).max(axis=(1, 2)) > 0)
    assert len(changes) > 3 and (changes % every == 0).all()


@pytest.mark.key("control.scale")
def test_control_scale(optimize: Runner) -> None:
    one = optimize(control__initial=["0.2", "0.4"], **ONE_AWAY)
    two = optimize(control__initial=["0.1", "0.2"], control__scale=2, **ONE_AWAY)
    assert one.history["tracking"][0] != optimize(**ONE_AWAY).history["tracking"][0]
    for name in ("tracking", "terminal"):
        near(two.history[name], one.history[name])
    near(two.history["control_cost"], one.history["control_cost"] / 4)


PUSH = FREE | {"control__initial": ["0", "2"]}


@pytest.mark.key("control.on")
@pytest.mark.parametrize("group, measure", ((None, 1), ("body", 1), ("top", 1), ("rest", 3)))
def test_control_on(group: str | None, measure: float, simulate: Runner) -> None:
    done = simulate(**({"control__on": group} if group else {}), **PUSH)
    near(done.momentum(), [0, 2 * T * measure])
    if group == "top":
        first = abs(done.field("displacement")[1][:, 1])
        assert first.max() > 2 * first.min(), "a push of the whole body moves all alike"


@pytest.mark.key("control.components")
@pytest.mark.parametrize("components, acting", ((None, (0, 1)), (["y"], (1,)), (["x"], (0,))), ids=str)
def test_control_components(components: list[str] | None, acting: tuple[int, ...], optimize: Runner) -> None:
    given = {"control__components": components} if components else {}
    u = optimize(iterations=1, **given, **FREE | {"objective__desired": {"displacement": ["1", "1"]}}).field("control", "control")
    assert tuple(c for c in (0, 1) if abs(u[..., c]).max() > 0) == acting


@pytest.mark.key("control.constant_in_time")
@pytest.mark.parametrize("constant", (False, True))
def test_constant_in_time(constant: bool, optimize: Runner) -> None:
    u = optimize(iterations=1, control__constant_in_time=constant).field("control", "control")
    assert abs(u).max() > 0 and (np.ptp(u, axis=0).max() == 0) == constant


@pytest.mark.key("control.space")
def test_control_space(optimize: Runner) -> None:
    nodal = optimize(iterations=1, control__space="nodal")
    cellwise = optimize(iterations=1, control__space="cellwise")
    assert nodal.field("control", "control").shape == (30, nodal.manifest["unknowns"] / 2, 2)
    assert cellwise.field("control", "control").shape == (30, cellwise.manifest["cells"], 2)
    # Nodes are the displacement's own, with midpoints of edges where it is quadratic.
    quadratic = optimize(iterations=1, control__space="nodal", mesh__degree=2).manifest
    assert quadratic["unknowns"] > 3 * nodal.manifest["unknowns"]


@pytest.mark.key("control.space")
def test_push_by_a_cellwise_control(simulate: Runner) -> None:
    near(simulate(control__space="cellwise", control__initial=["0", "2"], **FREE).momentum(), [0, 2 * T])


@pytest.mark.key("control.initial")
def test_control_initial(simulate: Runner, optimize: Runner) -> None:
    near(simulate(control__initial=["0.3", "2*t"], **FREE).momentum(), [0.3 * T, T**2])
    first = optimize(control__initial=["0.3", "2"])
    near(first.field("control", "control"), np.tile([0.3, 2], (30, first.manifest["unknowns"] // 2, 1)))
    assert optimize().history["control_cost"][0] == 0


@pytest.mark.key("control.initial.run")
def test_control_initial_run(plain: Run, simulate: Runner, optimize: Runner) -> None:
    first = optimize(iterations=2)
    again = simulate(control__initial={"run": str(first.folder)})
    near(again.manifest["objective"]["value"], first.manifest["objective"]["value"])
    assert again.manifest["objective"]["control_cost"] > 0 == plain.manifest["objective"]["control_cost"]


@pytest.mark.key("control.lower", "control.upper")
@pytest.mark.parametrize("side", (1, -1), ids=("upper", "lower"))
def test_bound_of_the_control(side: int, optimize: Runner) -> None:
    def reached(**bounds: object) -> np.ndarray:
        """The largest of each component, the lowest where the side is the lower one."""
        u = optimize(iterations=1, objective__desired={"displacement": 2 * [str(side)]}, **bounds, **FREE).field("control", "control")
        return (side * u).max(axis=(0, 1))

    bound = "control__upper" if side > 0 else "control__lower"
    assert reached().max() > 0.05, "the bounds below restrict nothing"
    near(reached(**{bound: side * 0.02}), [0.02, 0.02], 0)
    near(reached(**{bound: [side * 0.01, side * 0.02]}), [0.01, 0.02], 0)


@pytest.mark.key("control.lower", "control.upper")
@pytest.mark.parametrize("given, applied", (({}, 0.5), ({"control__initial": ["9", "9"]}, 0.75)), ids=("lower", "upper"))
def test_simulate_keeps_to_the_bounds(given: dict[str, object], applied: float, simulate: Runner) -> None:
    near(simulate(control__lower=0.5, control__upper=0.75, **given, **FREE).momentum(), [applied * T, applied * T])
