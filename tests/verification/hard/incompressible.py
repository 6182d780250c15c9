# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearly incompressible bodies: ν = 0.49, 0.499, 0.4999. Solvers converge, energy stays bounded, and degree 1 locks.

Hertz's half-width a = 2 √(P R (1 - ν²) / π E) hardly depends on ν there. Linear triangles of such a body can hardly
deform at all, and their contact stays too narrow, the more the nearer ν is to 1/2; quadratic ones have the motions that keep
their volume, and hold the tolerance of ../hertz.py at every ν, whose element is the distance between nodes.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
import hertz  # noqa: E402
from harness import SOURCE, signorini  # noqa: E402
from table import SCHEMES, Table, energy, run  # noqa: E402

import numpy as np  # noqa: E402

NUMBERS = (0.49, 0.499, 0.4999)
YOUNG = 200.0


def half_width(nu: float, size: float, degree: int, folder: Path, **overrides: object) -> tuple[float, float, int]:
    """Of the press at rest: found, relative to Hertz's; that one; nodes in contact."""
    out = folder / "out"
    viscosity = {"bulk": YOUNG / (3 * (1 - 2 * nu)), "shear": YOUNG / (2 * (1 + nu))}  # the moduli times 1 s, as in the scene
    signorini("simulate", SOURCE / "scenes" / "hertz-press.toml", out, mesh__file=str(hertz.mesh(size, folder)), mesh__degree=degree,
              material__poisson=nu, material__viscosity=viscosity, output__fields=[], output__every=1, **overrides)  # fmt: skip
    x, _, force = hertz.pressure(out)
    load = force.sum()
    found = 2 * np.sqrt(((x - (x * force).sum() / load) ** 2 * force).sum() / load)
    exact = 2 * np.sqrt(load * hertz.RADIUS * (1 - nu**2) / (np.pi * YOUNG))
    return found / exact, exact, int((force > 0).sum())


def locking(folder: Path, table: Table) -> None:
    widths = []
    for nu in NUMBERS:
        coarse, fine = (half_width(nu, size, 1, folder)[0] for size in hertz.SIZES)
        quadratic, exact, nodes = half_width(nu, hertz.SIZES[0], 2, folder)
        tolerance = hertz.HERTZ + (hertz.SIZES[0] / 2 / exact) ** 2
        widths.append(coarse)
        table.row(f"H1 at nu = {nu}, degree 2", f"{nodes} nodes in contact; half-width over Hertz's {quadratic:.4f} (+- {tolerance:.4f})",
                  nodes > 10 and abs(quadratic - 1) <= tolerance)  # fmt: skip
        # Locked: narrower than the tolerance of a mesh that is not, and less so with shorter elements.
        table.row(f"H1 at nu = {nu}, degree 1 locks", f"half-width over Hertz's {coarse:.4f}, with elements half as long {fine:.4f}",
                  coarse < 1 - tolerance and coarse < fine < 1)  # fmt: skip
    table.row("H1, degree 1 locks the more, the nearer nu is to 1/2", " ".join(f"{width:.4f}" for width in widths),
              bool((np.diff(widths) < 0).all()))  # fmt: skip


TOUCH, STEP, FALL = 10.0, 0.02, 5.0  # s, s, m
WAYS = {**SCHEMES, "conjugate gradients": {"solver__linear": "iterative"}}


def drops(folder: Path, table: Table) -> None:
    """The disc of D1, without viscosity, to 30 s: beyond the rebound."""
    for nu in NUMBERS:
        for degree in (1, 2):
            for way, overrides in WAYS.items():
                steps, _ = run("simulate", SOURCE / "scenes" / "disc-drop.toml", folder / "out", mesh__size=4, mesh__degree=degree,
                               time__step=STEP, time__end=30, material__poisson=nu, output__every=1500,
                               **({"solver__linear": "direct"} | overrides))  # fmt: skip
                total = energy(steps) - np.cumsum(steps["external_work"])
                impact = steps["kinetic_energy"][round(TOUCH / STEP)]
                touched = int((steps["contact_force_y"] > 0).sum())
                rise, off = np.maximum(0, np.diff(total).max()) / impact, abs(steps["energy_residual"]).max() / impact
                # The elastic forces of a displacement cancel where it is rigid, but for eps y|A|y: a few of 1e-16 (5 m)² K of
                # each of some 1000 unknowns over the impact's 630 J, with K = E / 3 (1 - 2 nu) of E = 50 Pa.
                rounding = 1e-13 / (1 - 2 * nu)
                # Conjugate gradients leave 1e-12 of the displacement, in the velocity, of 1 m/s, 2/τ times that.
                allowed = rounding + (2 * 2 / STEP * 1e-12 * FALL if way == "conjugate gradients" else 0)
                table.row(f"D1 at nu = {nu}, degree {degree}, {way}",
                          f"{touched} steps in contact; energy law to {off:.0e}, largest rise {rise:.0e} (<= {allowed:.0e}), lost "
                          f"{-total[-1] / impact:.4f} of the impact's", touched > 100 and np.maximum(rise, off) <= allowed)  # fmt: skip


def main() -> int:
    table = Table("incompressible")
    with tempfile.TemporaryDirectory() as folder:
        locking(Path(folder), table)
        drops(Path(folder), table)
    return 1 if table.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
