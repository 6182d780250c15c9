# SPDX-License-Identifier: GPL-3.0-or-later
"""Every key of a scene does what docs/reference/keys.md says: each is changed in a small scene and must show in the motion, in J or in
the files. The program itself names the keys that it accepts; each of them has an entry here, a case of bad input, and a
place in that page."""

import functools
import inspect
import itertools
import json
import re
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TESTS = Path(__file__).parents[1]
sys.path += [str(TESTS), str(TESTS / "regression" / "bad_input")]
from cases import all_cases  # noqa: E402
from harness import SIGNORINI, SOURCE, attempt, captured, signorini, table  # noqa: E402

import h5py  # noqa: E402
import numpy as np  # noqa: E402

DATA = SOURCE / "tests" / "data"
BLOCK = DATA / "block.toml"  # a unit square, 30 steps of 0.02 s
ROUNDING = 1e-12  # of sums over some hundred numbers, relative
T = 0.6  # s

# The block far from its obstacle, at rest and without weight: what else acts on it is all that it feels.
FREE = {"contact__obstacle__point": [0, -100], "load__body": ["0", "0"], "initial__velocity": ["0", "0"]}
# What the resting block is away from this is one, everywhere and at all times.
ONE_AWAY = FREE | {"objective__desired": {"displacement": ["0", "1"]}}
FLAT = {"contact__obstacle__normal": [0, 1]}

SHOWN: set[str] = set()
ENTRIES: list[Callable[[], None]] = []
WORKERS = 2
PLACE = tempfile.TemporaryDirectory()
FOLDER = Path(PLACE.name)


def key(*names: str) -> Callable[[Callable[[], None]], Callable[[], None]]:
    """Marks what shows the effect of one key, or of some that have none without each other."""

    def register(show: Callable[[], None]) -> Callable[[], None]:
        SHOWN.update(names)
        ENTRIES.append(show)
        return show

    return register


# --- Runs -------------------------------------------------------------------------------------------------------------


class Run:
    """What a run left."""

    numbers = itertools.count()

    def __init__(self, verb: str, scene: Path, overrides: dict[str, object]):
        self.folder = FOLDER / str(next(Run.numbers))
        self.stdout = signorini(verb, scene, self.folder, **overrides).stdout

    @functools.cached_property
    def steps(self) -> dict[str, np.ndarray]:
        return table(self.folder / "steps.csv")

    @functools.cached_property
    def history(self) -> dict[str, np.ndarray]:
        return table(self.folder / "history.csv")

    @functools.cached_property
    def manifest(self) -> dict:
        return json.loads((self.folder / "run.json").read_text())

    @functools.cached_property
    def echo(self) -> dict:
        return tomllib.loads((self.folder / "scene.toml").read_text())

    @functools.cached_property
    def start(self) -> dict[str, np.ndarray]:
        """The candidates before the first step."""
        contact = table(self.folder / "contact.csv")
        return {name: column[contact["step"] == 0] for name, column in contact.items()}

    @functools.cached_property
    def points(self) -> np.ndarray:
        return self.mesh("geometry")

    def mesh(self, part: str) -> np.ndarray:
        with h5py.File(self.folder / "state.h5") as file:
            return file[f"Mesh/mesh/{part}"][:]

    def field(self, name: str, file: str = "state") -> np.ndarray:
        """Stored time × node or cell × component."""
        with h5py.File(self.folder / f"{file}.h5") as h5:
            stored = h5[f"Function/{name}"]
            return np.array([stored[t][:, :2] for t in sorted(stored, key=lambda t: float(t.replace("_", ".")))])

    def momentum(self) -> np.ndarray:
        """Of the block (density 1) at the end, by nodal masses: exact for linear functions."""
        triangles, x = self.mesh("topology"), self.points
        sides = x[triangles[:, 1:]] - x[triangles[:, :1]]
        areas = abs(np.linalg.det(sides[:, :, :2])) / 2
        return (areas[:, None] / 3 * self.field("velocity")[-1][triangles].sum(axis=1)).sum(axis=0)

    def gaps(self, expected: Callable[[np.ndarray, np.ndarray], np.ndarray], rtol: float = ROUNDING) -> None:
        """Compares the first gaps with a function of x and y; there must be candidates in several places."""
        x, y = self.start["x"], self.start["y"]
        assert len(x) > 2
        near(self.start["gap"], expected(x, y), rtol)


def simulate(scene: Path = BLOCK, **overrides: object) -> Run:
    return run("simulate", scene, overrides)


@functools.cache
def plain_run() -> Run:
    """Of the block as it is."""
    return simulate()


def optimize(scene: Path = BLOCK, iterations: int = 0, **overrides: object) -> Run:
    return run("optimize", scene, {"optimizer__max_iterations": iterations} | overrides)


def run(verb: str, scene: Path, overrides: dict[str, object]) -> Run:
    """A run whose scene.toml says what was asked for."""
    done = Run(verb, scene, overrides)
    for path, given in overrides.items():
        found = get(done.echo, path.split("__"))
        assert says(found, given), f"{path} = {given!r} is echoed as {found!r}"
    return done


def get(scene: dict, path: Sequence[str]) -> object:
    for name in path:
        scene = scene[int(name)] if name.isdigit() else scene[name]
    return scene


def says(found: object, given: object) -> bool:
    """Whether a value of scene.toml is the given one, or a table has all that was given."""
    if isinstance(found, list) and isinstance(given, list):
        return len(found) == len(given) and all(map(says, found, given))
    if isinstance(given, dict):
        return all(name in found and says(found[name], value) for name, value in given.items())
    if isinstance(found, str) and found.startswith("/"):  # paths are echoed in full
        return found.endswith(given)
    return found == given or str(found) == str(given) or (isinstance(found, float) and found == float(given))


def near(found: object, expected: object, rtol: float = ROUNDING) -> None:
    size = np.abs(expected).max()
    assert np.shape(found) == np.shape(expected), f"{found}, not {expected}"
    assert np.allclose(found, expected, rtol=0, atol=rtol * (size if size > 0 else 1)), f"{found}, not {expected}"


def same(a: Run, b: Run, rounding: float = 0) -> None:
    """The same motion, by energies, forces and gaps."""
    for name in ("time", "kinetic_energy", "elastic_energy", "contact_force_y", "active", "min_gap"):
        near(a.steps[name], b.steps[name], rounding)


def edited(name: str, *edits: tuple[str, str], source: Path = BLOCK) -> Path:
    """A copy of a file with other text, as --set cannot take a key away."""
    text = source.read_text().replace('"square.geo"', f'"{DATA / "square.geo"}"')
    for old, new in edits:
        text, count = re.subn(old, new, text)
        assert count, old
    copy = FOLDER / name
    copy.write_text(text)
    return copy


# --- The body -----------------------------------------------------------------------------------------------------------


@key("mesh.file")
def mesh_file() -> None:
    near(plain_run().steps["kinetic_energy"][0], 0.5)
    near(simulate(mesh__file=str(DATA / "parts.geo")).steps["kinetic_energy"][0], 1.0)  # two squares


@key("mesh.size")
def mesh_size() -> None:
    own = edited("own.geo", (r"(Point.*), 0\}", r"\1, 0, 0.5}"), source=DATA / "square.geo")
    scene = edited("own.toml", (r"(?m)^file = .*", f'file = "{own.name}"'), (r"(?m)^size = .*\n", ""))
    for overrides, nodes in (({}, 3), ({"mesh__size": 0.25}, 5), ({"mesh__size": 0.125}, 9)):  # of the lower side
        assert simulate(scene, **overrides).manifest["candidates"] == nodes


