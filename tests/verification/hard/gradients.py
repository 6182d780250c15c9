# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradients without and with little viscosity: the derivative beside the slope over a tenth of the control, which is what an
optimizer and an experiment see.

The flat face is the lower end of a bar without lateral contraction (bar_impact's), that hits the plane with all its nodes at
once and leaves again; a force along the bar, constant in time, is to change where it is then. There an exact derivative of
the contact-implicit scheme can have the wrong sign, since its contact chatters: that is shown, not allowed away. The round
one is the half disc. What is asserted: every derivative is exact (Taylor order 2, or where sets are kept in too small a
neighbourhood for that, the difference quotient within it); massless and contact-stabilized steps see the macroscopic slope
within 5 %; and the verdict names what is found.
"""

import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from table import SCHEMES, Table

from harness import HALF_DISC, SOURCE, attempt

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
    rf"stay the same within {NUMBER} of the control.*\nThe derivative along d is {NUMBER}; over .* with (\d+) changes .* slope {NUMBER}\.\n"
    rf"Verdict: exact, (and what|but valid only within {NUMBER})"
)
ALIKE = 0.05  # of the macroscopic slope
WRONG = 0.5  # a derivative that far off is of no use to anyone


def judged(scene: Path, over: dict) -> tuple[float, float, str, bool]:
    """How far the derivative is off the macroscopic slope, the invariance radius, all figures, and whether the check holds."""
    done = attempt("check", scene, **over)
    found = SAID.search(done.stdout)
    if not found:
        return float("nan"), 0, done.stdout[-300:] + done.stderr, False
    radius, derivative, changes, slope = (float(value) for value in found.groups()[:4])
    off = abs(derivative - slope) / np.maximum(abs(derivative), abs(slope))
    useful = found.group(5) == "and what"
    text = f"{derivative:10.3e}, macroscopic {slope:10.3e}, {100 * off:5.1f} % off, sets kept within {radius:.0e}, {changes:.0f} changes in 0.1"
    return off, radius, text, done.returncode == 0 and useful == (off <= ALIKE)


def main() -> int:
    lines = Table("gradients")
    useless = 0
    with tempfile.TemporaryDirectory() as name:
        scene = Path(name) / "bar.toml"
        for viscosity in (0, 0.1):  # Pa s, with Young's modulus a relaxation time of 0 and 1e-4 s
            for courant in (1, 0.7):
                for elements in (40, 80, 160) if courant == 1 and not viscosity else (40, 80):
                    size = 10 / elements
                    step = courant * size / 30
                    scene.write_text(BAR.format(meshes=SOURCE / "meshes", size=size, step=step, end=round(1 / step) * step))
                    for scheme, over in SCHEMES.items():
                        if viscosity:
                            over = over | {"material__viscosity": {"bulk": viscosity, "shear": viscosity}}
                        off, _, text, holds = judged(scene, over)
                        useless += off > WRONG
                        lines.row(f"flat, {scheme}, {viscosity} Pa s, Courant {courant}, {elements} elements", text,
                                  holds and (scheme == "contact-implicit" or off <= ALIKE))  # fmt: skip
        lines.row("flat, contact-implicit: the case is a hard one", f"{useless} derivatives off by more than {100 * WRONG:.0f} %", useless > 0)
        scene.write_text(re.sub(r"viscosity = .*\n", "", HALF_DISC.read_text()).replace("../meshes", str(SOURCE / "meshes")))
        for viscosity in (0, 100):
            for size in (1, 0.5):
                for scheme, over in SCHEMES.items():
                    if viscosity:
                        over = over | {"material__viscosity": {"bulk": viscosity, "shear": viscosity}}
                    off, _, text, holds = judged(scene, over | {"mesh__size": size, "time__step": size * 1e-4})
                    lines.row(f"round, {scheme}, {viscosity} Pa s, size {size}", text, holds and off <= ALIKE)
    return 1 if lines.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
