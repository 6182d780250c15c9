# SPDX-License-Identifier: GPL-3.0-or-later
"""Derivatives, metric, bounds, caching: identities that hold on any number of ranks."""

from collections.abc import Callable

import numpy as np
import pytest
from common import PUSHED, direction, half_disc

import signorini

ROUNDING = 1e-11  # of sums over a control, of conjugate gradients to rounding
CHATTER = 1e-6  # contact-implicit steps amplify the rounding by which steps together and alone differ
BOUNDS = {"control__lower": [-2, -1.5], "control__upper": 1.25}
CASES = {
    "free": {},
    "bounded": BOUNDS,
    "cells": {"control__space": "cellwise"},
    "a surface, intervals": {"control__on": "contact", "control__step": 2.5e-4, "control__components": ["y"],
                             "control__initial": ["0", "-30"]},
    "a half section": {"mesh__file": "../meshes/half-ball-section.geo", "mesh__model": "axisymmetric"},
    "rubbed": {"contact__friction": 0.3},
    "an obstacle with mass": {"contact__obstacle__mass": 100.0, "contact__obstacle__inertia": 2e4, "contact__friction": 0.3},
    "a plate": {"mesh__model": "plane-stress", "material__viscosity": {"bulk": 13e4 / 6, "shear": 1e4}},
}  # fmt: skip
one_rank = pytest.mark.skipif(signorini.ranks > 1, reason="the other cases are those to which ranks matter")


