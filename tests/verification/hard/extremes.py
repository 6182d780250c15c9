# SPDX-License-Identifier: GPL-3.0-or-later
"""Impacts that press a solver: at half the wave speed, of a flat face in one step, without a clamp, on doubled obstacles."""

import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
import bar  # noqa: E402
from harness import SOURCE, attempt, stored  # noqa: E402
from harness import table as read  # noqa: E402
from table import SCHEMES, Table, energy, run  # noqa: E402

import numpy as np  # noqa: E402

WAYS = {**SCHEMES, "full VI": {"solver__vi": "full"}, "conjugate gradients": {"solver__linear": "iterative"}}


def fast(folder: Path, table: Table) -> None:
    """B2 at c/2 = 15 m/s in place of 10 m/s: all is linear in the speed but the time of flight. The force is ρ c v = 450 N/m²,
    the contact lasts 2 L/c, and a strain of 1/2 is no matter to small strain."""
    speed, elements = bar.WAVE / 2, 80
    start = 5 / speed
    step = bar.LENGTH / elements / bar.WAVE
    count = round(1.5 / step)
    for way, overrides in WAYS.items():
        steps, _ = run("simulate", SOURCE / "scenes" / "bar-impact.toml", folder / "out", time__step=step, time__end=count * step,
                       output__every=count, initial__velocity=["0", f"-{speed}"], mesh__size=bar.LENGTH / elements, **overrides)  # fmt: skip
        motion = bar.read(replace(bar.IMPACT, contacts=[(start, start + 2 / 3)], impulse=300), folder / "out", elements, step)
        force, time = motion.force, motion.time
        pushed = np.flatnonzero(force > 0)
        assert len(pushed) > elements, "hardly any contact: the case says nothing"
        inside = (time[1:-1] > start + 0.05) & (time[1:-1] < start + 0.6)
        # As in bar.py: a half pair of alternating forces, none above twice the mean, is cut at either end of the window.
        off = abs(motion.two_step_force()[inside].mean() / (bar.WAVE * speed) - 1)
        begin, end = time[pushed[0] - 1] - start, time[pushed[-1]] - start - 2 / 3
        late = float(motion.delay(start + 2 / 3))
        impulse = step * force.sum() / (2 * bar.LENGTH * speed) - 1
        total = energy(steps) / energy(steps)[0]
        holds = (abs(begin) <= 1.001 * step and abs(end) <= late and off <= step / 0.55 and abs(impulse) <= late / (2 / 3)
                 and 1 - total[-1] <= 1 / elements and np.diff(total).max() <= 1e-10)  # fmt: skip
        table.row(f"impact at half the wave speed, {way}",
                  f"{len(pushed)} steps in contact; contact off by {begin:+.4f} and {end:+.4f} s (<= {late:.4f}), mean force by {off:.1e}, "
                  f"impulse by {impulse:+.1e}; energy lost {1 - total[-1]:.1e}", bool(holds))  # fmt: skip


BLOCK = """
[mesh]
file = "{mesh}"
[time]
end = 0.6
step = {step}
[material]
density = 1.0
young = 50.0
poisson = 0.3
{contact}
[initial]
velocity = ["0", "-1"]
"""
PLANE = """[[contact]]
on = "bottom"
obstacle = {{ shape = "half-space", point = [0, {height}], normal = [0, 1] }}
"""
CANDIDATES, STEP = 200, 2.5e-3


PLACE = -0.1013  # m: 40.52 steps away, so that the impact falls between two


def block(folder: Path, heights: tuple[float, ...], massless: bool) -> Path:
    """A square thrown flatly at planes: its lower side has all candidates, its others ten edges each."""
    mesh, scene = folder / "block.geo", folder / "block.toml"
    square = (SOURCE / "tests" / "data" / "square.geo").read_text()
    mesh.write_text(square + f"Transfinite Curve{{1}} = {CANDIDATES};\nTransfinite Curve{{2, 3, 4}} = 11;\n")
    mass = 'mass = "massless"\n' if massless else ""
    contact = "".join(PLANE.format(height=height) + mass for height in heights)
    scene.write_text(BLOCK.format(mesh=mesh, step=STEP, contact=contact))
    return scene


