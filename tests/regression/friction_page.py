# SPDX-License-Identifier: GPL-3.0-or-later
"""Page, figures and film of runs with friction: forces along obstacles, stick and slip, works, impulses, as the run's tables have them."""

import functools
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import as_package  # noqa: F401
import numpy as np
import pytest
from browser import BODY, browser, opened, page_of
from drawn import numbers, tables_of, views_of
from harness import SOURCE, signorini, table
from signorini.post import animation, contact_force, contact_force_history, energy, report_compare, report_motion, report_run, style
from signorini.post.contact_table import MOTION, SLIP, STICK
from signorini.post.friction_force import coefficients
from signorini.post.run_folder import RunFolder
from soft_scenes import REVOLVED, soft

FLOOR = '[contact]\non = "bottom"\nfriction = {}\nobstacle = {{ name = "floor", shape = "half-space", {} }}\n'
FIELDS = '[output]\nfields = ["displacement", "velocity", "pressure", "friction"]\n'
SCENES = {
    # A disc that bounces off a wall obliquely, a block on a belt, one between a jaw and a dome, a cube thrown along a floor, a half ball.
    "disc": soft("../../meshes/thrown-disc.geo", 0.12, 0.15, 1e-3).replace("density = 1.0", "density = 1000.0").replace("50.0", "2e6") + """
[contact]
on = "contact"
friction = 0.4
obstacle = { name = "wall", shape = "half-space", point = [0.51, 0], normal = [-1, 0] }

[initial]
velocity = ["1.5", "0.4"]

""" + FIELDS,
    "belt": soft("square.geo", 0.2, 1.0, 0.01)
            + FLOOR.format(0.4, 'point = [0, 0], normal = [0, 1], surface_velocity = ["0.6", "0"]') + '[load]\ngravity = ["0", "-3"]\n',
    "jaws": soft("square.geo", 0.125, 0.6, 0.01) + """
[[contact]]
on = "bottom"
friction = 0.5
obstacle = { name = "jaw", shape = "half-space", point = [0, "-0.02 + 0.05*min(1, 5*t)"], normal = [0, 1], BELT }

[[contact]]
on = "top"
friction = "0.2 + 0.1*x"
obstacle = { name = "dome", shape = "cylinder", point = [0.5, 2.52], radius = 1.5 }
""".replace("BELT", 'surface_velocity = ["0.3", "0"]'),
    "cube": soft("cube.geo", 0.34, 0.6, 0.01) + FLOOR.format(0.25, "point = [0, 0, -0.05], normal = [0, 0, 1]")
            + '[initial]\nvelocity = ["0.3", "0.1", "-1"]\n' + FIELDS,
    "revolved": REVOLVED.replace('on = "contact"', 'on = "contact"\nfriction = 0.1').replace('"von_mises"', '"friction"'),
}  # fmt: skip
COEFFICIENT = {"disc": 0.4, "belt": 0.4, "cube": 0.25, "revolved": 0.1}
Runs = Callable[[str], RunFolder]
every_scene = pytest.mark.parametrize("name", SCENES)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Gives the run of one of the SCENES; "smooth NAME" is that without friction, "NAME every N" that which stores each Nth step."""
    folder = tmp_path_factory.mktemp("friction")

    @functools.cache
    def run(name: str) -> RunFolder:
        smooth, scene, every = name.startswith("smooth "), name.removeprefix("smooth ").split(" every ")[0], name.partition(" every ")[2]
        text = SCENES[scene]
        if smooth:
            text = re.sub(r'friction = .*\n|, surface_velocity = \[".*", "0"\]|, "friction"(?=\])', "", text)
        (folder / f"{name}.toml").write_text(text)
        signorini("simulate", folder / f"{name}.toml", folder / name, **({"output__every": int(every)} if every else {}))
        return RunFolder(folder / name)

    return run


def rows_of(run: RunFolder) -> dict[str, np.ndarray]:
    """Columns of contact.csv as times × candidates."""
    return {name: column.reshape(run.stored_steps, -1) for name, column in table(run.path / "contact.csv").items()}


def summed(run: RunFolder, obstacle: str) -> tuple[np.ndarray, np.ndarray]:
    """The sum of an obstacle's normal forces, and of its friction along the normal turned clockwise or, in space, as a vector."""
    rows, axes = rows_of(run), "xyz"[: run.dim]
    own = rows["obstacle"] == obstacle
    force = np.stack([rows[f"tangential_force_{axis}"] * own for axis in axes])
    if run.dim == 2:
        force = (force[0] * rows["normal_y"] - force[1] * rows["normal_x"])[None]
    return (rows["force"] * own).sum(axis=1), force.sum(axis=2)


