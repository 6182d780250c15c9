# SPDX-License-Identifier: GPL-3.0-or-later
"""Impacts that press a solver: at half the wave speed, of a flat face in one step, without a clamp, on doubled obstacles."""

import functools
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from exact_bar import IMPACT, LENGTH, WAVE, read
from harness import SOURCE, attempt, stored, table
from schemes import SCHEMES, energy, run

SOLVERS = {**SCHEMES, "full VI": {"solver__vi": "full"}, "conjugate gradients": {"solver__linear": "iterative"}}
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
DOUBLED = {"twice the same plane": PLACE, "a plane 5 mm below": PLACE - 5e-3}


@pytest.mark.parametrize("solver", SOLVERS)
def test_impact_at_half_the_wave_speed(solver: str, tmp_path: Path) -> None:
    """B2 at c/2 = 15 m/s in place of 10 m/s: all is linear in the speed but the time of flight. The force is ρ c v = 450 N/m²,
    the contact lasts 2 L/c, and a strain of 1/2 does not matter to small strain."""
    speed, elements = WAVE / 2, 80
    start = 5 / speed
    end = start + 2 / 3
    step = LENGTH / elements / WAVE
    count = round(1.5 / step)
    steps = run(SOURCE / "scenes" / "bar-impact.toml", tmp_path, time__step=step, time__end=count * step, output__every=count,
                initial__velocity=["0", f"-{speed}"], mesh__size=LENGTH / elements, **SOLVERS[solver])  # fmt: skip
    motion = read(replace(IMPACT, contacts=((start, end),), impulse=300), tmp_path, elements, step)
    force, time = motion.force, motion.time
    pushed = np.flatnonzero(force > 0)
    assert len(pushed) > elements, "hardly any contact: the case says nothing"
    inside = (time[1:-1] > start + 0.05) & (time[1:-1] < start + 0.6)
    # As in bar.py: a half pair of alternating forces, none above twice the mean, is cut at either end of the window.
    off = abs(motion.two_step_force()[inside].mean() / (WAVE * speed) - 1)
    early, later = time[pushed[0] - 1] - start, time[pushed[-1]] - end
    late = float(motion.delay(end))
    impulse = step * force.sum() / (2 * LENGTH * speed) - 1
    total = energy(steps) / energy(steps)[0]
    print(f"{len(pushed)} steps in contact; contact off by {early:+.4f} (<= {step:.4f}) and {later:+.4f} s (<= {late:.4f}), mean force by "
          f"{off:.1e} (<= {step / 0.55:.1e}), impulse by {impulse:+.1e} (<= {late / (2 / 3):.1e}); energy lost {1 - total[-1]:.1e} "
          f"<= {1 / elements:.1e}")  # fmt: skip
    assert abs(early) <= 1.001 * step
    assert abs(later) <= late
    assert off <= step / 0.55
    assert abs(impulse) <= late / (2 / 3)
    assert 1 - total[-1] <= 1 / elements
    assert np.diff(total).max() <= 1e-10, "energy rises"


def rounding(solver: str) -> float:
    """Conjugate gradients leave 1e-12 of the motion in each of 240 steps; the other solvers rounding, 1e-14."""
    return 240 * (1e-12 if solver == "conjugate gradients" else 1e-14)


def block(folder: Path, solver: str, *heights: float) -> Path:
    """A square thrown flatly at planes: its lower side has all candidates, its others ten edges each."""
    mesh, scene = folder / "block.geo", folder / "block.toml"
    square = (SOURCE / "tests" / "data" / "square.geo").read_text()
    mesh.write_text(square + f"Transfinite Curve{{1}} = {CANDIDATES};\nTransfinite Curve{{2, 3, 4}} = 11;\n")
    mass = 'mass = "massless"\n' if solver == "massless" else ""
    contact = "".join(PLANE.format(height=height) + mass for height in heights)
    scene.write_text(BLOCK.format(mesh=mesh, step=STEP, contact=contact))
    return scene


def given(solver: str) -> dict:
    """The overrides of a block's run; a massless one has its key in the scene."""
    return {} if solver == "massless" else SOLVERS[solver]


