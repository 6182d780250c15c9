# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps that the motion chooses: cases in which a longer look back would be too late, figures that nothing may change, and
orders of an accuracy that must not be called met.

Each case is compared with steps of one length that need not be chosen, or with an exact figure. chosen_steps_frames.py tests the
choice itself.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, captured, grids, signorini, table, toml
from soft_scenes import soft

BALL, RING = SOURCE / "scenes" / "drop-ball.toml", SOURCE / "scenes" / "drop-ring.toml"
DATA = SOURCE / "tests" / "data"


def run(scene: Path, out: Path, **overrides: object) -> dict:
    signorini("simulate", scene, out, **({"output__fields": [], "output__tables": ["steps", "probes"]} | overrides))
    return json.loads((out / "run.json").read_text())


@dataclass
class Near:
    """An impact at the start of a run."""

    scene: Path
    given: dict[str, object]
    time: dict[str, object]
    end: float  # s, of the run in chosen steps
    fine_end: float  # s, of that in steps of one length
    tolerances: tuple[float, ...]


FORCE = {"quantity": "contact-force", "scheme": "contact-stabilized"}
RING_NEAR = {"initial": {"velocity": ["0", "-1.98"]}, "contact__obstacle__point": [0, -0.101]}
BALL_NEAR = {"initial": {"velocity": ["0", "0", "-1.98"]}, "contact__obstacle__point": [0, 0, -0.0201], "mesh__size": 8e-3}
NEAR = {"ball": Near(BALL, BALL_NEAR, FORCE, 0.2, 2e-3, (1e-2,)), "ring": Near(RING, RING_NEAR, FORCE, 0.08, 0.08, (1e-2, 1e-3))}


@pytest.mark.parametrize("case", NEAR.values(), ids=NEAR)
def test_near_at_the_start(case: Near, tmp_path: Path) -> None:
    """Impacts within the first two steps, of whatever length: as with steps of one length, eight in the time t_w."""
    chosen_times = {tolerance: {"end": case.end, "step": "auto", "tolerance": tolerance} | case.time for tolerance in case.tolerances}
    found = {tolerance: run(case.scene, tmp_path / "chosen", **case.given, time=time) for tolerance, time in chosen_times.items()}
    steps = int(np.ceil(case.fine_end / (found[case.tolerances[0]]["steps"]["wave_time"] / 8)))
    time = {"end": case.fine_end, "step": case.fine_end / steps, "scheme": case.time["scheme"]}
    fine = run(case.scene, tmp_path / "fine", **case.given, time=time)["impact"]["all"]
    for tolerance, chosen in found.items():
        touch, energy = chosen["impact"]["all"], chosen["energy"]
        assert fine["normal_impulse"] > 0 and touch["start"] < 0.01 * case.end, "nothing is hit at the start"
        assert touch["normal_impulse"] / fine["normal_impulse"] == pytest.approx(1, abs=tolerance), tolerance
        assert touch["impulse_duration"] / fine["impulse_duration"] == pytest.approx(1, abs=3 * tolerance), tolerance
        assert touch["normal_peak"] / fine["normal_peak"] == pytest.approx(1, abs=0.05), f"{tolerance}: peak of two steps"
        lost = -energy["contact_work"] / (energy["kinetic_at_start"] + energy["elastic_at_start"])
        assert lost == pytest.approx(0, abs=0.02), f"{tolerance}: energy lost in contact"


def test_steel_disc(tmp_path: Path) -> None:
    """Waves cross it in a hundred thousandth of the run."""
    scene, end = tmp_path / "steel.toml", 0.5
    scene.write_text(f"""[mesh]
file = "{SOURCE / "meshes" / "disc.geo"}"
size = 3.0
[time]
end = {end}
step = "auto"
tolerance = 1e-2
[material]
density = 7800.0
young = 2e11
poisson = 0.3
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -20.001], normal = [0, 1] }}
[initial]
velocity = ["0", "-1"]
""")
    chosen = run(scene, tmp_path / "chosen")
    count = int(np.ceil(0.05 / (chosen["steps"]["wave_time"] / 8)))
    fine = run(scene, tmp_path / "fine", time={"end": 0.05, "step": 0.05 / count})
    assert fine["impact"]["ended"], "the disc has not left"
    for name, tolerance in (("normal_impulse", 0.01), ("impulse_duration", 0.03), ("sustained_peak", 0.03)):
        assert chosen["impact"]["all"][name] / fine["impact"]["all"][name] == pytest.approx(1, abs=tolerance), name


def momentum(push: object, folder: Path, **time: object) -> float:
    """Vertical momentum that a push on the top of a free body has given it after 5 s."""
    scene = folder / "free.toml"
    scene.write_text(soft("square.geo", 0.05, 5, 0.1))
    done = run(scene, folder / "pushed", load={"traction": [{"on": "top", "value": ["0", push]}]},
               output__probe=[{"name": "all", "body": True}], time={"end": 5, **time})  # fmt: skip
    assert done["steps"]["done"] > 2
    return float(table(folder / "pushed" / "probes.csv")["all.momentum_y"][-1])


