# SPDX-License-Identifier: GPL-3.0-or-later
"""J as a function of JAX: with JAX where it is, else with a stand-in of the few functions that signorini.jax calls."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from common import PUSHED, SCENES, direction, half_disc

if with_jax := importlib.util.find_spec("jax") is not None:
    import jax

    jax.config.update("jax_enable_x64", True)
else:
    sys.path.insert(0, str(Path(__file__).parent / "jax_stand_in"))
    import jax

import signorini
import signorini.jax

stand_in = pytest.mark.skipif(with_jax, reason="of the stand-in")


@pytest.fixture(scope="module")
def problem() -> signorini.Problem:
    return half_disc(3, control__initial=PUSHED, objective__desired={"displacement": ["0", "0"]}).problem()


def test_value_and_gradient(problem: signorini.Problem) -> None:
    u = problem.first_guess()
    before = problem.sweeps
    value, derivative = jax.value_and_grad(signorini.jax.function(problem))(u)
    expected, gradient = problem.value_and_gradient(u)
    assert float(value) == expected and np.array_equal(np.asarray(derivative), gradient)
    assert problem.sweeps.forward - before.forward <= 1 and problem.sweeps.adjoint - before.adjoint <= 1


@stand_in
def test_batch(problem: signorini.Problem) -> None:
    u = problem.first_guess()
    many = np.stack([u + 0.02 * i * direction(problem) for i in range(4)])
    both = jax.value_and_grad(signorini.jax.function(problem))

    values = jax.vmap(signorini.jax.function(problem), problem.shape)(many)
    assert values.shape == (4,)
    for i in range(4):
        value, derivative = both(many[i])
        assert abs(values[i] / value - 1) < 1e-6 and derivative.shape == problem.shape


@stand_in
def test_single_precision(problem: signorini.Problem) -> None:
    value, derivative = jax.value_and_grad(signorini.jax.function(problem))(problem.first_guess().astype(np.float32))
    assert np.asarray(value).dtype == derivative.dtype == np.float32


@stand_in
def test_fit() -> None:
    fit = signorini.Scene(SCENES / "find-the-wall.toml").fit()
    values, pulled = jax.value_and_grad(signorini.jax.function(fit))(fit.start.copy())
    assert np.array_equal(values, fit.residuals(fit.start))
    assert np.allclose(pulled, fit.jacobian(fit.start).sum(axis=0), rtol=1e-12, atol=0)
