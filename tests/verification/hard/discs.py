# SPDX-License-Identifier: GPL-3.0-or-later
"""D1, H1 and P1 by all schemes: a disc that falls, Hertz's contact, and uniform pressure.

../disc_drop.py and ../hertz.py derive the tolerances of the first two. At rest no scheme knows of mass: the equilibrium
A y = f + F is the fixed point of each, and the pressures must be the same to what is left of the motion.
"""

import contextlib
import io
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
import disc_drop  # noqa: E402
import hertz  # noqa: E402
from harness import boundary, signorini, stored  # noqa: E402
from harness import table as read  # noqa: E402
from patch_scene import PRESSURE, patch  # noqa: E402
from table import SCHEMES, Table, Worst, energy, run  # noqa: E402

import numpy as np  # noqa: E402


def quietly(function, *arguments, **overrides):  # noqa: ANN001, ANN002, ANN003, ANN201
    with contextlib.redirect_stdout(io.StringIO()):
        return function(*arguments, **overrides)


def drops(folder: Path, table: Table) -> None:
    """Energy may rise by rounding only, in each single step of 40 s."""
    for scheme, overrides in SCHEMES.items():
        lost = {}
        for size in (4.0, 2.0):
            worst, out = Worst(), folder / "out"
            # Without mass a contact node keeps its weight f h/2, hangs by f h²/2E below its body, and as trapezoidal
            # steps let what has no mass alternate about its equilibrium, by up to twice that.
            sag = disc_drop.ACCELERATION * size**2 / 50 if scheme == "massless" else 0
            lost[size], _ = quietly(disc_drop.drop, size, out, worst, sag, output__fields=[], **overrides)
            steps = read(out / "steps.csv")
            total = energy(steps) - np.cumsum(steps["external_work"])
            impact = steps["kinetic_energy"][round(disc_drop.TOUCH / disc_drop.SIZES[size])]
            rise = np.maximum(0, np.diff(total).max()) / impact
            table.row(f"D1, {scheme}, elements of {size:g} m",
                      f"{(steps['contact_force_y'] > 0).sum()} steps in contact; {worst}; largest rise of energy {rise:.0e}, lost "
                      f"{lost[size]:.1e} of the impact's", not worst.failed)  # fmt: skip


def presses(folder: Path, table: Table) -> None:
    at_rest = {}
    for scheme, overrides in SCHEMES.items():
        errors, worsts = [], []
        for size in hertz.SIZES:
            worsts.append(Worst())
            errors.append(quietly(hertz.press, size, "traction", folder, worsts[-1], output__fields=[], **overrides))
            force = hertz.pressure(folder / "out")[2]
            first = at_rest.setdefault(size, force)
            # The motion lives in each run by e^-10, of the whole load, and they differ by no more than both.
            apart = abs(force - first).sum() / first.sum()
            holds = not worsts[-1].failed and apart <= 2 * hertz.REST
            table.row(f"H1, {scheme}, elements of {size:g} m",
                      f"{(force > 0).sum()} nodes in contact; {worsts[-1]}; profile off by {errors[-1]:.4f}, from contact-implicit "
                      f"{apart:.0e}", holds)  # fmt: skip
        # First order in the element, but for what Hertz leaves out.
        table.row(f"H1, {scheme}, profile under refinement", f"{errors[0]:.4f} {errors[1]:.4f}",
                  errors[1] <= errors[0] / 2 + hertz.HERTZ)  # fmt: skip


def shares(out: Path, x: np.ndarray, degree: int) -> np.ndarray:
    """What of the lower side each node stands for, the integral of its shape function (m, in space m²)."""
    if x.shape[1] == 1:
        ends = np.sort(x[:, 0])[::degree]
        lengths = np.diff(ends)
        found = np.zeros(len(x))
        for i, length in enumerate(lengths):
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


def patches(folder: Path, table: Table) -> None:
    """The uniform pressure of the patch test, by every scheme."""
    rounding = 1e-11  # 2000 steps, each to about 1e-14, and what is left of the motion
    out = folder / "out"
    for name, dim, size, degree in (("plane", 2, 0.1, 1), ("plane, degree 2", 2, 0.2, 2), ("space", 3, 0.3, 1)):
        scene = folder / "patch.toml"
        scene.write_text(patch(dim, size, 5e-3, degree))
        for scheme, overrides in SCHEMES.items():
            signorini("simulate", scene, out, output__every=1999, **overrides)
            contact = read(out / "contact.csv")
            last = contact["step"][-1]
            now = contact["step"] == last
            x = np.array([contact[axis][now] for axis in "xy"[: dim - 1]]).T
            force = (contact["force"][now] + contact["force"][contact["step"] == last - 1]) / 2
            assert (force > 0).all(), "not all of the lower side is in contact: the case says nothing"
            p = force / shares(out, x, degree)
            off = abs(p / PRESSURE - 1).max()
            table.row(f"P1, {name}, {scheme}", f"{len(p)} nodes in contact, pressure {p.mean():.6f} N/m², off by {off:.0e} at most",
                      off <= rounding)  # fmt: skip


def main() -> int:
    table = Table("discs")
    with tempfile.TemporaryDirectory() as folder:
        drops(Path(folder), table)
        presses(Path(folder), table)
        patches(Path(folder), table)
    return 1 if table.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