def mean(values: np.ndarray) -> np.ndarray:
    return (values[..., 2:] + values[..., 1:-1]) / 2


def curves(view: dict) -> dict[str, np.ndarray]:
    return {trace["name"]: numbers(trace["y"]) for trace in view["data"]}


@every_scene
def test_candidates_slip_and_stick(runs: Runs, name: str) -> None:
    """Both occur, and the chart has their numbers."""
    run = runs(name)
    motion, steps = rows_of(run)["motion"], run.steps
    view = views_of(report_run.page(run))["slip-stick"][""]
    for what in ("slip", "stick"):
        counted = (motion == what).sum(axis=1)
        assert counted.any(), f"no candidate is in {what}"
        assert (steps[what] == counted).all() and (curves(view)[what] == counted).all()
    assert {trace["line"]["shape"] for trace in view["data"]} == {"vh"} and len({trace["line"]["color"] for trace in view["data"]}) == 2


@pytest.mark.parametrize("name, obstacle", (("disc", "wall"), ("belt", "floor"), ("jaws", "jaw"), ("jaws", "dome"), ("cube", "floor"),
                                            ("revolved", "obstacle 1")))  # fmt: skip
def test_force_is_split(runs: Runs, name: str, obstacle: str) -> None:
    """Into the normal force and that along the obstacle, with Coulomb's bound, which limits the latter."""
    run = runs(name)
    view = views_of(report_run.page(run))["contact-force"][f"{obstacle}: " * (name == "jaws") + "normal force and friction"]
    normal, friction = map(mean, summed(run, obstacle))
    friction = friction[0] if run.dim == 2 else np.linalg.norm(friction, axis=0)
    factor, unit = style.prefixed(np.concatenate([normal, friction]), style.per_depth("N", run.whole))
    found, scale = curves(view), 1e-6 * factor * normal.max()
    assert np.abs(found["normal"] - factor * normal).max() < scale and np.abs(found["friction"] - factor * friction).max() < scale
    assert f"({unit})" in view["layout"]["yaxis"]["title"]["text"] and np.ptp(friction) > 0.01 * normal.max()
    if obstacle == "dome":
        assert len(found) == 2, "its coefficient varies"
        return
    mu = COEFFICIENT.get(name, 0.5)
    bound = found[f"{'±' if run.dim == 2 else ''}{mu:g} × normal"]
    assert np.abs(bound[: len(normal)] - mu * factor * normal).max() < scale
    assert run.dim == 3 or np.isnan(bound[len(normal)]) and (bound[len(normal) + 1:] == -bound[: len(normal)]).all()
    assert (np.abs(found["friction"]) <= bound[: len(normal)] + scale).all()


@every_scene
def test_works_of_friction(runs: Runs, name: str) -> None:
    """The chart has the sums of both columns; the account has them apart from the rest of the work of contact, and adds up."""
    run = runs(name)
    page, steps, given = report_run.page(run), table(run.path / "steps.csv"), run.manifest["energy"]
    found, works = curves(views_of(page)["energies"][""]), {"lost to friction so far": -np.cumsum(steps["friction_work"])}
    if name in ("belt", "jaws"):
        works["work of moving surfaces so far"] = np.cumsum(steps["belt_work"])
    factor = found["kinetic"].max() / steps["kinetic_energy"].max()
    assert {curve for curve in found if "friction" in curve or "surfaces" in curve} == set(works)
    for curve, work in works.items():
        assert np.abs(work).max() > 0 and np.abs(found[curve] - factor * work).max() < 1e-6 * factor * np.abs(work).max(), curve
    rows = {row[0]: float(row[1]) for row in tables_of(page)["Energy"].rows}
    assert "Work of contact" not in rows and ("Work of moving surfaces" in rows) == (name in ("belt", "jaws"))
    unit = rows["Work of friction"] / given["friction_work"]
    assert rows["Work of friction"] < 0 and np.log10(unit) == pytest.approx(round(np.log10(unit)), rel=0, abs=1e-3)
    *parts, end = rows.values()
    assert sum(parts) == pytest.approx(end, rel=0, abs=1e-3 * np.abs(parts).max() * len(parts))


