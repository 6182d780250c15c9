# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of drop tests: the fall, the end of a bounce, accelerations and their filter."""

from pathlib import Path

import numpy as np
import pytest
from harness import table
from regression.keys.runs import BLOCK, Run, Runner, near

G = 10.0
FALLS = {"load__body": ["0", "0"], "load__gravity": [0, -G], "initial": {"drop": {"height": 0.2}}, "contact__obstacle__normal": [0, 1]}
BODY = {"every": 1, "probe": [{"name": "body", "body": True, "acceleration": True}]}


def dropped(folder: Path, **more: object) -> Run:
    """A simulation of a drop whose end the program chooses, so that scene.toml says another one; without the block's control."""
    text = BLOCK.read_text().replace("square.geo", str(BLOCK.parent / "square.geo"))
    (folder / "block.toml").write_text(text[: text.index("[control]")])
    return Run(folder, "simulate", folder / "block.toml", {"time__end": "auto"} | FALLS | more)


@pytest.mark.key("initial.drop.height")
@pytest.mark.parametrize("point, normal", (([0, -0.7], [0, 1]), ([0, 0.25], [0, 1]), ([0, -1], [0.3, 1]), ([0.5, -0.6], [-0.2, 1])), ids=str)
def test_drop(point: list[float], normal: list[float], simulate: Runner) -> None:
    """The body starts as one that was put there with the speed of the fall, also from inside of the obstacle; it does not turn."""
    obstacle = {"shape": "half-space", "point": point, "normal": normal}
    falls = {key: value for key, value in FALLS.items() if key != "contact__obstacle__normal"} | {"contact__obstacle": obstacle}
    done = simulate(**falls, output=BODY)
    speed = np.sqrt(2 * G * 0.2)
    assert f"dropped from 0.2 m: touches at {speed:.6g} m/s" in done.stdout
    n = np.array(normal) / np.linalg.norm(normal)
    corners = np.array([[x, 0.0] for x in done.points[abs(done.points[:, 1]) < 1e-9, 0]])
    way = ((corners - point) @ n / n[1]).min()  # along gravity
    assert abs(done.start["gap"].min()) < 1e-14
    near(done.field("displacement")[0], np.broadcast_to([0, -way], done.points[:, :2].shape), 1e-12)
    near(done.field("velocity")[0], np.broadcast_to([0, -speed], done.points[:, :2].shape), 1e-14)
    same = simulate(**falls | {"initial": {"displacement": ["0", str(-way)], "velocity": ["0", str(-speed)]}}, output=BODY)
    assert done.steps["active"].max() > 0
    near(done.steps["kinetic_energy"], same.steps["kinetic_energy"], 1e-10)
    assert done.manifest["effects"]["drop"] and not same.manifest["effects"]["drop"]


@pytest.mark.key("time.end")
def test_end_of_a_bounce(tmp_path: Path, simulate: Runner) -> None:
    """The motion is that of a scene with a long time until it ends, after the last force and before the next; the end is in scene.toml."""
    done = dropped(tmp_path, material__young=500.0, output=BODY)
    long = simulate(**FALLS, material__young=500.0, output=BODY)
    steps = len(done.steps["step"])
    assert "to the end of the bounce, at most 20" in done.stdout and 3 < steps < 20
    near(done.steps["kinetic_energy"], long.steps["kinetic_energy"][:steps])
    touching = done.steps["active"] > 0
    assert touching[1:4].any() and not touching[-2:].any()
    assert done.manifest["impact"]["restitution"] == pytest.approx(long.manifest["impact"]["bounces"][0]["restitution"], rel=1e-12)
    assert done.echo["time"]["end"] == pytest.approx(done.steps["time"][-1], rel=1e-12) and done.manifest["stop_reason"] == "end of time"
    again = simulate(done.folder / "scene.toml")
    near(again.steps["kinetic_energy"], done.steps["kinetic_energy"])


def test_bounce_on_an_edge(tmp_path: Path, simulate: Runner) -> None:
    """The block turns and comes down on its other edge: the motion continues until that touch is over too."""
    n = np.array([0.25, 1]) / np.hypot(0.25, 1)
    edge = {"contact__obstacle__normal": [0.25, 1], "load__gravity": list(-G * n), "material__young": 2e4,
            "time__step": 2e-3, "material__viscosity": {"bulk": 1.0, "shear": 1.0}}  # fmt: skip
    done = dropped(tmp_path, **edge, output=BODY)
    long = simulate(**FALLS | edge | {"time__end": 0.2}, output=BODY)  # before its next fall
    for run in (done, long):
        touching = run.steps["active"] > 0
        assert np.sum(np.diff(touching[1:].astype(int)) == 1) >= 1, "it touches once only: the case says nothing"
        assert not touching[-1]
    assert done.steps["time"][-1] < 0.2
    assert done.manifest["impact"]["restitution"] == pytest.approx(long.manifest["impact"]["restitution"], rel=1e-12)


