# SPDX-License-Identifier: GPL-3.0-or-later
"""J and residuals as functions of PyTorch: exact derivatives, no sweep too many, batches, and a network that learns through contact."""

import numpy as np
import pytest
import torch
from common import PUSHED, SCENES, direction, half_disc, started

import signorini
import signorini.torch

THROW = {"mesh.size": 0.25, "time.step": 4e-3}


@pytest.fixture(scope="module")
def problem() -> signorini.Problem:
    return half_disc(3, control__initial=PUSHED, objective__desired={"displacement": ["0", "0"]}).problem()


@pytest.fixture(scope="module")
def u(problem: signorini.Problem) -> torch.Tensor:
    assert problem.active(problem.first_guess()).max() > 0, "the body touches"
    return torch.from_numpy(problem.first_guess())


def test_value_and_gradient_are_those_of_the_problem(problem: signorini.Problem, u: torch.Tensor) -> None:
    J = signorini.torch.function(problem)
    x = u.clone().requires_grad_()
    value = J(x)
    value.backward()
    expected, derivative = problem.value_and_gradient(u.numpy())
    assert value.shape == () and value.item() == expected and np.array_equal(x.grad.numpy(), derivative)
    (twice,) = torch.autograd.grad(2 * J(x), x)
    assert np.array_equal(twice.numpy(), 2 * derivative)


def test_backward_twice(problem: signorini.Problem, u: torch.Tensor) -> None:
    J = signorini.torch.function(problem)
    x = u.clone().requires_grad_()
    value = 3 * J(x)
    value.backward(retain_graph=True)
    once = x.grad.clone()
    value.backward()
    assert np.array_equal(once.numpy(), 3 * problem.gradient(u.numpy())) and np.array_equal(x.grad.numpy(), 2 * once.numpy())


def test_no_sweep_too_many(problem: signorini.Problem, u: torch.Tensor) -> None:
    J = signorini.torch.function(problem)
    x = (u + 0.01 * torch.from_numpy(direction(problem))).requires_grad_()
    before = problem.sweeps
    J(x).backward()
    assert (problem.sweeps.forward - before.forward, problem.sweeps.adjoint - before.adjoint) == (1, 1)
    with torch.no_grad():
        J(x + 1e-3)
    assert problem.sweeps.adjoint - before.adjoint == 1


GRADCHECK = """
import signorini.torch, torch
from common import PUSHED, direction, half_disc
problem = half_disc(3, control__initial=PUSHED, objective__desired={"displacement": ["0", "0"]}).problem()
u, J = torch.from_numpy(problem.first_guess()), signorini.torch.function(problem)
shapes = torch.stack([torch.from_numpy(direction(problem, phase)) for phase in (0.0, 0.7, 1.9)])
zero = torch.zeros(3, dtype=torch.float64, requires_grad=True)
print(torch.autograd.gradcheck(lambda p: 1e3 * J(u + 0.01 * torch.tensordot(p, shapes, 1)), zero, eps=1e-4, atol=0, rtol=1e-5))
"""


def test_gradcheck() -> None:
    """Against differences along directions of a few parameters, as a network has them. In a Python of its own: PyTorch's function fails
    where pytest has rewritten its assertions."""
    done = started("-c", GRADCHECK, mpi4py=False)
    assert done.stdout == "True\n", done.stderr


def test_second_derivatives(problem: signorini.Problem, u: torch.Tensor) -> None:
    """Hessian products; those that are not available are refused, not zero."""
    J = signorini.torch.function(problem)
    d = torch.from_numpy(direction(problem))
    _, product = torch.autograd.functional.vhp(J, u, d)
    assert np.array_equal(product.numpy(), problem.hessian_product(u.numpy(), d.numpy()))
    x = u.clone().requires_grad_()
    (gradient,) = torch.autograd.grad(J(x), x, create_graph=True)
    with pytest.raises(RuntimeError, match="beyond the second"):
        torch.autograd.grad((gradient * d).sum(), x, create_graph=True)
    many = torch.stack([u, u]).requires_grad_()
    with pytest.raises(RuntimeError, match="of a batch"):
        torch.autograd.grad(J(many).sum(), many, create_graph=True)


def test_batch(problem: signorini.Problem, u: torch.Tensor) -> None:
    """Dimensions before those of a control are a batch, whose motions make their steps together."""
    J = signorini.torch.function(problem)
    many = torch.stack([u + 0.02 * i * torch.from_numpy(direction(problem)) for i in range(6)]).reshape(2, 3, *problem.shape).requires_grad_()
    values = J(many)
    weights = torch.arange(1.0, 7.0, dtype=torch.float64).reshape(2, 3)
    (weights * values).sum().backward()
    assert values.shape == (2, 3) and many.grad.shape == many.shape
    for i in np.ndindex(2, 3):
        value, derivative = problem.value_and_gradient(many[i].detach().numpy())
        assert abs(values[i].item() / value - 1) < 1e-6
        assert (many.grad[i] - weights[i] * torch.from_numpy(derivative)).abs().max() < 1e-6 * weights[i] * np.abs(derivative).max()
    with torch.no_grad():
        assert not J(many).requires_grad