@every_scene
def test_impulse_of_friction(runs: Runs, name: str) -> None:
    """The table has it beside that along the normals, and their ratio."""
    run, columns = runs(name), rows_of(runs(name))
    step = run.scene["time"]["step"]
    shown = {row[0]: row[1:] for row in tables_of(report_run.page(run))["With friction"].rows}
    assert list(shown) == list(coefficients(run)) and len(shown) == (2 if name == "jaws" else 1)
    for obstacle, (coefficient, normal, friction, ratio) in shown.items():
        own = columns["obstacle"] == obstacle
        impulse = step * np.array([(columns[f"tangential_force_{axis}"] * own).sum() for axis in "xyz"[: run.dim]])
        impulse *= [0, 1] if run.axisymmetric else 1  # radial forces cancel
        expected, largest = step * (columns["force"] * own).sum(), np.abs(impulse).argmax()
        assert float(ratio) == pytest.approx(np.linalg.norm(impulse) / expected, rel=1e-3, abs=1e-12)
        parts = np.array([float(part) for part in friction[1: friction.index(")")].split(", ")])
        assert np.sign(parts[largest]) == np.sign(impulse[largest])
        assert float(normal.split(" ")[0]) > 0 and normal.endswith(style.per_depth("N s", run.whole))
        assert coefficient == "varies" if obstacle == "dome" else float(ratio) <= float(coefficient) * (1 + 1e-9)
        assert run.axisymmetric or float(ratio) > 0.01


def shown_times(run: RunFolder) -> list[int]:
    """Numbers of the stored times that the picture of the body shows."""
    motion = report_motion.motion(run)
    times = np.array(motion["times"]) * {"s": 1, "ms": 1e-3}[motion["unit"]]
    return [int(np.abs(run.contact.times - time).argmin()) for time in times]


@every_scene
def test_marks_of_the_motion(runs: Runs, name: str) -> None:
    """Each candidate has the mark of its motion in each frame; marks differ in colour and shape."""
    run = runs(name)
    motion = report_motion.motion(run)
    touching, rows, frames = motion["touching"], rows_of(run)["motion"], shown_times(run)
    expected = np.searchsorted(MOTION, rows[frames], sorter=np.argsort(MOTION))
    assert (numbers(touching["on"]).reshape(len(frames), -1) == np.argsort(MOTION)[expected]).all()
    marks = touching["marks"]
    assert marks[STICK - 1]["name"] == "sticks" and marks[SLIP - 1]["name"] == "slips"
    assert len({mark["color"] for mark in marks}) == len({mark["symbol"] for mark in marks}) == 3


@pytest.mark.parametrize("name", ("disc", "revolved"))
def test_fits_a_phone(runs: Runs, name: str, tmp_path: Path) -> None:
    with browser(tmp_path) as driver, opened(driver, page_of(runs(name).path), 390, 844) as reader:
        reader.fits()


@pytest.mark.parametrize("name", ("disc", "revolved"))
def test_marks_in_a_browser(runs: Runs, name: str, tmp_path: Path) -> None:
    """They are drawn at the nodes of a frame, with a legend; the map of stick and slip is drawn too."""
    run = runs(name)
    rows, times = rows_of(run)["motion"], shown_times(run)
    with browser(tmp_path) as driver, opened(driver, page_of(run.path)) as reader:
        legend = reader.ask("document.querySelector('#body .legend').innerText")
        assert "sticks" in legend and "slips" in legend and "in contact\n" not in legend + "\n"
        drawn = []
        for frame in range(0, len(times), 3):
            reader.ask(f"(frame.value = {frame}, frame.dispatchEvent(new Event('input')))")
            drawn.append([reader.ask(f"{BODY}.find((trace) => trace.name === '{what}').x.length") for what in ("sticks", "slips")])
        assert (np.array(drawn) > 0).any(axis=0).all(), "a mark is never drawn"
        assert drawn == [[int((rows[frame] == what).sum()) for what in ("stick", "slip")] for frame in times[::3]]
        views = [option.text for option in reader.find("#contact-surface-view").find_elements("tag name", "option")]
        reader.select("#contact-surface-view", views.index("stick and slip"))
        reader.wait("document.getElementById('contact-surface-plot').data[0].colorbar.ticktext?.includes('slips')")
        reader.fits()


