# SPDX-License-Identifier: GPL-3.0-or-later
"""The half disc's control by SciPy's L-BFGS-B, on any number of ranks.

    ./dev exec python3 python/examples/scipy_optimize.py
    ./dev exec mpirun -n 2 python3 -m mpi4py python/examples/scipy_optimize.py
"""

from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import signorini

SCENES = Path(__file__).parents[2] / "scenes"

problem = signorini.Scene(SCENES / "half-disc.toml", {"mesh.size": 1}).problem()
flat = problem.replicated()  # vectors that are whole on every rank, each of which runs the same search
found = minimize(flat.value_and_gradient, flat.start, jac=True, method="L-BFGS-B", bounds=flat.bounds,
                 options={"maxiter": 60, "maxcor": 20})  # fmt: skip

u = flat.control(found.x)
whole = problem.gather(u).reshape(len(problem.times), -1, len(problem.components))  # intervals × places × components
active = problem.active(u)
if signorini.rank == 0:
    print(f"J = {found.fun:.8f} after {found.nfev} calls; the control pushes with {np.mean(whole[..., 1]):.3f} in the mean")
    print(f"the body is in contact after {np.count_nonzero(active)} of {len(active) - 1} steps")
