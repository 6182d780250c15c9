# SPDX-License-Identifier: GPL-3.0-or-later
"""Derivatives, metric, bounds, caching: identities that hold on any number of ranks."""

import numpy as np
from common import PUSHED, direction, half_disc, show

import signorini

ROUNDING = 1e-11  # of sums over a control, of conjugate gradients to rounding


def taylor(problem: signorini.Problem, u: np.ndarray) -> None:
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
    orders = np.log2(np.divide(left[:-1], left[1:]))
    show(f"Taylor remainders {left}, orders {orders}")
    assert np.all(np.abs(orders - 2) < 0.05), orders
    assert left[-1] < 1e-3 * abs(sizes[-1] * slope)


def hessian(problem: signorini.Problem, u: np.ndarray) -> None:
    """Symmetric, and the difference of derivatives."""
    d, e = direction(problem), direction(problem, 1.0)
    one = problem.pairing(problem.hessian_product(u, d), e)
    other = problem.pairing(problem.hessian_product(u, e), d)
    h = 1e-4
    difference = (problem.gradient(u + h * d) - problem.gradient(u - h * d)) / (2 * h)
    quotient = problem.pairing(difference, e)
    show(f"Hessian {one:.10g}, transposed {other:.10g}, by differences {quotient:.10g}")
    assert abs(one - other) < 1e-10 * abs(one)
    assert abs(one - quotient) < 1e-6 * abs(one)


def metric(problem: signorini.Problem, u: np.ndarray) -> None:
    """What the products of a metric are of each other."""
    d, e, product = direction(problem), direction(problem, 2.0), problem.metric.product
    dual = problem.metric.apply(d)
    assert abs(problem.pairing(dual, e) / product(d, e) - 1) < ROUNDING
    assert abs(product(d, e) / product(e, d) - 1) < ROUNDING and product(d, d) > 0
    back = problem.metric.apply_inverse(dual) - d
    assert product(back, back) < ROUNDING**2 * product(d, d)
    derivative, g = problem.gradient(u), problem.representative(u)
    off = problem.riesz(derivative) - g
    assert product(off, off) < ROUNDING**2 * product(g, g)
    assert abs(product(g, d) / problem.pairing(derivative, d) - 1) < ROUNDING
    diagonal, weights = problem.metric.diagonal, problem.metric.weights
    # Both measure constants alike.
    one = np.ones(problem.shape)
    assert abs(problem.pairing(weights, one) / product(one, one) - 1) < ROUNDING
    if diagonal is not None:
        assert np.allclose(diagonal * d, dual, rtol=1e-12, atol=0)
    ratio = product(d, d) / problem.pairing(weights * d, d)
    show(f"metric {'diagonal' if diagonal is not None else 'consistent'}: product over lumped {ratio:.4f}")
    assert 0.2 < ratio < 2


def known(problem: signorini.Problem, u: np.ndarray) -> None:
    """What is known is not computed again; a returned array is the caller's own."""
    for factor in (1.5, 1.75):
        problem.value(factor * u)
    before = problem.sweeps
    value = problem.value(u)
    assert problem.sweeps == (before.forward + 1, before.adjoint)
    again, derivative = problem.value_and_gradient(u)
    assert again == value and problem.sweeps == (before.forward + 1, before.adjoint + 1)
    kept = derivative.copy()
    derivative[:] = 7  # whoever changes it changes nothing of the problem's
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
    assert problem.sweeps == (before.forward + 2, before.adjoint + 1), problem.sweeps
    states = problem.states(u)
    assert states.shape == (len(problem.step_times), *problem.nodes.shape)
    assert np.array_equal(problem.displacement(u, len(states) - 1), states[-1]) and states[-1].any()


def places(problem: signorini.Problem, u: np.ndarray) -> None:
    """gather() and scatter() undo each other, in an order of places."""
    whole = problem.gather(u)
    assert np.array_equal(problem.scatter(whole), u)
    x = problem.gather(np.tile(np.repeat(problem.points[:, 0], len(problem.components)), (problem.shape[0], 1)))
    assert np.all(np.diff(x[0]) > -1e-6 * np.ptp(x)), "places stand in the order of their coordinates"
    flat = problem.replicated()
    vector, d = flat.vector(u), flat.vector(direction(problem))
    assert vector.shape == (flat.size,) and np.allclose(flat.control(vector), u, rtol=1e-14, atol=0)
    value, gradient = flat.value_and_gradient(vector)
    slope = problem.pairing(problem.gradient(flat.control(vector)), direction(problem))
    assert abs(gradient @ d / slope - 1) < ROUNDING and value == problem.value(flat.control(vector))
    second = flat.hessian_product(vector, d) @ d
    assert abs(second / problem.pairing(problem.hessian_product(flat.control(vector), direction(problem)), direction(problem)) - 1) < 1e-9
    show(f"J = {value:.15g}, slope {slope:.15g}, |x| = {np.linalg.norm(vector):.15g} of {flat.size} entries")


