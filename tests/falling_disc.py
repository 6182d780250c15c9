# SPDX-License-Identifier: GPL-3.0-or-later
"""scenes/disc-drop.toml: an elastic disc falls on a plane; its figures beside free fall and the energy that there is."""

from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

TOUCH, ACCELERATION = 10.0, 0.1  # s, m/s²
WAVE = 60**0.5  # m/s, of pressure
SIZES = {4.0: 0.02, 2.0: 0.01, 1.0: 0.005}  # m, and the step in proportion, s: as shipped in the middle
COARSE, MIDDLE, _ = SIZES
END = 40.0


def drop(size: float, out: Path, sag: float = 0, **overrides: object) -> tuple[float, float]:
    """Runs the scene, checks its figures and returns the part of the impact's energy that is lost until the end, and the speed of
    the rebound (m/s), from the impulses of contact and gravity. Contact nodes that fall otherwise than their body may be off by
    `sag` (m), with waves that cross an element; the speed is that of two steps, because without mass they may alternate."""
    step = SIZES[size]
    signorini("simulate", SOURCE / "scenes" / "disc-drop.toml", out, mesh__size=size, time__step=step,
              output__every=round(END / step), **overrides)  # fmt: skip
    steps = table(out / "steps.csv")
    time, gap, force = steps["time"], steps["min_gap"], steps["contact_force_y"]
    energy = steps["kinetic_energy"] + steps["elastic_energy"] - np.cumsum(steps["external_work"])
    pushed = np.flatnonzero(force > 0)
    assert len(pushed) > 500, "hardly any contact: the case says nothing"
    falling = round(TOUCH / step)
    impact = steps["kinetic_energy"][falling]
    # Steps are exact for a parabola; 1e-14 of the fall's height in each of up to 2000 of them.
    assert gap[: falling + 1] == pytest.approx(5 - ACCELERATION / 2 * time[: falling + 1] ** 2, abs=1e-10 + sag)
    assert time[pushed[0]] == pytest.approx(TOUCH, abs=1.001 * step + sag)
    speed = (gap[falling - 2] - gap[falling]) / (2 * step)
    assert speed == pytest.approx(1, abs=1.001 * ACCELERATION * step + sag * WAVE / size)
    # Sums of the works of up to 8000 steps.
    assert np.diff(energy).max() <= 1e-11 * impact, "energy rises"
    mass = 2 * impact  # at 1 m/s
    left = pushed[-1]
    rebound = step * force.sum() / mass - ACCELERATION * time[left]
    lost = -energy[-1] / impact
    print(f"elements of {size:g} m, {overrides}: rebound at {rebound:.5f} m/s, last force at {time[left]:.2f} s, energy lost {lost:.5f}")
    assert rebound <= np.sqrt(1 - lost), "faster than the energy left allows"
    return lost, rebound
