# SPDX-License-Identifier: GPL-3.0-or-later
"""What figures and pages draw of obstacles and controls is what the program computed with: gaps, surfaces, cuts, resultants."""

import base64
import json
import math
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import as_package  # noqa: F401
import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, signorini, stored, table
from signorini.post import animation, report_compare, report_run, shock
from signorini.post.boundary import arc_of
from signorini.post.files import Table, Unreadable
from signorini.post.mesh import Mesh
from signorini.post.obstacles import normals
from signorini.post.report_contact import along_surface, around_contact, contact_surface, touched
from signorini.post.report_control import resultant_of
from signorini.post.report_cut import cut_open
from signorini.post.energy_terms import potential_of_loads
from signorini.post.run_folder import RunFolder, first_largest
from signorini.post.scenery import drawn_obstacles
from signorini.post.surfaces import between
from soft_scenes import REVOLVED, soft

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


@pytest.fixture(scope="module")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, RunFolder]:
    """Runs with obstacles of all shapes."""
    folder, cube = tmp_path_factory.mktemp("shapes"), SQUARE.replace("square.geo", "cube.geo") + IN_SPACE
    return {"plane": run_of(folder, "plane", SQUARE + SHAPES), "space": run_of(folder, "space", cube, mesh__size=0.34)}


@pytest.mark.parametrize("name, number", [*(("plane", i) for i in range(4)), *(("space", i) for i in range(3))])
def test_gaps_lead_to_the_surface(shapes: dict[str, RunFolder], name: str, number: int) -> None:
    """A candidate's gap leads, along its obstacle's normal, to the surface that the run wrote."""
    run = shapes[name]
    obstacle, own = run.obstacles[number], run.contact.of(number)
    assert len(run.obstacles) == len(set(run.contact.obstacle)) == {"plane": 4, "space": 3}[name]
    assert np.ptp(own.gap[0]) > 1e-3, "it is as far from every node"
    assert (obstacle.gap == own.gap[0]).all() and (obstacle.normal == own.normal).all()
    off = off_surface(own.points - own.gap[0][:, None] * own.normal, obstacle.at(0.0))
    # A level set's half-spaces touch it where the node is near.
    near = own.gap[0] <= np.quantile(own.gap[0], 0.2)
    assert off[near].max() < (0.02 if number == len(run.obstacles) - 1 else 2e-3)
    points, facets = obstacle.at(0.0)
    foot = own.points[closest := own.gap[0].argmin()] - own.gap[0][closest] * own.normal[closest]
    turned = normals(points, facets)
    facets, turned = facets[turned.any(axis=1)], turned[turned.any(axis=1)]  # where the level is 0 at a node of its grid some have no area
    facing = turned[np.linalg.norm(points[facets].mean(axis=1) - foot, axis=1).argmin()]
    assert facing @ own.normal[closest] > 0.95, "the surface is turned"


def test_gaps_of_a_moving_plane(shapes: dict[str, RunFolder]) -> None:
    """At any time they are the distance of the moved nodes; drawn enlarged, the nearest node has so many times the gap."""
    run = shapes["plane"]
    series, own, jaw = run.field("state", "displacement"), run.contact.of(0), run.obstacles[0]
    assert jaw.moves and jaw.rigid and jaw.flat and (own.force > 0).any() and len(own.times) == len(series.times) == len(jaw.times)
    nodes = [int(np.abs(series.mesh.points - point).max(axis=1).argmin()) for point in own.points]
    enlarged, normal = 7.0, own.normal[0]
    drawn = drawn_obstacles(run, enlarged)[0]
    touching = np.flatnonzero(own.force.any(axis=0))
    closest = int(touching[np.argmin(own.gap[0][touching])])
    for k, time in enumerate(own.times):
        moved = series.at(k)[nodes]
        assert np.abs((own.points + moved - jaw.at(time)[0][0]) @ normal - own.gap[k]).max() < 1e-12
        assert ((own.gap[k] > 1e-9) <= (own.force[k] == 0)).all() and (own.touches[k] >= (own.force[k] > 0)).all()
        seen = (own.points[closest] + enlarged * moved[closest] - drawn.at(time)[0][0]) @ normal
        assert seen == pytest.approx(enlarged * own.gap[k, closest], rel=0, abs=1e-12)
    assert own.touches.any() and not own.touches.all()


