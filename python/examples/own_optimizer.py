# SPDX-License-Identifier: GPL-3.0-or-later
"""A search of one's own, in the metric of the control: steepest descent with the step lengths of Barzilai and Borwein. Arrays are
local parts, and the metric sums over the ranks: the same lines run on any number of them.

    ./dev exec mpirun -n 2 python3 -m mpi4py python/examples/own_optimizer.py
"""

from pathlib import Path

import signorini

SCENES = Path(__file__).parents[2] / "scenes"

problem = signorini.Scene(SCENES / "half-disc.toml", {"mesh.size": 1}).problem()
product = problem.metric.product

u = problem.first_guess()
g = problem.representative(u)  # the gradient as a control
length = 1.0
for iteration in range(25):
    value = problem.value(u)
    if signorini.rank == 0:
        print(f"{iteration:3d}  J = {value:.8f}")
    slope = product(g, g)
    while problem.value(u - length * g) > value - 1e-4 * length * slope:
        length /= 2
    before, u = (u, g), u - length * g
    g = problem.representative(u)  # the motion is known: an adjoint sweep alone
    s, y = u - before[0], g - before[1]
    curvature = product(s, y)
    length = product(s, s) / curvature if curvature > 0 else 2 * length
