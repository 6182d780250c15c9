# SPDX-License-Identifier: GPL-3.0-or-later
"""D1: an elastic disc falls on a plane. The fall is a parabola until the touch, and energy only ever goes.

How fast the disc flies off, and how much of it rings instead, nobody knows in closed form; but no faster than the energy allows,
and as fast on the next finer mesh, and with massless contact, which loses no energy, but for a difference that vanishes.

What the contact condition takes is the kinetic energy of the nodes that come to rest on the plane, a layer of the body as
thick as an element: it vanishes with the element size, at order 1.
"""

import functools
from collections.abc import Callable

import numpy as np
import pytest
from falling_disc import ACCELERATION, COARSE, MIDDLE, SIZES, drop


@pytest.fixture(scope="module")
def dropped(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., tuple[float, float]]:
    """drop() by size, sag and overrides; each motion is computed once."""
    return functools.cache(lambda size, sag=0, **overrides: drop(size, tmp_path_factory.mktemp("drop") / "out", sag, **overrides))


@pytest.mark.parametrize("size", SIZES)
def test_fall_and_energy(dropped: Callable, size: float) -> None:
    dropped(size)


def test_rebound_converges(dropped: Callable) -> None:
    coarse, shipped, fine = (dropped(size)[1] for size in SIZES)
    # Of order 1 each difference is half of the one before, and what is left as large as the last.
    assert abs(fine - shipped) / abs(shipped - coarse) <= 0.5


def test_massless(dropped: Callable) -> None:
    coarse, shipped = dropped(COARSE)[1], dropped(MIDDLE)[1]
    # Gravity moves a contact node by this against its body, see hard/discs.py.
    _, massless = dropped(MIDDLE, ACCELERATION * MIDDLE**2 / 50, contact__mass="massless")
    assert massless == pytest.approx(shipped, rel=0, abs=abs(shipped - coarse)), "further from the default than the next mesh"


def test_order_of_the_energy_lost(dropped: Callable) -> None:
    order = float(np.polyfit(np.log(list(SIZES)), np.log([dropped(size)[0] for size in SIZES]), 1)[0])
    # Which nodes come to rest when is accidental; halfway to order 1/2, at which a layer of √h would be lost.
    assert order >= 0.75, "order 1 is expected"