@key("mesh.scale")
def mesh_scale() -> None:
    own = edited("scaled.geo", (r"(Point.*), 0\}", r"\1, 0, 0.5}"), source=DATA / "square.geo")
    scene = edited("scaled.toml", (r"(?m)^file = .*", f'file = "{own.name}"'), (r"(?m)^size = .*\n", ""))
    for scale, nodes in ((1, 3), (0.5, 5), (0.25, 9)):  # of the lower side
        assert simulate(scene, mesh__scale=scale).manifest["candidates"] == nodes


@key("mesh.unit")
def mesh_unit() -> None:
    for unit, length in (("m", 1), ("mm", 1e-3)):
        done = simulate(mesh__unit=unit, mesh__size=0.25 * length, time__step=0.02 * length, time__end=0.02 * length)
        near(done.manifest["body"]["extent"], [length, length])
        near(done.steps["kinetic_energy"][0], length**2 / 2)
        assert done.manifest["candidates"] == 5
    large = edited("large.geo", (r"= \{(\d), (\d), 0\}", r"= {1000*\1, 1000*\2, 0}"), source=DATA / "square.geo")
    done = simulate(mesh__file=str(large), mesh__unit="mm")
    near(done.steps["kinetic_energy"][0], 0.5)
    assert done.manifest["candidates"] == 5 and done.manifest["body"]["doubts"] == []


@key("mesh.degree")
def mesh_degree() -> None:
    one, two = plain_run().manifest, simulate(mesh__degree=2).manifest
    vertices, cells = one["unknowns"] // 2, one["cells"]
    edges = vertices + cells - 1  # Euler
    assert two["cells"] == cells and two["unknowns"] == 2 * (vertices + edges)


@key("time.end")
def time_end() -> None:
    whole, half = plain_run(), simulate(time__end=0.3)
    assert len(whole.steps["time"]) == 31 and len(half.steps["time"]) == 16
    near(half.steps["kinetic_energy"], whole.steps["kinetic_energy"][:16], 0)


@key("time.step")
def time_step() -> None:
    near(simulate(time__step=0.01).steps["time"], 0.01 * np.arange(61))
    near(simulate(time__step=0.1).steps["time"], 0.1 * np.arange(7))


def varying(**more: object) -> dict[str, object]:
    """The block thrown back by the floor, in steps whose lengths the motion chooses."""
    return FLAT | {"contact__obstacle__point": [0, -1], "load__body": ["0", "0"], "time": {"end": 12, "step": "auto", "tolerance": 1e-2} | more}


def lengths(done: Run) -> np.ndarray:
    return np.diff(done.steps["time"])


@key("time.tolerance", "time.longest", "time.shortest")
def chosen_steps() -> None:
    loose, usual, tight = (simulate(**varying(tolerance=tolerance)) for tolerance in (0.3, 1e-2, 1e-3))
    assert len(lengths(loose)) < len(lengths(usual)) < len(lengths(tight))
    bounded = lengths(simulate(**varying(longest=0.2, shortest=0.0125)))
    assert abs(bounded.max() - 0.2) < 1e-12 and abs(bounded.min() - 0.0125) < 1e-12
    near(usual.steps["time"][-1:], np.array([12.0]), 0)


@key("time.quantity")
def chosen_by() -> None:
    runs = [simulate(**varying(tolerance=0.3, quantity=quantity)) for quantity in ("displacement", "contact-force", "energy")]
    assert len({len(lengths(done)) for done in runs}) == 3


@key("control.step")
def control_intervals() -> None:
    for step, every in ((0.02, 1), (0.06, 3)):
        u = optimize(iterations=1, control__step=step, output__every=1).field("control", "control")
        changes = 1 + np.flatnonzero(abs(np.diff(u, axis=0)).max(axis=(1, 2)) > 0)
        assert len(changes) > 3 and (changes % every == 0).all()


@key("time.scheme")
def time_scheme() -> None:
    flying = [simulate(time__scheme=scheme, **FREE | {"initial__velocity": ["x", "y"]}) for scheme in
              ("contact-implicit", "contact-stabilized")]  # fmt: skip
    same(*flying, ROUNDING)
    implicit, stabilized = plain_run(), simulate(time__scheme="contact-stabilized")
    touch = np.flatnonzero(implicit.steps["active"])[0]
    for name in ("kinetic_energy", "elastic_energy"):
        near(stabilized.steps[name][:touch], implicit.steps[name][:touch])
        assert abs(stabilized.steps[name] - implicit.steps[name]).max() > 1e-3
    assert [done.manifest["counters"]["VI solvers"] for done in (implicit, stabilized)] == [1, 2], "the predictor has its own"


@key("material.density")
def density() -> None:
    near(simulate(material__density=3.0).steps["kinetic_energy"][0], 1.5)


@key("material.young", "material.poisson")
def elasticity() -> None:
    stretched = FREE | {"initial__displacement": ["0", "0.1*y"]}
    for young, poisson in ((50.0, 0.3), (80.0, 0.3), (50.0, -0.2)):
        modulus = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
        found = simulate(material__young=young, material__poisson=poisson, **stretched)
        near(found.steps["elastic_energy"][0], modulus / 2 * 0.1**2)


@key("material.viscosity.bulk", "material.viscosity.shear")
def viscosity() -> None:
    def power(velocity: list[str], bulk: float, shear: float) -> float:
        step = 1e-8  # so short that the velocity is still the initial one, but for 1e-6 of it
        done = simulate(material__viscosity={"bulk": bulk, "shear": shear}, time__step=step, time__end=step,
                        **FREE | {"initial__velocity": velocity})  # fmt: skip
        return done.steps["viscous_dissipation"][1] / step

    near(power(["x", "y"], 0.07, 0), 4 * 0.07, 1e-5)  # swells: bulk (div v)²
    near(power(["x", "y"], 0.07, 0.03), 4 * (0.07 + 0.03 / 3), 1e-5)  # nothing along z
    near(power(["y", "0"], 0.07, 0.03), 0.03, 1e-5)  # shears
    elastic = simulate(edited("elastic.toml", (r"(?m)^viscosity.*\n", "")))
    assert (elastic.steps["viscous_dissipation"] == 0).all()
    lost, touched = plain_run().steps["viscous_dissipation"], np.argmax(plain_run().steps["active"] > 0)
    # In flight nothing strains, and what is left is rounding, of either sign.
    assert touched > 1 and (lost[touched:] > 0).all() and np.max(abs(lost[:touched])) < 1e-14 * np.max(lost)


@key("material.on")
def material_on() -> None:
    def energy(left: str, right: str) -> float:  # of 0 < x < 1 with density 3 and the rest with 1
        done = simulate(DATA / "two-materials.toml", material__0__on=left, material__1__on=right, initial__velocity=["0", "-x"])
        return done.steps["kinetic_energy"][0]

    near(energy("left", "right"), (3 / 3 + 7 / 3) / 2)
    near(energy("right", "left"), (3 * 7 / 3 + 1 / 3) / 2)


# --- Clamps and contact -------------------------------------------------------------------------------------------------