@pytest.fixture(scope="module", params=[pytest.param(name, marks=[one_rank] * (name in ("bounded", "cells", "a plate"))) for name in CASES])
def name(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def problem(name: str) -> signorini.Problem:
    return half_disc(**{"control__initial": PUSHED, "objective__desired": {"displacement": ["0", "0"]}, **CASES[name]}).problem()


@pytest.fixture(scope="module")
def u(problem: signorini.Problem) -> np.ndarray:
    return problem.first_guess()


def test_shapes(problem: signorini.Problem, u: np.ndarray) -> None:
    assert u.shape == problem.shape == (len(problem.times), problem.size // len(problem.times))
    assert u.shape[1] == len(problem.points) * len(problem.components)
    assert abs(problem.lengths.sum() - problem.step_times[-1]) < 1e-12


def test_batch(problem: signorini.Problem, u: np.ndarray) -> None:
    """Motions that are made together have the J and the derivatives that they have alone, whatever their companions are."""
    many = np.stack([u + 0.02 * i * direction(problem, phase=0.3 * i) for i in range(18)])  # more than are made together
    found = problem.batch(many, gradients=True)
    assert found.values.shape == (18,) and found.gradients.shape == many.shape
    assert np.ptp(found.values) > 1e-3 * found.values[0]
    sweeps = problem.sweeps
    few = problem.batch(many[[17, 4]], gradients=True)
    if signorini.ranks == 1:  # solves on several ranks round differently each time
        assert (few.values == found.values[[17, 4]]).all() and (few.gradients == found.gradients[[17, 4]]).all()
    assert problem.batch(many[:1]).gradients is None and problem.batch(many[:0]).values.shape == (0,)
    assert problem.batch(list(many[:2])).values == pytest.approx(problem.batch(many[:2]).values, rel=1e-12)
    with pytest.raises(ValueError, match=r"expected \(controls, "):
        problem.batch(u)
    if signorini.ranks == 1:
        assert problem.sweeps == sweeps, "motions that are made together are none of the problem's own sweeps"
    for i in (0, 4, 17):
        value, derivative = problem.value_and_gradient(many[i])
        assert abs(found.values[i] / value - 1) < CHATTER
        assert abs(found.gradients[i] - derivative).max() < CHATTER * abs(derivative).max()


def test_taylor(problem: signorini.Problem, u: np.ndarray) -> None:
    """J(u + h d) − J(u) − h dJ·d is of second order where contact is active and its sets stay."""
    d = direction(problem)
    value, derivative = problem.value_and_gradient(u)
    slope = problem.pairing(derivative, d)
    active = problem.active(u)
    assert np.count_nonzero(active) > 20 and active[0] == 0, "hardly any contact: the case says nothing"
    assert len(active) == len(problem.step_times)
    sizes = [4e-4, 2e-4, 1e-4]
    left = []
    for h in sizes:
        left.append(abs(problem.value(u + h * d) - value - h * slope))
        assert np.array_equal(problem.active(u + h * d), active), "the active sets change: no order to be seen"
    assert np.log2(np.divide(left[:-1], left[1:])) == pytest.approx(2, abs=0.05)
    assert left[-1] < 1e-3 * abs(sizes[-1] * slope)


def test_hessian(problem: signorini.Problem, u: np.ndarray) -> None:
    """Symmetric, and the difference of derivatives."""
    d, e = direction(problem), direction(problem, 1.0)
    one = problem.pairing(problem.hessian_product(u, d), e)
    assert problem.pairing(problem.hessian_product(u, e), d) == pytest.approx(one, rel=1e-10, abs=0)
    h = 1e-4
    difference = (problem.gradient(u + h * d) - problem.gradient(u - h * d)) / (2 * h)
    assert problem.pairing(difference, e) == pytest.approx(one, rel=1e-6, abs=0)


def test_metric(problem: signorini.Problem, u: np.ndarray) -> None:
    """Product, operator, inverse, diagonal and weights agree."""
    d, e, product = direction(problem), direction(problem, 2.0), problem.metric.product
    dual = problem.metric.apply(d)
    assert problem.pairing(dual, e) / product(d, e) == pytest.approx(1, abs=ROUNDING)
    assert product(d, e) / product(e, d) == pytest.approx(1, abs=ROUNDING) and product(d, d) > 0
    back = problem.metric.apply_inverse(dual) - d
    assert product(back, back) < ROUNDING**2 * product(d, d)
    derivative, g = problem.gradient(u), problem.representative(u)
    off = problem.riesz(derivative) - g
    assert product(off, off) < ROUNDING**2 * product(g, g)
    assert product(g, d) / problem.pairing(derivative, d) == pytest.approx(1, abs=ROUNDING)
    diagonal, weights = problem.metric.diagonal, problem.metric.weights
    # Both measure constants alike.
    one = np.ones(problem.shape)
    assert problem.pairing(weights, one) / product(one, one) == pytest.approx(1, abs=ROUNDING)
    if diagonal is not None:
        assert np.allclose(diagonal * d, dual, rtol=1e-12, atol=0)
    ratio = product(d, d) / problem.pairing(weights * d, d)
    assert 0.2 < ratio < 2, f"product over lumped product, the metric is {'diagonal' if diagonal is not None else 'consistent'}"


def test_nothing_is_computed_twice(problem: signorini.Problem, u: np.ndarray) -> None:
    """Nor does a change of a returned array change what the problem keeps."""
    for factor in (1.5, 1.75):
        problem.value(factor * u)
    before = problem.sweeps
    value = problem.value(u)
    assert problem.sweeps == (before.forward + 1, before.adjoint)
    again, derivative = problem.value_and_gradient(u)
    assert again == value and problem.sweeps == (before.forward + 1, before.adjoint + 1)
    kept = derivative.copy()
    derivative[:] = 7
    _, other = problem.value_and_gradient(u)
    g = problem.representative(u)
    g *= 0
    assert np.array_equal(other, kept) and np.array_equal(problem.gradient(u), kept) and problem.representative(u).any()
    moved = u.copy()
    problem.value(moved)
    moved *= 1.25
    assert problem.value(moved) != value, "an array that was changed counts as changed"
    problem.value(u)
    problem.value(moved)
    tracking, terminal, cost = problem.parts(u)
    assert cost > 0 and tracking + terminal + cost == value
    assert problem.sweeps == (before.forward + 2, before.adjoint + 1)
    states = problem.states(u)
    assert states.shape == (len(problem.step_times), *problem.nodes.shape)
    assert np.array_equal(problem.displacement(u, len(states) - 1), states[-1]) and states[-1].any()


def test_gather_and_scatter(problem: signorini.Problem, u: np.ndarray) -> None:
    """They undo each other, in an order of places."""
    assert np.array_equal(problem.scatter(problem.gather(u)), u)
    x = problem.gather(np.tile(np.repeat(problem.points[:, 0], len(problem.components)), (problem.shape[0], 1)))
    assert np.all(np.diff(x[0]) > -1e-6 * np.ptp(x)), "places stand in the order of their coordinates"


def test_replicated(problem: signorini.Problem, u: np.ndarray) -> None:
    flat = problem.replicated()
    vector, d = flat.vector(u), flat.vector(direction(problem))
    assert vector.shape == (flat.size,) and np.allclose(flat.control(vector), u, rtol=1e-14, atol=0)
    value, gradient = flat.value_and_gradient(vector)
    slope = problem.pairing(problem.gradient(flat.control(vector)), direction(problem))
    assert gradient @ d / slope == pytest.approx(1, abs=ROUNDING) and value == problem.value(flat.control(vector))
    second = flat.hessian_product(vector, d) @ d
    product = problem.pairing(problem.hessian_product(flat.control(vector), direction(problem)), direction(problem))
    assert second / product == pytest.approx(1, abs=1e-9)
    print(f"J = {value:.15g}, slope {slope:.15g}, |x| = {np.linalg.norm(vector):.15g} of {flat.size} entries")


def test_bounds(name: str, problem: signorini.Problem) -> None:
    """They are the scene's, component by component and in both shapes."""
    flat = problem.replicated()
    if name != "bounded":
        assert (problem.lower, problem.upper, flat.bounds) == (None, None, None)
        return
    columns = np.arange(problem.shape[1]) % 2  # x and y in turn
    lower = np.broadcast_to(np.where(columns == 0, -2.0, -1.5), problem.shape)
    assert np.array_equal(problem.lower, lower) and np.array_equal(problem.upper, np.full(problem.shape, 1.25))
    low, high = np.transpose(flat.bounds)
    scale = np.sqrt(problem.metric.weights)
    for side, whole in ((lower, low), (problem.upper, high)):
        assert np.allclose(whole, problem.gather(side * scale).ravel(), rtol=1e-13, atol=0)


@one_rank
def test_first_guess_is_within_bounds() -> None:
    given = {"control__initial": ["3", "-9"]}
    beyond = half_disc(4, **given, **BOUNDS).problem()
    expected = np.broadcast_to(np.where(np.arange(beyond.shape[1]) % 2 == 0, 1.25, -1.5), beyond.shape)
    assert np.array_equal(beyond.first_guess(), expected)
    assert np.array_equal(np.unique(half_disc(4, **given).problem().first_guess()), [-9, 3])


@one_rank
@pytest.mark.parametrize("own, other, beyond", (("lower", "upper", np.inf), ("upper", "lower", -np.inf)))
def test_one_bound(own: str, other: str, beyond: float) -> None:
    problem = half_disc(4, **{f"control__{own}": 0.25}).problem()
    assert np.array_equal(getattr(problem, own), np.full(problem.shape, 0.25)) and getattr(problem, other) is None
    sides = np.transpose(problem.replicated().bounds)
    mine, theirs = sides if own == "lower" else sides[::-1]
    assert np.all(theirs == beyond) and np.allclose(problem.replicated().control(mine), 0.25, rtol=1e-13, atol=0)


CALLS = {
    "value": lambda problem, u, bad: problem.value(bad),
    "gradient": lambda problem, u, bad: problem.gradient(bad),
    "product of it": lambda problem, u, bad: problem.hessian_product(u, bad),
    "product at it": lambda problem, u, bad: problem.hessian_product(bad, u),
}


@pytest.mark.parametrize("wrong", (np.nan, np.inf, "shape"))
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_refused(problem: signorini.Problem, u: np.ndarray, call: Callable, wrong: float | str) -> None:
    """What is no control of this problem on one rank is refused on all, and leaves what is known."""
    before, last = problem.gradient(u), signorini.rank == signorini.ranks - 1
    bad = u.copy()
    if last and wrong == "shape":
        bad = bad[:, :-1]
    elif last:
        bad.flat[-1] = wrong
    own = "found an array of shape" if wrong == "shape" else "found nan or inf"
    with pytest.raises(ValueError, match=own if last else "the array of another rank has a wrong shape, nan or inf"):
        call(problem, u, bad)
    assert np.array_equal(problem.gradient(u), before)


def test_after_failure() -> None:
    """A sweep whose numbers overflow leaves nothing in those that follow."""
    problem = half_disc(control__initial=PUSHED).problem()
    u = problem.first_guess()
    product = problem.hessian_product(0 * u, np.full_like(u, 1e308))
    assert not np.isfinite(product).all(), "it did not overflow: the case says nothing"
    problem.value(u)
    found, expected = problem.gradient(u), half_disc(control__initial=PUSHED).problem().gradient(u)
    assert np.max(np.abs(found - expected)) <= ROUNDING * np.max(np.abs(expected))
