# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of runs with several obstacles, with tables and fields of known numbers, in space, and of two runs side by side."""

import json
import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import BODY, Reader, browser, make, page_of  # noqa: E402
from harness import SOURCE, signorini, stored, table  # noqa: E402
from soft_scenes import ON_A_BALL, soft  # noqa: E402

sys.path.insert(0, str(SOURCE / "postprocess"))
import as_package  # noqa: E402, F401
import h5py  # noqa: E402
import numpy as np  # noqa: E402
from signorini.post.run_folder import RunFolder  # noqa: E402

from selenium.webdriver import Chrome  # noqa: E402
from selenium.webdriver.support.select import Select  # noqa: E402

DATA = SOURCE / "tests" / "data"
GRIPPER = soft("square.geo", 0.125, 0.3, 0.01) + """
[[contact]]
on = "left"
obstacle = { shape = "half-space", point = ["-0.02 + 0.05*min(1, 5*t)", 0], normal = [1, 0] }

[[contact]]
on = "rest"
obstacle = { shape = "ball", center = [2.52, 0.5], radius = 1.5 }

[[contact]]
on = "bottom"
obstacle = { shape = "signed-distance", distance = "y + 0.1 - 0.09*cos(3*(x - 0.5))" }

[load]
body = ["0", "-0.5"]
"""
# Positions of a trace, as lists.
XYZ = "[{0}.x, {0}.y, {0}.z].map((axis) => Array.from(axis))"


def simulate(folder: Path, name: str, text: str, **more: object) -> Path:
    (folder / f"{name}.toml").write_text(text)
    signorini("simulate", folder / f"{name}.toml", folder / name, **more)
    return folder / name


def with_known_tables(out: Path) -> None:
    """Tables and a summary with numbers that the page must show: each obstacle's force, and how far it goes by a probe."""
    run = RunFolder(out)
    contact, times = run.contact, run.steps["time"]
    rows = ["step,time,obstacle,force_x,force_y,normal_force,active,min_gap"]
    for k, time in enumerate(times):
        for i, name in enumerate(run.obstacle_names):
            own = contact.of(i)
            rows.append(f"{k},{time:.10g},{name},0,0,{own.force[k].sum():.17g},{(own.force[k] > 0).sum()},{own.gap[k].min():.17g}")
    (out / "obstacles.csv").write_text("\n".join(rows) + "\n")
    lines = ["step,time,the tip.displacement_x,the tip.displacement_y,the tip.velocity_x,body.rotation"]
    (out / "probes.csv").write_text("\n".join(lines + [f"{k},{t:.10g},{t},{2 * t},{-t},{3 * t}" for k, t in enumerate(times)]) + "\n")
    manifest = json.loads((out / "run.json").read_text())
    touch = {"start": 0.0123, "end": 0.25, "duration": 0.2377, "contact_time": 0.2, "impulse": [0.5, 1e-18], "normal_impulse": 0.5,
             "peak": 9.0, "peak_time": 0.11, "normal_peak": 9.5, "peak_at_onset": True, "largest_step": 10.0,
             "impulse_duration": 0.02, "sustained_peak": 8.5, "sustained_over": 1e-3}  # fmt: skip
    idle = {"start": None, "end": None, "duration": 0, "contact_time": 0, "impulse": [0, 0], "normal_impulse": 0, "peak": 0, "peak_time": None,
            "normal_peak": 0, "largest_step": 0, "impulse_duration": 0, "sustained_peak": 0, "sustained_over": 1e-3}  # fmt: skip
    each = [{"name": name} | (touch if i < 2 else idle) for i, name in enumerate(run.obstacle_names)]
    manifest["impact"] = {"mass": 1.0, "obstacles": each, "all": touch, "ended": True, "velocity_before": [0, -1], "velocity_after": [0, 0.8],
                          "restitution": 0.8125,
                          "bounces": [{"start": at, "end": at + 0.05, "touches": touches, "impulse": [0.25, 0], "peak": 8.75, "velocity_before": [0, -2 * ratio], "velocity_after": [0, 1],
                                       "restitution": ratio} for at, ratio, touches in ((0.0123, 0.625, 1337), (0.2, 0.6875, 4211))]}  # fmt: skip
    manifest["largest_von_mises"] = {"value": 4.25e6, "point": [0.5, 0.25], "time": 0.19}
    manifest["energy"] = {"kinetic_at_start": 0.25, "elastic_at_start": 0, "load_work": 0.5, "control_and_clamp_work": 0, "contact_work": -0.125,
                          "viscous_dissipation": 0.0625, "residual": 0, "kinetic_at_end": 0.5, "elastic_at_end": 0.0625}  # fmt: skip
    (out / "run.json").write_text(json.dumps(manifest, indent=2) + "\n")


