# SPDX-License-Identifier: GPL-3.0-or-later
"""What pages and figures draw of obstacles and bodies, by closed forms."""

import itertools
from pathlib import Path
from types import SimpleNamespace

import as_package  # noqa: F401
import h5py
import numpy as np
import pytest
from signorini.post import animation, report_compare, report_motion, scenery, style, surfaces
from signorini.post.boundary import arc_of
from signorini.post.mesh import Mesh, Series
from signorini.post.obstacles import Obstacle, both_halves, normals
from signorini.post.report_fields import nodal
from signorini.post.view import View

ROUNDING = 1e-12
TIMES = np.linspace(0, 1, 5)


def near(what: str, found: object, expected: object, relative: float = ROUNDING) -> None:
    """Asserts that numbers are equal, relative to the largest expected one and 1."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    assert found.shape == expected.shape, what
    off = np.max(np.abs(found - expected), initial=0)
    assert off <= relative * np.max(np.abs(expected), initial=1), f"{what}: found {found}, expected {expected}"


def obstacle(points: np.ndarray, facets: np.ndarray, **more: object) -> Obstacle:
    """One that is still, with a candidate on the surface."""
    dim = points.shape[1]
    given = {"name": "obstacle", "flat": False, "whole": False, "gap": np.zeros(1), "normal": np.eye(dim)[-1:], "times": TIMES}
    return Obstacle(**given | more, points=np.asarray(points, float), facets=np.asarray(facets))


def circle(middle: list[float], radius: float, count: int = 400, inside: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Its points and segments, with the obstacle to the right; `inside`: the body."""
    angle = np.linspace(0, -2 * np.pi, count, endpoint=False) * (-1 if inside else 1)
    points = np.array(middle) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return points, np.column_stack([np.arange(count), np.roll(np.arange(count), -1)])


def grid(sides: list[float], counts: list[int]) -> np.ndarray:
    """Points of a box from the origin on, the last coordinate changing first."""
    axes = [np.linspace(0, side, count) for side, count in zip(sides, counts)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(sides))


