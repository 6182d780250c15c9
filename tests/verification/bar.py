# SPDX-License-Identifier: GPL-3.0-or-later
"""B2 and B3, a bar hits a plane once and a bar bounces: figures against the exact solutions of exact_bar.py.

Contact-implicit forces alternate about the exact one in contact, on every mesh. Displacements, energy, impulses, contact
times and the mean of two neighbouring forces converge, and they alone are tested.
"""

import functools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from exact_bar import BOUNCE, IMPACT, LENGTH, Case, Motion, compare, read, simulate, strip
from harness import SOURCE, signorini

ELEMENTS = (50, 100, 200, 400)
THIN = 0.001  # m, in place of 1
CASES = [(case, courant) for case in (IMPACT, BOUNCE) for courant in case.courant]
each_case = pytest.mark.parametrize("case, courant", CASES, ids=[f"{case.scene}-{courant}" for case, courant in CASES])


@pytest.fixture(scope="module")
def refined(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Case, float], list[Motion]]:
    """The motions on all meshes, by case and Courant number; each is computed once."""

    @functools.cache
    def motions(case: Case, courant: float) -> list[Motion]:
        found = [simulate(case, tmp_path_factory.mktemp("bar") / "out", n, courant) for n in ELEMENTS]
        for motion in found:
            raw = motion.force[motion.contacts()[0]]
            print(f"{case.scene}, {motion.elements} elements: relative error of the gap {motion.gap_error():.5f}, of the two-step force "
                  f"{motion.force_error():.4f}; raw force {raw.min():.0f} to {raw.max():.0f} N/m²")  # fmt: skip
        return found

    return motions


def order(errors: list[float]) -> float:
    return float(np.polyfit(np.log([1 / n for n in ELEMENTS]), np.log(errors), 1)[0])


@each_case
def test_exact_solution(refined: Callable, case: Case, courant: float) -> None:
    compare(refined(case, courant)[ELEMENTS.index(100)])


@each_case
def test_orders(refined: Callable, case: Case, courant: float) -> None:
    """2/3 of the gap, 1/3 of the two-step force: above 1/2 and 1/4 of a scheme whose fronts are spread by damping, as h^(1/2)."""
    motions = refined(case, courant)
    assert order([motion.gap_error() for motion in motions]) >= 1 / 2
    assert order([motion.force_error() for motion in motions]) >= 1 / 4


def test_impact_as_shipped(tmp_path: Path) -> None:
    signorini("simulate", SOURCE / "scenes" / "bar-impact.toml", tmp_path)
    motion = read(IMPACT, tmp_path, 80, 1 / 240)
    compare(motion)
    inside = (motion.time[1:-1] > 0.55) & (motion.time[1:-1] < 1.1)
    # At either end of the window half a pair of alternating forces, none above 600, is cut.
    assert motion.two_step_force()[inside].mean() == pytest.approx(300, abs=300 * motion.step / 0.55), "N/m²"


def test_bounces_as_shipped(tmp_path: Path) -> None:
    signorini("simulate", SOURCE / "scenes" / "bouncing-bar.toml", tmp_path)
    motion = read(BOUNCE, tmp_path, 100, 5e-3)
    assert len(motion.contacts()) == 6
    assert motion.energy_loss() == pytest.approx(0, abs=6 / motion.elements)


def thin(case: Case, elements: int, courant: float, folder: Path) -> Motion:
    """A run of a thin strip, to compare with figures of an independent implementation of the same scheme in one dimension.

    The edges of a strip share out mass otherwise than a bar does; one as thin as 1/100 of an element cannot answer to that, and is
    the bar. Both must agree far better than either does with the exact solution, here to 1/20 of that distance, and to the figure's
    last digit.
    """
    return simulate(case, folder / "out", elements, courant, strip(THIN, folder), THIN)


def test_one_dimension_impact_on_a_step(tmp_path: Path) -> None:
    assert thin(IMPACT, 80, 1, tmp_path).energy_loss() == pytest.approx(0.0016, abs=0.0016 / 20 + 5e-5)


def test_one_dimension_impact_between_steps(tmp_path: Path) -> None:
    motion = thin(IMPACT, 100, 1.41, tmp_path)
    assert motion.energy_loss() == pytest.approx(0.0072, abs=0.0072 / 20 + 5e-5)
    rebound = motion.step * motion.force.sum() / LENGTH - 10
    assert rebound == pytest.approx(9.812, abs=0.188 / 20 + 5e-4), "mean velocity, m/s"


def test_one_dimension_gap_of_bounces(tmp_path: Path) -> None:
    assert thin(BOUNCE, 100, 1.5, tmp_path).gap_error() == pytest.approx(0.028, abs=0.028 / 20 + 5e-4)


def test_one_dimension_energy_after_six_impacts(tmp_path: Path) -> None:
    motion = thin(replace(BOUNCE, end=16.0), 100, 1.5, tmp_path)
    assert motion.energy_loss() == pytest.approx(0.0255, abs=0.0255 / 20 + 5e-5)