def with_known_fields(out: Path) -> None:
    """A stress, its equivalent and a pressure whose values are known at every node."""
    nodes, cells, _ = stored(out, "state", "displacement")
    text = (out / "state.xdmf").read_text()
    pattern = re.compile(r' *<Attribute Name="displacement".*?</Attribute>\n', re.DOTALL)
    with h5py.File(out / "state.h5", "a") as data:
        names = list(data["Function/displacement"])
        for field, kind, center, make_values in (
            ("stress", "Tensor", "Cell", lambda: np.tile(np.array([-3e6, 1e6, 0, 1e6, 2e6, 0, 0, 0, -1e6]), (len(cells), 1))),
            ("von_mises", "Scalar", "Cell", lambda: np.full((len(cells), 1), 4e6)),
            ("pressure", "Scalar", "Node", lambda: 1e3 * nodes[:, :1]),
        ):
            for name in names:
                data[f"Function/{field}/{name}"] = make_values()
            text = pattern.sub(lambda found: found[0] + found[0].replace("displacement", field).replace('AttributeType="Vector"', f'AttributeType="{kind}"')
                               .replace('Center="Node"', f'Center="{center}"'), text)  # fmt: skip
    (out / "state.xdmf").write_text(text)


def axes_of(reader: Reader, trace: str) -> np.ndarray:
    return np.array(reader.ask(XYZ.format(trace)), dtype=float)


def read_gripper(driver: Chrome, page: Path) -> None:
    """Three obstacles are drawn where the nodes in contact are, the jaw follows the frames, and numbers are those of the tables."""
    reader = Reader(driver, page, 1280, 900)
    traces = reader.ask(f"{BODY}.map((trace) => trace.text || trace.name || '')")
    obstacles = {name: f"{BODY}[{traces.index(name)}]" for name in ("obstacle 1", "obstacle 2", "obstacle 3")}
    touching = axes_of(reader, f"{BODY}[{traces.index('in contact')}]")
    jaw, ball = axes_of(reader, obstacles["obstacle 1"]), axes_of(reader, obstacles["obstacle 2"])
    face = jaw[0].max()
    assert np.isclose(touching[0], face, rtol=0, atol=1e-4).sum() >= 5, "the jaw is not where the left side is"  # 16 bits
    in_contact = f"{BODY}[{traces.index('in contact')}]"
    reader.changed(f"Array.from({in_contact}.x)", lambda: reader.find("#frame").send_keys("\ue010"))  # End, where the disc is touched
    touching = axes_of(reader, in_contact)
    # A disc that is linearised stays near its tangents where a body of its size touches.
    reach = np.hypot(ball[0] - 2.52, ball[1] - 0.5)
    found = reach.max(), np.hypot(touching[0] - 2.52, touching[1] - 0.5).min()
    assert abs(found[0] - 1.5) < 1e-3 and found[1] < 1.52, found
    wave = axes_of(reader, obstacles["obstacle 3"])
    assert np.abs(wave[1] + 0.1 - 0.09 * np.cos(3 * (wave[0] - 0.5))).min() < 1e-3
    reader.changed(f"Array.from({obstacles['obstacle 1']}.x)", lambda: reader.find("#frame").send_keys("\ue011"))  # Home
    assert abs(axes_of(reader, obstacles["obstacle 1"])[0].max() + 0.02) < 1e-6, "the jaw at the start"
    forces(reader, page)
    known_numbers(reader)
    reader.close()
    phone = Reader(driver, page, 390, 844)
    phone.fits()
    phone.close()