def box_of(sides: list[float], counts: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Points of a box in space and tetrahedra that fill it."""
    number, (ni, nj, nk) = np.arange(np.prod(counts)).reshape(counts), [count - 1 for count in counts]
    corners = [number[i : i + ni, j : j + nj, k : k + nk].ravel() for i, j, k in itertools.product((0, 1), repeat=3)]
    edges = itertools.permutations((1, 2, 4), 2)
    cells = [np.stack([corners[0], corners[one], corners[one | two], corners[7]], axis=1) for one, two in edges]
    return grid(sides, counts), np.concatenate(cells)


def area(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    if points.shape[1] == 2:
        return np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


@pytest.fixture(scope="module")
def box() -> tuple[np.ndarray, np.ndarray]:
    points, cells = box_of([1.0, 0.5, 0.25], [9, 5, 3])
    assert len(points) == 135
    a, b, c, d = np.moveaxis(points[cells], 1, 0)
    near("the box is filled", np.sum(np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a))) / 6, 1 / 8)
    return points, cells


def level(points: np.ndarray, direction: list[float]) -> np.ndarray:
    """A linear function that is 0 in the middle of the box, or beside it where that would be at its nodes."""
    return (points - [0.5, 0.25, 0.125]) @ direction + 1e-3 * (direction[2] == 1)


SECTIONS = (([0.0, 0, 1], 0.5), ([1.0, 1, 0], 0.25 * np.sqrt(0.5)), ([0.0, 1, 2], np.sqrt(5) / 4))


@pytest.mark.parametrize("direction, expected", SECTIONS, ids=("z", "x + y", "y + 2 z"))
def test_zeros_of_linear_functions_are_planes(box: tuple[np.ndarray, np.ndarray], direction: list[float], expected: float) -> None:
    points, cells = box
    pairs, weight, faces = surfaces.zeros(cells, level(points, direction))
    cut = surfaces.between(pairs, weight, points)
    near("on the plane", surfaces.between(pairs, weight, level(points, direction)), np.zeros(len(pairs)))
    near("values go with it", surfaces.between(pairs, weight, points @ [1.0, 2, 3]), cut @ [1.0, 2, 3])
    near("area of a section", np.sum(area(cut, faces)), expected, 1e-9)
    for side in (1, -1):
        p, q, r = np.moveaxis(cut[surfaces.facing(faces, cut, side * np.array(direction))], 1, 0)
        assert np.min(side * np.cross(q - p, r - p) @ direction) >= 0


def test_unknown_value_makes_no_surface(box: tuple[np.ndarray, np.ndarray]) -> None:
    points, cells = box
    middle = level(points, SECTIONS[-1][0])
    count = len(surfaces.zeros(cells, middle)[2])
    middle[np.argmax(points @ [1, 1, 1])] = np.nan
    assert len(surfaces.zeros(cells, middle)[2]) <= count


POLYGON = 200 * np.sin(2 * np.pi / 400)  # the area of a circle's 400 segments, of radius 1


def seen(one: Obstacle, depth: float) -> float:
    return np.sum(area(*surfaces.seen_of(one, 0.0, depth)))


def test_strip_below_a_line() -> None:
    line = np.array([[-1.0, -0.5], [1, 0.5]])
    points, triangles = surfaces.seen_of(obstacle(line, [[0, 1]]), 0.0, 0.2)
    near("area", np.sum(area(points, triangles)), 0.2 * np.sqrt(5))
    near("depth", np.min((points - line[0]) @ [-0.5, 1]) / np.hypot(0.5, 1), -0.2)


def test_disc_is_filled() -> None:
    near("area", seen(obstacle(*circle([0.1, 0.2], 0.5), whole=True), 0.1), POLYGON * 0.25)


def test_strip_of_a_part_of_a_disc() -> None:
    near("area", seen(obstacle(*circle([0.1, 0.2], 0.5)), 0.1), POLYGON * (0.5**2 - 0.4**2), 1e-3)


def test_strip_around_a_hole() -> None:
    near("area", seen(obstacle(*circle([0.1, 0.2], 0.5, inside=True), whole=True), 0.1), POLYGON * (0.6**2 - 0.5**2), 1e-3)


def test_nothing_of_no_curve() -> None:
    assert len(surfaces.seen_of(obstacle(np.empty((0, 2)), np.empty((0, 2), int)), 0.0, 0.2)[1]) == 0


def triangles(counts: list[int]) -> np.ndarray:
    """Cells of a grid in the plane."""
    number = np.arange(np.prod(counts)).reshape(counts)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    return np.stack([part.ravel() for part in corners], axis=1)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


SQUARE = Mesh(grid([1.0, 1], [5, 5]), triangles([5, 5]))
BOTTOM = np.array([[0.5, 0], [0, 0], [1, 0], [0.25, 0], [0.75, 0], [0.375, 0]])


def test_boundary_is_a_loop() -> None:
    (loop,) = SQUARE.loops()
    assert loop[0] == loop[-1] and len(set(loop)) == 16 and set(loop) == set(SQUARE.boundary_nodes())


def test_arc_length_along_a_side() -> None:
    """Middles of edges count."""
    arc = arc_of(SQUARE, BOTTOM, 0)
    near("in order", BOTTOM[arc.order, 0], [0, 0.25, 0.375, 0.5, 0.75, 1])
    near("from the one that is pushed", arc.position, [-0.5, -0.25, -0.125, 0, 0.25, 0.5])
    assert not arc.part.any() and list(arc.rows()[arc.order]) == [0, 1, 2, 3, 4, 5] and len(arc.edges()) == 7


def test_arc_length_along_two_sides() -> None:
    arc = arc_of(SQUARE, np.concatenate([BOTTOM, BOTTOM + [0, 1]]), 2)
    assert sorted(set(arc.part)) == [0, 1] and len(set(arc.rows())) == 12 and set(range(13)) - set(arc.rows()) == {6}
    near("each part is as long as its side", [np.ptp(arc.position[arc.part == part]) for part in (0, 1)], [1, 1])
    near("and far from the other", np.min(np.abs(arc.position[arc.part == 0][:, None] - arc.position[arc.part == 1])), 0.3 * 2)


def test_parts_end_at_nodes_that_are_no_candidates() -> None:
    arc = arc_of(SQUARE, np.array([[0, 0], [0.25, 0], [0, 0.25], [0.75, 0]]), 0)
    assert sorted(np.bincount(arc.part)) == [1, 3], "the corner is one part, and the node between is none of them"


def test_closed_boundary_is_opened_opposite_the_contact() -> None:
    arc = arc_of(SQUARE, SQUARE.points[SQUARE.boundary_nodes()], 3)
    assert not arc.part.any() and list(arc.order).index(3) in (7, 8)
    near("all around", np.diff(arc.position), np.full(15, 0.25))


def test_hole_has_a_boundary_of_its_own() -> None:
    ring, first = np.concatenate([circle([0, 0], 1, 20)[0], circle([0, 0], 0.5, 20)[0]]), np.arange(20)
    after = np.roll(first, -1)
    mesh = Mesh(ring, np.concatenate([np.stack([first, after, first + 20], axis=1), np.stack([after, after + 20, first + 20], axis=1)]))
    assert sorted(map(len, mesh.loops())) == [21, 21]
    assert np.bincount(arc_of(mesh, ring, 5).part).tolist() == [20, 20]


TOUCHING, HOLLOW = (Mesh(SQUARE.points + [at, 0], SQUARE.cells) for at in (0.0, 0.5))  # half sections that reach the axis or do not
HALVES = pytest.mark.parametrize("half", (TOUCHING, HOLLOW), ids=("touching the axis", "hollow"))


@HALVES
def test_rim_revolved_is_the_surface(half: Mesh) -> None:
    """It sweeps the body's surface from outside, and the volume that the cells sweep (Pappus)."""
    (ra, za), (rb, zb) = np.moveaxis(half.points[half.rim()], (1, 2), (0, 1))
    outer, inner = half.points[:, 0].max(), half.points[:, 0].min()
    near("surface", np.sum(np.pi * (ra + rb) * np.hypot(rb - ra, zb - za)), 2 * np.pi * (outer + inner + outer**2 - inner**2))
    near("volume", np.sum(np.pi / 3 * (ra**2 + ra * rb + rb**2) * (zb - za)), np.pi * (outer**2 - inner**2))


@HALVES
def test_mirrored_half_section(half: Mesh) -> None:
    whole, source = half.mirrored()
    near("area", np.sum(area(whole.points, whole.cells)), 2)
    near("image of its node", whole.points, half.points[source] * np.where(np.arange(len(source)) < 25, 1, [[-1], [1]]).T)
    assert len(whole.points) == (45 if half is TOUCHING else 50) and len(whole.loops()) == (1 if half is TOUCHING else 2)


def half_circle(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a circle of radius 1 with x ≥ 0, from above to below, and segments with the disc to their right."""
    angle = np.linspace(np.pi / 2, -np.pi / 2, count + 1)
    return np.column_stack([np.cos(angle), np.sin(angle)]), np.column_stack([np.arange(count), np.arange(1, count + 1)])


def test_half_disc_is_filled_to_the_axis() -> None:
    points, segments = half_circle(200)
    near("half", seen(obstacle(points, segments, whole=True, half=True), 0.1), POLYGON / 2)
    near("both halves", seen(obstacle(points, segments, whole=True, half=True, mirrored=True), 0.1), POLYGON)
    points, segments = both_halves(points, segments)
    near("normals point outwards", np.sign((normals(points, segments) * points[segments].mean(axis=1)).sum(axis=1)), np.ones(400))


RECTANGLE = Mesh(grid([3.0, 2], [4, 3]), triangles([4, 3]))
BOX = Mesh(*box_of([2.0, 2, 4], [3, 3, 5]))
MESHES = pytest.mark.parametrize("mesh", (RECTANGLE, BOX), ids=("plane", "space"))


def test_boundary_of_a_rectangle() -> None:
    points, cells = RECTANGLE.points, RECTANGLE.cells
    edges, of = RECTANGLE.facets()
    near("length", np.sum(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)), 10)
    assert np.array_equal(edges, RECTANGLE.outline()) and all(set(edge) <= set(cells[cell]) for edge, cell in zip(edges.tolist(), of))
    assert list(RECTANGLE.boundary_nodes()) == [n for n in range(12) if n not in (4, 7)] and RECTANGLE.size == 3


def test_boundary_of_a_box() -> None:
    faces, of = BOX.facets()
    near("surface", np.sum(area(BOX.points, faces)), 40)
    p, q, r = np.moveaxis(BOX.points[faces], 1, 0)
    near("volume, from outside", np.sum(np.einsum("ij,ij->i", np.cross(p, q), r)) / 6, 16)
    assert all(set(face) <= set(BOX.cells[cell]) for face, cell in zip(faces.tolist(), of)) and BOX.size == 4
    assert len(BOX.boundary_nodes()) == len(BOX.points) - 3


def series_of(mesh: Mesh, values: np.ndarray, folder: Path) -> Series:
    """A series of one time with values of cells."""
    with h5py.File(folder / "values.h5", "w") as file:
        file["at"] = values
    return Series(mesh, np.array([0.0]), [(folder / "values.h5", "at")], True)


@MESHES
@pytest.mark.parametrize("width", (1, 3, 9))
def test_values_of_cells_at_nodes(mesh: Mesh, width: int, tmp_path: Path) -> None:
    dim, values = mesh.points.shape[1], np.random.default_rng(1).normal(size=(len(mesh.cells), width))
    series = series_of(mesh, values, tmp_path)
    near("components", series.components(0), values)
    near("values", series.values(0), values.reshape(-1, 3, 3) if width == 9 else values[:, :dim] if width == 3 else values)
    if width == 3:
        near("a vector", series.at(0), values[:, :dim])
    found = nodal(series, series.values(0))
    for node in range(len(mesh.points)):
        near("mean of the cells at a node", found[node], series.values(0)[(mesh.cells == node).any(axis=1)].mean(axis=0))


@MESHES
def test_values_of_cells_that_act_at_nodes(mesh: Mesh, tmp_path: Path) -> None:
    dim = mesh.points.shape[1]
    only = np.zeros((len(mesh.cells), dim))
    only[::3] = np.random.default_rng(1).normal(size=only[::3].shape)
    found = nodal(series_of(mesh, np.zeros((len(only), 9)), tmp_path), only, only)
    for node in range(len(mesh.points)):
        there = only[(mesh.cells == node).any(axis=1)]
        acting = there[there.any(axis=1)]
        near("mean of those that act", found[node], acting.mean(axis=0) if len(acting) else np.zeros(dim))


def test_values_of_nodes_stay() -> None:
    points = RECTANGLE.points
    assert nodal(Series(RECTANGLE, np.array([0.0]), [], False), points) is points


@pytest.mark.parametrize("corners", (((1, 2), (3, 2.5)), ((-5, 1), (-4, 31)), ((2, 2), (4, 4))), ids=("wide", "slim", "square"))
def test_box_fills_the_picture(corners: tuple) -> None:
    """More of the world is seen where it is too slim for labels."""
    low, high = np.array(corners, dtype=float)
    axes = style.plan(low, high, ("x", "y"))
    seen = np.array([axes.get_xlim(), axes.get_ylim()]).T
    inches = axes.get_position().size * axes.figure.get_size_inches()
    near("in its middle", seen.mean(axis=0), (low + high) / 2)
    near("of equal scale", inches / (seen[1] - seen[0]), np.full(2, np.min(style.PLAN / (high - low))))
    near("as wide as the box or as labels", inches, np.maximum(np.min(style.PLAN / (high - low)) * (high - low), style.LEAST_PLAN))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "y (m)")


def body(end: float, box: list, *fields: tuple) -> tuple[dict, Series]:
    """A motion to that time, with the fields' names, units, factors and ranges."""
    made = [{"name": name, "label": f"{name} ({unit})", "factor": factor, "scale": factor / 8, "least": factor * least,
             "largest": factor * largest} for name, unit, factor, least, largest in fields]  # fmt: skip
    return {"fields": made, "box": box, "eye": end, "start": end, "note": "."}, Series(None, np.array([0.0, end]), [], False)


SLOW = body(1.0, [[0, 0], [1, 4]], ("speed", "mm/s", 1e3, 0.1, 0.5), ("stress", "Pa", 1.0, 0, 7), ("own", "m", 1.0, 0, 1))
FAST = body(2.0, [[-1, 1], [3, 2]], ("stress", "Pa", 1.0, 1, 9), ("speed", "m/s", 1.0, 0.2, 8))


@pytest.mark.parametrize("pair", ((SLOW, FAST), (FAST, SLOW)), ids=("slow first", "fast first"))
def test_two_motions_have_common_fields_and_one_box(pair: tuple) -> None:
    """The fields that both have, in the unit of the larger values."""
    copies = [dict(one, fields=[dict(field) for field in one["fields"]]) for one, _ in pair]
    motions = report_compare.alike(copies, np.array([0.0, 2]), [own for _, own in pair])
    for one, (own, _) in zip(motions, pair):
        names, found = [field["name"] for field in one["fields"]], {field["name"]: field for field in one["fields"]}
        assert set(names) == {"speed", "stress"} and names == [field["name"] for field in motions[0]["fields"]], "not in one order"
        for name, label, least, largest in (("speed", "speed (m/s)", 0.1, 8), ("stress", "stress (Pa)", 0, 9)):
            assert found[name]["label"] == label and found[name]["factor"] == 1
            near("one range", [found[name][key] for key in ("least", "largest", "scale")], [least, largest, 1 / 8])
        near("one box", one["box"], [[-1, 0], [3, 4]])
        assert one["eye"] == one["start"] == pair[0][0]["eye"]
        assert one["note"] == (". It ends at 1 s and stays as it is then." if own is SLOW[0] else ".")


SIZE = 2.0
POSITION = np.tile(np.array([[0.0, 0], [2, 0], [2, 1]]), (5, 1, 1))  # of a body that is still
LINE = np.array([[-5.0, -0.5], [9, -0.5]]), [[0, 1]]


def beside(one: Obstacle) -> tuple[object, np.ndarray]:
    """An obstacle over the frames of a picture, and the picture's box."""
    found, box = scenery.scenery([one], TIMES, POSITION, SIZE)
    assert len(found) == 1
    return found[0], box


def test_obstacle_that_is_still() -> None:
    still, box = beside(obstacle(*LINE, flat=True))
    near("the body and a margin", box, np.array([[0.0, 0], [2, 1]]) + scenery.MARGIN * SIZE * np.array([[-1], [1]]))
    assert len(still.shapes) == 1 and list(still.shape) == [0] * 5 and not still.offset.any()
    assert report_motion.packed_scenery(still, 5)["offset"] is None


def test_obstacle_that_rises() -> None:
    """One shape comes along."""
    moved = np.stack([np.zeros(5), TIMES - 0.5], axis=1)
    rising, _ = beside(obstacle(*LINE, flat=True, displacement=np.tile(moved[:, None], (1, 2, 1))))
    where = [points + rising.offset[i] for i, (points, _) in ((i, rising.shapes[rising.shape[i]]) for i in range(5))]
    near("where it is in each frame", [points[:, 1].max() for points in where], TIMES - 1)
    assert report_motion.packed_scenery(rising, 5)["offset"] is not None, "it moves along one axis alone"


def test_obstacle_that_grows() -> None:
    """It has one shape a frame."""
    points, segments = circle([1, -0.6], 0.5)
    growth = 0.5 * TIMES[:, None, None] * (points - [1, -0.6])
    growing, box = beside(obstacle(points, segments, whole=True, displacement=growth))
    assert len(growing.shapes) == 5 and list(growing.shape) == [0, 1, 2, 3, 4] and not growing.offset.any()
    near("its size in each frame", [np.ptp(points[:, 0]) for points, _ in growing.shapes], 1 + TIMES / 2, 0.01)
    near("all of it is in the picture", box[0, 1], -1.35 - scenery.BAND * SIZE)


def test_obstacle_that_is_far() -> None:
    assert scenery.scenery([obstacle(*circle([1, 9], 1), whole=True)], TIMES, POSITION, SIZE)[0] == []


def test_obstacle_with_another_surface_at_each_time() -> None:
    """Its points are drawn where their motion, enlarged, takes them."""
    first = {"first_point": np.array([0, 2, 5, 7, 9, 11]), "first_facet": np.array([0, 1, 3, 4, 5, 6])}
    line = np.column_stack([np.arange(11.0), np.zeros(11)])
    facets = [[0, 1], [0, 1], [1, 2], [0, 1], [0, 1], [0, 1]]
    moved = np.column_stack([np.zeros(11), np.repeat(TIMES, np.diff(first["first_point"]))])
    changing = obstacle(line, facets, displacement=moved, **first)
    points, segments = changing.drawn(3.0, np.array([0, 10.0])).at(0.25)
    near("of its time alone", points, [[2, 10.75], [3, 10.75], [4, 10.75]])
    assert segments.tolist() == [[0, 1], [1, 2]] and changing.moves and not changing.rigid


@pytest.mark.parametrize("enlarged", (1, 10, 5e7))
@pytest.mark.parametrize("sides", ([1.0, 10], [10, 10], [10, 1]), ids=("narrow", "square", "flat"))
def test_scale_of_a_film_is_beside_the_name_of_the_axis(sides: list[float], enlarged: float) -> None:
    mesh = SimpleNamespace(size=np.max(sides))
    motion = SimpleNamespace(mesh=mesh, position=np.array([[[0, 0], sides]]), box=np.array([[0, 0], sides]), obstacles=[], forces=None,
                             enlarged=enlarged, view=View(np.eye(2), ("radius", "height")))  # fmt: skip
    axes = animation.scenery(motion)
    name, scale = axes.xaxis.label.get_window_extent(), axes.texts[0].get_window_extent()
    assert name.x1 + 10 < scale.x0 and scale.x1 < axes.figure.bbox.x1 and scale.y0 > 0


def test_long_numbers_have_room() -> None:
    axes = style.plan(np.array([0.0, -17.5]), np.array([17.5, 0.0]), ("x", "y"))
    assert np.max([len(label.get_text()) for label in axes.get_yticklabels()]) > 4 and axes.yaxis.get_tightbbox().x0 > 0


FORCE = np.array([[0.0, 1, 0], [0, 0, 0], [0, 1, 2]])


@pytest.mark.parametrize("force, nearest", ((FORCE, 2), (0 * FORCE, 0), (None, 0)), ids=("touched", "not touched", "no table"))
def test_nearness_is_that_of_candidates_that_touch(force: np.ndarray | None, nearest: int) -> None:
    three = obstacle(*circle([0, 0], 1), gap=np.array([0.1, 0.3, 0.2]), normal=np.array([[0.0, 1], [1, 0], [0.6, 0.8]]))
    contact = SimpleNamespace(of=lambda number: SimpleNamespace(force=force))
    (drawn,) = scenery.drawn_obstacles(SimpleNamespace(has_contact_table=force is not None, contact=contact, obstacles=[three]), 5.0)
    near("its gap is enlarged", drawn.shift, -4 * three.gap[nearest] * three.normal[nearest])