@key("clamp.on", "clamp.components")
def clamp_on() -> None:
    weight = FREE | {"load__body": ["1", "-1"]}
    for group, axis, place in (("left", 0, 0), ("top", 1, 1)):
        for components, held in ((["x", "y"], (0, 1)), (["x"], (0,)), (["y"], (1,))):
            done = simulate(clamp=[{"on": group, "components": components}], **weight)
            moved = abs(done.field("displacement")[-1])
            on = abs(done.points[:, axis] - place) < ROUNDING
            assert 2 < on.sum() < len(on) and (moved[~on] > 0).all()
            assert [c for c in (0, 1) if (moved[on, c] == 0).all()] == list(held), "and no other component"
    default = simulate(clamp=[{"on": "left"}], **weight)
    same(default, simulate(clamp=[{"on": "left", "components": ["x", "y"]}], **weight))


@key("clamp.value")
def clamp_value() -> None:
    for components, value, end in (
        (["x", "y"], ["0.1*t^2", "0.2*t^2*(1+x)"], [0.1 * T**2, 0.2 * T**2]),
        (["y", "x"], ["0.1*t^2", "0.2*t^2"], [0.2 * T**2, 0.1 * T**2]),  # each value is its component's
        (["y"], ["0.3*t^2"], [None, 0.3 * T**2]),
    ):
        done = simulate(clamp=[{"on": "left", "components": components, "value": value}], **FREE)
        same(done, simulate(done.folder / "scene.toml"))
        left = done.points[:, 0] == 0
        for c, expected in enumerate(end):
            if expected is not None:
                near(done.field("displacement")[-1][left, c], np.full(left.sum(), expected))


@key("contact.on")
def contact_on() -> None:
    for group, axis, place, nodes in (("bottom", "y", 0, 5), ("top", "y", 1, 5), ("left", "x", 0, 5), ("boundary", None, 0, 16)):
        done = simulate(contact__on=group, **FREE)
        assert done.manifest["candidates"] == len(done.start["x"]) == nodes
        assert axis is None or (abs(done.start[axis] - place) < ROUNDING).all()


@key("contact.mass")
def contact_mass() -> None:
    for mass, moved in (("consistent", 1), ("massless", 0)):
        done = simulate(contact__mass=mass, **FLAT)
        near(done.steps["kinetic_energy"][0], 0.5)  # the whole mass stays
        towards = simulate(contact__mass=mass, initial__velocity=["0", "y < 0.01 ? -1 : 0"], **FLAT).steps["kinetic_energy"][0]
        assert (towards > 0.03) if moved else (abs(towards) < ROUNDING), "that of the lower nodes, towards the plane"


@key("contact.initial")
def contact_initial() -> None:
    inside = FLAT | {"contact__obstacle__point": [0, 0.05]}
    assert attempt("simulate", BLOCK, FOLDER / "inside", **inside).returncode == 2
    assert attempt("simulate", BLOCK, FOLDER / "inside", contact__initial="outside", **inside).returncode == 2
    done = simulate(contact__initial="project", **inside)
    near(done.start["gap"], np.zeros(5))
    lower = done.points[:, 1] == 0
    near(done.field("displacement")[0][:, 1], np.where(lower, 0.05, 0))


@key("contact.obstacle.shape", "contact.obstacle.point", "contact.obstacle.normal")
def half_space() -> None:
    for point, normal in (([0, -0.1], [0.3, 1]), ([0.5, -0.3], [0.3, 1]), ([0, -0.1], [0, 2]), ([2, -2], [-1, 1])):
        done = simulate(contact__obstacle={"shape": "half-space", "point": point, "normal": normal})
        n = np.array(normal) / np.hypot(*normal)
        done.gaps(lambda x, y, p=point, n=n: n[0] * (x - p[0]) + n[1] * (y - p[1]))


@key("contact.obstacle.point")
def moving_half_space() -> None:
    resting = FREE | FLAT | {"contact__obstacle__point": ["0", "-0.1 + 0.5*t"]}
    pushed = simulate(**resting)
    near(pushed.start["gap"], np.full(5, 0.1))
    force = pushed.steps["contact_force_y"]
    assert (force[1:10] == 0).all() and force.max() > 0, "the plane arrives after 0.2 s"
    near(pushed.momentum()[1], 0.02 * force[1:].sum())
    lower = pushed.points[:, 1] == 0
    assert (pushed.field("displacement")[-1][lower, 1] >= 0.2 - ROUNDING).all()


@key("contact.obstacle.center", "contact.obstacle.radius", "contact.obstacle.side")
def ball() -> None:
    for center, radius in (([0.5, -1], 0.9), ([0.2, -1], 0.9), ([0.5, -1], 0.5)):
        for side in ({}, {"side": "outside"}):
            done = simulate(contact__obstacle={"shape": "ball", "center": center, "radius": radius} | side)
            done.gaps(lambda x, y, c=center, r=radius: np.hypot(x - c[0], y - c[1]) - r)
    done = simulate(contact__obstacle={"shape": "ball", "center": [0.5, 0.4], "radius": 2, "side": "inside"})
    done.gaps(lambda x, y: 2 - np.hypot(x - 0.5, y - 0.4))
    assert done.steps["active"].max() == 0 and simulate(contact__obstacle={"shape": "ball", "center": [0.5, -1],
                                                                       "radius": 0.9}).steps["active"].max() > 0  # fmt: skip


@key("contact.obstacle.center", "contact.obstacle.radius", "contact.obstacle.distance", "contact.obstacle.point")
def moving_round_obstacles() -> None:
    """Gaps of the undeformed body, which rests far from everything until the obstacle comes."""
    nodes, resting = np.linspace(0, 1, 5), {name: value for name, value in FREE.items() if "obstacle" not in name}
    for shape in ({"shape": "ball", "center": ["0.5 + t", "-1.5 + t"], "radius": "0.5 + 0.2*t"},
                  {"shape": "cylinder", "point": ["0.5 + t", "-1.5 + t"], "radius": "0.5 + 0.2*t"},
                  {"shape": "signed-distance", "distance": "sqrt((x - 0.5 - t)^2 + (y + 1.5 - t)^2) - 0.5 - 0.2*t"}):  # fmt: skip
        done = simulate(contact__obstacle=shape, **resting)
        contact = table(done.folder / "contact.csv")
        assert done.steps["active"].max() == 0 and done.manifest["effects"]["moving obstacle"]
        t, x = np.unique(contact["time"])[:, None], nodes[None, :]
        near(contact["gap"].reshape(31, 5), np.hypot(x - 0.5 - t, 1.5 - t) - 0.5 - 0.2 * t, 1e-9)
    fast = simulate(contact__obstacle={"shape": "ball", "center": [0.5, "-1.2 + t"], "radius": 1}, **resting)
    assert fast.steps["active"].max() > 0 and fast.momentum()[1] > 0.1


@key("contact.obstacle.axis", "contact.obstacle.point", "contact.obstacle.radius", "contact.obstacle.side")
def cylinder() -> None:
    disc = {"shape": "cylinder", "point": [0.5, -1], "radius": 0.9}
    simulate(contact__obstacle=disc).gaps(lambda x, y: np.hypot(x - 0.5, y + 1) - 0.9)
    inside = {"shape": "cylinder", "point": [0.5, 0.4], "radius": 2, "side": "inside"}
    simulate(contact__obstacle=inside).gaps(lambda x, y: 2 - np.hypot(x - 0.5, y - 0.4))
    rod = {"shape": "cylinder", "point": [0.5, 0.5, -1], "radius": 0.9}
    for axis, along in (([1, 0, 0], lambda x, y: y), ([0, 2, 0], lambda x, y: x), ([1, 1, 0], lambda x, y: (y - x) / 2**0.5 + 0.5)):
        done = simulate(DATA / "cube.toml", contact__obstacle=rod | {"axis": axis}, time__end=0.02)
        done.gaps(lambda x, y, along=along: np.hypot(along(x, y) - 0.5, 1) - 0.9)