def forces(reader: Reader, page: Path) -> None:
    """Each obstacle's force is a curve, and a map has a blank band where there are no candidates."""
    contact = RunFolder(page.parent).contact
    names = reader.ask("document.getElementById('contact-force-plot').data.map((trace) => trace.name)")
    assert names == ["obstacle 1", "obstacle 2", "obstacle 3"], names
    for i in range(2):
        force = contact.of(i).force.sum(axis=1)
        curve = np.array(reader.ask(f"Array.from(document.getElementById('contact-force-plot')._fullData[{i}].y)"))
        assert force.max() > 0.1 and np.abs(curve - (force[2:] + force[1:-1]) / 2).max() < 1e-6 * force.max()
    options = [option.text for option in Select(reader.find("#contact-force-view")).options]
    assert options == ["each obstacle", "all obstacles", "obstacle 1", "obstacle 2", "obstacle 3"], options
    reader.changed("document.getElementById('contact-force-plot').data.map((trace) => trace.name)",
                   lambda: reader.select("#contact-force-view", 1))  # fmt: skip
    assert "obstacle 3" in reader.ask("document.getElementById('active').innerText")


def known_numbers(reader: Reader) -> None:
    """The tables that were written, and the fields."""
    text = reader.ask("document.body.innerText")
    for expected in ("12.3 ms", "500 mN s/m", "(500, 0) mN s/m", "9.5 N/m", "110 ms ∗", "before a wave has crossed the body", "8.5 N/m", "20 ms", "need not converge with step and size", "(250, 0) mN s/m", "8.75 N/m", "4.25 MPa", "0.625", "0.6875", "1337", "4211", "never", "0.8125", "Work of the loads\t500", "-62.5"):
        assert expected in text.replace("\u2212", "-"), f"{expected} is not on the page"
    for view, slopes in ((0, (1, 2)), (1, (-1,))):
        reader.select("#probe-1-view", view)
        for i, slope in enumerate(slopes):
            x, y = (np.array(reader.ask(f"Array.from(document.getElementById('probe-1-plot')._fullData[{i}].{axis})")) for axis in "xy")
            assert np.allclose(y, slope * x, rtol=1e-12, atol=0), (view, i)
    colours = [option.text for option in Select(reader.find("#field")).options]
    expected = {"von Mises stress": (4, 4), "contact pressure": (0, 1), "stress xx": (-3, -3), "stress yy": (2, 2), "stress zz": (-1, -1),
                "stress xy": (1, 1)}  # fmt: skip
    assert set(expected) < set(colours) and "stress xz" not in colours, colours
    for name, (least, largest) in expected.items():
        reader.select("#field", colours.index(name))
        values = reader.ask(f"Array.from({BODY}[0].intensity)")
        assert abs(np.min(values) - least) < 1e-3 and abs(np.max(values) - largest) < 1e-3, (name, np.min(values), np.max(values))
        low, high = reader.ask(f"[{BODY}[0].cmin, {BODY}[0].cmax]")
        assert (low == -high) == (least < 0) and high > 0, f"{name}: colours from {low} to {high}"
        label = reader.ask(f"{BODY}[0].colorbar.title.text")
        assert label == f"{name} ({'kPa' if name == 'contact pressure' else 'MPa'})", label


def blank_bands(folder: Path, driver: Chrome) -> None:
    """Two jaws on opposite sides: between them no candidates, and nothing is painted."""
    text = GRIPPER.split("[[contact]]")[0] + "".join(
        f'[[contact]]\non = "{side}"\nobstacle = {{ shape = "half-space", point = [0, "{at}"], normal = [0, {way}] }}\n'
        for side, at, way in (("bottom", "-0.01 + 0.1*t", 1), ("top", "1.01 - 0.1*t", -1)))
    page = page_of(simulate(folder, "jaws", text))
    reader = Reader(driver, page, 1280, 900)
    drawn = "document.getElementById('contact-surface-plot')._fullData[0]"
    rows = reader.ask(f"{drawn}.z.map((row) => Array.from(row).every((value) => Number.isNaN(value) || value === null))")
    blank = [i for i, empty in enumerate(rows) if empty]
    edges = reader.ask(f"Array.from({drawn}.y)")
    assert len(blank) == 1 and len(edges) == len(rows) + 1 and 0 < blank[0] < len(rows) - 1, (blank, len(rows), len(edges))
    assert edges[blank[0] + 1] - edges[blank[0]] > 2 * (edges[1] - edges[0])
    force = RunFolder(page.parent).contact
    assert all(force.of(i).force.any() for i in (0, 1)), "a jaw never touches"
    reader.close()


