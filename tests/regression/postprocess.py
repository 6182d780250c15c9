# SPDX-License-Identifier: GPL-3.0-or-later
"""What figures and pages draw of obstacles and controls is what the program computed with: gaps, surfaces, cuts, resultants."""

import base64
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, signorini, stored, table  # noqa: E402
from soft_scenes import soft  # noqa: E402

sys.path.insert(0, str(SOURCE / "postprocess"))
import as_package  # noqa: E402, F401
import numpy as np  # noqa: E402
from signorini.post import report_compare  # noqa: E402

from signorini.post.boundary import arc_of  # noqa: E402
from signorini.post.files import Table  # noqa: E402
from signorini.post.mesh import Mesh  # noqa: E402
from signorini.post.obstacles import normals  # noqa: E402
from signorini.post.report_contact import along_surface, around_contact, contact_surface, touched  # noqa: E402
from signorini.post.report_control import resultant_of  # noqa: E402
from signorini.post.report_cut import cut_open  # noqa: E402
from signorini.post.run_folder import RunFolder, first_largest, potential_of_loads  # noqa: E402
from signorini.post.scenery import drawn_obstacles  # noqa: E402
from signorini.post.surfaces import between  # noqa: E402

DATA = SOURCE / "tests" / "data"
SQUARE = soft("square.geo", 0.2, 0.2, 0.02)
SHAPES = """
[[contact]]
on = "left"
obstacle = { shape = "half-space", point = ["-0.05 + t", 0.5], normal = [2, 0.1] }

[[contact]]
on = "bottom"
obstacle = { shape = "ball", center = [0.4, -1], radius = 0.9 }

[[contact]]
on = "top"
obstacle = { shape = "cylinder", point = [0.5, 0.4], radius = 1.1, side = "inside" }

[[contact]]
on = "bottom"
obstacle = { shape = "signed-distance", distance = "2*y + 0.3 - 0.1*cos(3*x)^2" }
"""
IN_SPACE = """
[[contact]]
on = "bottom"
obstacle = { shape = "ball", center = [0.4, 0.4, -1], radius = 0.9 }

[[contact]]
on = "top"
obstacle = { shape = "cylinder", point = [0.5, 0.4, 1.55], axis = [1, 1, 0.5], radius = 0.2 }

[[contact]]
on = "left"
obstacle = { shape = "signed-distance", distance = "x > -5 ? exp(x + 0.2) - 1 + 0.05*sin(y*z) : -1" }
"""


def run_of(folder: Path, name: str, text: str, verb: str = "simulate", **overrides: object) -> RunFolder:
    scene = folder / f"{name}.toml"
    scene.write_text(text)
    signorini(verb, scene, folder / name, **overrides)
    return RunFolder(folder / name)