def limits(problem: signorini.Problem) -> None:
    """Bounds are the scene's, component by component and in both shapes; the first guess is within them."""
    columns = np.arange(problem.shape[1]) % 2  # x and y in turn
    lower = np.broadcast_to(np.where(columns == 0, -2.0, -1.5), problem.shape)
    assert np.array_equal(problem.lower, lower) and np.array_equal(problem.upper, np.full(problem.shape, 1.25))
    flat = problem.replicated()
    low, high = np.transpose(flat.bounds)
    scale = np.sqrt(problem.metric.weights)
    for side, whole in ((lower, low), (problem.upper, high)):
        assert np.allclose(whole, problem.gather(side * scale).ravel(), rtol=1e-13, atol=0)
    if signorini.ranks > 1:
        return
    given = {"control__initial": ["3", "-9"]}
    beyond = half_disc(4, **given, control__lower=[-2, -1.5], control__upper=1.25).problem()
    expected = np.broadcast_to(np.where(np.arange(beyond.shape[1]) % 2 == 0, 1.25, -1.5), beyond.shape)
    assert np.array_equal(beyond.first_guess(), expected) and np.array_equal(np.unique(half_disc(4, **given).problem().first_guess()), [-9, 3])
    for key, own, other, beyond_it in (("control__lower", "lower", "upper", np.inf), ("control__upper", "upper", "lower", -np.inf)):
        one_sided = half_disc(4, **{key: 0.25}).problem()
        assert np.array_equal(getattr(one_sided, own), np.full(one_sided.shape, 0.25)) and getattr(one_sided, other) is None
        sides = np.transpose(one_sided.replicated().bounds)
        mine, theirs = sides if own == "lower" else sides[::-1]
        assert np.all(theirs == beyond_it) and np.allclose(one_sided.replicated().control(mine), 0.25, rtol=1e-13, atol=0)


def refused(problem: signorini.Problem, u: np.ndarray) -> None:
    """What is no control of this problem on one rank is refused on all, and leaves what is known."""
    before, last = problem.gradient(u), signorini.rank == signorini.ranks - 1
    for number in (np.nan, np.inf, None):
        bad = u.copy()
        if last and number is None:
            bad = bad[:, :-1]
        elif last:
            bad.flat[-1] = number
        for call in (lambda: problem.value(bad), lambda: problem.gradient(bad), lambda: problem.hessian_product(u, bad), lambda: problem.hessian_product(bad, u)):
            try:
                call()
            except ValueError as error:
                own = "found nan or inf" if number is not None else "found an array of shape"
                assert (own if last else "another rank's array is refused") in str(error), error
            else:
                raise AssertionError(f"taken: {number}")
    assert np.array_equal(problem.gradient(u), before)


def after_failure() -> None:
    """A sweep whose numbers overflow leaves nothing in those that follow."""
    problem = half_disc(**{"control__initial": PUSHED}).problem()
    u = problem.first_guess()
    product = problem.hessian_product(0 * u, np.full_like(u, 1e308))
    assert not np.isfinite(product).all(), "it did not overflow: the case says nothing"
    problem.value(u)
    found, expected = problem.gradient(u), half_disc(**{"control__initial": PUSHED}).problem().gradient(u)
    assert np.max(np.abs(found - expected)) <= ROUNDING * np.max(np.abs(expected))


def main() -> None:
    after_failure()
    for name, overrides in {
        "free": {},
        "bounded": {"control__lower": [-2, -1.5], "control__upper": 1.25},
        "cells": {"control__space": "cellwise"},
        "a surface, intervals": {"control__on": "contact", "control__step": 2.5e-4, "control__components": ["y"], "control__initial": ["0", "-30"]},
    }.items():
        if signorini.ranks > 1 and name in ("bounded", "cells"):  # what ranks matter to is in the others
            continue
        show(f"--- {name}")
        problem = half_disc(**{"control__initial": PUSHED, "objective__desired": {"displacement": ["0", "0"]}, **overrides}).problem()
        u = problem.first_guess()
        assert u.shape == problem.shape == (len(problem.times), problem.size // len(problem.times))
        assert u.shape[1] == len(problem.points) * len(problem.components)
        assert abs(problem.lengths.sum() - problem.step_times[-1]) < 1e-12
        bounds = (problem.lower, problem.upper)
        if name == "bounded":
            assert np.all(bounds[1] == 1.25) and set(np.unique(bounds[0])) == {-2, -1.5}
            limits(problem)
        else:
            assert bounds == (None, None) and problem.replicated().bounds is None
        taylor(problem, u)
        hessian(problem, u)
        metric(problem, u)
        known(problem, u)
        refused(problem, u)
        places(problem, u)


main()
