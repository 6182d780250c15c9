# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of runs with several obstacles, with tables and fields of known numbers, in space, and of two runs side by side."""

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import as_package  # noqa: F401
import h5py
import numpy as np
import pytest
from browser import BODY, Reader, browser, make, opened, page_of
from harness import signorini, stored, table
from selenium.webdriver import Chrome, Keys
from selenium.webdriver.support.select import Select
from signorini.post.run_folder import RunFolder
from soft_scenes import ON_A_BALL, REVOLVED, soft

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
# What the page shows of the tables, and the least and largest colours of the fields (MPa, of pressures kPa).
KNOWN_NUMBERS = (
    "12.3 ms", "500 mN s/m", "(500, 0) mN s/m", "9.5 N/m", "110 ms ∗", "before a wave has crossed the body", "8.5 N/m", "20 ms",
    "need not converge with step and size", "(250, 0) mN s/m", "8.75 N/m", "4.25 MPa", "0.625", "0.6875", "1337", "4211", "never", "0.8125",
    "Work of the loads\t500", "-62.5",
)  # fmt: skip
KNOWN_RANGES = {"von Mises stress": (4, 4), "contact pressure": (0, 1), "stress xx": (-3, -3), "stress yy": (2, 2), "stress zz": (-1, -1),
                "stress xy": (1, 1)}  # fmt: skip
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


def names_of(reader: Reader) -> list[str]:
    """The names or texts of the traces in the picture of the body."""
    return reader.ask(f"{BODY}.map((trace) => trace.text || trace.name || '')")


def numbers_of(reader: Reader, array: str) -> np.ndarray:
    return np.array(reader.ask(f"Array.from({array})"))


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture(scope="module")
def gripper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(tmp_path_factory.mktemp("runs"), "gripper", GRIPPER)


