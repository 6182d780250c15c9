# SPDX-License-Identifier: GPL-3.0-or-later
"""Film of the deformed body beside its obstacles: colours show the displacement, arrows the contact forces, with friction those of
candidates that stick and that slip in different colours.

A body in space is seen from the side, along the obstacle's plane; of a body of revolution the full section is shown,
with the contact pressure in place of forces.

Displacements below 2 % of the body's size are enlarged, and the picture shows the factor. The gap of the node nearest
to an obstacle and the obstacle's motion are then enlarged with them: this node touches in the picture when it does in
the run. A curved body may seem to overlap the obstacle beside it. Writes a GIF, and an .mp4 where ffmpeg is present.
"""

import math
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.colors import to_rgb
from matplotlib.quiver import Quiver
from matplotlib.tri import Triangulation
from PIL import Image

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import run_alone
from .contact_table import OPEN, SLIP, STICK, Contact
from .files import Unreadable
from .mesh import Mesh
from .obstacle_artists import GREY, obstacle_artists
from .obstacles import Obstacle
from .run_folder import RunFolder, nearest
from .scenery import comes_near, drawn_obstacles, picture
from .view import View, view_of

MOST_FRAMES = 76  # 75 intervals
FRAME_MILLISECONDS = 80  # a GIF counts in hundredths of a second
DOTS_PER_INCH = 100  # on the screen; 640 dots wide
SMALL = 0.02  # displacements below this part of the body's size are enlarged …
VISIBLE = 0.05  # … to about this part
ARROW = 0.15  # longest arrow, as a part of the body's size
KEY = 0.17  # inches from the axes up to the arrow of the scale
ARROW_COLOURS = {STICK: style.BLUE, SLIP: style.VERMILION}  # with friction
SPACING = 0.012  # least distance of arrows, as a part of the body's size


@dataclass(frozen=True)
class Forces:
    """Contact forces, or pressures on a body of revolution: points on which they act (frames × nodes × 2, m), sizes (frames × nodes,
    `unit`), directions (nodes × 2); with friction also the forces along the obstacle (frames × nodes × 2), and numbers of the
    candidates' motions in MOTION (frames × nodes)."""

    points: np.ndarray
    sizes: np.ndarray
    directions: np.ndarray
    unit: str
    friction: np.ndarray | None = None
    motion: np.ndarray | None = None

    @property
    def vectors(self) -> np.ndarray:
        """Forces as vectors (frames × nodes × 2)."""
        normal = self.sizes[..., None] * self.directions
        return normal if self.friction is None else normal + self.friction

    @property
    def largest(self) -> float:
        return float(self.sizes.max() if self.friction is None else np.linalg.norm(self.vectors, axis=2).max())

    def mirrored(self) -> "Forces":
        """Returns the forces on a half section and on its mirror image."""
        image = np.repeat([False, True], len(self.directions))
        friction = None if self.friction is None else on_both_sides(np.tile(self.friction, (1, 2, 1)), image)
        motion = None if self.motion is None else np.tile(self.motion, (1, 2))
        return Forces(on_both_sides(np.tile(self.points, (1, 2, 1)), image), np.tile(self.sizes, (1, 2)),
                      on_both_sides(np.tile(self.directions, (2, 1)), image), self.unit, friction, motion)  # fmt: skip


@dataclass(frozen=True)
class Motion:
    """Data of the film at times (s): moduli of the nodes' displacements (frames × nodes, m), and positions of the mesh's nodes
    on paper (frames × nodes × 2, m), with displacements drawn `enlarged` times as large; obstacles near the body, and the box
    (two corners, m) of their visible parts and the body."""

    mesh: Mesh
    view: View
    times: np.ndarray
    magnitude: np.ndarray
    position: np.ndarray
    enlarged: float
    forces: Forces | None
    obstacles: list[Obstacle]
    box: np.ndarray


def draw(run: RunFolder) -> list[Path]:
    """Writes animation.gif and animation.mp4; returns the paths of those written."""
    motion = read_motion(run)
    stage = Stage(motion)
    frames = [stage.picture(frame) for frame in range(len(motion.times))]
    name = run.path / "figures" / "animation.gif"
    paths = [write_gif(frames, name, palette(motion.forces is not None and motion.forces.friction is not None))]
    if shutil.which("ffmpeg"):
        paths.append(write_mp4(frames, name.with_suffix(".mp4")))
    return paths


