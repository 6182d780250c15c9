# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradients without and with little viscosity: the derivative beside the slope over a tenth of the control, which is what an
optimizer and an experiment see.

The flat face is the lower end of a bar without lateral contraction (bar_impact's), that hits the plane with all its nodes at
once and leaves again; a force along the bar, constant in time, is to change where it is then. There an exact derivative of
the contact-implicit scheme can have the wrong sign, since its contact chatters: that is shown, and nothing in the case avoids it.
The round one is the half disc. Asserted is: every derivative is exact (Taylor order 2, or where sets are kept in too small a
neighbourhood for that, the difference quotient within it); massless and contact-stabilized steps see the macroscopic slope
within 5 %; and the verdict names what is found.
"""

import functools
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, SOURCE, attempt
from schemes import SCHEMES

BAR = """
[mesh]
file = "{meshes}/bar.geo"
size = {size!r}
[time]
end = {end!r}
step = {step!r}
[material]
density = 1.0
young = 900.0
poisson = 0.0
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -2], normal = [0, 1] }}
[initial]
velocity = ["0", "-10"]
[control]
scale = 1.0
constant_in_time = true
components = ["y"]
[objective]
desired = {{ displacement = ["0", "0"] }}
gamma = 1.0
alpha = 1e-8
[check]
control = ["0", "10"]
"""
NUMBER = r"(-?[\d.]+e[+-]\d+)"
SAID = re.compile(
    rf"stay the same for relative changes of the control up to {NUMBER}.*\nThe derivative along d is {NUMBER}; over .* with (\d+) changes .* slope {NUMBER}\.\n"
    rf"Verdict: the derivative is exact, (and holds|but only for relative changes of the control below {NUMBER})"
)
ALIKE = 0.05  # of the macroscopic slope
WRONG = 0.5  # a derivative that far off is of no use to anyone
# Viscosity (Pa s, with Young's modulus a relaxation time of 0 and 1e-4 s), Courant number, elements.
FLAT = [(viscosity, courant, elements) for viscosity in (0, 0.1) for courant in (1, 0.7)
        for elements in ((40, 80, 160) if courant == 1 and not viscosity else (40, 80))]  # fmt: skip


def off(scene: Path, scheme: str, viscosity: float, **overrides: object) -> float:
    """How far the derivative is off the macroscopic slope. The check succeeds, and its verdict says whether that is far."""
    viscous = {"material__viscosity": {"bulk": viscosity, "shear": viscosity}} if viscosity else {}
    done = attempt("check", scene, **SCHEMES[scheme], **viscous, **overrides)
    found = SAID.search(done.stdout)
    assert found, done.stdout[-300:] + done.stderr
    radius, derivative, changes, slope = (float(value) for value in found.groups()[:4])
    off = abs(derivative - slope) / np.maximum(abs(derivative), abs(slope))
    print(f"derivative {derivative:.3e}, macroscopic {slope:.3e}, {100 * off:.1f} % off, sets kept within {radius:.0e}, "
          f"{changes:.0f} changes in 0.1")  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert (found.group(5) == "and holds") == (off <= ALIKE), "the verdict"
    return off


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, float, float, int], float]:
    """off() of the bar, by scheme, viscosity, Courant number and elements; each check is run once."""

    @functools.cache
    def of_bar(scheme: str, viscosity: float, courant: float, elements: int) -> float:
        scene = tmp_path_factory.mktemp("bar") / "bar.toml"
        size = 10 / elements
        step = courant * size / 30
        scene.write_text(BAR.format(meshes=SOURCE / "meshes", size=size, step=step, end=round(1 / step) * step))
        return off(scene, scheme, viscosity)

    return of_bar


@pytest.mark.parametrize("viscosity, courant, elements", FLAT, ids=["{} Pa s, Courant {}, {} elements".format(*case) for case in FLAT])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_flat_face(flat: Callable, scheme: str, viscosity: float, courant: float, elements: int) -> None:
    found = flat(scheme, viscosity, courant, elements)
    assert scheme == "contact-implicit" or found <= ALIKE


def test_flat_face_is_a_hard_case(flat: Callable) -> None:
    useless = sum(flat("contact-implicit", *case) > WRONG for case in FLAT)
    print(f"{useless} contact-implicit derivatives off by more than {100 * WRONG:.0f} %")
    assert useless > 0


@pytest.mark.parametrize("size", (1, 0.5), ids="size {}".format)
@pytest.mark.parametrize("viscosity", (0, 100), ids="{} Pa s".format)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_round_face(scheme: str, viscosity: float, size: float, tmp_path: Path) -> None:
    scene = tmp_path / "half-disc.toml"
    scene.write_text(re.sub(r"viscosity = .*\n", "", HALF_DISC.read_text()).replace("../meshes", str(SOURCE / "meshes")))
    assert off(scene, scheme, viscosity, mesh__size=size, time__step=size * 1e-4) <= ALIKE