def momentum(out: Path, which: int) -> np.ndarray:
    """Momentum of the whole body (N s/m): linear triangles have the mean of their corners' velocities."""
    nodes, cells, velocity = stored(out, "state", "velocity")
    a, b, c = (nodes[cells[:, i], :2] for i in range(3))
    areas = abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return areas @ velocity[which][cells].mean(axis=1)[:, :2]


@dataclass(frozen=True)
class Throw:
    """A block thrown at one plane."""

    scene: Path
    steps: dict[str, np.ndarray]
    contact: dict[str, np.ndarray]
    momentum: np.ndarray  # its change from the start to the end


@pytest.fixture(scope="module")
def thrown(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Throw]:
    """The throws by solver; each motion is computed once."""

    @functools.cache
    def found(solver: str) -> Throw:
        folder = tmp_path_factory.mktemp("block")
        scene, out = block(folder, solver, PLACE), folder / "out"
        steps = run(scene, out, output__every=1, output__fields=["velocity"], **given(solver))
        assert (steps["contact_force_y"] > 0).sum() > 10, "hardly any contact: the case says nothing"
        return Throw(scene, steps, table(out / "contact.csv"), momentum(out, -1) - momentum(out, 0))

    return found


@pytest.mark.parametrize("solver", SOLVERS)
def test_free_block(thrown: Callable, solver: str) -> None:
    """Its whole face touches in one step, and it flies off again: contact's impulse is the change of its momentum, and energy only
    ever goes."""
    throw, small = thrown(solver), rounding(solver)
    steps, contact = throw.steps, throw.contact
    touched = np.flatnonzero(steps["contact_force_y"] > 0)
    first = contact["step"] == touched[0]
    at_once, candidates = int((contact["force"][first] > 0).sum()), int(first.sum())
    assert candidates >= CANDIDATES and at_once > CANDIDATES / 2
    e = energy(steps)
    impulse = STEP * np.array([steps[f"contact_force_{axis}"].sum() for axis in "xy"])
    if solver == "massless":  # whose momentum has no part of the contact's velocity: the program's own law, beyond rounding, stands for it
        off = float(re.search(r"momentum law.*?(\d\.\d+e[+-]\d+)", attempt("check", throw.scene, **given(solver)).stdout)[1])
    else:
        off = abs(throw.momentum - impulse).max() / impulse[1]
    rise = np.maximum(0, np.diff(e).max()) / e[0]
    speed = impulse[1] - 1  # of the centre, whose mass is 1 kg/m and whose speed was -1 m/s
    print(f"{at_once} of {candidates} candidates touch in one step, {len(touched)} steps in contact; momentum law to {off:.0e}, rise of "
          f"energy {rise:.0e} (each <= {small:.0e}), lost {1 - e[-1] / e[0]:.4f}; flies off at {speed:.3f} m/s")  # fmt: skip
    assert off <= small, "the momentum law"
    assert rise <= small, "energy rises"
    assert 0 < speed <= 1, "the speed of the throw would be all of the energy"
    assert steps["min_gap"][-1] > 0


@pytest.mark.parametrize("case", DOUBLED)
@pytest.mark.parametrize("solver", [solver for solver in SOLVERS if solver != "full VI"])  # which takes one obstacle per node
def test_second_plane_changes_nothing(thrown: Callable, solver: str, case: str, tmp_path: Path) -> None:
    """Whether at the same place or below: the forces of the two are not unique, but their sum is."""
    single, small = thrown(solver).steps, rounding(solver)
    steps = run(block(tmp_path, solver, PLACE, DOUBLED[case]), tmp_path / "out", output__every=1, **given(solver))
    contact = table(tmp_path / "out" / "contact.csv")
    lower = contact["force"][contact["obstacle"] == "obstacle 2"].sum() / contact["force"].sum()
    apart = abs(steps["contact_force_y"] - single["contact_force_y"]).max() / single["contact_force_y"].max()
    energies = abs(energy(steps) - energy(single)).max() / energy(single)[0]
    pull = np.maximum(0, -contact["force"].min()) / contact["force"].max()
    print(f"{(steps['contact_force_y'] > 0).sum()} steps in contact; resultant off by {apart:.0e}, energy by {energies:.0e} (each <= "
          f"{small:.0e}); the second carries {lower:.2f} of it, adhesion {pull:.0e} <= 1e-10")  # fmt: skip
    assert apart <= small and energies <= small
    assert pull <= 1e-10 and contact["gap"].min() >= -1e-10  # as in `check`