@key("contact.obstacle.distance")
def signed_distance() -> None:
    done = simulate(contact__obstacle={"shape": "signed-distance", "distance": "3*(y + 0.1 + 0.2*x^2)"})
    done.gaps(lambda x, y: (0.1 + 0.2 * x**2) / np.hypot(1, 0.4 * x), 1e-10)  # differences: rounding over 1e-4 of the body


# --- Loads and the start ------------------------------------------------------------------------------------------------


@key("load.body")
def body_load() -> None:
    near(simulate(**FREE | {"load__body": ["0.3", "2*t"]}).momentum(), [0.3 * T, T**2])


@key("load.gravity")
def gravity() -> None:
    """By the density of each material; the weight of the whole is its momentum's rate."""
    near(simulate(**FREE | {"load__gravity": [0.3, "2*t"], "material__density": 1.0}).momentum(), [0.3 * T, T**2])
    heavy = simulate(**FREE | {"load__gravity": [0, -2], "material__density": 3.0})
    near(heavy.field("velocity")[-1], np.tile([0, -2 * T], (len(heavy.points), 1)))
    near(heavy.steps["external_work"].sum(), 3 * (2 * T) ** 2 / 2)


@key("load.traction.on", "load.traction.value")
def traction() -> None:
    for group, length in (("top", 1), ("rest", 3), ("boundary", 4)):
        done = simulate(load__traction=[{"on": group, "value": ["0.3", "2*t"]}], **FREE)
        near(done.momentum(), [0.3 * T * length, T**2 * length])


@key("initial.displacement")
def initial_displacement() -> None:
    before, after = plain_run(), simulate(initial__displacement=["0.1", "0.25"])
    near(after.start["gap"], before.start["gap"] + (0.3 * 0.1 + 0.25) / np.hypot(0.3, 1))


@key("initial.velocity")
def initial_velocity() -> None:
    done = simulate(**FREE | {"initial__velocity": ["3", "x"]})
    near(done.steps["kinetic_energy"][0], (9 + 1 / 3) / 2)
    near(done.momentum(), [3, 0.5])


# --- Control ------------------------------------------------------------------------------------------------------------


@key("control.scale")
def control_scale() -> None:
    one = optimize(control__initial=["0.2", "0.4"], **ONE_AWAY)
    two = optimize(control__initial=["0.1", "0.2"], control__scale=2, **ONE_AWAY)
    assert one.history["tracking"][0] != optimize(**ONE_AWAY).history["tracking"][0]
    for name in ("tracking", "terminal"):
        near(two.history[name], one.history[name])
    near(two.history["control_cost"], one.history["control_cost"] / 4)


@key("control.on")
def control_on() -> None:
    push = FREE | {"control__initial": ["0", "2"]}
    near(simulate(**push).momentum(), [0, 2 * T])
    for group, measure in (("body", 1), ("top", 1), ("rest", 3)):
        near(simulate(control__on=group, **push).momentum(), [0, 2 * T * measure])
    top = simulate(control__on="top", **push).field("displacement")[1]
    assert abs(top[:, 1]).max() > 2 * abs(top[:, 1]).min(), "a push of the whole body moves all alike"


@key("control.components")
def control_components() -> None:
    for overrides, acting in (({}, (0, 1)), ({"control__components": ["y"]}, (1,)), ({"control__components": ["x"]}, (0,))):
        u = optimize(iterations=1, **overrides, **FREE | {"objective__desired": {"displacement": ["1", "1"]}}).field("control", "control")
        assert [c for c in (0, 1) if abs(u[..., c]).max() > 0] == list(acting)


@key("control.constant_in_time")
def constant_in_time() -> None:
    for constant in (False, True):
        u = optimize(iterations=1, control__constant_in_time=constant).field("control", "control")
        assert abs(u).max() > 0 and (np.ptp(u, axis=0).max() == 0) == constant


@key("control.space")
def control_space() -> None:
    nodal = optimize(iterations=1, control__space="nodal")
    cellwise = optimize(iterations=1, control__space="cellwise")
    assert nodal.field("control", "control").shape == (30, nodal.manifest["unknowns"] / 2, 2)
    assert cellwise.field("control", "control").shape == (30, cellwise.manifest["cells"], 2)
    near(simulate(control__space="cellwise", control__initial=["0", "2"], **FREE).momentum(), [0, 2 * T])
    # Nodes are the displacement's own, with midpoints of edges where it is quadratic.
    quadratic = optimize(iterations=1, control__space="nodal", mesh__degree=2).manifest
    assert quadratic["unknowns"] > 3 * nodal.manifest["unknowns"]


