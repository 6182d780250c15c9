# SPDX-License-Identifier: GPL-3.0-or-later
"""D1, H1 and P1 by all schemes: a disc that falls, Hertz's contact, and uniform pressure.

falling_disc.py and pressed_disc.py derive the tolerances of the first two. At rest mass enters no scheme: the equilibrium
A y = f + F is the fixed point of each, and the pressures must be the same to what is left of the motion.
"""

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from falling_disc import ACCELERATION, COARSE, MIDDLE, SIZES, TOUCH, drop
from harness import boundary, signorini, stored, table
from patch_scene import PRESSURE, patch
from pressed_disc import HERTZ, REST, press, pressure
from pressed_disc import SIZES as PRESSED
from schemes import SCHEMES, energy

PATCHES = {"plane": (2, 0.1, 1), "plane, degree 2": (2, 0.2, 2), "space": (3, 0.3, 1)}  # dimension, size and degree of the elements


@pytest.mark.parametrize("size", (COARSE, MIDDLE), ids="{:g} m".format)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_drop(scheme: str, size: float, tmp_path: Path) -> None:
    """Energy may rise by rounding only, in each single step of 40 s."""
    # Without mass a contact node keeps its weight f h/2, hangs by f h²/2E below its body, and as trapezoidal
    # steps let what has no mass alternate about its equilibrium, by up to twice that.
    sag = ACCELERATION * size**2 / 50 if scheme == "massless" else 0
    drop(size, tmp_path, sag, output__fields=[], **SCHEMES[scheme])
    steps = table(tmp_path / "steps.csv")
    total = energy(steps) - np.cumsum(steps["external_work"])
    rise = np.maximum(0, np.diff(total).max()) / steps["kinetic_energy"][round(TOUCH / SIZES[size])]
    print(f"{(steps['contact_force_y'] > 0).sum()} steps in contact, largest rise of energy {rise:.0e} of the impact's")


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, float], tuple[float, np.ndarray]]:
    """The profile's relative error and the nodes' forces, by scheme and size; each motion is computed once."""

    @functools.cache
    def found(scheme: str, size: float) -> tuple[float, np.ndarray]:
        folder = tmp_path_factory.mktemp("press")
        error = press(size, "traction", folder, output__fields=[], **SCHEMES[scheme])
        return error, pressure(folder / "out")[2]

    return found


@pytest.mark.parametrize("size", PRESSED, ids="{:g} m".format)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_press(pressed: Callable, scheme: str, size: float) -> None:
    """The rest of the motion, e^-10 of the whole load in each run, is all that schemes differ by."""
    _, force = pressed(scheme, size)
    _, first = pressed("contact-implicit", size)
    apart = abs(force - first).sum() / first.sum()
    print(f"off contact-implicit by {apart:.0e} <= {2 * REST:.0e}")
    assert apart <= 2 * REST


@pytest.mark.parametrize("scheme", SCHEMES)
def test_press_under_refinement(pressed: Callable, scheme: str) -> None:
    """The profile is of first order in the element, but for what Hertz leaves out."""
    coarse, fine = (pressed(scheme, size)[0] for size in PRESSED)
    print(f"profile off by {coarse:.4f} and {fine:.4f}")
    assert fine <= coarse / 2 + HERTZ


def shares(out: Path, x: np.ndarray, degree: int) -> np.ndarray:
    """The part of the lower side that each node represents, the integral of its shape function (m, in space m²)."""
    if x.shape[1] == 1:
        ends = np.sort(x[:, 0])[::degree]
        found = np.zeros(len(x))
        for i, length in enumerate(np.diff(ends)):
            for j, weight in enumerate((1 / 2, 1 / 2) if degree == 1 else (1 / 6, 4 / 6, 1 / 6)):
                found[degree * i + j] += weight * length
        return found[np.argsort(np.argsort(x[:, 0]))]
    nodes, cells, _ = stored(out, "state", "displacement")
    found = np.zeros(len(nodes))
    for facet in boundary(cells):
        corner = nodes[facet]
        if abs(corner[:, 2]).max() < 1e-12:
            found[facet] += abs(np.cross(corner[1] - corner[0], corner[2] - corner[0])[2]) / 6
    return np.array([found[np.argmin(np.linalg.norm(nodes - np.append(place, 0), axis=1))] for place in x])


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("case", PATCHES)
def test_patch(case: str, scheme: str, tmp_path: Path) -> None:
    """The uniform pressure of the patch test, to the rounding of 2000 steps, each to about 1e-14, and what is left of the motion."""
    dim, size, degree = PATCHES[case]
    scene, out = tmp_path / "patch.toml", tmp_path / "out"
    scene.write_text(patch(dim, size, 5e-3, degree))
    signorini("simulate", scene, out, output__every=1999, **SCHEMES[scheme])
    contact = table(out / "contact.csv")
    last = contact["step"][-1]
    now = contact["step"] == last
    x = np.array([contact[axis][now] for axis in "xy"[: dim - 1]]).T
    force = (contact["force"][now] + contact["force"][contact["step"] == last - 1]) / 2
    assert (force > 0).all(), "not all of the lower side is in contact: the case says nothing"
    p = force / shares(out, x, degree)
    off = abs(p / PRESSURE - 1).max()
    print(f"{len(p)} nodes in contact, pressure {p.mean():.6f} N/m², off by {off:.0e} <= 1e-11 at most")
    assert off <= 1e-11