@pytest.fixture(scope="module")
def known(gripper: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the run with known tables and fields."""
    out = shutil.copytree(gripper, tmp_path_factory.mktemp("known") / "gripper")
    with_known_tables(out)
    with_known_fields(out)
    return page_of(out)


@pytest.fixture(scope="module")
def reader(known: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    """The reader of that page for tests that leave the bodies as they are and use different parts of the page."""
    with browser(tmp_path_factory.mktemp("profile")) as driver, opened(driver, known) as reader:
        yield reader


@pytest.fixture(scope="module")
def stiffer(gripper: Path) -> Path:
    return simulate(gripper.parent, "stiffer", GRIPPER, material__young=100, time__end=0.2)


@pytest.fixture(scope="module")
def comparison(gripper: Path, stiffer: Path) -> Path:
    return page_of(gripper, stiffer)


@pytest.fixture(scope="module")
def space(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return page_of(simulate(tmp_path_factory.mktemp("runs"), "space", ON_A_BALL))


@pytest.fixture(scope="module")
def revolved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return page_of(simulate(tmp_path_factory.mktemp("runs"), "revolved", REVOLVED))


@pytest.mark.parametrize("page", ("known", "comparison", "space", "revolved"))
def test_fits_a_phone(page: str, driver: Chrome, request: pytest.FixtureRequest) -> None:
    with opened(driver, request.getfixturevalue(page), 390, 844) as reader:
        reader.fits()


def test_obstacles(driver: Chrome, known: Path) -> None:
    """Three obstacles are drawn where the nodes in contact are, and the jaw follows the frames."""
    with opened(driver, known) as reader:
        traces = names_of(reader)
        jaw, ball, wave = (f"{BODY}[{traces.index(f'obstacle {i}')}]" for i in (1, 2, 3))
        in_contact = f"{BODY}[{traces.index('in contact')}]"
        face, touching = axes_of(reader, jaw)[0].max(), axes_of(reader, in_contact)
        assert np.isclose(touching[0], face, rtol=0, atol=1e-4).sum() >= 5, "the jaw is not where the left side is"  # 16 bits
        centers = axes_of(reader, ball)
        reader.changed(f"Array.from({in_contact}.x)", lambda: reader.find("#frame").send_keys(Keys.END))  # where the disc is touched
        touching = axes_of(reader, in_contact)
        # A disc that is linearised stays near its tangents where a body of its size touches.
        assert np.hypot(centers[0] - 2.52, centers[1] - 0.5).max() == pytest.approx(1.5, rel=0, abs=1e-3)
        assert np.hypot(touching[0] - 2.52, touching[1] - 0.5).min() < 1.52
        x, y, _ = axes_of(reader, wave)
        assert np.abs(y + 0.1 - 0.09 * np.cos(3 * (x - 0.5))).min() < 1e-3
        reader.changed(f"Array.from({jaw}.x)", lambda: reader.find("#frame").send_keys(Keys.HOME))
        assert axes_of(reader, jaw)[0].max() == pytest.approx(-0.02, rel=0, abs=1e-6), "the jaw at the start"


def test_force_of_each_obstacle(reader: Reader) -> None:
    contact, plot = RunFolder(reader.page.parent).contact, "document.getElementById('contact-force-plot')"
    assert reader.ask(f"{plot}.data.map((trace) => trace.name)") == ["obstacle 1", "obstacle 2", "obstacle 3"]
    for i in range(2):
        force = contact.of(i).force.sum(axis=1)
        curve = numbers_of(reader, f"{plot}._fullData[{i}].y")
        assert force.max() > 0.1 and np.abs(curve - (force[2:] + force[1:-1]) / 2).max() < 1e-6 * force.max()
    options = [option.text for option in Select(reader.find("#contact-force-view")).options]
    assert options == ["each obstacle", "all obstacles", "obstacle 1", "obstacle 2", "obstacle 3"]
    reader.changed(f"{plot}.data.map((trace) => trace.name)", lambda: reader.select("#contact-force-view", 1))
    assert "obstacle 3" in reader.ask("document.getElementById('active').innerText")


def test_numbers_of_tables(reader: Reader) -> None:
    text = reader.ask("document.body.innerText").replace("\u2212", "-")
    assert [number for number in KNOWN_NUMBERS if number not in text] == [], "not on the page"


@pytest.mark.parametrize("view, slopes", ((0, (1, 2)), (1, (-1,))), ids=("displacement", "velocity"))
def test_probe(view: int, slopes: tuple[int, ...], reader: Reader) -> None:
    reader.select("#probe-1-view", view)
    for i, slope in enumerate(slopes):
        x, y = (numbers_of(reader, f"document.getElementById('probe-1-plot')._fullData[{i}].{axis}") for axis in "xy")
        assert np.allclose(y, slope * x, rtol=1e-12, atol=0), f"curve {i}"


@pytest.mark.parametrize("name", KNOWN_RANGES)
def test_colours_of_field(name: str, reader: Reader) -> None:
    colours, (least, largest) = [option.text for option in Select(reader.find("#field")).options], KNOWN_RANGES[name]
    reader.select("#field", colours.index(name))
    values = numbers_of(reader, f"{BODY}[0].intensity")
    assert abs(values.min() - least) < 1e-3 and abs(values.max() - largest) < 1e-3
    low, high = reader.ask(f"[{BODY}[0].cmin, {BODY}[0].cmax]")
    assert (low == -high) == (least < 0) and high > 0
    assert reader.ask(f"{BODY}[0].colorbar.title.text") == f"{name} ({'kPa' if name == 'contact pressure' else 'MPa'})"


def test_colours_to_choose(reader: Reader) -> None:
    colours = {option.text for option in Select(reader.find("#field")).options}
    assert set(KNOWN_RANGES) < colours and "stress xz" not in colours


def test_blank_bands(driver: Chrome, tmp_path: Path) -> None:
    """Two jaws on opposite sides: between them no candidates, and nothing is painted."""
    text = GRIPPER.split("[[contact]]")[0] + "".join(
        f'[[contact]]\non = "{side}"\nobstacle = {{ shape = "half-space", point = [0, "{at}"], normal = [0, {normal}] }}\n'
        for side, at, normal in (("bottom", "-0.01 + 0.1*t", 1), ("top", "1.01 - 0.1*t", -1)))
    page = page_of(simulate(tmp_path, "jaws", text))
    contact = RunFolder(page.parent).contact
    assert all(contact.of(i).force.any() for i in (0, 1)), "a jaw never touches"
    with opened(driver, page) as reader:
        drawn = "document.getElementById('contact-surface-plot')._fullData[0]"
        rows = reader.ask(f"{drawn}.z.map((row) => Array.from(row).every((value) => Number.isNaN(value) || value === null))")
        blank = [i for i, empty in enumerate(rows) if empty]
        edges = numbers_of(reader, f"{drawn}.y")
        assert len(blank) == 1 and len(edges) == len(rows) + 1 and 0 < blank[0] < len(rows) - 1
        assert edges[blank[0] + 1] - edges[blank[0]] > 2 * (edges[1] - edges[0])


def test_space(driver: Chrome, space: Path) -> None:
    """A ball below a cube, which can be seen through and cut open."""
    with opened(driver, space) as reader:
        ball = axes_of(reader, f"{BODY}[{names_of(reader).index('obstacle 1')}]")
        assert np.abs(np.linalg.norm(ball - [[0.5], [0.5], [-0.62]], axis=0) - 0.6).max() < 0.01, "the ball"
        whole = reader.ask(f"{BODY}[0].i.length")
        assert reader.ask(f"{BODY}[0].opacity") == 1
        reader.select("#mode", 1)
        assert 0 < reader.ask(f"{BODY}[0].opacity") < 1
        reader.select("#mode", 2)
        assert reader.ask(f"{BODY}[0].opacity") == 1 and reader.ask(f"{BODY}[0].i.length") != whole
        # The section's points lie in one plane.
        nodes, y = reader.ask(f"Array.from({BODY}[0].k).slice(-20)"), axes_of(reader, f"{BODY}[0]")[1]
        assert np.ptp(y[nodes]) < 0.2 * np.ptp(y)


@pytest.mark.parametrize("number, mode", enumerate(("full section", "revolved", "revolved, cut open"), 1))
def test_body_of_revolution(number: int, mode: str, driver: Chrome, revolved: Path) -> None:
    """In place of its half section the page shows copies of it, turned about the axis, of body, floor and nodes in contact."""
    with opened(driver, revolved) as reader:
        floor, touching = (f"{BODY}[{names_of(reader).index(name)}]" for name in ("obstacle 1", "in contact"))
        half, marks, triangles = axes_of(reader, f"{BODY}[0]"), axes_of(reader, touching), f"{BODY}[0].i.length"
        faces = reader.ask(triangles)
        assert half[0].min() == 0 and not half[2].any() and marks.size > 0
        reader.changed(triangles, lambda: reader.select("#mode", number))
        assert Select(reader.find("#mode")).first_selected_option.text == mode
        (x, y, z), plane = axes_of(reader, f"{BODY}[0]"), mode == "full section"
        place = np.stack([abs(x), y] if plane else [np.hypot(x, y), z])
        assert np.abs(place[:, :, None] - half[:2, None, :]).max(axis=0).min(axis=1).max() < 1e-5 * half[0].max(), "a point that is no copy"
        assert np.ptp(x) == pytest.approx(2 * half[0].max(), rel=0.01, abs=0)
        assert (reader.ask(triangles) == 2 * faces) == plane == (not z.any())
        assert axes_of(reader, touching).shape[1] > marks.shape[1]
        ground = axes_of(reader, floor)
        assert ground[0].min() == pytest.approx(-ground[0].max(), rel=1e-6, abs=0)
        assert ground[1 if plane else 2].max() == pytest.approx(-15.2, rel=1e-6, abs=0)
        heights = f"Array.from({BODY}[0].{'y' if plane else 'z'})"
        reader.changed(heights, lambda: reader.find("#frame").send_keys(Keys.HOME))
        reader.changed(f"{BODY}[0].colorbar.title.text", lambda: reader.select("#field", 2))
        reader.select("#mode", 0)
        reader.wait(f"{triangles} === {faces}")


def test_comparison(driver: Chrome, comparison: Path, gripper: Path, stiffer: Path) -> None:
    """Both bodies are driven by one slider and have the same colours; the page has the differences of scenes and results."""
    with opened(driver, comparison) as reader:
        bodies = [BODY, BODY.replace("body-plot", "body-plot-2")]
        before = [reader.ask(f"Array.from({body}[0].y)") for body in bodies]
        reader.find("#frame").send_keys(Keys.END)
        for body, was in zip(bodies, before):
            reader.wait(f"JSON.stringify(Array.from({body}[0].y)) !== {json.dumps(json.dumps(was, separators=(',', ':')))}")
        for part in ("cmax", "colorbar.title.text"):
            first, second = (reader.ask(f"{body}[0].{part}") for body in bodies)
            assert first == second, part
        scenes, results = ({cells[0]: cells[1:] for cells in reader.ask(
            f"Array.from(document.querySelectorAll('#{of} tbody tr'), (row) => Array.from(row.cells, (cell) => cell.textContent))")}
            for of in ("scenes", "results"))  # fmt: skip
        assert scenes == {"material.young": ["50.0", "100.0"], "time.end": ["0.3", "0.2"]}
        assert results["Steps"] == ["30", "20", "-10", "-33.3 %"] and results["Unknowns"][2:] == ["0", "0"]
        curves = reader.ask("document.getElementById('energies-plot')._fullData.map((trace) => Array.from(trace.y))")
    assert len(curves) >= 2
    for curve, out in zip(curves, (gripper, stiffer)):
        steps = table(out / "steps.csv")
        work = np.cumsum(steps.get("load_work", np.zeros(1)))
        total = steps["kinetic_energy"] + steps["elastic_energy"] + (work.max() - work)
        assert np.allclose(np.array(curve) / np.max(curve), total / total.max(), rtol=1e-5, atol=0)


@pytest.mark.parametrize("other, expected", (("space", "found a body in space"), ("nowhere", "no such folder")))
def test_not_two_comparable_runs(other: str, expected: str, gripper: Path, space: Path) -> None:
    folder = space.parent if other == "space" else gripper.parent / other
    done = make(gripper, folder)
    assert done.returncode == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert not done.stdout and not (folder / "comparison.html").exists()
