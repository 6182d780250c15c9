# SPDX-License-Identifier: GPL-3.0-or-later
"""J of a scene's control and residuals of its fit as functions of PyTorch, with their exact derivatives::

    J = signorini.torch.function(scene.problem())
    J(network(target)).backward()
"""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch.autograd.function import FunctionCtx

from .fit import Fit
from .problem import Problem


class _Objective(torch.autograd.Function):
    @staticmethod
    def forward(ctx: FunctionCtx, u: torch.Tensor, problem: Problem) -> torch.Tensor:
        ctx.problem, ctx.derivatives = problem, None
        ctx.single = u.dim() == len(problem.shape)
        if ctx.single:
            ctx.save_for_backward(u)
            if not ctx.needs_input_grad[0]:
                return u.new_tensor(problem.value(u.detach().numpy()))
            value, derivative = problem.value_and_gradient(u.detach().numpy())
            ctx.derivatives = torch.from_numpy(derivative)
            return u.new_tensor(value)
        found = problem.batch(u.detach().reshape(-1, *problem.shape).numpy(), gradients=ctx.needs_input_grad[0])
        if found.gradients is not None:
            ctx.derivatives = torch.from_numpy(found.gradients).reshape(u.shape)
        return torch.from_numpy(found.values).reshape(u.shape[: -len(problem.shape)])

    @staticmethod
    def backward(ctx: FunctionCtx, by_value: torch.Tensor) -> tuple[torch.Tensor, None]:
        if not ctx.single:
            _require_last("of a batch")
            return by_value[..., None, None] * ctx.derivatives, None
        (u,) = ctx.saved_tensors
        if torch.is_grad_enabled():
            return by_value * _Derivative.apply(u, ctx.problem), None
        # Given away, so that autograd need not copy it; a second call computes it again.
        derivative, ctx.derivatives = ctx.derivatives, None
        if derivative is None:
            derivative = torch.from_numpy(ctx.problem.gradient(u.detach().numpy()))
        return derivative if by_value == 1 else derivative.mul_(by_value), None


class _Derivative(torch.autograd.Function):
    """dJ(u), whose derivative in turn is a Hessian product."""

    @staticmethod
    def forward(ctx: FunctionCtx, u: torch.Tensor, problem: Problem) -> torch.Tensor:
        ctx.problem = problem
        ctx.save_for_backward(u)
        return torch.from_numpy(problem.gradient(u.detach().numpy()))

    @staticmethod
    def backward(ctx: FunctionCtx, direction: torch.Tensor) -> tuple[torch.Tensor, None]:
        _require_last("beyond the second")
        (u,) = ctx.saved_tensors
        return torch.from_numpy(ctx.problem.hessian_product(u.detach().numpy(), direction.contiguous().numpy())), None


class _Residuals(torch.autograd.Function):
    @staticmethod
    def forward(ctx: FunctionCtx, theta: torch.Tensor, fit: Fit) -> torch.Tensor:
        ctx.fit = fit
        ctx.save_for_backward(theta)
        return torch.from_numpy(fit.residuals(theta.detach().numpy()))

    @staticmethod
    def backward(ctx: FunctionCtx, by_residuals: torch.Tensor) -> tuple[torch.Tensor, None]:
        _require_last("of residuals")
        (theta,) = ctx.saved_tensors
        return by_residuals @ torch.from_numpy(ctx.fit.jacobian(theta.detach().numpy())), None


def _require_last(what: str) -> None:
    """Raises RuntimeError where autograd wants to differentiate the derivative again."""
    if torch.is_grad_enabled():
        raise RuntimeError(f"signorini.torch: higher derivatives {what} are not available; use create_graph=False")


def function(problem: Problem | Fit) -> Callable[[torch.Tensor], torch.Tensor]:
    """Returns J(u) of a control problem, or the residuals r(θ) of a fit, as a function of a tensor that autograd differentiates.

    A control has the shape of Problem.shape, on several ranks that of this rank's part, or dimensions of a batch before it:
    then J has these dimensions, and up to 16 motions make their steps together. J makes a forward sweep and, if a gradient is
    needed, the adjoint sweep; backward() makes none. Second derivatives are the products of Problem.hessian_product(); those of batches and
    residuals raise RuntimeError. θ has the values of Fit.start. Bounds of the scene are not applied. Memory is shared with
    tensors on the CPU in double precision; others of floating-point numbers are converted. Calls and backward() are
    collective, and raise the errors of Problem and Fit.
    """
    rule = _Residuals if isinstance(problem, Fit) else _Objective

    def evaluate(argument: torch.Tensor) -> torch.Tensor:
        if not argument.is_floating_point():
            raise TypeError(f"found a tensor of {argument.dtype}; expected floating-point numbers")
        given = argument.to(dtype=torch.float64, device="cpu").contiguous()
        return rule.apply(given, problem).to(dtype=argument.dtype, device=argument.device)

    return evaluate