def read_motion(run: RunFolder) -> Motion:
    """Reads the stored steps, thinned out evenly to the number of frames."""
    series = run.field("state", "displacement")
    stride = max(1, -(-(len(series.times) - 1) // (MOST_FRAMES - 1)))
    shown = range(0, len(series.times), stride)
    displacement = np.stack([series.at(i) for i in shown])
    magnitude = np.linalg.norm(displacement, axis=2)
    enlarged = enlargement(magnitude.max(), series.mesh.size)
    times, view = series.times[shown], view_of(run)
    position = series.mesh.points + enlarged * displacement
    drawn = drawn_obstacles(run, enlarged) if run.has_contact else []
    obstacles = [obstacle for obstacle in drawn if comes_near(obstacle, times, position, series.mesh.size)]
    forces = None
    if run.has_contact and run.has_contact_table:
        forces = read_forces(run, view, series.mesh, times, displacement, enlarged, stride)
    mesh, _ = view.seen(series.mesh)
    if run.axisymmetric:
        mesh, source = mesh.mirrored()
        position, magnitude = on_both_sides(position[:, source], mesh.points[:, 0] < 0), magnitude[:, source]
        obstacles = [replace(obstacle, mirrored=True) for obstacle in obstacles]
        forces = None if forces is None else forces.mirrored()
    return Motion(mesh, view, times, magnitude, view.project(position), enlarged, forces, obstacles,
                  picture(obstacles, times, position, series.mesh.size))  # fmt: skip


def on_both_sides(points: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Returns points or directions (… × nodes × 2), those of the mirror image reflected about the axis x = 0."""
    return points * np.column_stack([np.where(image, -1, 1), np.ones(len(image))])


def enlargement(largest: float, size: float) -> float:
    """Returns the factor by which displacements are enlarged in the picture: 1 unless they are too small to see. `largest`: largest
    displacement, m; `size`: size of the body, m."""
    return 1.0 if largest == 0 or largest >= SMALL * size else round_down(VISIBLE * size / largest)


def round_down(value: float) -> float:
    """Returns the largest number of the sequence …, 1, 2, 5, 10, 20, 50, … that does not exceed the value."""
    power = 10 ** math.floor(math.log10(value))
    return float(max(digit for digit in (1, 2, 5) if digit * power <= value) * power)


def read_forces(run: RunFolder, view: View, mesh: Mesh, times: np.ndarray, displacement: np.ndarray, enlarged: float,
                stride: int) -> Forces:
    """Reads the contact forces of all frames, at so few nodes that their arrows can be distinguished."""
    contact, boundary = run.contact, mesh.boundary_nodes()
    points = contact.points + enlarged * follow(mesh.points[boundary], contact.points, displacement[:, boundary])
    spacing = np.median(np.linalg.norm(np.diff(contact.points, axis=0), axis=1)) if len(contact.points) > 1 else np.inf
    every = math.ceil(SPACING * mesh.size / spacing) or 1 if spacing else 1
    # The force of a node of a body of revolution acts on a ring, which is the longer, the farther it is from the axis.
    acting, unit = (contact.pressure, "Pa") if run.axisymmetric else (contact.force, style.per_depth("N", run.whole))
    found = Forces(view.project(points[:, ::every]), frame_means(contact.times, acting, times, stride)[:, ::every],
                   view.project(contact.normal[::every]), unit)  # fmt: skip
    if contact.friction is None or not contact.friction.force.any():
        return found
    along = contact.friction.force
    if run.axisymmetric:  # a traction, as the pressure is
        along = along * np.divide(contact.pressure, contact.force, out=np.zeros_like(contact.force), where=contact.force > 0)[..., None]
    friction = view.project(frame_means(contact.times, along, times, stride)[:, ::every])
    return replace(found, friction=friction, motion=last_motion(contact, times, stride)[:, ::every])


def follow(nodes: np.ndarray, points: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Interpolates the displacement of points on the boundary (frames × points × dim, m).

    It is linear between the two nearest nodes of the mesh: exact at the nodes and on straight edges between them, where
    elements of second degree have candidates for contact too.
    """
    distance = np.linalg.norm(points[:, None] - nodes[None], axis=2)
    pair = np.argsort(distance, axis=1)[:, :2]
    near, far = np.take_along_axis(distance, pair, axis=1).T
    weight = (far / (near + far))[None, :, None]
    return weight * displacement[:, pair[:, 0]] + (1 - weight) * displacement[:, pair[:, 1]]


def frame_means(stored: np.ndarray, forces: np.ndarray, times: np.ndarray, stride: int) -> np.ndarray:
    """Returns forces or pressures (frames × nodes): means over the steps stored (s) since the last frame.

    Means take at least two steps: single forces alternate from step to step, and only their mean is meaningful.
    """
    return np.stack([forces[i: j + 1].mean(axis=0) for i, j in since_last_frame(stored, times, stride)])


def since_last_frame(stored: np.ndarray, times: np.ndarray, stride: int) -> list[tuple[int, int]]:
    """Returns the first and the last of the steps stored (s) that each frame shows."""
    last = [nearest(stored, time) for time in times]
    return [(min(max(1, index - max(stride, 2) + 1), index), index) for index in last]


def last_motion(contact: Contact, times: np.ndarray, stride: int) -> np.ndarray:
    """Returns the numbers in MOTION (frames × candidates) of the last step in contact of those that each frame shows."""
    motion = contact.friction.motion
    found = np.stack([motion[j] for _, j in since_last_frame(contact.times, times, stride)])
    for frame, (first, last) in enumerate(since_last_frame(contact.times, times, stride)):
        for step in range(last - 1, first - 1, -1):
            found[frame] = np.where(found[frame] == OPEN, motion[step], found[frame])
    return found


class Stage:
    """Picture of a frame: parts at rest are drawn once, moving parts are drawn over them in every frame."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        self.edges = motion.mesh.outline()
        largest = motion.magnitude.max()
        self.factor, unit = style.prefixed(largest, "m")
        self.time_factor, self.time_unit = style.prefixed(motion.times, "s")

        axes = scenery(motion)
        self.title = axes.set_title(" ", loc="left")
        self.body = TriMesh(Triangulation(*motion.position[0].T, motion.mesh.cells), cmap=style.FIELD_COLOURS)
        self.body.set_clim(0, largest * self.factor or 1)
        self.outline = LineCollection([], colors="black", linewidths=0.8)
        for part in (self.body, self.outline):
            axes.add_collection(part, autolim=False)
        style.colour_bar(self.body, axes, f"displacement ({unit})")
        self.arrows = add_arrows(axes, motion)
        self.obstacles = obstacle_artists(axes, motion.obstacles, motion.view, motion.mesh.size)
        for obstacle in self.obstacles:
            obstacle.place(motion.times[0])

        self.axes = axes
        passing = [artist for obstacle in self.obstacles if obstacle.moves for artist in obstacle.artists]
        self.moving = [part for part in (*passing, self.body, self.outline, self.arrows, self.title) if part is not None]
        for part in self.moving:
            part.set_animated(True)
        self.canvas = FigureCanvasAgg(axes.figure)
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(axes.figure.bbox)

    def picture(self, frame: int) -> Image.Image:
        """Returns the frame in red, green and blue."""
        self._move(frame)
        self.canvas.restore_region(self.background)
        for part in self.moving:
            self.axes.draw_artist(part)
        return Image.fromarray(np.asarray(self.canvas.buffer_rgba())[..., :3].copy())

    def _move(self, frame: int) -> None:
        position = self.motion.position[frame]
        # The triangulation is read again at every drawing; a new surface per frame would be ten times slower.
        self.body._triangulation.x, self.body._triangulation.y = position.T
        self.body.set_array(self.motion.magnitude[frame] * self.factor)
        self.outline.set_segments(position[self.edges])
        self.title.set_text(f"$t$ = {self.time_factor * self.motion.times[frame]:.2f} {self.time_unit}")
        for obstacle in self.obstacles:
            if obstacle.moves:
                obstacle.place(self.motion.times[frame])
        if self.arrows is not None:
            forces = self.motion.forces
            self.arrows.set_offsets(forces.points[frame])
            # A force of zero would leave a dot.
            self.arrows.set_UVC(*np.where(forces.sizes[frame] > 0, forces.vectors[frame].T, np.nan))
            if forces.motion is not None:
                self.arrows.set_color([ARROW_COLOURS.get(motion, "black") for motion in forces.motion[frame]])


def scenery(motion: Motion) -> Axes:
    """Makes the axes, in a figure of their own."""
    axes = style.plan(*view(motion), motion.view.names, DOTS_PER_INCH)
    scale = "true to scale" if motion.enlarged == 1 else f"displacement × {motion.enlarged:g}"
    # Below the colours, where a narrow figure has room beside the name of the horizontal axis.
    axes.annotate(scale, (1, 0), (-8, -28), xycoords=("figure fraction", "axes fraction"), textcoords="offset points", ha="right",
                  va="top", fontsize=12)
    if motion.view.names[0] == "radius":
        axes.xaxis.set_major_formatter(lambda x, _: f"{abs(x):g}")
    return axes


def view(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Returns two corners (m) of the picture with the body at all times, obstacles of its size next to it, and the arrows."""
    size, dim = motion.mesh.size, motion.box.shape[1]
    inside = [motion.position.reshape(-1, 2)]
    if any(obstacle.whole for obstacle in motion.obstacles):
        corners = motion.box[[[i >> axis & 1 for axis in range(dim)] for i in range(2**dim)], range(dim)]
        inside.append(motion.view.project(corners))
    if motion.forces is not None and (acting := motion.forces.sizes > 0).any():
        forces = motion.forces
        way = forces.directions if forces.friction is None else forces.vectors / forces.largest
        inside.append((forces.points - 1.1 * ARROW * size * way)[acting])
    every = np.concatenate(inside)
    return every.min(axis=0) - 0.04 * size, every.max(axis=0) + 0.04 * size


def add_arrows(axes: Axes, motion: Motion) -> Quiver | None:
    """Adds arrows that end at the nodes in contact, and one in the margin as their scale."""
    if motion.forces is None or not motion.forces.sizes.any():
        return None
    largest = motion.forces.largest
    arrows = axes.quiver(*motion.forces.points[0].T, *np.zeros_like(motion.forces.points[0]).T, angles="xy",
                         scale_units="xy", scale=largest / (ARROW * motion.mesh.size), pivot="tip",
                         color=style.VERMILION, width=0.007)
    key = round_down(largest)
    factor, unit = style.prefixed(key, motion.forces.unit)
    height = axes.get_position().height * axes.figure.get_figheight()
    colour = {} if motion.forces.motion is None else {"color": "black"}
    axes.quiverkey(arrows, 0.72, 1 + KEY / height, key, f"{key * factor:g} {unit}", labelpos="E", coordinates="axes", **colour)
    if motion.forces.motion is not None:
        for height, number, name in ((-10, STICK, "sticks"), (-25, SLIP, "slips")):
            axes.annotate(name, (0, 0), (5, height), xycoords=("figure fraction", "axes fraction"), textcoords="offset points",
                          va="top", fontsize=12, color=ARROW_COLOURS[number])  # fmt: skip
    return arrows


def palette(friction: bool = False) -> Image.Image:
    """Returns the 256 colours of a GIF: the field's, greys, and the arrows' blended into their background."""
    def blend(start: str, end: str, count: int) -> np.ndarray:
        return np.linspace(to_rgb(start), to_rgb(end), count)

    field = colormaps[style.FIELD_COLOURS](np.linspace(0, 1, 160))[:, :3]
    colours = np.concatenate([field, blend("black", "white", 32), blend(style.VERMILION, GREY, 16),
                              blend(style.VERMILION, "white", 16),
                              *([blend(style.BLUE, GREY, 16), blend(style.BLUE, "white", 16)] if friction else [])])  # fmt: skip
    image = Image.new("P", (1, 1))
    image.putpalette(np.rint(255 * colours).astype(np.uint8).tobytes())
    return image


def write_gif(frames: list[Image.Image], path: Path, colours: Image.Image) -> Path:
    """Writes all frames with one palette, so that pixels that stay the same cost nothing."""
    indexed = [frame.quantize(palette=colours, dither=Image.Dither.NONE) for frame in frames]
    with style.whole_file(path) as partial:
        indexed[0].save(partial, save_all=True, append_images=indexed[1:], duration=FRAME_MILLISECONDS, loop=0,
                        comment=style.MARK.encode())
    return path


def write_mp4(frames: list[Image.Image], path: Path) -> Path:
    """Writes the frames as H.264, which needs even numbers of pixels."""
    width, height = frames[0].width // 2 * 2, frames[0].height // 2 * 2
    raw = b"".join(frame.crop((0, 0, width, height)).tobytes() for frame in frames)
    with style.whole_file(path) as partial:
        command = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24",
                   "-video_size", f"{width}x{height}", "-framerate", f"{1000 / FRAME_MILLISECONDS}", "-i", "-",
                   "-pix_fmt", "yuv420p", "-crf", "18", "-metadata", f"comment={style.MARK}", "-movflags", "+faststart",
                   str(partial)]
        result = subprocess.run(command, input=raw, capture_output=True)
        if result.returncode:
            reason = result.stderr.decode(errors="replace").strip().splitlines()
            raise Unreadable(f"{path}: ffmpeg failed ({reason[-1] if reason else result.returncode})")
    return path


if __name__ == "__main__":
    sys.exit(run_alone(draw, __doc__))