def read_space(driver: Chrome, page: Path) -> None:
    """A ball below a cube, which can be seen through and cut open."""
    reader = Reader(driver, page, 1280, 900)
    traces = reader.ask(f"{BODY}.map((trace) => trace.text || trace.name || '')")
    ball = axes_of(reader, f"{BODY}[{traces.index('obstacle 1')}]")
    assert np.abs(np.linalg.norm(ball - [[0.5], [0.5], [-0.62]], axis=0) - 0.6).max() < 0.01, "the ball"
    whole = reader.ask(f"{BODY}[0].i.length")
    assert reader.ask(f"{BODY}[0].opacity") == 1
    reader.select("#mode", 1)
    assert 0 < reader.ask(f"{BODY}[0].opacity") < 1
    reader.select("#mode", 2)
    assert reader.ask(f"{BODY}[0].opacity") == 1 and reader.ask(f"{BODY}[0].i.length") != whole
    # The section's points lie in one plane.
    nodes = reader.ask(f"Array.from({BODY}[0].k).slice(-20)")
    assert np.ptp(axes_of(reader, f"{BODY}[0]")[1][nodes]) < 0.2 * np.ptp(axes_of(reader, f"{BODY}[0]")[1])
    reader.close()
    phone = Reader(driver, page, 390, 844)
    phone.fits()
    phone.close()


def read_comparison(driver: Chrome, page: Path) -> None:
    """Both bodies are driven by one slider and have the same colours; what differs is told."""
    reader = Reader(driver, page, 1280, 900)
    bodies = [BODY, BODY.replace("body-plot", "body-plot-2")]
    before = [reader.ask(f"Array.from({body}[0].y)") for body in bodies]
    reader.find("#frame").send_keys("\ue010")  # End
    for body, was in zip(bodies, before):
        reader.wait(f"JSON.stringify(Array.from({body}[0].y)) !== {json.dumps(json.dumps(was, separators=(',', ':')))}")
    for part in ("cmax", "colorbar.title.text"):
        first, second = (reader.ask(f"{body}[0].{part}") for body in bodies)
        assert first == second, (part, first, second)
    rows = {cells[0]: cells[1:] for cells in reader.ask(
        "Array.from(document.querySelectorAll('#scenes tbody tr'), (row) => Array.from(row.cells, (cell) => cell.textContent))")}  # fmt: skip
    assert rows == {"material.young": ["50.0", "100.0"], "time.end": ["0.3", "0.2"]}, rows
    results = {cells[0]: cells[1:] for cells in reader.ask(
        "Array.from(document.querySelectorAll('#results tbody tr'), (row) => Array.from(row.cells, (cell) => cell.textContent))")}  # fmt: skip
    assert results["Steps"] == ["30", "20", "-10", "-33.3 %"] and results["Unknowns"][2:] == ["0", "0"], results
    curves = reader.ask("document.getElementById('energies-plot')._fullData.map((trace) => Array.from(trace.y))")
    for curve, out in zip(curves, (page.parent.parent / "gripper", page.parent)):
        steps = table(out / "steps.csv")
        total = np.array(steps["kinetic_energy"]) + steps["elastic_energy"]
        work = np.cumsum(steps.get("load_work", np.zeros(1)))
        total = total + (work.max() - work)
        assert np.allclose(np.array(curve) / np.max(curve), total / total.max(), rtol=1e-5, atol=0)
    reader.close()
    phone = Reader(driver, page, 390, 844)
    phone.fits()
    phone.close()


def refused(folder: Path, out: Path) -> None:
    """Two runs are compared, nothing else."""
    for pair, expected in (((out, folder / "space"), "space"), ((out, folder / "nowhere"), "no such folder")):
        done = make(*pair)
        assert done.returncode == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr
        assert not done.stdout and not (pair[1] / "comparison.html").exists()


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        gripper = simulate(folder, "gripper", GRIPPER)
        stiffer = simulate(folder, "stiffer", GRIPPER, material__young=100, time__end=0.2)
        space = simulate(folder, "space", ON_A_BALL)
        both = page_of(gripper, stiffer)
        with_known_tables(gripper)
        with_known_fields(gripper)
        with browser(folder / "profile") as driver:
            read_comparison(driver, both)
            read_gripper(driver, page_of(gripper))
            blank_bands(folder, driver)
            read_space(driver, page_of(space))
        refused(folder, gripper)
        print("pages of several obstacles, of known numbers, in space and of two runs are as they should be")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