def momentum(out: Path, which: int) -> np.ndarray:
    """Of the whole body (N s/m): linear triangles have the mean of their corners' velocities."""
    nodes, cells, velocity = stored(out, "state", "velocity")
    a, b, c = (nodes[cells[:, i], :2] for i in range(3))
    areas = abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return areas @ velocity[which][cells].mean(axis=1)[:, :2]


def thrown(folder: Path, table: Table) -> None:
    """A free block, all of whose face touches in one step, and which flies off again: contact's impulse is the change of its
    momentum, and energy only ever goes. A second plane at the same place, or one below, changes nothing: forces of the two
    are not unique, but their sum is."""
    out = folder / "out"
    for way, given in WAYS.items():
        massless = "contact__mass" in given
        overrides = {} if massless else given
        # Conjugate gradients leave 1e-12 of the motion in each of 240 steps; the others rounding, 1e-14.
        small = 240 * (1e-12 if way == "conjugate gradients" else 1e-14)
        scene = block(folder, (PLACE,), massless)
        single, record = run("simulate", scene, out, output__every=1, output__fields=["velocity"], **overrides)
        contact = read(out / "contact.csv")
        touched = np.flatnonzero(single["contact_force_y"] > 0)
        assert len(touched) > 10, "hardly any contact: the case says nothing"
        first = contact["step"] == touched[0]
        at_once, candidates = int((contact["force"][first] > 0).sum()), int(first.sum())
        assert candidates >= CANDIDATES and at_once > CANDIDATES / 2, f"{at_once} of {candidates} candidates at once"
        e = energy(single)
        impulse = STEP * np.array([single[f"contact_force_{axis}"].sum() for axis in "xy"])
        change = momentum(out, -1) - momentum(out, 0)
        off = abs(change - impulse).max() / impulse[1]
        rise = np.maximum(0, np.diff(e).max()) / e[0]
        speed = impulse[1] - 1  # of the centre, whose mass is 1 kg/m and whose speed was -1 m/s
        # Without mass at the contact its velocity is no part of the momentum, and the program's own law stands for it.
        law = re.search(r"momentum law.*?(\d\.\d+e[+-]\d+)", attempt("check", scene, **overrides).stdout)
        off = float(law[1]) if massless else off
        # It leaves at no more than the speed of the throw, which would be all of the energy.
        table.row(f"free block, {candidates} candidates, {way}",
                  f"{at_once} touch in one step, {len(touched)} steps in contact; momentum law to {off:.0e}, rise of energy {rise:.0e}, "
                  f"lost {1 - e[-1] / e[0]:.4f}; flies off at {speed:.3f} m/s",
                      off <= small and rise <= small and 0 < speed <= 1 and single["min_gap"][-1] > 0)  # fmt: skip
        if way == "full VI":  # takes one obstacle per node
            continue
        for title, other in (("twice the same plane", PLACE), ("a plane 5 mm below", PLACE - 5e-3)):
            steps, _ = run("simulate", block(folder, (PLACE, other), massless), out, output__every=1, **overrides)
            contact = read(out / "contact.csv")
            lower = contact["force"][contact["obstacle"] == "obstacle 2"].sum() / contact["force"].sum()
            apart = abs(steps["contact_force_y"] - single["contact_force_y"]).max() / single["contact_force_y"].max()
            energies = abs(energy(steps) - e).max() / e[0]
            pull = np.maximum(0, -contact["force"].min()) / contact["force"].max()
            # Gaps and pulls as in `check`.
            holds = apart <= small and energies <= small and pull <= 1e-10 and contact["gap"].min() >= -1e-10
            table.row(f"free block on {title}, {way}",
                      f"{(steps['contact_force_y'] > 0).sum()} steps in contact; resultant off by {apart:.0e}, energy by {energies:.0e}; the "
                      f"second carries {lower:.2f} of it, adhesion {pull:.0e}", holds)  # fmt: skip


def main() -> int:
    table = Table("extremes")
    with tempfile.TemporaryDirectory() as folder:
        fast(Path(folder), table)
        thrown(Path(folder), table)
    return 1 if table.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