def test_single_precision(problem: signorini.Problem, u: torch.Tensor) -> None:
    """Tensors of a network in single precision are converted on the way in and back."""
    J = signorini.torch.function(problem)
    x = u.float().requires_grad_()
    value = J(x)
    value.backward()
    assert value.dtype == x.grad.dtype == torch.float32
    assert abs(value.item() / problem.value(u.numpy()) - 1) < 1e-4


def test_errors_reach_the_caller(problem: signorini.Problem, u: torch.Tensor) -> None:
    J = signorini.torch.function(problem)
    with pytest.raises(ValueError):
        J(torch.full_like(u, torch.nan))
    with pytest.raises(TypeError, match="floating-point"):
        J(torch.ones(problem.shape, dtype=torch.int64))
    with pytest.raises((ValueError, RuntimeError)):
        J(u[1:])


def test_memory_is_shared(problem: signorini.Problem, u: torch.Tensor) -> None:
    """A tensor in double precision reaches the solver without a copy."""
    seen = []

    class Watching:
        shape = problem.shape

        def value(self, given: np.ndarray) -> float:
            seen.append(given)
            return 0.0

    signorini.torch.function(Watching())(u)
    assert seen[0].__array_interface__["data"] == u.numpy().__array_interface__["data"]


def test_residuals_of_a_fit() -> None:
    """Residuals and their derivatives by the unknowns, of which an initial velocity is one."""
    fit = signorini.Scene(SCENES / "find-the-wall.toml").fit()
    r = signorini.torch.function(fit)
    theta = torch.from_numpy(fit.start.copy()).requires_grad_()
    residuals = r(theta)
    assert np.array_equal(residuals.detach().numpy(), fit.residuals(fit.start))
    (residuals**2).sum().backward()
    assert np.allclose(theta.grad.numpy(), 2 * fit.residuals(fit.start) @ fit.jacobian(fit.start), rtol=1e-12, atol=0)


def test_overhead(problem: signorini.Problem, u: torch.Tensor) -> None:
    """The time beside the solver's own sweeps is small even on a mesh of 94 unknowns; `./dev bench python` has the figure of a usual one."""
    import time

    J = signorini.torch.function(problem)
    shares = []
    for i in range(5):
        x = (u + 1e-3 * i).requires_grad_()
        start, inside = time.perf_counter(), problem.sweep_seconds
        J(x).backward()
        shares.append((time.perf_counter() - start) / (problem.sweep_seconds - inside) - 1)
    assert np.min(shares) < 0.2, shares


def test_a_network_learns_to_throw() -> None:
    """Its output, the force over time for a wanted height, lifts a ball that flies; the derivative goes through both impacts."""
    torch.manual_seed(0)
    heights = (0.3, 0.5)
    problems = [signorini.Scene(SCENES / "throw.toml", THROW | {"objective.desired.displacement": ["0", str(height)]}).problem() for height in heights]
    functions = [signorini.torch.function(one) for one in problems]
    shape = problems[0].shape
    knots = torch.linspace(0, 1, 8, dtype=torch.float64)
    times = torch.from_numpy(problems[0].times.copy()) / problems[0].step_times[-1]
    hats = torch.clamp(1 - (times[:, None] - knots).abs() * 7, min=0)
    network = torch.nn.Sequential(torch.nn.Linear(1, 8), torch.nn.Tanh(), torch.nn.Linear(8, 8)).double()

    def loss() -> torch.Tensor:
        total = torch.zeros((), dtype=torch.float64)
        for height, J in zip(heights, functions):
            force = hats @ (10 * torch.tanh(network(torch.tensor([height], dtype=torch.float64))))
            total = total + J(force[:, None].expand(shape))
        return total

    optimizer = torch.optim.Adam(network.parameters(), lr=0.03)
    found = []
    for _ in range(60):
        optimizer.zero_grad()
        value = loss()
        value.backward()
        found.append(value.item())
        optimizer.step()
    assert found[-1] < 0.2 * found[0], found
    with torch.no_grad():
        force = hats @ (10 * torch.tanh(network(torch.tensor([0.5], dtype=torch.float64))))
    active = problems[1].active(force[:, None].expand(shape).numpy().copy())
    assert active.max() > 0 and (active[1:-1] == 0).any(), "the ball lies on the block, and flies"
