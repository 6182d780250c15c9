# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits: SciPy's least squares finds what the data were made with; Jacobians are differences; nothing is computed twice."""

import numpy as np
import pytest
from common import SCENES
from scipy.optimize import OptimizeResult, least_squares

import signorini

one_rank = pytest.mark.skipif(signorini.ranks > 1, reason="the other tests are those to which ranks matter")
RATIO = {"unknown.0.of": "poisson", "unknown.0.start": 0.4, "unknown.1.scale": "linear"}


@pytest.fixture(scope="module")
def found() -> tuple[signorini.Fit, OptimizeResult, int]:
    """A fit, SciPy's answer, and the sweeps that it took."""
    fit = signorini.Scene(SCENES / "find-the-wall.toml").fit()
    result = least_squares(fit.residuals, fit.start, fit.jacobian, bounds=(fit.lower, fit.upper), x_scale="jac")
    return fit, result, fit.sweeps


def off_difference(fit: signorini.Fit, theta: np.ndarray, j: int, h: float) -> float:
    """How far a column of the Jacobian is from the difference of residuals, relative."""
    step = h * np.eye(2)[j]
    difference = (fit.residuals(theta + step) - fit.residuals(theta - step)) / (2 * h)
    return np.linalg.norm(difference - fit.jacobian(theta)[:, j]) / np.linalg.norm(difference)


def test_names_and_shapes() -> None:
    fit = signorini.Scene(SCENES / "find-the-wall.toml").fit()
    assert fit.names == ["height", "angle"] and list(fit.measurements) == ["right x", "right y", "left x", "left y"]
    assert len(fit.measured) == len(fit.times) == len(fit.deviations) == fit.measurements["left y"].stop and np.all(fit.deviations == 1e-4)
    assert np.all(fit.lower <= fit.start) and np.all(fit.start <= fit.upper)
    r, jacobian = fit.residuals(fit.start), fit.jacobian(fit.start)
    assert fit.sweeps == 3 and jacobian.shape == (len(r), 2), "one motion, and one linearised one of each unknown"
    assert np.allclose((fit.simulated(fit.start) - fit.measured) / fit.deviations, r, rtol=1e-9, atol=1e-9)


def test_least_squares(found: tuple[signorini.Fit, OptimizeResult, int]) -> None:
    fit, result, sweeps = found
    deviation = np.sqrt(np.diag(np.linalg.inv(result.jac.T @ result.jac)))
    off = np.abs(result.x) / deviation  # both are zero in the scene that made the data
    misfit = np.sqrt(2 * result.cost / len(fit.measured))
    print(f"{dict(zip(fit.names, result.x))}, off by {off} deviations, misfit {misfit:.3f}, {result.nfev} evaluations, {sweeps} sweeps")
    assert np.all(off < 4) and 0.8 < misfit < 1.2
    assert sweeps <= 3 * (result.nfev + 1), "more than one evaluation a point"


@pytest.mark.parametrize("j, h", ((0, 1e-8), (1, 1e-7)), ids=("height", "angle"))
def test_jacobian_at_the_minimum(found: tuple[signorini.Fit, OptimizeResult, int], j: int, h: float) -> None:
    """Near it contact does not change within the difference."""
    fit, result, _ = found
    assert off_difference(fit, result.x, j, h) < 1e-4


def drop_test(**overrides: object) -> signorini.Fit:
    """Unknowns on a logarithmic scale, with values of their own size."""
    return signorini.Scene(SCENES / "drop-test.toml", {"mesh.size": 8e-3, **overrides}).fit()


@one_rank
@pytest.mark.parametrize("j", (0, 1))
def test_jacobian_on_a_logarithmic_scale(j: int) -> None:
    fit = drop_test()
    assert off_difference(fit, fit.start, j, 1e-5 * fit.start[j]) < 1e-3


def refused(fit: signorini.Fit, theta: np.ndarray, *texts: str) -> None:
    for compute in (fit.residuals, fit.jacobian, fit.simulated):
        with pytest.raises(signorini.SceneError) as raised:
            compute(theta)
        assert all(text in str(raised.value) for text in texts)


@one_rank
@pytest.mark.parametrize("value", (-1000.0, 0.0, np.nan, np.inf))
@pytest.mark.parametrize("j", (0, 1))
def test_values_of_no_scene(j: int, value: float) -> None:
    """They are refused by name, and nothing is lost by them."""
    fit = drop_test()
    r = fit.residuals(fit.start)
    refused(fit, np.where(np.arange(2) == j, value, fit.start), f'the unknown "{fit.names[j]}" is {value:g}')
    assert np.all(fit.residuals(fit.start) == r)


@one_rank
@pytest.mark.parametrize("value", (2.0, 0.5, -1.0))
def test_no_ratio_of_poisson(value: float) -> None:
    refused(drop_test(**RATIO), np.array([value, 100.0]), f'the unknown "poisson" is {value:g}', "greater than -1 and less than 0.5")


@one_rank
def test_negative_viscosity() -> None:
    refused(drop_test(**RATIO), np.array([0.4, -1e-9]), '"shear viscosity" is -1e-09')
