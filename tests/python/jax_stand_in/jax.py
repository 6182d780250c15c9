# SPDX-License-Identifier: GPL-3.0-or-later
"""What signorini.jax needs of JAX, on numpy: no tracing, no compilation. Debian has no JAX; with this the calls are tested, not JAX."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass
class ShapeDtypeStruct:
    shape: tuple[int, ...]
    dtype: np.dtype


def pure_callback(callback: Callable, result: ShapeDtypeStruct, *arguments: np.ndarray, vmap_method: str) -> np.ndarray:
    assert vmap_method == "broadcast_all"
    found = callback(*arguments)
    batch = _batch[-1] if _batch else ()
    assert np.shape(found) == (*batch, *result.shape) and found.dtype == result.dtype
    return found


_batch: list[tuple[int, ...]] = []


class custom_vjp:
    def __init__(self, function: Callable) -> None:
        self.function = function

    def defvjp(self, forward: Callable, backward: Callable) -> None:
        self.forward, self.backward = forward, backward

    def __call__(self, argument: np.ndarray) -> np.ndarray:
        return self.function(argument)


def value_and_grad(function: custom_vjp) -> Callable:
    """Of a scalar function, or the pull-back of ones of another."""

    def both(argument: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value, kept = function.forward(argument)
        (derivative,) = function.backward(kept, np.ones(np.shape(value), argument.dtype))
        return value, derivative

    return both


def vmap(function: Callable, example: tuple[int, ...]) -> Callable:
    """The function with one more dimension in front; `example`: the shape of one argument. As JAX does, the callback gets all at once."""

    def mapped(arguments: np.ndarray) -> np.ndarray:
        _batch.append(arguments.shape[: arguments.ndim - len(example)])
        try:
            return function(arguments)
        finally:
            _batch.pop()

    return mapped
