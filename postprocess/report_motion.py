"""The body in motion as a page shows it: some of the stored times, rounded to 16 bits, of a body in space its surface."""

from collections.abc import Iterator

import numpy as np

import style
from animation import enlargement
from report_parts import packed, whole
from run_folder import HalfSpace, Mesh, NotInRun, RunFolder, Series, nearest

MOST_FRAMES = 100
MOST_NUMBERS = 2_000_000  # in all frames, which then take about 5 MB
MOST_NODES = 100_000
BAND = 0.06  # thickness of what is drawn of the obstacle, as a part of the body's size


def motion(run: RunFolder) -> dict:
    """What report.js draws: positions in m, fields frame by frame, both as whole numbers times a scale."""
    series = run.field("state.xdmf", "displacement")
    faces = series.mesh.cells if run.dim == 2 else series.mesh.surface()[0]
    nodes, own = np.unique(faces, return_inverse=True)
    if len(nodes) > MOST_NODES:
        raise NotInRun(f"{whole(len(nodes))} nodes are more than a page can hold")
    mesh = Mesh(series.mesh.points[nodes], own.reshape(-1, 3))
    fields = list(stored_fields(run))
    shown = frames(len(series.times), len(nodes) * (run.dim + len(fields)))
    times = series.times[shown]

    displacement = np.stack([series.at(i)[nodes] for i in shown])
    enlarged = enlargement(np.linalg.norm(displacement, axis=2).max(), mesh.size)
    position = mesh.points + enlarged * displacement
    obstacle = drawn_obstacle(run, mesh, position, enlarged)
    everything = np.concatenate([position.reshape(-1, run.dim), position[0] if obstacle is None else obstacle])
    factor, unit = style.prefixed(times, "s")
    return {
        "dim": run.dim,
        "times": (times * factor).tolist(),
        "unit": unit,
        "note": note(len(shown), len(series.times), enlarged, run.dim),
        "faces": packed(mesh.cells.T, "i4"),
        "edges": packed(mesh.outline() if run.dim == 2 else np.empty((0, 2)), "i4"),
        "points": packed(mesh.points.T),
        "displacement": rounded(enlarged * np.moveaxis(displacement, 2, 1), "i2"),
        "fields": [colouring(*field, times, nodes) for field in fields],
        "obstacle": None if obstacle is None else packed(obstacle.T),
        "touching": touching(run, mesh, times),
        "size": mesh.size,
        "box": [everything.min(axis=0).tolist(), everything.max(axis=0).tolist()],
    }


def frames(stored: int, numbers: int) -> np.ndarray:
    """Which of the stored times are shown, the last one always; numbers in one frame."""
    most = min(MOST_FRAMES, max(2, MOST_NUMBERS // numbers))
    stride = max(1, -(-(stored - 1) // (most - 1)))
    return np.unique(np.append(np.arange(0, stored, stride), stored - 1))


def note(shown: int, stored: int, enlarged: float, dim: int) -> str:
    """What the picture does not tell by itself."""
    scale = "Displacements are true to scale" if enlarged == 1 else f"Displacements are drawn {enlarged:g} times as large"
    count = "all stored times" if shown == stored else f"{shown} of {whole(stored)} stored times"
    return f"{scale}; {count}{'' if dim == 2 else '; lengths in m; drag to turn'}."


def stored_fields(run: RunFolder) -> Iterator[tuple[str, str, Series]]:
    """Those whose magnitude may colour the body: name, unit, values."""
    for file, name, unit in (("state.xdmf", "displacement", "m"), ("state.xdmf", "velocity", "m/s"),
                             ("control.xdmf", "control", ""), ("adjoint.xdmf", "adjoint", "")):  # fmt: skip
        try:
            yield name, unit, run.field(file, name)
        except NotInRun:
            continue


def colouring(name: str, unit: str, series: Series, times: np.ndarray, nodes: np.ndarray) -> dict:
    """The magnitude at the stored times nearest to those given (s)."""
    values = np.stack([np.linalg.norm(nodal(series, nearest(series.times, time)), axis=1)[nodes] for time in times])
    factor, unit = style.prefixed(values, unit) if unit else (1.0, "× control.scale" if name == "control" else "")
    return {"name": name, "label": f"{name} ({unit})" if unit else name} | rounded(values * factor, "u2")


def nodal(series: Series, index: int) -> np.ndarray:
    """Values at the nodes; of a field that is constant in each cell the mean over the cells there."""
    values, mesh = series.at(index), series.mesh
    if not series.cellwise:
        return values
    total, count = np.zeros((len(mesh.points), values.shape[1])), np.zeros(len(mesh.points))
    for corner in mesh.cells.T:
        np.add.at(total, corner, values)
        np.add.at(count, corner, 1)
    return total / count[:, None]


def rounded(values: np.ndarray, kind: str) -> dict:
    """Frames of values as whole numbers and what one of them stands for."""
    scale = np.abs(values).max() / np.iinfo(kind).max or 1.0
    return {"values": packed(np.rint(values / scale), kind), "scale": float(scale), "largest": float(values.max())}


def drawn_obstacle(run: RunFolder, mesh: Mesh, position: np.ndarray, enlarged: float) -> np.ndarray | None:
    """Corners of a band below the line, in space of a rectangle in the plane, m; None where there is none near the body."""
    if not run.has_contact:
        return None
    try:
        obstacle = run.obstacle
    except NotInRun:
        return None
    # The gap grows with the displacements, as in the film: the node nearest to the plane meets it when it does in truth.
    candidates = run.contact.points if run.has_contact_table else mesh.points
    gap = obstacle.height(candidates).min()
    drawn = HalfSpace(obstacle.point + (1 - enlarged) * gap * obstacle.normal, obstacle.normal)
    points = position.reshape(-1, run.dim)
    if drawn.height(points).min() > mesh.size:
        return None
    across = [drawn.tangent] if run.dim == 2 else plane_axes(drawn.normal)
    reach = [(points - drawn.point) @ axis for axis in across]
    sides = [(along.min() - 0.1 * mesh.size, along.max() + 0.1 * mesh.size) for along in reach]
    if run.dim == 2:
        across, sides = [*across, drawn.normal], [*sides, (-BAND * mesh.size, 0.0)]
    (left, right), (low, high) = sides
    return drawn.point + np.array([[left, low], [right, low], [right, high], [left, high]]) @ np.array(across)


def plane_axes(normal: np.ndarray) -> list[np.ndarray]:
    """Two unit vectors along a plane in space."""
    across = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    across /= np.linalg.norm(across)
    return [across, np.cross(normal, across)]


def touching(run: RunFolder, mesh: Mesh, times: np.ndarray) -> dict | None:
    """Candidates among the mesh's nodes, and which of them are in contact in each frame."""
    if not run.has_contact or not run.has_contact_table:
        return None
    contact = run.contact
    candidates = np.array([np.abs(mesh.points - point).max(axis=1).argmin() for point in contact.points])
    # A candidate between two nodes, as elements of second degree have them, has no place in the mesh.
    known = np.abs(mesh.points[candidates] - contact.points).max(axis=1) < 1e-9 * mesh.size
    # The solver takes 1e-10 of the body's diameter as zero.
    state = np.stack([contact.touching(nearest(contact.times, time), 1e-10 * mesh.size)[known] for time in times])
    return {"nodes": packed(candidates[known], "i4"), "on": packed(state, "u1")} if state.any() else None
