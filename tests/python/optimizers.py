# SPDX-License-Identifier: GPL-3.0-or-later
"""SciPy's L-BFGS-B solves the half disc's control problem; how many calls that takes, and what a call costs beside its sweeps.
It takes the same steps on two ranks as on one."""

import json
import time

import numpy as np
from common import half_disc, started
from scipy.optimize import minimize

ENOUGH = 0.00992  # the least J known is 0.0099 at this size
CALLS = 160  # about 70 are needed
ITERATIONS = 8
SAME = 1e-6  # of J, as rounding grows over the iterations; 1e-10 is usual
OBJECTIVES = f"""
import json, signorini
from optimizers import search
found = search({ITERATIONS})[2]
if signorini.rank == 0:
    print(json.dumps(found))
"""


def search(iterations: int) -> tuple[float, int, list[float]]:
    """J at the end, the number of calls, and J of each iteration. Asserts what a call costs."""
    problem = half_disc(1).problem()
    flat = problem.replicated()
    seen, calls, seconds = [], 0, 0.0

    def evaluate(x: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal calls, seconds
        start = time.perf_counter()
        answer = flat.value_and_gradient(x)
        calls, seconds = calls + 1, seconds + time.perf_counter() - start
        return answer

    def iterated(intermediate_result: object) -> None:
        seen.append(intermediate_result.fun)

    found = minimize(evaluate, flat.start, jac=True, method="L-BFGS-B", callback=iterated, options={"maxiter": iterations, "maxcor": 20})
    assert problem.sweeps == (calls, calls), "a call is one forward and one adjoint sweep"
    assert abs(problem.value(flat.control(found.x)) / found.fun - 1) < 1e-12
    if iterations > ITERATIONS:
        more = seconds / problem.sweep_seconds - 1
        print(f"J = {found.fun:.10f} after {found.nit} iterations, {calls} calls in {seconds:.2f} s, "
              f"{100 * more:.1f} % more than their sweeps")  # fmt: skip
    return found.fun, calls, seen


def test_scipy_finds_a_minimiser() -> None:
    value, calls, _ = search(60)
    assert value < ENOUGH and calls <= CALLS


def test_same_on_two_ranks() -> None:
    found = []
    for ranks in (1, 2):
        done = started("-c", OBJECTIVES, ranks=ranks)
        assert done.returncode == 0, done.stderr
        found.append(json.loads(done.stdout))
    one, two = np.array(found)
    assert len(one) == ITERATIONS
    assert np.max(np.abs(two / one - 1)) < SAME