def test_drop_of_a_vertex_on_the_axis(tmp_path: Path) -> None:
    """In degree 2 the vertex on the axis is no candidate; the drop does not leave it inside of the floor."""
    scene = tmp_path / "ball.toml"
    scene.write_text(f'''
[mesh]
file = "{BLOCK.parent.parent.parent / "meshes" / "half-ball-section.geo"}"
size = 4.0
degree = 2
model = "axisymmetric"
[time]
end = 1e-3
step = 1e-4
[material]
density = 1.0
young = 1e8
poisson = 0.3
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -20], normal = [0, 1] }}
[load]
gravity = [0, -10]
[initial]
drop = {{ height = 1.0 }}
''')
    done = Run(tmp_path, "simulate", scene, {})
    tip = np.flatnonzero((done.points[:, 0] == 0) & (done.points[:, 1] == done.points[:, 1].min()))
    y = done.points[tip, 1] + done.field("displacement")[0][tip, 1]
    near(y, [-20.0], 1e-12)
    assert done.start["gap"].min() > 0


def test_bounce_that_does_not_end(tmp_path: Path) -> None:
    """A body that stays in contact ends with the time of an elastic bounce, and the program says so."""
    done = dropped(tmp_path, material__viscosity={"bulk": 50.0, "shear": 50.0})
    assert "warning: the bounce was not over at 0.4 s" in done.stdout and done.steps["time"][-1] == pytest.approx(0.4, rel=1e-12)


@pytest.mark.key("output.probe.acceleration")
@pytest.mark.parametrize("where, velocity", (({"point": [0.5, 0.5]}, "velocity"), ({"on": "top"}, "velocity"), ({"body": True}, "momentum"),
                                             ({"obstacle": "obstacle 1"}, "velocity")), ids=str)  # fmt: skip
def test_acceleration(where: dict[str, object], velocity: str, simulate: Runner) -> None:
    """The change of the velocity (of a body of mass 1 that of the momentum) over each step; its peak as the mean of two."""
    done = simulate(contact__obstacle__mass=3.0, output={"every": 1, "probe": [{"name": "p", "acceleration": True, **where}]})
    found, step = table(done.folder / "probes.csv"), 0.02
    a = np.stack([found[f"p.acceleration_{c}"] for c in "xy"], axis=1)
    v = np.stack([found[f"p.{velocity}_{c}"] for c in "xy"], axis=1)
    assert abs(a).max() > 1 and not a[0].any()
    near(a[1:], np.diff(v, axis=0) / step, 1e-10)
    size = np.linalg.norm((a[2:] + a[1:-1]) / 2, axis=1)
    (peak,) = done.manifest["probe_peaks"]
    assert (peak["name"], peak["quantity"]) == ("p", "acceleration") and peak["peak"] == pytest.approx(size.max(), rel=1e-10)
    assert peak["time"] == pytest.approx(found["time"][1:-1][size.argmax()], rel=1e-9)
    assert f'probe "p": peak acceleration {size.max():.4g} m/s² ({size.max() / 9.80665:.3g} g)' in done.stdout


def filtered(samples: np.ndarray, interval: float, channel_class: float) -> np.ndarray:
    """By the transfer function of a Butterworth filter of second order, forwards and backwards; zero before, constant afterwards."""
    scipy = pytest.importorskip("scipy.signal")
    b, a = scipy.butter(2, 2.0775 * channel_class, fs=1 / interval)
    longer = np.append(samples, np.full(4000, samples[-1]))
    back = scipy.lfilter(b, a, scipy.lfilter(b, a, longer)[::-1], zi=scipy.lfilter_zi(b, a) * longer[-1])[0]
    return back[::-1][: len(samples)]


@pytest.mark.key("output.probe.filter.cfc")
@pytest.mark.parametrize("quantity, where", (("acceleration", {"point": [0.5, 0.5], "acceleration": True}), ("force", {"obstacle": "obstacle 1"})), ids=str)
def test_filter(quantity: str, where: dict[str, object], simulate: Runner) -> None:
    done = simulate(output={"every": 1, "probe": [{"name": "p", "filter": {"cfc": 4.0}, **where}]})
    found = table(done.folder / "probes.csv")
    smooth = np.stack([filtered(found[f"p.{quantity}_{c}"][1:], 0.02, 4.0) for c in "xy"], axis=1)
    size = np.linalg.norm(smooth, axis=1)
    (peak,) = done.manifest["probe_peaks"]
    assert 0.1 < peak["filtered_peak"] < peak["peak"] and peak["cfc"] == 4
    assert peak["filtered_peak"] == pytest.approx(size.max(), rel=1e-10)
    assert peak["filtered_time"] == pytest.approx(found["time"][1:][size.argmax()] - 0.01, rel=1e-9)
    assert f"with CFC 4 {size.max():.4g}" in done.stdout