MOVING = """
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


@pytest.fixture(scope="module")
def moving(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    run = run_of(tmp_path_factory.mktemp("moving"), "moving", SQUARE + MOVING)
    times = run.obstacles[0].times
    assert np.array_equal(times, run.contact.times) and times[-1] == run.last_time > 0.1
    return run


def test_balls_that_fly_and_grow_keep_their_points(moving: RunFolder) -> None:
    flying, growing, _ = moving.obstacles
    assert flying.whole and growing.whole and flying.rigid and not growing.rigid
    for time in flying.times:
        assert np.abs(np.linalg.norm(flying.at(time)[0] - [0.2 + 3 * time, -0.6], axis=1) - 0.5).max() < 1e-12
        assert np.abs(np.linalg.norm(growing.at(time)[0] - [0.5, 1.7], axis=1) - 0.3 - time).max() < 1e-12


def test_level_set_has_a_surface_for_each_time(moving: RunFolder) -> None:
    """Each comes from the first."""
    wave = moving.obstacles[2]
    assert not wave.rigid and wave.first_point is not None
    for time in moving.contact.times:
        x, y = wave.at(time)[0].T
        assert len(x) > 20 and np.abs(x + 0.3 - 0.5 * time - 0.05 * np.cos(4 * y + 20 * time)).max() < 1e-4
        start = wave.at(time)[0] - wave.displacement[wave.first_point[list(wave.times).index(time)] :][: len(x)]
        assert np.abs(start[:, 0] + 0.3 - 0.05 * np.cos(4 * start[:, 1])).max() < 0.01


CUTS = {"in the middle": ([0.9, -1.5, 0.5], None, 0.5), "at 0.3": ([1.5, -0.9, 0.5], np.array([0.3, 0.0, 0.0]), 0.3)}


@pytest.mark.parametrize("eye, point, part", CUTS.values(), ids=CUTS)
def test_cut_body_is_closed(shapes: dict[str, RunFolder], eye: list[float], point: np.ndarray | None, part: float) -> None:
    """Shell and section have the volume beyond the plane."""
    nodes, cells, _ = stored(shapes["space"].path, "state", "displacement")
    mesh = Mesh(nodes, cells)
    cut = cut_open(mesh, mesh.surface()[0], point, eye)
    points = np.concatenate([nodes, between(cut.pairs, cut.weight, nodes)])
    a, b, c = np.moveaxis(points[cut.faces], 1, 0)
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(part, rel=0, abs=1e-12)
    section = cut.faces >= len(nodes) + len(cut.pairs) // 2
    a, b, c = np.moveaxis(points[cut.faces[section.all(axis=1)]], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(1, rel=0, abs=1e-12), "the section of a unit cube"
    assert cut.pairs.max() < len(nodes) <= cut.faces.max()


def test_places_without_candidates_have_rows_of_their_own(tmp_path: Path) -> None:
    """Two sides of a square: a row for each node, and one between them that no node has."""
    text = SQUARE + "".join(
        f'[[contact]]\non = "{side}"\nobstacle = {{ shape = "half-space", point = [0, {at}], normal = [0, {up}] }}\n'
        for side, at, up in (("bottom", -0.01, 1), ("top", 1.01, -1)))  # fmt: skip
    run = run_of(tmp_path, "sides", text, initial__velocity=["0", "-1"])
    contact = run.contact.by_node()
    arc = arc_of(run.boundary_mesh, contact.points, contact.most_pushed)
    rows, edges = arc.rows(), arc.edges()
    assert len(set(rows)) == len(contact.points) and len(edges) == len(contact.points) + 2
    empty = set(range(len(edges) - 1)) - set(rows)
    assert len(empty) == 1 and len(set(arc.part)) == 2 and (np.diff(edges) > 0).all()
    low = {row for row, point in zip(rows, contact.points) if point[1] < 0.5}
    low, high, (gap,) = np.array(list(low)), np.array(list(set(rows) - low)), empty
    assert low.max() < gap < high.min() or low.min() > gap > high.max()
    for row, point in zip(rows, contact.points):
        place = arc.position[list(arc.order).index(list(rows).index(row))]
        assert edges[row] < place < edges[row + 1], point


def drawn_without_warnings(*command: object) -> None:
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr


FLOOR = '[[contact]]\non = "bottom"\nobstacle = {{ shape = "half-space", point = {}, normal = {} }}\n'
PLANE, SPACE = SQUARE, SQUARE.replace("square.geo", "cube.geo")
BOTH = pytest.mark.parametrize("dim", (2, 3))


@BOTH
def test_touch_without_force(dim: int, tmp_path: Path) -> None:
    """A body at rest on the floor without a load touches it and pushes nowhere: its page and figures show all of the surface."""
    text = (PLANE if dim == 2 else SPACE.replace("size = 0.2", "size = 0.34")) + FLOOR.format([0] * dim, [0] * (dim - 1) + [1])
    run = run_of(tmp_path, "rest", text, output__fields=["displacement", "pressure"])
    assert run.touches and not run.contact.force.any()
    assert {"gap", "force of each step"} <= set(contact_surface(run).views)
    contact = run.contact.by_node()
    place = along_surface(run, contact) if run.dim == 2 else around_contact(contact)
    assert touched(contact, place) == [place.edges[0], place.edges[-1]]
    for verb in ("report", "figures"):
        drawn_without_warnings(SIGNORINI, verb, run.path)


@pytest.mark.parametrize("on", ({}, {"control__on": "top"}), ids=("body", "top"))
@pytest.mark.parametrize("space", ({}, {"control__space": "cellwise"}), ids=("nodal", "cellwise"))
def test_control_of_one_pushes_with_its_scale(on: dict, space: dict, tmp_path: Path) -> None:
    """The force is the scale times the area or the length."""
    text = SQUARE + '[[clamp]]\non = "left"\n[control]\nscale = 3.0\ninitial = ["0", "-2"]\n'
    text += '[objective]\ndesired = { displacement = ["0", "0"] }\n'
    run = run_of(tmp_path, "control", text, "optimize", optimizer__max_iterations=0, **on, **space)
    force = resultant_of(run, run.field("control", "control"))
    assert force == pytest.approx(np.tile([0.0, -6.0], (10, 1)), rel=0, abs=1e-12)


# --- Models of bodies in the plane ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def revolved(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    run = run_of(tmp_path_factory.mktemp("revolved"), "revolved", REVOLVED)
    assert run.contact.force.any(), "the body never touches"
    return run


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    text = SQUARE.split("viscosity")[0] + FLOOR.format([0, -0.01], [0, 1]) + '[initial]\nvelocity = ["0", "-1"]\n'
    return run_of(tmp_path_factory.mktemp("plate"), "plate", text, mesh__model="plane-stress")


def units_of(run: RunFolder) -> set[str]:
    """Units of forces, energies, impulses and masses on a page."""
    page = report_run.page(run)
    texts = [str(table.head) + str(table.rows) for section in page.sections for table in section.tables]
    for chart in (chart for section in page.sections for chart in section.charts):
        texts += [str(view["layout"]) for view in chart.views.values()]
    return set(re.findall(r"[ ('][mkMGµn]?((?:N s|N|J|g)(?:/m)?)[') ]", "\n".join(texts)))


def test_units_of_models(revolved: RunFolder, plate: RunFolder, shapes: dict[str, RunFolder], tmp_path: Path) -> None:
    """Per metre of depth but for whole bodies; a run of an earlier version, which names no model, is in plane strain."""
    old = RunFolder(Path(shutil.copytree(shapes["plane"].path, tmp_path / "old")))
    manifest = json.loads((old.path / "run.json").read_text())
    del manifest["body"]
    (old.path / "run.json").write_text(json.dumps(manifest) + "\n")
    runs = {"axisymmetric": revolved, "plane-stress": plate, "plane-strain": shapes["plane"], "space": shapes["space"]}
    assert [run.model for run in runs.values()] == list(runs) and old.model == "plane-strain"
    for run in (revolved, plate, shapes["plane"], old):
        assert units_of(run) == {unit + "/m" * (run is not revolved) for unit in ("N", "N s", "J", "g")}, run.model
        assert report_run.objective_unit(run) == ("m⁵ s" if run is revolved else "m⁴ s")


@pytest.mark.parametrize("on", ({}, {"control__on": "top"}), ids=("body", "top"))
@pytest.mark.parametrize("space", ({}, {"control__space": "cellwise"}), ids=("nodal", "cellwise"))
def test_control_of_a_body_of_revolution(on: dict, space: dict, tmp_path: Path) -> None:
    """The force is the scale times the integral over all around the axis; its radial part has no resultant."""
    text = REVOLVED.split("[output]")[0] + '[control]\nscale = 3.0\ninitial = ["1", "-2*x"]\n'
    text += '[objective]\ndesired = { displacement = ["0", "0"] }\n'
    run = run_of(tmp_path, "control", text, "optimize", optimizer__max_iterations=0, **on, **space)
    control = run.field("control", "control")
    points, cells = control.mesh.points, control.mesh.cells
    value = control.at(0)[:, 1] if space else control.at(0)[cells, 1]  # of each cell or of its corners
    assert np.ptp(value) > 10 and (control.at(0)[:, 0] > 0).any()
    if on:
        edges, owner = control.mesh.facets()
        a, b = np.sort(points[edges, 0], axis=1).T
        rings = np.pi * (b**2 - a**2) * (points[edges, 1] > -1e-9).all(axis=1)
        expected = 3 * rings @ value[owner] if space else -12 * np.pi / 3 * 15**3
    else:  # products of linear functions are integrated exactly by the middles of the edges
        corners = points[cells]
        sizes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 2
        middle = (corners + np.roll(corners, 1, axis=1))[..., 0] / 2
        there = value[:, None] if space else (value + np.roll(value, 1, axis=1)) / 2
        expected = 6 * np.pi * sizes @ (middle * there).mean(axis=1)
    assert resultant_of(run, control) == pytest.approx(np.tile([0.0, expected], (40, 1)), rel=1e-11, abs=0)
    drawn_without_warnings(sys.executable, SOURCE / "postprocess" / "figures.py", run.path)


def test_film_of_a_body_of_revolution(revolved: RunFolder) -> None:
    """It shows the full section, with pressures."""
    motion, half = animation.read_motion(revolved), revolved.field("state", "displacement").mesh
    x, y = np.moveaxis(motion.position, 2, 0)
    order, image = np.lexsort((y[0], x[0])), np.lexsort((y[0], -x[0]))
    assert np.array_equal(x[:, order], -x[:, image]) and len(half.points) < len(motion.mesh.points) < 2 * len(half.points)
    assert motion.forces.unit == "Pa" and motion.forces.sizes.max() <= revolved.contact.pressure.max()
    assert motion.forces.directions.sum(axis=0)[0] == 0 and all(obstacle.at(0.0)[0].min() < 0 for obstacle in motion.obstacles)
    low, high = animation.view(motion)
    assert low[0] == -high[0]
    for verb in ("report", "figures"):
        drawn_without_warnings(SIGNORINI, verb, revolved.path)


def test_surface_begins_at_the_axis(revolved: RunFolder) -> None:
    contact = revolved.contact.by_node()
    place = along_surface(revolved, contact)
    assert place.edges[0] == 0 and list(place.rows) == list(np.argsort(np.argsort(contact.points[:, 0])))


def test_body_of_revolution_beside_another(revolved: RunFolder, shapes: dict[str, RunFolder]) -> None:
    """Two of them are compared, one and a plane body are not."""
    page = report_compare.page((revolved, revolved))
    assert any("revolved" in motion for section in page.sections for motion in section.motions)
    for other in shapes.values():
        with pytest.raises(Unreadable, match="found a body of revolution; expected one as in"):
            report_compare.page((other, revolved))


# --- Further runs -----------------------------------------------------------------------------------------------------


@BOTH
def test_moving_clamp(dim: int, tmp_path: Path) -> None:
    """The echoed scene has no initial displacement, which all scripts can do without."""
    value = [*['"0"'] * (dim - 1), '"-0.2*t"']
    text = (PLANE if dim == 2 else SPACE) + f'[[clamp]]\non = "left"\nvalue = [{", ".join(value)}]\n'
    text += FLOOR.format([0] * (dim - 1) + [-0.01], [0] * (dim - 1) + [1])
    run = run_of(tmp_path, "clamped", text, mesh__size=0.34)
    assert "displacement" not in run.scene.get("initial", {}) and run.dim == dim and run.touches
    for script in ("report.py", "figures.py"):
        drawn_without_warnings(sys.executable, SOURCE / "postprocess" / script, run.path)


def test_loads_have_a_potential(tmp_path: Path) -> None:
    """In free fall kinetic energy and potential add up to what they were."""
    run = run_of(tmp_path, "fall", SQUARE + '[load]\nbody = ["0.5", "-3"]\n')
    steps = table(run.path / "steps.csv")
    potential = potential_of_loads(Table(run.path, {**steps, "load_work": steps["external_work"]}.items()))
    energy = steps["kinetic_energy"] + steps["elastic_energy"] + np.cumsum(steps["viscous_dissipation"])
    assert potential[0] > 0.05 and potential.min() == 0 and np.ptp(potential + energy) < 1e-12 * potential[0]
    assert potential_of_loads(Table(run.path, {"external_work": energy}.items())) is None


@pytest.mark.parametrize("force, step", (([0, 0], 0), ([0, 2, 1, 2], 1), ([0, 1, 2, 2 + 1e-12], 2), ([0, 1, 1 + 1e-6, 1], 2),
                                         ([0, 3, 0, 3 - 1e-12], 1)), ids=str)  # fmt: skip
def test_first_of_equal_forces(force: list[float], step: int) -> None:
    """Forces that differ by rounding alone are equal."""
    assert first_largest(np.array(force, float)) == step


# --- Fits beside runs -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Fits:
    """Two fits, the second of more iterations, another run, and the page of the fits by the names of its sections."""

    short: Path
    longer: Path
    other: Path
    page: dict

    @property
    def manifests(self) -> list[dict]:
        return [json.loads((out / "run.json").read_text()) for out in (self.short, self.longer)]

    def charts(self) -> dict[str, dict]:
        return {chart.name: next(iter(chart.views.values())) for chart in self.page["control"].charts}


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Fits:
    short, longer, other = (tmp_path_factory.mktemp("fits") / name for name in ("fit-1", "fit-2", "no-fit"))
    for out, iterations in ((short, 1), (longer, 2)):
        signorini("optimize", SOURCE / "scenes" / "bar-speed.toml", out, optimizer__max_iterations=iterations)
    signorini("simulate", SOURCE / "tests" / "data" / "block.toml", other, mesh__size=0.5, time__end=0.1)
    page = report_compare.page((RunFolder(short), RunFolder(longer)))
    return Fits(short, longer, other, {section.name: section for section in page.sections})


def test_values_of_two_fits(fits: Fits) -> None:
    """Values, deviations and differences."""
    rows = {row[0]: row[2:] for row in fits.page["results"].tables[1].rows}
    unknowns = [fit["unknowns_fitted"] for fit in fits.manifests]
    assert len(rows) == 2 and set(rows) == {one["name"] for one in unknowns[0]}
    for ones in zip(*unknowns):
        a, b = (one["value"] for one in ones)
        assert abs(b - a) > 1e-3 * abs(b), "both fits found the same"
        *texts, difference, ratio = rows[ones[0]["name"]]
        for text, one in zip(texts, ones, strict=True):
            value, deviation = map(float, text.split(" ± "))
            assert one["value"] == pytest.approx(value, rel=5e-6, abs=0)
            assert one["standard_deviation"] == pytest.approx(deviation, rel=5e-3, abs=0)
        assert float(difference) == pytest.approx(b - a, rel=1e-3, abs=0)
        assert float(ratio) == pytest.approx((b - a) / math.hypot(*(one["standard_deviation"] for one in ones)), rel=0.06, abs=0)


def test_misfits_of_two_fits(fits: Fits) -> None:
    results = {row[0]: row[1:3] for row in fits.page["results"].tables[0].rows}
    expected = [float(f"{fit['fit']['misfit']:.6g}") for fit in fits.manifests]
    assert [float(text) for text in results["Misfit, standard deviations"]] == expected


@pytest.mark.parametrize("name", ("objective", "decrement"))
def test_curves_of_two_fits(fits: Fits, name: str) -> None:
    for curve, out in zip(fits.charts()[name]["data"], (fits.short, fits.longer), strict=True):
        drawn = np.frombuffer(base64.b64decode(curve["y"]["bdata"]), "<f4")
        assert drawn == pytest.approx(table(out / "history.csv")[name], rel=1e-6, abs=0), out


def test_objective_of_a_fit_has_no_unit(fits: Fits) -> None:
    assert fits.charts()["objective"]["layout"]["yaxis"]["title"]["text"] == "objective"


@pytest.mark.parametrize("first, second", (("short", "longer"), ("longer", "other"), ("other", "short")))
def test_page_of_a_fit_beside_another_run(fits: Fits, first: str, second: str) -> None:
    pair = getattr(fits, first), getattr(fits, second)
    drawn_without_warnings(SIGNORINI, "report", *pair, "--threads", "1")
    assert (pair[1] / "comparison.html").is_file()


def plot(*words: object) -> subprocess.CompletedProcess:
    return subprocess.run([str(SIGNORINI), "plot", *map(str, words)], capture_output=True, text=True, timeout=100)


def test_convergence_of_a_fit_is_drawn(fits: Fits) -> None:
    done, last = plot(fits.longer), table(fits.longer / "history.csv")
    expected = f"iteration 2: J = {last['objective'][-1]:.6e}, decrement {last['decrement'][-1]:.2e}, "
    assert done.returncode == 0 and not done.stderr and done.stdout.startswith(expected), done.stdout + done.stderr
    assert (fits.longer / "figures" / "convergence.png").stat().st_size > 5000


@pytest.mark.parametrize("run, words, text", (
    ("other", (), "{}: found a run of simulate without history.csv; plot shows the convergence of signorini optimize"),
    ("longer", ("--threads", "0"), "--threads: found 0; expected 1 to 1024")), ids=("simulation", "no threads"))  # fmt: skip
def test_plot_is_refused_at_once(fits: Fits, run: str, words: tuple[str, ...], text: str) -> None:
    out = getattr(fits, run)
    done = plot(out, *words)
    assert done.returncode == 2 and not done.stdout and done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"signorini plot: {text.format(out)}")


def test_spectrum() -> None:
    """The Fourier integral of a decaying exponential, and Parseval's identity, also of uneven samples."""
    t = np.linspace(0, 1, 20001)
    f, modulus = shock.spectrum(t, np.exp(-50 * t)[:, None])
    low = f < 100
    assert np.allclose(modulus[low, 0], 1 / np.hypot(50, 2 * np.pi * f[low]), rtol=3e-3, atol=0)
    uneven = np.sort(np.concatenate([t[::2], t[1:1000:2]]))
    again, same = shock.spectrum(uneven, np.exp(-50 * uneven)[:, None])
    assert np.allclose(np.interp(f[low], again, same[:, 0]), modulus[low, 0], rtol=3e-3, atol=0)