@every_scene
def test_maps_of_friction(runs: Runs, name: str) -> None:
    """In the plane the maps along the surface have a row for each node: its friction, and its motion, of those that occur."""
    run, rows = runs(name), rows_of(runs(name))
    views = views_of(report_run.page(run))["contact-surface"]
    for view in ("friction, mean of two steps", "friction of each step", "slip velocity", "stick and slip"):
        assert view in views
    if run.dim == 3:
        return
    force = rows["tangential_force_x"] * rows["normal_y"] - rows["tangential_force_y"] * rows["normal_x"]
    shown = numbers(views["friction of each step"]["data"][0]["z"])
    shown = shown[~np.isnan(shown).all(axis=1)]
    factor = np.abs(shown).max() / np.abs(force).max()
    assert np.sort(shown.ravel()) == pytest.approx(np.sort(factor * force[1:].ravel()), rel=0, abs=1e-6 * np.abs(shown).max())
    signed = views["friction of each step"]["data"][0]
    assert (force < 0).any() and signed["colorscale"] == "RdBu" and signed["zmin"] == -signed["zmax"]
    slip = numbers(views["slip velocity"]["data"][0]["z"])
    assert (~np.isnan(slip)).sum() == (rows["motion"][1:] != "open").sum(), "it has a value where there is no contact"
    trace = views["stick and slip"]["data"][0]
    level, names = numbers(trace["z"]), trace["colorbar"]["ticktext"]
    for what, label in (("stick", "sticks"), ("slip", "slips"), ("open", "open")):
        assert (level == names.index(label)).sum() == (rows["motion"][1:] == what).sum(), what


def figure_of(module: object, run: RunFolder, monkeypatch: pytest.MonkeyPatch) -> object:
    """The axes of a figure, which is not written."""
    monkeypatch.setattr(style, "save", lambda figure, path: figure)
    return module.draw(run)[0].axes[0]