def expression(folder: Path) -> tuple[str, float]:
    return "t > 0.1231 && t < 0.1251 ? 500 : 0", 1.0


def series(folder: Path) -> tuple[dict, float]:
    (folder / "push.csv").write_text("time,push\n0,0\n0.1231,0\n0.1231000001,500\n0.1251,500\n0.1251000001,0\n5,0\n")
    return {"file": str(folder / "push.csv"), "column": "push"}, 1.0


def blow_of_a_millisecond(folder: Path) -> tuple[dict, float]:
    """In five seconds at 10 kHz."""
    times = np.arange(0, 50001) * 1e-4
    force = np.where((times > 2.1234) & (times < 2.1244), 1000.0, 0.0)
    np.savetxt(folder / "blow.csv", np.column_stack([times, force]), delimiter=",", header="time,push", comments="", fmt="%.17g")
    return {"file": str(folder / "blow.csv"), "column": "push"}, float(np.sum(force) * 1e-4)


def local_push(folder: Path) -> tuple[str, float]:
    """On one element's edge; its resultant is that of a steady push."""
    shape = "exp(-((x - 0.3)/0.05)^2)"
    return f"(t > 0.5 && t < 0.502 ? 500 : 0)*{shape}", momentum(shape, folder, step=0.1) / 5


@pytest.mark.parametrize("time", ({"step": "auto", "tolerance": 1e-2}, {"step": 0.1}), ids=("chosen", "of one length"))
@pytest.mark.parametrize("push", (expression, series, blow_of_a_millisecond, local_push))
def test_short_push(push, time: dict, tmp_path: Path) -> None:
    """A push of 1 ms or 2 ms gives its whole impulse, however long the steps are."""
    given, integral = push(tmp_path)
    assert integral > 0.01
    assert momentum(given, tmp_path, **time) / integral == pytest.approx(1, abs=1e-6 if push is series else 1e-9)


@pytest.mark.parametrize("speed, warned", ((200, True), (2, False)))
def test_passage_within_a_step(speed: float, warned: bool, tmp_path: Path) -> None:
    """A ball that moves through the whole body within a step is warned of; one that does so slowly is not."""
    ball = {"shape": "ball", "center": ["0.6", f"-0.5 + {speed}*t"], "radius": 0.3}
    done = run(DATA / "block.toml", tmp_path / "passed", load={}, contact__obstacle=ball, time={"end": 0.2, "step": 0.01})
    assert ("passage within a step" in [one["name"] for one in done["warnings"]]) == warned


def test_frames_stored(tmp_path: Path) -> None:
    """The first step after each 300th of the time, the initial state, the last step and that of the largest force, however many steps."""
    out = tmp_path / "stored"
    done = run(RING, out, output__fields=["displacement"], time__tolerance=1e-4, time__end=0.25)
    times, force = (table(out / "steps.csv")[name] for name in ("time", "normal_force"))
    assert len(times) > 600 and "every" not in (out / "scene.toml").read_text()
    assert force.max() > 0, "no contact"
    part = np.floor(300 * times / times[-1] + 1e-9)
    firsts = [*times[1:-1][part[1:-1] > part[:-2]]]
    peak = times[force.argmax()]
    expected = sorted([times[0], *firsts, times[-1], *([] if peak in firsts else [peak])])
    found = grids(out / "state.xdmf")["displacement"]
    assert found == pytest.approx(expected, rel=0, abs=1e-9)
    assert done["steps"]["stored"] == len(found) <= 303


IMPACT = RING_NEAR | {"time__end": 0.08, "mesh__size": 6e-3}


@pytest.fixture(scope="module")
def impulse(tmp_path_factory: pytest.TempPathFactory) -> float:
    """Of a run of a quarter of the size, in steps of one length."""
    fine = IMPACT | {"mesh__size": 1.5e-3, "time": {"end": 0.08, "step": 2e-5, "scheme": "contact-stabilized"}}
    return run(RING, tmp_path_factory.mktemp("fine") / "truth", **fine)["impact"]["all"]["normal_impulse"]


@pytest.mark.parametrize("quantity, budget, met, tolerance", (("impulse", "100s", True, 2e-2), ("peak_force", "15s", False, 0.1)))
def test_ordered(impulse: float, quantity: str, budget: str, met: bool, tolerance: float, tmp_path: Path) -> None:
    """Of an impact at the start the impulse is met to 2 %, as a finer run confirms; a peak that grows with refinement is not called met.

    An earlier program called a peak met that was one of a single long step.
    """
    words = [f"--set={key.replace('__', '.')}={toml(value)}" for key, value in IMPACT.items()]
    done = captured([str(SIGNORINI), "simulate", str(RING), "--out", str(tmp_path / "out"), "--accuracy", "2e-2", "--quantity", quantity,
                     "--budget", budget, *words])  # fmt: skip
    ordered = json.loads((tmp_path / "out" / "run.json").read_text())
    print(done.stdout.splitlines()[-2])
    assert done.returncode == (0 if ordered["accuracy"]["met"] else 1), done.stdout + done.stderr
    assert ordered["accuracy"]["met"] == met
    assert ordered["impact"]["all"]["normal_impulse"] / impulse == pytest.approx(1, abs=tolerance)