def off_surface(points: np.ndarray, surface: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """How far points are from the nearest segment, in space from the plane of the triangle whose middle is nearest."""
    corners = surface[0][surface[1]]
    if points.shape[1] == 3:
        nearest = np.linalg.norm(points[:, None] - corners.mean(axis=1), axis=2).argmin(axis=1)
        return np.abs(((points - corners[nearest, 0]) * normals(*surface)[nearest]).sum(axis=1))
    start, side = corners[:, 0], corners[:, 1] - corners[:, 0]
    part = np.clip(((points[:, None] - start) * side).sum(axis=2) / (side**2).sum(axis=1), 0, 1)
    return np.linalg.norm(points[:, None] - start - part[:, :, None] * side, axis=2).min(axis=1)


def surfaces_are_where_gaps_lead(folder: Path) -> None:
    """A candidate's gap leads, along its obstacle's normal, to the surface that the run wrote; of a moving plane at any time."""
    runs = [run_of(folder, "plane", SQUARE + SHAPES), run_of(folder, "space", SQUARE.replace("square.geo", "cube.geo") + IN_SPACE, mesh__size=0.34)]
    for run in runs:
        contact = run.contact
        assert len(run.obstacles) == len(set(contact.obstacle)) >= 3
        for i, obstacle in enumerate(run.obstacles):
            own = contact.of(i)
            assert np.ptp(own.gap[0]) > 1e-3, f"{obstacle.name} is as far from every node"
            assert (obstacle.gap == own.gap[0]).all() and (obstacle.normal == own.normal).all()
            off = off_surface(own.points - own.gap[0][:, None] * own.normal, obstacle.at(0.0))
            # A level set's half-spaces touch it where the node is near.
            near = own.gap[0] <= np.quantile(own.gap[0], 0.2)
            assert off[near].max() < (0.02 if i == len(run.obstacles) - 1 else 2e-3), f"{obstacle.name}: {off[near].max()}"
            points, facets = obstacle.at(0.0)
            foot = own.points[closest := own.gap[0].argmin()] - own.gap[0][closest] * own.normal[closest]
            turned = normals(points, facets)
            facets, turned = facets[turned.any(axis=1)], turned[turned.any(axis=1)]  # where the level is 0 at a node of its grid some have no area
            facing = turned[np.linalg.norm(points[facets].mean(axis=1) - foot, axis=1).argmin()]
            assert facing @ own.normal[closest] > 0.95, f"{obstacle.name} is turned"
    run = RunFolder(folder / "plane")
    series, own, jaw = run.field("state.xdmf", "displacement"), run.contact.of(0), run.obstacles[0]
    assert jaw.moves and jaw.rigid and jaw.flat and (own.force > 0).any() and len(own.times) == len(series.times) == len(jaw.times)
    nodes = [int(np.abs(series.mesh.points - point).max(axis=1).argmin()) for point in own.points]
    enlarged = 7.0
    drawn = drawn_obstacles(run, enlarged)[0]
    touching = np.flatnonzero(own.force.any(axis=0))
    closest = int(touching[np.argmin(own.gap[0][touching])])
    for k, time in enumerate(own.times):
        moved, way = series.at(k)[nodes], own.normal[0]
        assert np.abs((own.points + moved - jaw.at(time)[0][0]) @ way - own.gap[k]).max() < 1e-12
        assert ((own.gap[k] > 1e-9) <= (own.force[k] == 0)).all() and (own.touches[k] >= (own.force[k] > 0)).all()
        # Drawn enlarged, the nearest node has so many times the gap.
        seen = (own.points[closest] + enlarged * moved[closest] - drawn.at(time)[0][0]) @ way
        assert abs(seen - enlarged * own.gap[k, closest]) < 1e-12, (seen, own.gap[k, closest])
    assert own.touches.any() and not own.touches.all()


def obstacles_that_move(folder: Path) -> None:
    """A ball that flies and one that grows keep their points; a level set has a surface for each time, which comes from the first."""
    moving = """
[[contact]]
on = "bottom"
obstacle = { name = "flying", shape = "ball", center = ["0.2 + 3*t", -0.6], radius = 0.5 }

[[contact]]
on = "top"
obstacle = { name = "growing", shape = "ball", center = [0.5, 1.7], radius = "0.3 + t" }

[[contact]]
on = "left"
obstacle = { name = "wave", shape = "signed-distance", distance = "x + 0.3 - 0.5*t - 0.05*cos(4*y + 20*t)" }
"""
    run = run_of(folder, "moving", SQUARE + moving)
    flying, growing, wave = run.obstacles
    assert flying.whole and growing.whole and flying.rigid and not growing.rigid and not wave.rigid and wave.first_point is not None
    assert np.array_equal(flying.times, run.contact.times) and flying.times[-1] == run.last_time > 0.1
    for time in flying.times:
        assert np.abs(np.linalg.norm(flying.at(time)[0] - [0.2 + 3 * time, -0.6], axis=1) - 0.5).max() < 1e-12
        assert np.abs(np.linalg.norm(growing.at(time)[0] - [0.5, 1.7], axis=1) - 0.3 - time).max() < 1e-12
        x, y = wave.at(time)[0].T
        assert len(x) > 20 and np.abs(x + 0.3 - 0.5 * time - 0.05 * np.cos(4 * y + 20 * time)).max() < 1e-4
        start = wave.at(time)[0] - wave.displacement[wave.first_point[list(wave.times).index(time)]:][: len(x)]
        assert np.abs(start[:, 0] + 0.3 - 0.05 * np.cos(4 * start[:, 1])).max() < 0.01


def half_a_body_is_left(folder: Path) -> None:
    """Shell and section of a cut body are closed and hold the volume beyond the plane."""
    nodes, cells, _ = stored(folder / "space", "state", "displacement")
    mesh = Mesh(nodes, cells)
    faces, _ = mesh.surface()
    for eye, point, part in (([0.9, -1.5, 0.5], None, 0.5), ([1.5, -0.9, 0.5], np.array([0.3, 0.0, 0.0]), 0.3)):
        cut = cut_open(mesh, faces, point, eye)
        points = np.concatenate([nodes, between(cut.pairs, cut.weight, nodes)])
        a, b, c = np.moveaxis(points[cut.faces], 1, 0)
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        assert abs(volume - part) < 1e-12, volume
        section = cut.faces >= len(nodes) + len(cut.pairs) // 2
        a, b, c = np.moveaxis(points[cut.faces[section.all(axis=1)]], 1, 0)
        assert abs(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 - 1) < 1e-12, "the section of a unit cube"
        assert cut.pairs.max() < len(nodes) <= cut.faces.max()


def places_without_candidates_have_rows_of_their_own(folder: Path) -> None:
    """Two sides of a square: a row for each node, and one between them that no node has."""
    text = SQUARE + "".join(
        f'[[contact]]\non = "{side}"\nobstacle = {{ shape = "half-space", point = [0, {at}], normal = [0, {way}] }}\n'
        for side, at, way in (("bottom", -0.01, 1), ("top", 1.01, -1)))
    run = run_of(folder, "sides", text, initial__velocity=["0", "-1"])
    contact = run.contact.by_node()
    arc = arc_of(run.boundary_mesh, contact.points, contact.most_pushed)
    rows, edges = arc.rows(), arc.edges()
    assert len(set(rows)) == len(contact.points) and len(edges) == len(contact.points) + 2, (len(edges), len(contact.points))
    empty = set(range(len(edges) - 1)) - set(rows)
    assert len(empty) == 1 and len(set(arc.part)) == 2 and (np.diff(edges) > 0).all()
    low = {row for row, point in zip(rows, contact.points) if point[1] < 0.5}
    low, high, (gap,) = np.array(list(low)), np.array(list(set(rows) - low)), empty
    assert low.max() < gap < high.min() or low.min() > gap > high.max()
    for row, point in zip(rows, contact.points):
        place = arc.position[list(arc.order).index(list(rows).index(row))]
        assert edges[row] < place < edges[row + 1], point


def touch_without_force(folder: Path) -> None:
    """A body at rest on the floor without a load touches it and pushes nowhere: its page and figures show all of the surface."""
    floor = '[[contact]]\non = "bottom"\nobstacle = { shape = "half-space", point = [0, 0], normal = [0, 1] }\n'
    space = floor.replace("[0, 0], normal = [0, 1]", "[0, 0, 0], normal = [0, 0, 1]")
    for name, text in (("rest", SQUARE + floor), ("rest-in-space", SQUARE.replace("square.geo", "cube.geo").replace("size = 0.2", "size = 0.34") + space)):
        run = run_of(folder, name, text, output__fields=["displacement", "pressure"])
        assert run.touches and not run.contact.force.any()
        views = contact_surface(run).views
        assert {"gap", "force of each step"} <= set(views), set(views)
        contact = run.contact.by_node()
        place = along_surface(run, contact) if run.dim == 2 else around_contact(contact)
        assert touched(contact, place) == [place.edges[0], place.edges[-1]]
        for verb in ("report", "figures"):
            done = subprocess.run([SIGNORINI, verb, run.path], capture_output=True, text=True)
            assert done.returncode == 0 and not done.stderr, done.stderr


def controls_add_up(folder: Path) -> None:
    """A control of one pushes with its scale times the area or the length, in each space of controls."""
    base = SQUARE + '[[clamp]]\non = "left"\n[control]\nscale = 3.0\ninitial = ["0", "-2"]\n'
    base += '[objective]\ndesired = { displacement = ["0", "0"] }\n'
    for name, more in (("body", {}), ("cells", {"control__space": "cellwise"}), ("top", {"control__on": "top"}),
                       ("top-cells", {"control__on": "top", "control__space": "cellwise"})):  # fmt: skip
        run = run_of(folder, name, base, "optimize", optimizer__max_iterations=0, **more)
        force = resultant_of(run, run.field("control.xdmf", "control"))
        assert len(force) == 10 and np.abs(force - [0.0, -6.0]).max() < 1e-12, f"{name}: {force[0]}"


def a_held_body_that_is_moved(folder: Path) -> None:
    """The echoed scene of a moving clamp has no initial displacement, which all scripts can do without."""
    for space, mesh in ((2, "square.geo"), (3, "cube.geo")):
        text = SQUARE.replace("square.geo", mesh)
        way = ", ".join(['"0"'] * (space - 1))
        text += f'[[clamp]]\non = "left"\nvalue = [{way}, "-0.2*t"]\n[contact]\non = "bottom"\n'
        point, normal = [0] * (space - 1) + [-0.01], [0] * (space - 1) + [1]
        text += f'obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}\n'
        run = run_of(folder, f"held-{space}", text, mesh__size=0.34)
        assert "displacement" not in run.scene.get("initial", {}) and run.dim == space and run.touches
        for script in ("report.py", "figures.py"):
            done = subprocess.run([sys.executable, SOURCE / "postprocess" / script, run.path], capture_output=True, text=True)
            assert done.returncode == 0 and not done.stderr, done.stderr


def loads_have_a_potential(folder: Path) -> None:
    """In free fall kinetic energy and potential add up to what they were."""
    run = run_of(folder, "fall", SQUARE + '[load]\nbody = ["0.5", "-3"]\n')
    steps = table(run.path / "steps.csv")
    fall = Table(run.path, {**steps, "load_work": steps["external_work"]}.items())
    potential = potential_of_loads(fall)
    energy = steps["kinetic_energy"] + steps["elastic_energy"] + np.cumsum(steps["viscous_dissipation"])
    assert potential[0] > 0.05 and potential.min() == 0 and np.ptp(potential + energy) < 1e-12 * potential[0]
    assert potential_of_loads(Table(run.path, {"external_work": energy}.items())) is None


def fits_beside_runs(folder: Path) -> None:
    """Two fits, and a fit and another run, have a page; a fit's convergence is drawn, that of a simulation refused at once."""
    short, longer, other = folder / "fit-1", folder / "fit-2", folder / "no-fit"
    scene = SOURCE / "scenes" / "bar-speed.toml"
    for out, iterations in ((short, 1), (longer, 2)):
        signorini("optimize", scene, out, optimizer__max_iterations=iterations)
    signorini("simulate", SOURCE / "tests" / "data" / "block.toml", other, mesh__size=0.5, time__end=0.1)
    two = report_compare.page((RunFolder(short), RunFolder(longer)))
    parts = {section.name: section for section in two.sections}
    rows = {row[0]: row[2:] for row in parts["results"].tables[1].rows}
    fits = [json.loads((out / "run.json").read_text()) for out in (short, longer)]
    assert len(rows) == 2 and set(rows) == {one["name"] for one in fits[0]["unknowns_fitted"]}
    for ones in zip(*(fit["unknowns_fitted"] for fit in fits)):
        a, b = (one["value"] for one in ones)
        scale = math.hypot(*(one["standard_deviation"] for one in ones))
        found = rows[ones[0]["name"]]
        assert abs(b - a) > 1e-3 * abs(b), "both fits found the same"
        for text, one in zip(found, ones):
            value, deviation = map(float, text.split(" ± "))
            assert abs(value - one["value"]) <= 5e-6 * abs(value) and abs(deviation - one["standard_deviation"]) <= 5e-3 * deviation
        assert abs(float(found[2]) - (b - a)) <= 1e-3 * abs(b - a) and abs(float(found[3]) - (b - a) / scale) <= 0.06 * abs(b - a) / scale
    charts = {chart.name: next(iter(chart.views.values())) for chart in parts["control"].charts}
    for name, column in (("objective", "objective"), ("decrement", "decrement")):
        for curve, out in zip(charts[name]["data"], (short, longer), strict=True):
            drawn = np.frombuffer(base64.b64decode(curve["y"]["bdata"]), "<f4")
            assert np.allclose(drawn, table(out / "history.csv")[column], rtol=1e-6, atol=0), (name, out)
    assert charts["objective"]["layout"]["yaxis"]["title"]["text"] == "objective", "J of a fit has no unit"
    results = {row[0]: row[1:3] for row in parts["results"].tables[0].rows}
    assert [float(text) for text in results["Misfit, standard deviations"]] == [float(f"{fit['fit']['misfit']:.6g}") for fit in fits]
    for pair in ((short, longer), (longer, other), (other, short)):
        done = subprocess.run([str(SIGNORINI), "report", *map(str, pair), "--threads", "1"], capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr and (pair[1] / "comparison.html").is_file(), done.stderr
    done = subprocess.run([str(SIGNORINI), "plot", str(longer)], capture_output=True, text=True, timeout=100)
    last = table(longer / "history.csv")
    expected = f"iteration 2: J = {last['objective'][-1]:.6e}, decrement {last['decrement'][-1]:.2e}, "
    assert done.returncode == 0 and not done.stderr and done.stdout.startswith(expected), done.stdout + done.stderr
    assert (longer / "figures" / "convergence.png").stat().st_size > 5000
    for words, said in (((other,), f"{other}: found a run of simulate without history.csv; plot shows the convergence of signorini optimize"),
                        ((longer, "--threads", "0"), "--threads: found 0; expected 1 to 1024")):  # fmt: skip
        done = subprocess.run([str(SIGNORINI), "plot", *map(str, words)], capture_output=True, text=True, timeout=100)
        assert done.returncode == 2 and not done.stdout and done.stderr.startswith(f"signorini plot: {said}") and done.stderr.count("\n") == 1, done.stderr


def largest_steps() -> None:
    """Of equal forces the first, of those that differ by rounding alone too."""
    for force, step in (([0, 0], 0), ([0, 2, 1, 2], 1), ([0, 1, 2, 2 + 1e-12], 2), ([0, 1, 1 + 1e-6, 1], 2), ([0, 3, 0, 3 - 1e-12], 1)):
        assert first_largest(np.array(force, float)) == step, force


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        surfaces_are_where_gaps_lead(folder)
        obstacles_that_move(folder)
        half_a_body_is_left(folder)
        places_without_candidates_have_rows_of_their_own(folder)
        touch_without_force(folder)
        controls_add_up(folder)
        a_held_body_that_is_moved(folder)
        loads_have_a_potential(folder)
        largest_steps()
        fits_beside_runs(folder)
        print("obstacles, surfaces, cuts, places, controls, moving clamps, potentials and fits hold")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
