# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensitivities of a quantity to the keys of a batch: rank correlations, and a linear fit with standardised coefficients."""

from dataclasses import dataclass

import numpy as np

from .batch_folder import varies

LEAST = 3  # cases
COLLINEAR = 1e-8  # singular values of standardised keys below this, relative to the largest one, count as zero


@dataclass(frozen=True)
class Sensitivity:
    """Sensitivity of one quantity; NaN where there is none.

    `ranks`: Spearman's correlation with each key. `coefficients`: change of the quantity in its standard deviations as a key changes by
    its own, in a linear fit by all keys. `explained`: R² of the fit. `predicted`: R² if each case is predicted by a fit to the others.
    """

    cases: int
    ranks: np.ndarray
    coefficients: np.ndarray
    explained: float
    predicted: float


def sensitivity(keys: np.ndarray, quantity: np.ndarray) -> Sensitivity:
    """Returns the sensitivity of a quantity to keys (cases × keys), by those cases that have all numbers."""
    known = np.isfinite(keys).all(axis=1) & np.isfinite(quantity)
    keys, quantity = keys[known], quantity[known]
    ranks, coefficients, r2 = np.full(keys.shape[1], np.nan), np.full(keys.shape[1], np.nan), (np.nan, np.nan)
    varied = np.array([varies(key) for key in keys.T], dtype=bool)
    if len(quantity) >= LEAST and varies(quantity) and varied.any():
        ranks[varied] = [correlation(average_ranks(key), average_ranks(quantity)) for key in keys[:, varied].T]
        coefficients[varied], *r2 = linear_fit(keys[:, varied], quantity)
    return Sensitivity(len(quantity), ranks, coefficients, *r2)


def average_ranks(values: np.ndarray) -> np.ndarray:
    """Returns the ranks of values; equal ones have the average of theirs."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2)[place]


def correlation(x: np.ndarray, y: np.ndarray) -> float:
    return float(np.clip(np.corrcoef(x, y)[0, 1], -1, 1))


def linear_fit(keys: np.ndarray, quantity: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Returns standardised coefficients, R², and R² of predicted cases. All are NaN if the keys depend on each other linearly, or if
    there are fewer cases than two above the number of keys: the fit would be exact for any data."""
    none = np.full(keys.shape[1], np.nan), np.nan, np.nan
    if len(quantity) < keys.shape[1] + 2:
        return none
    x, y = standardised(keys), standardised(quantity)
    coefficients, _, rank, _ = np.linalg.lstsq(x, y, rcond=COLLINEAR)
    if rank < keys.shape[1]:
        return none
    residual = y - x @ coefficients
    # Residual of each case in the fit to the others, by its leverage.
    slack = 1 - 1 / len(y) - (np.linalg.qr(x)[0] ** 2).sum(axis=1)
    predicted = 1 - np.sum((residual / slack) ** 2) / np.sum(y**2) if slack.min() > COLLINEAR else np.nan
    return coefficients, float(1 - np.sum(residual**2) / np.sum(y**2)), float(predicted)


def standardised(values: np.ndarray) -> np.ndarray:
    return (values - values.mean(axis=0)) / values.std(axis=0)


def by_chance(cases: int) -> float:
    """Returns the modulus that rank correlations of independent samples exceed with a probability of about 5 %."""
    return min(1.0, 1.96 / np.sqrt(cases - 1))
