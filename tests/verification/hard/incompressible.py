# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearly incompressible bodies: ν = 0.49, 0.499, 0.4999. Solvers converge, energy stays bounded, and degree 1 locks.

Hertz's half-width a = 2 √(P R (1 - ν²) / π E) hardly depends on ν there. Linear triangles of such a body can hardly
deform at all, and their contact stays too narrow, the more the nearer ν is to 1/2; quadratic ones have the motions that keep
their volume, and satisfy the tolerance of pressed_disc.py at every ν, whose element is the distance between nodes.
"""

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini
from pressed_disc import HERTZ, RADIUS, SIZES, mesh, pressure
from schemes import SCHEMES, energy, run

NUMBERS = (0.49, 0.499, 0.4999)
YOUNG = 200.0
TOUCH, STEP, FALL = 10.0, 0.02, 5.0  # s, s, m
SOLVERS = {**SCHEMES, "conjugate gradients": {"solver__linear": "iterative"}}


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[float, float, int], tuple[float, float, int]]:
    """Half-width of the press at rest over Hertz's, Hertz's (m), and the nodes in contact, by ν, size and degree of the elements; each
    motion is computed once."""

    @functools.cache
    def half_width(nu: float, size: float, degree: int) -> tuple[float, float, int]:
        folder = tmp_path_factory.mktemp("press")
        viscosity = {"bulk": YOUNG / (3 * (1 - 2 * nu)), "shear": YOUNG / (2 * (1 + nu))}  # the moduli times 1 s, as in the scene
        signorini("simulate", SOURCE / "scenes" / "hertz-press.toml", folder / "out", mesh__file=str(mesh(size, folder)),
                  mesh__degree=degree, material__poisson=nu, material__viscosity=viscosity, output__fields=[], output__every=1)  # fmt: skip
        x, _, force = pressure(folder / "out")
        load = force.sum()
        found = 2 * np.sqrt(((x - (x * force).sum() / load) ** 2 * force).sum() / load)
        exact = 2 * np.sqrt(load * RADIUS * (1 - nu**2) / (np.pi * YOUNG))
        return found / exact, exact, int((force > 0).sum())

    return half_width


def tolerance(exact: float) -> float:
    return HERTZ + (SIZES[0] / 2 / exact) ** 2


@pytest.mark.parametrize("nu", NUMBERS, ids="nu {}".format)
def test_degree_2(pressed: Callable, nu: float) -> None:
    width, exact, nodes = pressed(nu, SIZES[0], 2)
    print(f"{nodes} nodes in contact; half-width over Hertz's {width:.4f} (± {tolerance(exact):.4f})")
    assert nodes > 10, "hardly any contact: the case says nothing"
    assert width == pytest.approx(1, abs=tolerance(exact))


@pytest.mark.parametrize("nu", NUMBERS, ids="nu {}".format)
def test_degree_1_locks(pressed: Callable, nu: float) -> None:
    """Locked: narrower than the tolerance of a mesh that is not, and less so with shorter elements."""
    coarse, fine = (pressed(nu, size, 1)[0] for size in SIZES)
    narrow = 1 - tolerance(pressed(nu, SIZES[0], 2)[1])
    print(f"half-width over Hertz's {coarse:.4f} < {narrow:.4f}, with elements half as long {fine:.4f}")
    assert coarse < narrow
    assert coarse < fine < 1


def test_degree_1_locks_the_more_the_nearer_to_incompressible(pressed: Callable) -> None:
    widths = [pressed(nu, SIZES[0], 1)[0] for nu in NUMBERS]
    print("half-widths over Hertz's " + " ".join(f"{width:.4f}" for width in widths))
    assert (np.diff(widths) < 0).all()


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("degree", (1, 2), ids="degree {}".format)
@pytest.mark.parametrize("nu", NUMBERS, ids="nu {}".format)
def test_drop(nu: float, degree: int, solver: str, tmp_path: Path) -> None:
    """The disc of D1, without viscosity, to 30 s: beyond the rebound."""
    steps = run(SOURCE / "scenes" / "disc-drop.toml", tmp_path, mesh__size=4, mesh__degree=degree, time__step=STEP, time__end=30,
                material__poisson=nu, output__every=1500, **({"solver__linear": "direct"} | SOLVERS[solver]))  # fmt: skip
    total = energy(steps) - np.cumsum(steps["external_work"])
    impact = steps["kinetic_energy"][round(TOUCH / STEP)]
    touched = int((steps["contact_force_y"] > 0).sum())
    rise, off = np.maximum(0, np.diff(total).max()) / impact, abs(steps["energy_residual"]).max() / impact
    # The elastic forces of a displacement cancel where it is rigid, but for eps y|A|y: a few of 1e-16 (5 m)² K of
    # each of some 1000 unknowns over the impact's 630 J, with K = E / 3 (1 - 2 nu) of E = 50 Pa.
    allowed = 1e-13 / (1 - 2 * nu)
    if solver == "conjugate gradients":  # which leave 1e-12 of the displacement, in the velocity, of 1 m/s, 2/τ times that
        allowed += 2 * 2 / STEP * 1e-12 * FALL
    print(f"{touched} steps in contact; energy law to {off:.0e}, largest rise {rise:.0e} (<= {allowed:.0e}), lost "
          f"{-total[-1] / impact:.4f} of the impact's")  # fmt: skip
    assert touched > 100, "hardly any contact: the case says nothing"
    assert rise <= allowed
    assert off <= allowed