@key("control.initial")
def control_initial() -> None:
    near(simulate(control__initial=["0.3", "2*t"], **FREE).momentum(), [0.3 * T, T**2])
    first = optimize(control__initial=["0.3", "2"])
    near(first.field("control", "control"), np.tile([0.3, 2], (30, first.manifest["unknowns"] // 2, 1)))
    assert optimize().history["control_cost"][0] == 0


@key("control.initial.run")
def control_initial_run() -> None:
    first = optimize(iterations=2)
    again = simulate(control__initial={"run": str(first.folder)})
    near(again.manifest["objective"]["value"], first.manifest["objective"]["value"])
    assert again.manifest["objective"]["control_cost"] > 0 == simulate().manifest["objective"]["control_cost"]


@key("control.lower", "control.upper")
def control_bounds() -> None:
    def reached(desired: str, **bounds: object) -> np.ndarray:
        u = optimize(iterations=1, objective__desired={"displacement": [desired, desired]}, **bounds, **FREE).field("control", "control")
        return np.array([u.min(axis=(0, 1)), u.max(axis=(0, 1))])

    assert reached("1").max() > 0.05 and reached("-1").min() < -0.05, "the bounds below hold nothing back"
    near(reached("1", control__upper=0.02)[1], [0.02, 0.02], 0)
    near(reached("1", control__upper=[0.01, 0.02])[1], [0.01, 0.02], 0)
    near(reached("-1", control__lower=-0.02)[0], [-0.02, -0.02], 0)
    near(reached("-1", control__lower=[-0.01, -0.02])[0], [-0.01, -0.02], 0)
    for given, applied in (({}, 0.5), ({"control__initial": ["9", "9"]}, 0.75)):  # simulate keeps to them too
        near(simulate(control__lower=0.5, control__upper=0.75, **given, **FREE).momentum(), [applied * T, applied * T])


# --- Objective and optimizer --------------------------------------------------------------------------------------------


@key("objective.desired.displacement", "objective.tracking", "objective.gamma")
def parts_of_the_objective() -> None:
    for overrides, tracking, terminal in (
        ({}, T / 2, 1e-2),
        ({"objective__desired": {"displacement": ["0", "2"]}}, 4 * T / 2, 4e-2),
        ({"objective__tracking": 3}, 3 * T / 2, 1e-2),
        ({"objective__tracking": 0}, 0, 1e-2),
        ({"objective__gamma": 0.5}, T / 2, 0.5),
        ({"objective__gamma": 0}, T / 2, 0),
    ):
        found = optimize(**ONE_AWAY | overrides).history
        near(found["tracking"][0], tracking)
        near(found["terminal"][0], terminal)
        near(found["objective"][0], tracking + terminal)


@key("objective.on")
def objective_on() -> None:
    for group, measure in (("body", 1), ("top", 1), ("rest", 3)):
        found = optimize(objective__on=group, **ONE_AWAY).history
        near(found["tracking"][0], measure * T / 2)
        near(found["terminal"][0], measure * 1e-2)
    part = {"objective__desired": {"displacement": ["0", "y"]}}
    near(optimize(objective__on="top", **ONE_AWAY | part).history["tracking"][0], T / 2)
    near(optimize(**ONE_AWAY | part).history["tracking"][0], T / 2 / 3)


@key("objective.alpha")
def alpha() -> None:
    for overrides, weight in (({}, 1e-2), ({"objective__alpha": 3}, 3), ({"objective__alpha": 0}, 0)):
        near(optimize(control__initial=["3", "4"], **overrides).history["control_cost"][0], weight / 2 * 25 * T)


@key("objective.desired.control", "objective.desired.run")
def desired_motion() -> None:
    """By a control and by the run that it makes: there J is only the cost of the control, and nowhere else."""
    there = {"control__initial": ["0.2", "-0.5"]}
    motion = simulate(**there)
    assert motion.steps["active"].max() > 0
    for desired in ({"control": ["0.2", "-0.5"]}, {"run": str(motion.folder)}):
        at, off = (optimize(objective__desired=desired, **start).history for start in (there, {}))
        assert at["tracking"][0] + at["terminal"][0] < ROUNDING * off["tracking"][0]
        assert off["tracking"][0] > 1e-5 and off["terminal"][0] > 1e-5


@key("optimizer.method")
def optimizer_method() -> None:
    """Each goes down; of the first iterations only those of newton-cg make products, and projected-gradient's goes along the
    gradient."""
    sweeps = {}
    for method in ("lbfgs", "newton-cg", "projected-gradient"):
        history = optimize(iterations=3, optimizer__method=method).history
        assert len(history["iteration"]) == 4 and (np.diff(history["objective"]) < 0).all()
        sweeps[method] = history["adjoint_sweeps"][1]
    assert sweeps["newton-cg"] > sweeps["lbfgs"] == sweeps["projected-gradient"] == 3  # one tells the units
    usual, named = optimize(iterations=3), optimize(iterations=3, optimizer__method="lbfgs")
    near(usual.history["objective"], named.history["objective"], 0)


@key("optimizer.start")
def optimizer_start() -> None:
    """From coarse meshes a search is near the optimum before its first step; the usual start of a .geo with a size."""
    def first(**start: object) -> tuple[float, int]:
        done = optimize(iterations=3, mesh__size=0.06, time__step=0.03, **start)
        return done.history["objective"][0] / optimize(mesh__size=0.06, time__step=0.03).history["objective"][0], len(
            done.manifest["optimizer"]["coarse_levels"])  # fmt: skip

    assert first() == first(optimizer__start="coarse") and first()[0] < 0.9 and first()[1] == 1
    assert first(optimizer__start="guess") == (1, 0)


@key("optimizer.max_iterations")
def max_iterations() -> None:
    for most in (0, 1, 3):
        done = optimize(iterations=most)
        assert len(done.history["iteration"]) == most + 1 and done.manifest["stop_reason"] == "iteration limit"


@key("optimizer.tolerance")
def tolerance() -> None:
    steady = {"iterations": 5, "optimizer__method": "projected-gradient"}  # whose gradients shrink from the start
    norms = optimize(**steady, optimizer__tolerance=0).history["gradient_norm"]
    assert len(norms) == 6 and (np.diff(norms) < 0).all()
    between = float(np.sqrt(norms[2] * norms[3]) / norms[0])
    done = optimize(**steady, optimizer__tolerance=between)
    assert len(done.history["iteration"]) == 4 and done.manifest["stop_reason"] == "gradient norm below tolerance"


@key("optimizer.checkpoint")
def checkpoint() -> None:
    """As often as asked for, and at the end; none without."""
    for every, written in ((2, 4), (5, 2), (0, 0)):
        done = optimize(iterations=5, optimizer__tolerance=0, optimizer__checkpoint=every)
        assert done.manifest["timings"].get("checkpoint", {"calls": 0})["calls"] == written
        assert (done.folder / "checkpoint.h5").exists() == (written > 0)


@key("optimizer.memory")
def optimizer_memory() -> None:
    """With room for 16 controls a search goes on by the last eight pairs of steps and gradients: as with twenty until
    there are nine, then another way, and its checkpoint is that much smaller."""
    control = 8 * plain_run().manifest["unknowns"] * len(plain_run().steps["step"][1:])  # bytes, of the whole body
    usual, little = (optimize(iterations=16, objective__alpha=1e-6, **more) for more in ({}, {"optimizer__memory": 16 * control / 2}))
    assert usual.manifest["optimizer"]["iterations"] == 16  # and it does not end before
    differences = abs(little.history["objective"] / usual.history["objective"] - 1)
    assert differences[:10].max() == 0 and differences[10:].max() > 1e-6, differences
    sizes = [(run.folder / "checkpoint.h5").stat().st_size for run in (usual, little)]
    assert sizes[0] - sizes[1] > 12 * control, sizes


# --- Solver, check and output -------------------------------------------------------------------------------------------


@key("solver.vi", "solver.linear", "solver.memory")
def solvers() -> None:
    """Others come to the same motion in other ways."""
    usual = plain_run()
    assert usual.steps["active"].max() > 0
    for overrides, linear in (
        ({"solver__vi": "full"}, "CHOLMOD"),
        ({"solver__linear": "direct", "solver__memory": 1.0}, "CHOLMOD"),
        ({"solver__linear": "auto", "solver__memory": 1.0}, "CG"),
        ({"solver__linear": "iterative"}, "CG"),
    ):
        other = simulate(**overrides)
        same(other, usual, 1e-8)  # of the iterations, over 30 steps
        assert other.manifest["solver"].startswith(linear)
        solves = [done.manifest["counters"]["solves with D"] for done in (usual, other)]
        assert (solves[0] == solves[1]) == (overrides.get("solver__linear") == "direct"), f"{overrides}: {solves}"


@key("trajectory.storage", "trajectory.budget")
def trajectory() -> None:
    """The same search to the last bit, from states kept elsewhere or made again; the more room, the fewer of them."""
    usual = optimize(iterations=3)
    assert usual.manifest["counters"]["recomputed steps"] == 0 and "states written" not in usual.manifest["timings"]
    room = 4 * 8 * 2 * usual.manifest["unknowns"]  # bytes of two checkpoints, y and v, for two motions
    again = []
    for settings in (
        {"trajectory__storage": "disk"},
        {"trajectory": {"storage": "checkpoints", "budget": room}},
        {"trajectory": {"storage": "checkpoints", "budget": 3 * room}},
    ):
        other = optimize(iterations=3, **settings)
        for name in set(usual.history) - {"seconds"}:
            assert np.array_equal(usual.history[name], other.history[name]), (settings, name)
        same(other, usual)
        timings = other.manifest["timings"]
        on_disk = settings == {"trajectory__storage": "disk"}
        assert all(("states " + what in timings) == on_disk for what in ("written", "read"))
        assert ("states recomputed" in timings) != on_disk
        again.append(other.manifest["counters"]["recomputed steps"])
    assert again[0] == 0 < again[2] < again[1], again


@key("check.control")
def check_control() -> None:
    own = signorini("check", BLOCK).stdout
    assert "contact included" in own and "Derivatives at the reference control" in own
    away = attempt("check", BLOCK, check__control=["0", "9"])
    assert away.returncode == 1 and "Derivatives at the control of [check]" in away.stdout and "never" in away.stdout


@key("run.invariants", "run.tolerance")
def invariants() -> None:
    less_than_rounding = {"run__tolerance": 1e-30}
    warned = simulate(run__invariants="warn", **less_than_rounding)
    assert "run.tolerance" in warned.stdout and "run.tolerance" not in plain_run().stdout
    same(warned, plain_run())
    stopped = attempt("simulate", BLOCK, FOLDER / "stopped", run__invariants="stop", **less_than_rounding)
    assert stopped.returncode == 3 and "run.tolerance" in stopped.stderr and not (FOLDER / "stopped").exists()
    same(simulate(run__invariants="stop"), plain_run())
    off = simulate(run__invariants="off", output__tables=[], **less_than_rounding)
    assert "run.tolerance" not in off.stdout and "invariants" in warned.manifest and "invariants" not in off.manifest
    assert attempt("check", BLOCK, **less_than_rounding).returncode == 1


@key("contact.obstacle.name")
def obstacle_name() -> None:
    plane = {"shape": "half-space", "point": [0, -0.1], "normal": [0, 1]}
    for names, expected in ((({}, {}), ["obstacle 1", "obstacle 2"]), (({"name": "floor"}, {}), ["floor", "obstacle 2"])):
        done = simulate(contact=[{"on": "bottom", "obstacle": plane | names[0]}, {"on": "left", "obstacle": plane | names[1]}])
        assert [contact["obstacle"]["name"] for contact in done.echo["contact"]] == expected
        assert list(table(done.folder / "obstacles.csv")["obstacle"]) == 31 * expected
        assert [one["name"] for one in done.manifest["impact"]["obstacles"]] == expected


@key("output.probe.name", "output.probe.point", "output.probe.on", "output.probe.obstacle", "output.probe.body")
def probes() -> None:
    done = simulate(output__probe=[{"name": "corner", "point": [0, 1]}, {"on": "body"}, {"name": "floor", "obstacle": "obstacle 1"},
                                   {"name": "all", "body": True}])  # fmt: skip
    found = table(done.folder / "probes.csv")
    assert not (plain_run().folder / "probes.csv").exists()
    corner = np.flatnonzero(abs(done.points[:, :2] - [0, 1]).max(axis=1) < ROUNDING)
    for field in ("displacement", "velocity"):
        near(np.column_stack([found[f"corner.{field}_{axis}"] for axis in "xy"]), done.field(field)[:, corner[0]])
        near(found["all.center_y"] - 0.5, found["probe 2.displacement_y"])
    near(found["all.momentum_x"], found["probe 2.velocity_x"])
    near(found["floor.force_y"], done.steps["contact_force_y"])
    near(found["floor.impulse_x"][-1], 0.02 * done.steps["contact_force_x"].sum())
    assert abs(found["all.rotation"]).max() > 0.01, "one corner comes first"


@key("output.every")
def output_every() -> None:
    def times(done: Run, every: int) -> int:  # the first and the last state always, and that of the largest force
        force, last = done.steps["normal_force"], len(done.steps["step"]) - 1
        assert force.max() > 0
        return len({*range(0, last, every), last, int(np.flatnonzero(force >= (1 - 1e-9) * force.max())[0])})

    for step, every in ((0.02, 1), (0.002, 1), (0.00125, 2), (0.0005, 5)):  # 30, 300, 480, 1200 steps
        done = simulate(time__step=step, output__fields=["displacement"])
        assert done.echo["output"]["every"] == every and len(done.field("displacement")) == times(done, every)
        assert len(done.steps["step"]) == round(0.6 / step) + 1
    for every in (1, 7, 30, 100):
        done = optimize(output__every=every)
        stored = times(done, every)
        assert stored == (31 if every == 1 else 5 + 1 + (stored > 6) if every == 7 else 3)
        assert len(done.field("displacement")) == stored and len(done.field("control", "control")) == stored - 1
        assert len(table(done.folder / "contact.csv")["step"]) == 5 * stored and len(done.steps["step"]) == 31


@key("output.fields", "output.tables")
def output_files() -> None:
    always = {"scene.toml", "run.json", "checkpoint.h5"}
    files = {"displacement": "state", "velocity": "state", "control": "control", "adjoint": "adjoint", "strain": "state",
             "stress": "state", "von_mises": "state", "pressure": "state"}  # fmt: skip
    for field, name in files.items():
        done = optimize(output__fields=[field], output__tables=[])
        surfaces = {"surfaces.h5"} if name == "state" else set()
        assert {path.name for path in done.folder.iterdir()} == always | {f"{name}.xdmf", f"{name}.h5"} | surfaces
        assert abs(done.field(field, name)).max() > 0 or field == "control"
    for name in ("steps", "contact", "obstacles", "history"):
        done = optimize(output__fields=[], output__tables=[name])
        assert {path.name for path in done.folder.iterdir()} == always | {f"{name}.csv"} | ({"surfaces.h5"} if name == "contact" else set())


def study(**overrides: object) -> dict[str, np.ndarray]:
    """study.csv of the block without an objective, thrown onto its plane; its default ladder."""
    folder = FOLDER / f"study-{next(Run.numbers)}"
    scene = edited(f"{folder.name}.toml", (r"(?s)\[control\].*", ""))
    signorini("study", scene, folder, **overrides)
    return table(folder / "study.csv")


@key("exact.displacement")
def exact_displacement() -> None:
    free = {"contact__obstacle__point": [0, -100], "load__body": ["0", "0"]}
    assert np.max(study(**free, exact__displacement=["0", "-t"])["displacement_error"]) < 1e-9
    assert abs(study(**free, exact__displacement=["0", "-2*t"])["displacement_error"] - 0.5).max() < 1e-9


@key("exact.impulse", "exact.peak_force", "exact.contact_start", "exact.contact_time")
def exact_numbers() -> None:
    for name in ("impulse", "peak_force", "contact_start", "contact_time"):
        known = study(**{f"exact__{name}": 0.125})
        assert np.min(known[name]) > 0
        near(known[f"{name}_error"], abs(known[name] / 0.125 - 1), 1e-9)


@key("exact.pressure")
def exact_pressure() -> None:
    small, large = (study(exact__pressure=value)["pressure_error"] for value in ("0.1", "1e9"))
    assert abs(large - 1).max() < 1e-6 and np.min(small) > 0 and abs(small - 1).max() > 1e-3


# --- Fits ---------------------------------------------------------------------------------------------------------------

CORE = SOURCE / "scenes" / "two-materials.toml"
COARSE = {"mesh__size": 0.02, "time__end": 5e-3}
PROBES = [{"name": "top", "point": [0, 0.1]}, {"name": "sides", "on": "surface"}, {"name": "floor", "obstacle": "floor"}]
STIFF = {"of": "young", "on": "inclusion", "start": 3e7}


@functools.cache
def followed() -> Path:
    """What the core's scene gives, as data: columns by probe and quantity."""
    return simulate(CORE, **COARSE, output__probe=PROBES).folder / "probes.csv"


def measured(of: str, column: str, **more: object) -> dict:
    return {"of": of, "component": "y", "file": str(followed()), "column": column} | ({} if "noise" in more else {"deviation": 1.0}) | more


TOP = {"point": [0, 0.1]}


def fit(unknown: list[dict] | None = None, measurement: list[dict] | None = None, iterations: int = 0, **overrides: object) -> Run:
    given = {"unknown": unknown or [STIFF], "measurement": measurement or [measured("displacement", "top.displacement_y", **TOP)]}
    return optimize(CORE, iterations, **COARSE, **given, **overrides)


def parameters(done: Run) -> dict[str, np.ndarray]:
    return table(done.folder / "parameters.csv")


def residuals(done: Run) -> np.ndarray:
    return table(done.folder / "measurements.csv")["residual"]


@key("measurement.of", "measurement.point", "measurement.on", "measurement.component", "measurement.file", "measurement.column")
def measured_as_probes() -> None:
    """At the true values data that are a probe's leave nothing."""
    true = [STIFF | {"start": 2e7}]
    for of, column, where in (("displacement", "top.displacement_y", TOP), ("velocity", "top.velocity_x", TOP | {"component": "x"}),
                              ("displacement", "sides.displacement_y", {"on": "surface"}), ("velocity", "sides.velocity_y", {"on": "surface"}),
                              ("impulse", "floor.impulse_y", {})):  # fmt: skip
        scale = abs(table(followed())[column]).max()
        assert abs(residuals(fit(true, [measured(of, column, **where)]))).max() < 1e-9 * scale, column
    assert abs(residuals(fit(true, [measured("displacement", "top.displacement_x", **TOP)]))).max() > 1e-4


@key("measurement.obstacle")
def measured_obstacle() -> None:
    """Of two obstacles one is never touched."""
    wall = {"on": "surface", "obstacle": {"name": "wall", "shape": "half-space", "point": [9, 0], "normal": [-1, 0]}}
    floor = {"on": "bottom", "obstacle": {"name": "floor", "shape": "half-space", "point": [0, -0.001], "normal": [0, 1]}}
    forces = [table(fit(measurement=[measured("force", "floor.force_y", obstacle=name)], contact=[floor, wall]).folder / "measurements.csv")
              for name in ("floor", "wall")]  # fmt: skip
    assert abs(forces[0]["simulated"]).max() > 100 and not forces[1]["simulated"].any()


@key("measurement.name", "measurement.deviation", "measurement.noise")
def measured_noise() -> None:
    top = ("displacement", "top.displacement_y")
    known = fit(measurement=[measured(*top, deviation=0.5, name="crown", **TOP)])
    assert set(table(known.folder / "measurements.csv")["measurement"]) == {"crown"}
    near(residuals(known), 2 * residuals(fit(measurement=[measured(*top, **TOP)])))
    largest = abs(table(followed())["top.displacement_y"]).max()
    deviation = table(fit(measurement=[measured(*top, noise=0.1, **TOP)]).folder / "measurements.csv")["deviation"]
    near(deviation, np.full_like(deviation, 0.1 * largest))


@key("measurement.value")
def compared_time() -> None:
    figures = [{"of": "contact-start", "value": 1e-3, "deviation": 1e-4}, {"of": "impulse-duration", "value": 1e-3}, {"of": "sustained-peak", "value": 10.0}]
    done = fit(measurement=[measured("displacement", "top.displacement_y", **TOP), *figures])
    found, duration, peak = done.manifest["fit"]["contact_times"]
    assert found["value"] == 1e-3 and abs(found["simulated"] - 1e-3) < 1e-4 and "measured 0.001 s" in done.stdout
    touch = done.manifest["impact"]["all"]
    assert duration["simulated"] == touch["impulse_duration"] > 0 and peak["simulated"] == touch["sustained_peak"] > 0
    assert (duration["unit"], peak["unit"]) == ("s", "N/m") and "measured 10 N/m, simulated" in done.stdout


@key("unknown.of", "unknown.on", "unknown.name", "unknown.start")
def unknown() -> None:
    done = fit([STIFF, {"of": "young", "on": "matrix"}, {"of": "density", "on": "matrix", "name": "rubber's", "start": 1200}])
    found = parameters(done)
    assert list(found["name"]) == ["young of inclusion", "young of matrix", "rubber's"]
    near(found["value"], found["start"])
    assert list(found["start"]) == [3e7, 2e6, 1200] and len(set(found["gradient"])) == 3


@key("unknown.lower", "unknown.upper")
def bounds_of_unknowns() -> None:
    for bound, value in (("lower", 2.5e7), ("upper", 1.5e7)):
        found = parameters(fit([STIFF | {"start": value, bound: value}], iterations=20))
        near(np.array([found["value"][0], found[bound][0]]), np.full(2, value))
        assert found["at_bound"][0] == 1
    assert abs(parameters(fit(iterations=20))["value"][0] / 2e7 - 1) < 1e-4


@key("unknown.scale", "unknown.prior.mean", "unknown.prior.deviation")
def priors() -> None:
    """A prior adds half the square of its distance in deviations, on the unknown's scale."""
    without = fit().history["objective"][0]
    prior = {"mean": 1e7, "deviation": 0.1}
    near(fit([STIFF | {"prior": prior}]).history["objective"][0] - without, (np.log(3) / 0.1) ** 2 / 2, 1e-9)
    linear = STIFF | {"scale": "linear", "prior": {"mean": 1e7, "deviation": 1e7}}
    near(fit([linear]).history["objective"][0] - without, 2.0, 1e-9)


@key("unknown.component", "unknown.obstacle")
def unknown_of_a_part() -> None:
    found = parameters(fit([{"of": "initial.velocity", "component": "y"}, {"of": "position", "obstacle": "floor"}]))
    assert list(found["name"]) == ["initial.velocity y", "position of floor"] and list(found["value"]) == [-1, 0]
    assert parameters(fit([{"of": "initial.velocity"}]))["value"][0] == 1


# --- All keys -----------------------------------------------------------------------------------------------------------

EXACT = {"displacement": ["0", "0"], "pressure": "1", "impulse": 1, "peak_force": 1, "contact_start": 1, "contact_time": 1}
# Scenes in which every table and every optional key occurs.
FULL = (
    (BLOCK, {
        "clamp": [{"on": "left", "components": ["x"], "value": ["0"]}],
        "load__traction": [{"on": "top", "value": ["0", "0"]}], "load__gravity": [0, 0],
        "contact": [
            {"on": "bottom", "obstacle": {"shape": "half-space", "point": [0, -1], "normal": [0, 1]}},
            {"on": "bottom", "obstacle": {"shape": "ball", "center": [0, -2], "radius": 1}},
            {"on": "bottom", "obstacle": {"shape": "cylinder", "point": [0, -2], "radius": 1}},
            {"on": "bottom", "obstacle": {"shape": "signed-distance", "distance": "y + 1"}},
        ],
        "control__on": "body", "control__lower": -9, "control__upper": 9, "objective__on": "body", "check__control": ["0", "0"],
        "output__probe": [{"point": [0.5, 0.5]}, {"on": "top"}, {"obstacle": "obstacle 3"}, {"body": True}],
    }),
    (BLOCK, {"time": {"end": 0.6, "step": "auto", "longest": 0.06, "shortest": 1e-3}, "control__step": 0.06}),
    (DATA / "two-materials.toml", {"objective__desired": {"displacement": ["0", "0"]}, "trajectory__storage": "checkpoints"}),
    (BLOCK, {"objective__desired": {"run": "somewhere"}, "control__initial": {"run": str(FOLDER / "first")}}),
    (SOURCE / "scenes" / "hertz-press.toml", {"time__end": 0.05, "mesh__scale": 8, "exact": EXACT}),
    (CORE, COARSE | {
        "unknown": [STIFF | {"lower": 1e6, "upper": 1e9, "prior": {"mean": 2e7, "deviation": 1.0}},
                    {"of": "initial.velocity", "component": "y"}, {"of": "position", "obstacle": "floor"}],
        "measurement": [{"of": "force", "component": "y", "obstacle": "floor", "file": "a.csv", "noise": 0.1},
                        {"of": "displacement", "point": [0, 0.1], "component": "y", "file": "b.csv", "deviation": 1.0},
                        {"of": "velocity", "on": "surface", "component": "x", "file": "b.csv", "deviation": 1.0},
                        {"of": "contact-time", "value": 0.01}],
    }),
    (DATA / "cube.toml", {"contact__obstacle": {"shape": "cylinder", "point": [0, 0, -2], "axis": [1, 0, 0], "radius": 1}}),
)  # fmt: skip


def leaves(node: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The paths of a scene's values; the tables of a list by their numbers."""
    for name, value in node.items() if isinstance(node, dict) else enumerate(node):
        here = (*path, str(name))
        if isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict)):
            yield from leaves(value, here)
        else:
            yield here


def plain(path: tuple[str, ...]) -> str:
    return ".".join(name for name in path if not name.isdigit())


def accepted_keys() -> set[str]:
    """Those that scene.toml writes out, which must be all that the program says it allows in each table."""
    written: set[str] = set()
    signorini("optimize", BLOCK, FOLDER / "first", optimizer__max_iterations=0)
    tables: dict[tuple[str, str], tuple[Path, tuple[str, ...]]] = {}  # each kind once, wherever it occurs
    for scene, overrides in FULL:
        done = simulate(scene, **overrides)
        for path in leaves(done.echo):
            written.add(plain(path))
            for n in range(len(path)):
                if not path[n].isdigit():
                    kind = plain(path[:n]), get(done.echo, path[:n]).get("shape", "")
                    tables.setdefault(kind, (done.folder / "scene.toml", path[:n]))

    def allowed(scene: Path, path: tuple[str, ...]) -> set[str]:
        refused = attempt("info", scene, **{"__".join((*path, "nonsense")): 1})
        assert refused.returncode == 2 and "nonsense: unknown key" in refused.stderr, refused.stderr
        return {plain((*path, name)) for name in refused.stderr.strip().rsplit("keys here: ")[1].split(", ")}

    with ThreadPoolExecutor(WORKERS) as workers:
        # A key that may be a table or a value is both.
        values = set.union(*workers.map(allowed, *zip(*tables.values()))) - ({table for table, _ in tables} - written)
    assert values == written, f"allowed and never echoed, or the reverse: {values ^ written}"
    return written


def keys_of_bad_values() -> set[str]:
    """What messages name, but for those that a key is unknown or missing."""
    found = set()
    for case in all_cases():
        for text in case.expect:
            if isinstance(text, str) and (match := re.match(r"([a-z_]+(?:(?:\[\d\])?\.[a-z_]+)+)(?:$|: (?!unknown|missing))", text)):
                found.add(re.sub(r"\[\d\]", "", match[1]))
    return found


def choices(run: Run) -> Iterator[tuple[str, list[str]]]:
    """The names that the program allows where it allows no others."""

    def refused(path: tuple[str, ...]) -> str:
        return attempt("info", run.folder / "scene.toml", **{"__".join(path): "nonsense"}).stderr

    texts = [path for path in leaves(run.echo) if isinstance(get(run.echo, path), str)]
    with ThreadPoolExecutor(WORKERS) as workers:
        for path, message in zip(texts, workers.map(refused, texts)):
            if match := re.search(r"choices: (.*)", message):
                yield plain(path), match[1].split(", ")


def keys_of_the_page() -> set[str]:
    """Those of its table, which is the program's, with what can be chosen and the defaults that scene.toml confirms."""
    table = captured([str(SIGNORINI), "keys", "--markdown"]).stdout
    found = re.search(r"(?s)<!-- keys.*?-->\n(.*?)<!-- end of keys -->", (SOURCE / "docs" / "reference" / "keys.md").read_text())
    assert found and found[1] == table, "the table of docs/reference/keys.md is not the program's; docs/extend.md says how to make it"
    rows = re.findall(r"(?m)^\| `([a-z_]+\.[a-z_.]+)` \| (.*?) \| (.*?) \| .* \|$", table)
    assert len({name for name, _, _ in rows}) == len(rows), "the table has a key twice"
    default = simulate(edited("default.toml", ("(max_iterations|alpha|gamma).*", "")), clamp=[{"on": "left"}], initial__velocity=["0", "0"],
                       contact__obstacle={"shape": "ball", "center": [0, -2], "radius": 1},
                       measurement=[{"of": "force", "component": "y", "file": "none.csv"}])  # fmt: skip
    chosen = simulate(time={"end": 0.6, "step": "auto"})  # which has keys that others have not
    for name, names in itertools.chain(choices(default), choices(chosen)):
        value = next((value for key, value, _ in rows if key == name), "")
        assert all(f'"{choice}"' in value for choice in names), f"the table's {name} is not all of {names}"
    confirmed = 0
    for name, _, value in rows:
        if re.fullmatch("`[^`]*`", value):
            own = chosen if name in ("time.tolerance", "time.quantity") else default
            echoed = get(own.echo, re.sub("^(clamp|measurement)", r"\1.0", name).split("."))
            assert echoed == tomllib.loads(f"value = {value[1:-1]}")["value"], f"the table's default of {name} is {value}, not {echoed}"
            confirmed += 1
    assert confirmed > 20
    return {name for name, _, _ in rows}


def fails(show: Callable[[], None]) -> bool:
    try:
        show()
    except (AssertionError, SystemExit) as failure:
        line = inspect.getinnerframes(failure.__traceback__)[1].lineno
        print(f"FAIL  {show.__name__}, line {line}: {failure}", flush=True)
        return True
    print(f"ok    {show.__name__}", flush=True)
    return False


def main() -> int:
    with ThreadPoolExecutor(WORKERS) as workers:
        failed = sum(workers.map(fails, ENTRIES))
    keys = accepted_keys()
    for what, known in (("is shown here", SHOWN), ("is in docs/reference/keys.md", keys_of_the_page())):
        for name in sorted(keys ^ known):
            failed += 1
            print(f"FAIL  {name} {'is accepted, but not ' if name in keys else 'is not accepted, but '}{what}")
    for name in sorted(keys - keys_of_bad_values()):
        failed += 1
        print(f"FAIL  {name} has no bad value in bad_input/cases.py")
    print(f"{len(keys)} keys, {next(Run.numbers)} runs, {failed} failures")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
