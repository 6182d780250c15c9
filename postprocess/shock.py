# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectra of forces and accelerations: Fourier's, and shock response spectra."""

import numpy as np

Q = 10.0  # quality of the oscillators of a shock response spectrum, as is usual
MOST_SAMPLES = 2**18


def even(times: np.ndarray, values: np.ndarray) -> tuple[float, np.ndarray]:
    """Returns the distance (s) and the values of evenly spaced samples, as dense as the shortest step; `values` has one row for each step."""
    steps = np.diff(times)
    if len(steps) == 0:
        return 1.0, values
    if np.allclose(steps, steps[0], rtol=1e-6, atol=0):
        return float((times[-1] - times[0]) / len(steps)), values
    count = min(MOST_SAMPLES, int(np.ceil((times[-1] - times[0]) / steps.min())) + 1)
    dense = np.linspace(times[0], times[-1], count)
    return float(dense[1] - dense[0]), np.stack([np.interp(dense, times, part) for part in values.T], axis=1)


def spectrum(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns frequencies above 0 (Hz) and the modulus of Fourier's integral of each component (frequencies × components)."""
    step, samples = even(times, values)
    return np.fft.rfftfreq(len(samples), step)[1:], step * abs(np.fft.rfft(samples, axis=0))[1:]


def shock_response(times: np.ndarray, acceleration: np.ndarray, per_octave: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Returns natural frequencies (Hz) and, for each component, the largest modulus of the absolute acceleration of an oscillator on the moving
    point (frequencies × components), during the motion and one period of the slowest oscillator after it. The oscillators are those of
    Smallwood's ramp-invariant filter, exact for accelerations that are linear between samples."""
    step, samples = even(times, acceleration)
    least, most = 1 / (len(samples) * step), 1 / (10 * step)
    frequencies = least * 2 ** (np.arange(max(1, int(per_octave * np.log2(most / least)) + 1)) / per_octave)
    omega, zeta = 2 * np.pi * frequencies[:, None], 1 / (2 * Q)
    decay, angle = np.exp(-zeta * omega * step), omega * np.sqrt(1 - zeta**2) * step
    c, s = decay * np.cos(angle), decay * np.sin(angle) / angle
    x1 = x2 = np.zeros(samples.shape[1])
    y1 = y2 = largest = np.zeros((len(frequencies), samples.shape[1]))
    for x in np.concatenate([samples, np.zeros_like(samples)]):
        y = (1 - s) * x + 2 * (s - c) * x1 + (decay**2 - s) * x2 + 2 * c * y1 - decay**2 * y2
        x1, x2, y1, y2, largest = x, x1, y, y1, np.maximum(largest, abs(y))
    return frequencies, largest
