# SPDX-License-Identifier: GPL-3.0-or-later
"""D1: an elastic disc falls on a plane. The fall is a parabola until the touch, and energy only ever goes.

How fast the disc flies off, and how much of it rings instead, nobody knows in closed form; but no faster than the energy allows,
and as fast on the next finer mesh, and with massless contact, which loses no energy, but for a difference that vanishes.

What the contact condition takes is the kinetic energy of the nodes that come to rest on the plane, a layer of the body as
thick as an element: it vanishes with the element size, at order 1.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, Figures, signorini, table  # noqa: E402

import numpy as np  # noqa: E402

TOUCH, ACCELERATION = 10.0, 0.1  # s, m/s²
WAVE = 60**0.5  # m/s, of pressure
SIZES = {4.0: 0.02, 2.0: 0.01, 1.0: 0.005}  # m, and the step in proportion, s: as shipped in the middle
END = 40.0


def drop(size: float, out: Path, figures: Figures, sag: float = 0, **overrides: object) -> tuple[float, float]:
    """Runs the scene, shows its figures and returns the part of the impact's energy that is lost until the end, and the speed of
    the rebound (m/s), from the impulses of contact and gravity. Contact nodes
    that fall otherwise than their body may be off by `sag` (m), with waves that cross an element; two steps, because without
    mass they may alternate."""
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
    parabola = 5 - ACCELERATION / 2 * time[: falling + 1] ** 2
    print(f"elements of {size:g} m, step {step:g} s:")
    # Steps are exact for a parabola; 1e-14 of the fall's height in each of up to 2000 of them.
    figures.show("fall: error of the gap, m", abs(gap[: falling + 1] - parabola).max(), 0, 1e-10 + sag)
    figures.show("first force, s", time[pushed[0]], TOUCH, 1.001 * step + sag)
    figures.show("speed of the two steps before, m/s", (gap[falling - 2] - gap[falling]) / (2 * step), 1,
                 1.001 * ACCELERATION * step + sag * WAVE / size)  # fmt: skip
    # Sums of the works of up to 8000 steps.
    figures.show("largest rise of energy / of the impact", np.maximum(0, np.diff(energy).max()) / impact, 0, 1e-11)
    mass = 2 * impact  # at 1 m/s
    left = pushed[-1]
    rebound = step * force.sum() / mass - ACCELERATION * time[left]
    lost = -energy[-1] / impact
    figures.least("rebound, m/s, within the energy left", np.sqrt(1 - lost), rebound)
    print(f"       last force at {time[left]:.2f} s")
    return lost, rebound


def main() -> int:
    figures = Figures()
    with tempfile.TemporaryDirectory() as folder:
        dropped = {size: drop(size, Path(folder) / "out", figures) for size in SIZES}
        print("massless:")
        middle = list(SIZES)[1]
        # Gravity moves a contact node by this against its body, see hard/discs.py.
        _, massless = drop(middle, Path(folder) / "out", figures, ACCELERATION * middle**2 / 50, contact__mass="massless")
    losses = {size: lost for size, (lost, _) in dropped.items()}
    coarse, shipped, fine = (rebound for _, rebound in dropped.values())
    print(f"rebound, m/s: {coarse:.5f}, {shipped:.5f}, {fine:.5f}; massless {massless:.5f} at {middle:g} m")
    # Of order 1 each difference is half of the one before, and what is left as large as the last.
    figures.show("rebound: last difference, of the one before", abs(fine - shipped) / abs(shipped - coarse), 0, 0.5)
    figures.show("rebound, massless beside the default, m/s", massless, shipped, abs(shipped - coarse))
    print("energy lost, of the impact's:", ", ".join(f"{loss:.5f} at {size:g} m" for size, loss in losses.items()))
    order = float(np.polyfit(np.log(list(losses)), np.log(list(losses.values())), 1)[0])
    # Which nodes come to rest when is accidental; halfway to order 1/2, at which a layer of √h would be lost.
    figures.least("order of the energy lost, 1 expected", order, 0.75)
    return 1 if figures.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
