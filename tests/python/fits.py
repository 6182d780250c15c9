# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits: SciPy's least squares finds what the data were made with; Jacobians are differences; nothing is computed twice."""

import numpy as np
from common import SCENES, show
from scipy.optimize import least_squares

import signorini


def main() -> None:
    fit = signorini.Scene(SCENES / "find-the-wall.toml").fit()
    assert fit.names == ["height", "angle"] and list(fit.measurements) == ["right x", "right y", "left x", "left y"]
    assert len(fit.measured) == len(fit.times) == len(fit.deviations) == fit.measurements["left y"].stop and np.all(fit.deviations == 1e-4)
    assert np.all(fit.lower <= fit.start) and np.all(fit.start <= fit.upper)
    r, jacobian = fit.residuals(fit.start), fit.jacobian(fit.start)
    assert fit.sweeps == 3 and jacobian.shape == (len(r), 2), "one motion, and one linearised one of each unknown"
    simulated = fit.simulated(fit.start)
    assert np.allclose((simulated - fit.measured) / fit.deviations, r, rtol=1e-9, atol=1e-9)
    found = least_squares(fit.residuals, fit.start, fit.jacobian, bounds=(fit.lower, fit.upper), x_scale="jac")
    deviation = np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)))
    off = np.abs(found.x) / deviation  # both are zero in the scene that made the data
    misfit = np.sqrt(2 * found.cost / len(fit.measured))
    show(f"{dict(zip(fit.names, found.x))}, off by {off} deviations, misfit {misfit:.3f}, {found.nfev} evaluations, {fit.sweeps} sweeps")
    assert np.all(off < 4) and 0.8 < misfit < 1.2
    assert fit.sweeps <= 3 * (found.nfev + 1), "no more than one evaluation a point"
    # Near the fit contact does not change within the difference.
    for j, h in enumerate((1e-8, 1e-7)):
        step = h * np.eye(2)[j]
        difference = (fit.residuals(found.x + step) - fit.residuals(found.x - step)) / (2 * h)
        relative = np.linalg.norm(difference - fit.jacobian(found.x)[:, j]) / np.linalg.norm(difference)
        show(f"Jacobian by {fit.names[j]}: {relative:.1e} from the difference")
        assert relative < 1e-4
    if signorini.ranks > 1:
        return
    # Unknowns on a logarithmic scale, with values of their own size.
    fit = signorini.Scene(SCENES / "drop-test.toml", {"mesh.size": 8e-3}).fit()
    theta = fit.start
    h = 1e-5 * theta
    for j in range(2):
        step = h[j] * np.eye(2)[j]
        difference = (fit.residuals(theta + step) - fit.residuals(theta - step)) / (2 * h[j])
        relative = np.linalg.norm(difference - fit.jacobian(theta)[:, j]) / np.linalg.norm(difference)
        show(f"Jacobian by {fit.names[j]}: {relative:.1e} from the difference")
        assert relative < 1e-3
    # Values that no scene may have are refused by name, and nothing is lost by them.
    r = fit.residuals(theta)
    for j, name in enumerate(fit.names):
        for value in (-1000.0, 0.0, np.nan, np.inf):
            refused(fit, np.where(np.arange(2) == j, value, theta), f'the unknown "{name}" is {value:g}')
    assert np.all(fit.residuals(theta) == r)
    ratio = {"mesh.size": 8e-3, "unknown.0.of": "poisson", "unknown.0.start": 0.4, "unknown.1.scale": "linear"}
    fit = signorini.Scene(SCENES / "drop-test.toml", ratio).fit()
    for value in (2.0, 0.5, -1.0):
        refused(fit, np.array([value, 100.0]), f'the unknown "poisson" is {value:g}', "greater than -1 and less than 0.5")
    refused(fit, np.array([0.4, -1e-9]), '"shear viscosity" is -1e-09')


def refused(fit: signorini.Fit, theta: np.ndarray, *texts: str) -> None:
    for compute in (fit.residuals, fit.jacobian, fit.simulated):
        try:
            compute(theta)
        except signorini.SceneError as error:
            assert all(text in str(error) for text in texts), error
        else:
            raise AssertionError(f"{theta} was taken")


main()