@every_scene
def test_figures(runs: Runs, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of forces over time, of the nodes' forces at one time, and of energies."""
    run = runs(name)
    lines = {line.get_label(): np.asarray(line.get_ydata()) for line in figure_of(contact_force_history, run, monkeypatch).lines}
    obstacle = "jaw" if name == "jaws" else list(coefficients(run))[0]
    force = mean(summed(run, obstacle)[1])
    force = force[0] if run.dim == 2 else np.linalg.norm(force, axis=0)
    shown = lines["jaw, friction" if name == "jaws" else "friction, mean"]
    factor = np.abs(shown).max() / np.abs(force).max()
    assert shown == pytest.approx(factor * force, rel=0, abs=1e-9 * np.abs(shown).max())
    assert "lost to friction" in [line.get_label() for line in figure_of(energy, run, monkeypatch).lines]
    axes, at = figure_of(contact_force, run, monkeypatch), int(np.abs(run.contact.times - run.figure_time()).argmin())
    counts = {what: int((rows_of(run)["motion"][at] == what).sum()) for what in ("stick", "slip")}
    assert sum(counts.values()) > 0
    if run.dim == 3:
        arrows = [part for part in axes.collections if hasattr(part, "U")]
        assert sum(len(part.U) for part in arrows) == sum(counts.values())
    else:
        marks = {line.get_label(): len(line.get_xdata()) for line in axes.lines}
        assert [marks.get("sticks", 0), marks.get("slips", 0)] == list(counts.values())


@every_scene
def test_film(runs: Runs, name: str) -> None:
    """Its arrows are the whole force, of a body of revolution the whole traction, in a colour for each motion."""
    run = runs(name)
    motion, contact = animation.read_motion(run), run.contact
    forces, frame = motion.forces, int(motion.forces.sizes.sum(axis=1).argmax())
    assert np.abs(forces.friction).max() > 0.01 * forces.largest and forces.largest >= forces.sizes.max()
    if name == "jaws":  # of which each step is a frame
        whole = contact.force[..., None] * contact.normal + contact.friction.force
        expected = np.stack([whole[np.maximum(k - 1, np.minimum(k, 1)): k + 1].mean(axis=0) for k in range(len(whole))])
        assert np.abs(forces.vectors - expected).max() < 1e-12 * np.abs(expected).max()
    sticks = np.isin(forces.motion, STICK)
    assert sticks.any() and (forces.motion == SLIP).any() and not (sticks & (forces.sizes == 0)).any()
    if run.axisymmetric:
        half = forces.friction.shape[1] // 2
        assert (forces.friction[:, :half, 0] == -forces.friction[:, half:, 0]).all()
    stage, motions = animation.Stage(motion), set(forces.motion[frame].tolist())
    stage.picture(frame)
    colours = {tuple(np.round(colour[:3], 3)) for colour in stage.arrows.get_facecolor()}
    assert len(colours) == len(motions & {STICK, SLIP}) + bool(motions - {STICK, SLIP})


def test_beside_a_run_without_friction(runs: Runs) -> None:
    """Two runs side by side: rows and views of friction, with a curve of the run that has it; none if neither has it."""
    page = report_compare.page((runs("smooth disc"), runs("disc")))
    rows, views = {row[0]: row[1:] for row in tables_of(page)["Quantity"].rows}, views_of(page)
    for name in ("Work of friction", "Work of moving surfaces", "Modulus of the impulse of friction", "Most candidates that slip"):
        assert rows[name][0] == "–" and rows[name][1] != "–"
    assert list(views["contact-force"]) == ["normal", "friction"] and list(views["active"]) == ["in contact", "slip", "stick"]
    assert "lost to friction so far" in views["energies"] and "work of moving surfaces so far" not in views["energies"]
    (friction,) = views["contact-force"]["friction"]["data"]
    assert friction["name"].endswith("disc") and np.ptp(numbers(friction["y"])) > 0
    twice = views_of(report_compare.page((runs("disc"), runs("belt"))))
    assert all(len(view["data"]) == 2 for chart in ("contact-force", "active") for view in twice[chart].values())
    smooth = report_compare.page((runs("smooth disc"), runs("smooth belt")))
    assert list(views_of(smooth)["contact-force"]) == [""] and "riction" not in str(tables_of(smooth)["Quantity"].rows)


@pytest.mark.parametrize("name", ("disc", "cube"))
def test_pages_without_friction_know_nothing_of_it(runs: Runs, name: str, tmp_path: Path) -> None:
    """Nor does that of a run of an earlier version, whose scene has no such key."""
    run = runs(f"smooth {name}")
    old = RunFolder(Path(shutil.copytree(run.path, tmp_path / "old")))
    text = (old.path / "scene.toml").read_text()
    assert "friction = 0.0\n" in text
    (old.path / "scene.toml").write_text(text.replace("friction = 0.0\n", ""))
    assert run.touches
    pages = [report_run.page(one) for one in (run, old)]
    assert pages[0].data() == pages[1].data() and pages[0].left_out == pages[1].left_out
    texts = json.dumps(pages[0].data()) + str([table for section in pages[0].sections for table in section.tables]) + str(pages[0].left_out)
    for word in ("riction", "slip", "stick", "marks", "surfaces so far"):
        assert word not in texts, word
    for script in ("figures.py", "report.py"):
        done = subprocess.run([sys.executable, str(SOURCE / "postprocess" / script), str(old.path)], capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr, done.stderr


def test_without_every_step(runs: Runs) -> None:
    """Along a plane obstacle the force is that of every step; along a curved one only the stored steps have it, so that it is not split."""
    everything, some = (views_of(report_run.page(runs(name)))["contact-force"] for name in ("disc", "disc every 7"))
    assert json.dumps(some) == json.dumps(everything) and len(runs("disc every 7").contact.times) < 40
    page = report_run.page(runs("jaws every 7"))
    assert not any("friction" in view for view in views_of(page)["contact-force"]) and "slip-stick" in views_of(page)


def test_coefficients() -> None:
    """A fitted one and an expression have no value; without friction there is none."""
    tables = [{"friction": 0.0}, {"friction": 0.25}, {"friction": "0.1 + x"}, {}]
    run = SimpleNamespace(scene={"contact": tables}, obstacle_names=["a", "b", "c", "d"])
    assert coefficients(run) == {"b": 0.25, "c": None}
    run.scene["unknown"] = [{"of": "friction"}]
    assert coefficients(run) == {"b": None, "c": None}