@pytest.mark.parametrize("natural", (20.0, 80.0, 400.0))
def test_shock_response(natural: float) -> None:
    """Of half a sine of 10 ms, against the oscillator's equation solved in short steps by Runge and Kutta's method."""
    t = np.linspace(0, 0.05, 2501)
    a = np.where(t < 0.01, np.sin(np.pi * t / 0.01), 0)
    f, largest = shock.shock_response(t, np.stack([a, -2 * a], axis=1), per_octave=48)
    assert np.allclose(largest[:, 1], 2 * largest[:, 0], rtol=1e-12, atol=0)
    omega, zeta = 2 * np.pi * natural, 1 / (2 * shock.Q)

    def rate(state: np.ndarray, base: float) -> np.ndarray:  # relative displacement and velocity
        return np.array([state[1], -base - 2 * zeta * omega * state[1] - omega**2 * state[0]])

    state, most, h = np.zeros(2), 0.0, 1e-5
    for k in range(int(0.1 / h)):
        base = [np.sin(np.pi * x / 0.01) if x < 0.01 else 0.0 for x in (k * h, (k + 0.5) * h, (k + 1) * h)]
        k1 = rate(state, base[0])
        k2 = rate(state + h / 2 * k1, base[1])
        k3 = rate(state + h / 2 * k2, base[1])
        k4 = rate(state + h * k3, base[2])
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        most = np.maximum(most, abs(2 * zeta * omega * state[1] + omega**2 * state[0]))  # absolute acceleration
    assert np.interp(natural, f, largest[:, 0]) == pytest.approx(most, rel=0.01)
    assert 1.5 < largest[:, 0].max() < 1.77 and largest[-1, 0] == pytest.approx(1, abs=0.05)
