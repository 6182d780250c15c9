# SPDX-License-Identifier: GPL-3.0-or-later
"""Body in motion as a page shows it: some of the stored times, rounded to 16 bits; in space the body's surface and a cut
through it; of a body of revolution the half section and the line by which the page revolves it."""

from dataclasses import dataclass

import numpy as np

from . import style
from .animation import enlargement
from .contact_table import FREE, SLIP, STICK
from .files import NotInRun
from .mesh import Mesh
from .report_cut import Cut, cut_open
from .report_fields import Field, stored_fields
from .report_parts import packed, whole
from .run_folder import RunFolder, nearest
from .scenery import Scenery, drawn_obstacles, picture, scenery

MOST_FRAMES = 100
MOST_NUMBERS = 2_000_000  # in all frames, which then take about 5 MB
MOST_NODES = 100_000
MOST_ARROWS = 80
EYE = np.array([0.9, -1.5, 0.55])  # beside a body that is longer along x
# Of the numbers in MOTION from 1: colours and shapes differ, and each has a dark rim on any field.
MARKS = [{"name": "in contact, no friction", "color": "#b4bcc3", "symbol": "circle"},
         {"name": "sticks", "color": style.SKY, "symbol": "square"},
         {"name": "slips", "color": style.VERMILION, "symbol": "diamond"}]  # fmt: skip
ARROW = 0.15  # length of the longest, as a part of the body's size


@dataclass(frozen=True)
class Drawing:
    """Nodes of a run's mesh that a page draws (their numbers there), the triangles between them, and the cut."""

    nodes: np.ndarray
    mesh: Mesh
    edges: np.ndarray
    cut: Cut | None


def motion(run: RunFolder, times: np.ndarray | None = None, enlarged: float | None = None) -> dict:
    """Returns the data of report_motion.js: positions in m, fields frame by frame, both as whole numbers times a scale.

    `times`: the nearest stored ones are shown; by default as many as a page can contain. `enlarged`: factor of displacements;
    by default such that they are visible.
    """
    series = run.field("state", "displacement")
    peak = run.peak_time
    drawing = drawing_of(run, series.mesh, peak)
    mesh, nodes = drawing.mesh, drawing.nodes
    fields = stored_fields(run)
    if times is None:
        times = series.times[frames(series.times, len(nodes) * (run.dim + len(fields)), peak or 0.0)]
    displacement = np.stack([series.at(nearest(series.times, time))[nodes] for time in times])
    enlarged = enlarged or enlargement(np.linalg.norm(displacement, axis=2).max(), mesh.size)
    position = mesh.points + enlarged * displacement
    notes = [scale_note(enlarged), count_note(len(times), len(series.times))]
    obstacles, box = seen_obstacles(run, mesh, times, position, enlarged, notes)
    factor, unit = style.prefixed(times, "s")
    turned = "; lengths in m; drag to turn." if run.dim == 3 else "."
    if run.axisymmetric:
        turned = "; lengths of the revolved body in m, drag to turn it."
    return {
        "dim": run.dim,
        "times": (times * factor).tolist(),
        "start": nearest(times, peak or 0.0),
        "unit": unit,
        "note": "; ".join(notes) + turned,
        "faces": packed(mesh.cells.T, "i4"),
        "edges": packed(drawing.edges, "i4"),
        "points": packed(mesh.points.T),
        "displacement": rounded(enlarged * np.moveaxis(displacement, 2, 1), "i2"),
        "fields": [colouring(field, times, drawing, mesh.size) for field in fields],
        "obstacles": [packed_scenery(obstacle, len(times)) for obstacle in obstacles],
        "touching": touching(run, mesh, times),
        "cut": None if drawing.cut is None else packed_cut(drawing.cut),
        "eye": eye(run, mesh),
        "box": box.tolist(),
    } | ({"axes": run.axis_names, "revolved": {"rim": packed(mesh.rim(), "i4"), "eye": eye_in_space(run)}} if run.axisymmetric else {})


def drawing_of(run: RunFolder, mesh: Mesh, peak: float | None) -> Drawing:
    """Selects all of a plane body; of one in space its surface and the nodes about a cut."""
    faces = mesh.cells if run.dim == 2 else mesh.surface()[0]
    cut = None if run.dim == 2 else cut_open(mesh, faces, cut_point(run, peak), eye(run, mesh))
    nodes = np.unique(np.concatenate([faces.ravel()] + ([] if cut is None else [cut.pairs.ravel()])))
    if len(nodes) > MOST_NODES:
        raise NotInRun(f"{whole(len(nodes))} nodes are too many for a page")
    own = np.zeros(len(mesh.points), int)
    own[nodes] = np.arange(len(nodes))
    small = Mesh(mesh.points[nodes], own[faces])
    edges = small.outline() if run.dim == 2 else np.empty((0, 2))
    return Drawing(nodes, small, edges, None if cut is None else cut.renumbered(own, len(nodes)))


def cut_point(run: RunFolder, peak: float | None) -> np.ndarray | None:
    """Returns the point of the candidate that is pushed the most at a time (s); None without one."""
    if peak is None or not run.has_contact_table:
        return None
    contact = run.contact
    return contact.points[np.argmax(contact.force[nearest(contact.times, peak)])]


def eye(run: RunFolder, mesh: Mesh) -> list[float]:
    """Returns the viewpoint for a body in space: beside its longer side, a little from above, and not behind a wall."""
    if run.dim == 2:
        return [0.0, 0.0, 1.5]
    x, y, _ = np.ptp(mesh.points, axis=0)
    way = EYE if x >= y else np.array([1.5, -0.9, 0.55])
    normal = run.plane_normal
    if normal is not None:
        side = np.array([1.0, 1.0, 1.0])
        side[:2] = np.where((normal[:2] * way[:2] < 0) & (np.abs(normal[:2]) > 0.5), -1, 1)
        side[2] = -1 if normal[2] < -0.5 else 1
        way = way * side
    return way.tolist()


