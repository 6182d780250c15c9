# SPDX-License-Identifier: GPL-3.0-or-later
"""Position and slope of a floor: a scene's unknowns by SciPy's least squares, on any number of ranks.

    ./dev exec python3 python/examples/scipy_least_squares.py
"""

from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import signorini

SCENES = Path(__file__).parents[2] / "scenes"

fit = signorini.Scene(SCENES / "find-the-wall.toml").fit()
found = least_squares(fit.residuals, fit.start, fit.jacobian, bounds=(fit.lower, fit.upper), x_scale="jac")
deviations = np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)))

if signorini.rank == 0:
    for name, value, deviation in zip(fit.names, found.x, deviations):
        print(f"{name:8} {value: .6f} ± {deviation:.6f}")
    print(f"misfit {np.sqrt(2 * found.cost / len(found.fun)):.3f} standard deviations, {fit.sweeps} motions")
