# SPDX-License-Identifier: GPL-3.0-or-later
"""J of a scene's control and residuals of its fit as functions of JAX, with their exact derivatives::

    J = signorini.jax.function(scene.problem())
    jax.grad(lambda weights: J(network(weights, target)))(weights)
"""

from __future__ import annotations

from collections.abc import Callable

import jax
import numpy as np

from .fit import Fit
from .problem import Problem


def function(problem: Problem | Fit) -> Callable[[jax.Array], jax.Array]:
    """Returns J(u) of a control problem, or the residuals r(θ) of a fit, as a function that jax.grad, jax.jit and jax.vmap accept.

    A control has the shape of Problem.shape. jax.vmap evaluates its controls as a batch of Problem.batch(). A value takes a
    forward sweep; its derivative an adjoint sweep and, if more than two controls were evaluated since, the forward sweep
    again. Results have the precision of the argument: with jax.config.update("jax_enable_x64", True) that of the solver. On
    one rank only. Raises ValueError on several ranks, and the errors of Problem and Fit within those of JAX.
    """
    from .world import RANKS  # noqa: PLC0415

    if RANKS > 1:
        raise ValueError(f"signorini.jax.function: found {RANKS} ranks; JAX decides when a function is called, which must be one process")
    values, derivatives, of_value = _of_fit(problem) if isinstance(problem, Fit) else _of_problem(problem)

    def call(compute: Callable[..., np.ndarray], shape: tuple[int, ...], *arguments: jax.Array) -> jax.Array:
        result = jax.ShapeDtypeStruct(shape, arguments[0].dtype)
        return jax.pure_callback(lambda *given: compute(*map(np.asarray, given)).astype(result.dtype), result, *arguments, vmap_method="broadcast_all")

    @jax.custom_vjp
    def evaluate(argument: jax.Array) -> jax.Array:
        return call(values, of_value, argument)

    def forward(argument: jax.Array) -> tuple[jax.Array, jax.Array]:
        return evaluate(argument), argument

    def backward(argument: jax.Array, by_value: jax.Array) -> tuple[jax.Array]:
        return (call(derivatives, argument.shape, argument, by_value),)

    evaluate.defvjp(forward, backward)
    return evaluate


Parts = tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray, np.ndarray], np.ndarray], tuple[int, ...]]


def _of_problem(problem: Problem) -> Parts:
    """J, its derivative times a number, and the shape of J; all for batches too."""
    single = len(problem.shape)

    def value(u: np.ndarray) -> np.ndarray:
        u = np.ascontiguousarray(u, dtype=float)
        if u.ndim == single:
            return np.asarray(problem.value(u))
        return problem.batch(u.reshape(-1, *problem.shape)).values.reshape(u.shape[:-single])

    def derivative(u: np.ndarray, by_value: np.ndarray) -> np.ndarray:
        u = np.ascontiguousarray(u, dtype=float)
        if u.ndim == single:
            return by_value * problem.gradient(u)
        found = problem.batch(u.reshape(-1, *problem.shape), gradients=True).gradients.reshape(u.shape)
        return by_value.reshape(by_value.shape + (1,) * single) * found

    return value, derivative, ()


def _of_fit(fit: Fit) -> Parts:
    """Residuals, their derivative times a vector, and their shape; those of a batch one after another."""

    def of_each(compute: Callable[..., np.ndarray], *arguments: np.ndarray) -> np.ndarray:
        arguments = [np.ascontiguousarray(one, dtype=float) for one in arguments]
        if arguments[0].ndim == 1:
            return compute(*arguments)
        return np.array([of_each(compute, *each) for each in zip(*arguments)])

    def value(theta: np.ndarray) -> np.ndarray:
        return of_each(fit.residuals, theta)

    def derivative(theta: np.ndarray, by_value: np.ndarray) -> np.ndarray:
        return of_each(lambda at, weights: weights @ fit.jacobian(at), theta, by_value)

    return value, derivative, fit.residuals(fit.start).shape