def eye_in_space(run: RunFolder) -> list[float]:
    """Returns the viewpoint for a body of revolution, whose axis is upright: a little from above, or from below under a ceiling."""
    normal = run.plane_normal
    return (EYE * [1, 1, -1 if normal is not None and normal[1] < 0 else 1]).tolist()


def frames(times: np.ndarray, numbers: int, peak: float) -> np.ndarray:
    """Selects the stored times (s) to show, always the last one and that of the peak. `numbers`: size of one frame."""
    stored = len(times)
    most = min(MOST_FRAMES, max(2, MOST_NUMBERS // numbers))
    stride = max(1, -(-(stored - 1) // (most - 1)))
    return np.unique(np.append(np.arange(0, stored, stride), [nearest(times, peak), stored - 1]))


def scale_note(enlarged: float) -> str:
    return "Displacements are true to scale" if enlarged == 1 else f"Displacements are drawn {enlarged:g} times as large"


def count_note(shown: int, stored: int) -> str:
    return "all stored times" if shown == stored else f"{shown} of {whole(stored)} stored times"


def seen_obstacles(run: RunFolder, mesh: Mesh, times: np.ndarray, position: np.ndarray, enlarged: float,
                   notes: list[str]) -> tuple[list[Scenery], np.ndarray]:
    """Returns obstacles and the box of the picture; adds a note if they cannot be drawn."""
    try:
        obstacles = drawn_obstacles(run, enlarged)
    except NotInRun as reason:
        notes.append(f"no obstacle is drawn: {reason}")
        return [], picture([], times, position, mesh.size)
    return scenery(obstacles, times, position, mesh.size)


def packed_scenery(scenery: Scenery, count: int) -> dict:
    """Packs an obstacle for report_motion.js: an offset for each frame if it moves, a shape for each if that changes."""
    shapes = [{"points": packed(points.T), "faces": packed(faces.T, "i4")} for points, faces in scenery.shapes]
    for shape, curve in zip(shapes, scenery.curves):
        shape["curve"] = packed(curve, "i4")
    return {
        "name": scenery.name,
        "shapes": shapes,
        "shape": scenery.shape,
        "offset": packed(scenery.offset.T) if scenery.offset.any() else None,
    }


def packed_cut(cut: Cut) -> dict:
    return {"pairs": packed(cut.pairs.T, "i4"), "weight": packed(cut.weight), "faces": packed(cut.faces.T, "i4"), "name": cut.name}


def colouring(field: Field, times: np.ndarray, drawing: Drawing, size: float) -> dict:
    """Packs a field at the stored times nearest to those given (s)."""
    values = np.stack([field.at(time)[drawing.nodes] for time in times])
    factor, unit = style.prefixed(values, field.unit) if field.prefixed else (1.0, field.unit)
    values = values * factor
    found = {"name": field.name, "label": f"{field.name} ({unit})" if unit else field.name, "factor": factor}
    found |= rounded(values, "i2" if values.min() < 0 else "u2")
    if field.support is not None:
        found |= boundary_field(field, times, drawing, size)
    return found


def boundary_field(field: Field, times: np.ndarray, drawing: Drawing, size: float) -> dict:
    """Packs the edges, in the plane, that carry a field of a part of the boundary, and its vectors as arrows."""
    support = field.support[drawing.nodes]
    edges = drawing.edges[support[drawing.edges.astype(int)].all(axis=1)] if len(drawing.edges) else drawing.edges
    at = np.flatnonzero(support)
    at = at[:: -(-len(at) // MOST_ARROWS)] if len(at) else at
    vectors = np.stack([field.vectors(time)[drawing.nodes[at]] for time in times])
    longest = np.linalg.norm(vectors, axis=2).max() or 1.0
    arrows = rounded(np.moveaxis(vectors, 2, 1) * ARROW * size / longest, "i2")
    return {"edges": packed(edges, "i4"), "at": packed(at, "i4"), "arrows": arrows}


def rounded(values: np.ndarray, kind: str) -> dict:
    """Packs frames of values as whole numbers with their scale."""
    scale = np.abs(values).max(initial=0) / np.iinfo(kind).max or 1.0
    low, high = float(values.min(initial=0)), float(values.max(initial=0))
    return {"values": packed(np.rint(values / scale), kind), "scale": float(scale), "least": low, "largest": high}


def touching(run: RunFolder, mesh: Mesh, times: np.ndarray) -> dict | None:
    """Packs the candidates among the mesh's nodes, and for each frame which of the marks each has, from 1; 0 if it is not in contact."""
    if not run.has_contact or not run.has_contact_table:
        return None
    contact = run.contact
    candidates = np.array([np.abs(mesh.points - point).max(axis=1).argmin() for point in contact.points])
    # A candidate between two nodes, as elements of second degree have them, has no place in the mesh.
    known = np.abs(mesh.points[candidates] - contact.points).max(axis=1) < 1e-9 * mesh.size
    state = contact.touches if contact.friction is None else contact.friction.motion
    state = np.stack([state[nearest(contact.times, time)][known] for time in times])
    if not state.any():
        return None
    found = {"nodes": packed(candidates[known], "i4"), "on": packed(state, "u1")}
    return found if contact.friction is None else found | {"marks": marks_of(state)}


def marks_of(state: np.ndarray) -> list[dict]:
    """Returns the marks of candidates with friction in contact, by the numbers in MOTION from 1; those without a name are not used."""
    used = [number in state for number in (FREE, STICK, SLIP)]
    return [mark | ({} if on else {"name": ""}) for mark, on in zip(MARKS, used)]
