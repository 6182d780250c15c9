# SPDX-License-Identifier: GPL-3.0-or-later
"""Iterations and failures of steps with friction, over coefficients, Courant numbers, bodies and stiffness.

A block is thrown obliquely onto a tilted plane with a belt; where steps are long, every other one is clamped at its upper side
instead, which presses it onto the plane and shears it to and fro. A stiff cube on a turning plate is nearly rigid in each step: all
its candidates depend on six numbers, and single slips hardly on its deformation. Each step in which it touches is a problem. The Courant number
is the length of a step over the time in which a pressure wave crosses an element. Long runs are slowed down, so that the body
moves by metres only: displacements of many kilometres would be gaps known to 1e-10 m only.
"""

import itertools
import json
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import program
from program import ROOT

SCENE = """
[mesh]
file = "{folder}/{mesh}.geo"
size = {size}
[time]
step = {step!r}
end = {end!r}
scheme = "{scheme}"
[material]
density = 1.0
young = {young}
poisson = 0.3
[contact]
on = "bottom"
friction = {friction}
[output]
fields = []
tables = ["steps"]
"""
THROWN = """
[contact.obstacle]
shape = "half-space"
point = {point}
normal = {normal}
surface_velocity = {belt}
[load]
body = {body}
[initial]
velocity = {velocity}
"""
PRESSED = """
[contact.obstacle]
shape = "half-space"
point = {point}
normal = {up}
[[clamp]]
on = "top"
value = {value}
"""
TURNED = """
[contact.obstacle]
shape = "half-space"
point = [0, 0, 0]
normal = [0, 0, 1]
surface_velocity = ["-{turn}*(y-0.5)", "{turn}*(x-0.5)", "0"]
[load]
body = ["0", "0", "-1"]
"""
PLANE, SPACE = 2, 3
# Mesh: element size, m, and dimension.
BODIES = {"block": (0.1, PLANE), "strip": (0.4, PLANE), "ribbon": (0.1, PLANE), "cube": (0.25, SPACE), "slab": (0.3, SPACE)}
FRICTION = (0.05, 0.2, 0.5, 1.0, 2.0, 3.0)
COURANT = (0.1, 1.0, 10.0, 100.0, 1e4)
YOUNG = (50.0, 1e6)
STEPS = 40
SCHEMES = ("contact-implicit", "contact-stabilized")
# The stiff cube is that of steel with sides of 1 cm and steps of 1 to 100 ms, in units in which side, density and gravity are 1.
STIFF = {"friction": (0.02, 0.05, 0.1, 0.2, 0.5, 1.0), "courant": (2e3, 2e4, 6e4, 2e5), "young": 2.6e8, "size": 0.3, "turn": 0.032, "steps": 20}
FEW = {"friction": (0.2, 1.0), "courant": (10.0, 100.0), "steps": 10}  # of the ribbon, with 1000 candidates


def geometries(folder: Path) -> None:
    head = 'SetFactory("OpenCASCADE");\neps = 1e-6;\n'
    for name, (x, y) in {"block": (1, 1), "strip": (100, 0.2), "ribbon": (100, 0.2)}.items():
        sides = "".join(
            f"{side}() = Curve In BoundingBox {{-eps, {at} - eps, -eps, {x} + eps, {at} + eps, eps}};\n"
            f'Physical Curve("{side}") = {{{side}()}};\n' for side, at in (("bottom", 0), ("top", y)))  # fmt: skip
        (folder / f"{name}.geo").write_text(head + f"Rectangle(1) = {{0, 0, 0, {x}, {y}}};\n" + sides + 'Physical Surface("body") = {1};\n')
    for name, (x, z) in {"cube": (1, 1), "slab": (4, 0.5)}.items():
        sides = "".join(
            f"{side}() = Surface In BoundingBox {{-eps, -eps, {at} - eps, {x} + eps, {x} + eps, {at} + eps}};\n"
            f'Physical Surface("{side}") = {{{side}()}};\n' for side, at in (("bottom", 0), ("top", z)))  # fmt: skip
        (folder / f"{name}.geo").write_text(head + f"Box(1) = {{0, 0, 0, {x}, {x}, {z}}};\n" + sides + 'Physical Volume("body") = {1};\n')


def motion(dim: int, pressed: bool, generator: np.random.Generator, end: float) -> str:
    """The tables of a scene that set the body in motion, until a time."""
    across, speed, slow = 2 * generator.standard_normal(), generator.random(), float(np.minimum(1, 1 / end))
    between = ["0"] * (dim - 2)
    if pressed:
        turns = f"2*pi*t/{end!r}"
        sheared = [f"{0.03 * (1 + c)}*sin({2 + c}*{turns})" for c in range(dim - 1)]
        return PRESSED.format(point=[0.0] * dim, up=[0.0] * (dim - 1) + [1.0], value=json.dumps([*sheared, f"-0.02*sin({turns}/2)"]))
    return THROWN.format(point=[0.0] * dim, normal=[0.02, 0.01, 1.0] if dim == SPACE else [0.02, 1.0],
                         belt=json.dumps([f"{0.3 * slow!r}", *[f"{0.1 * slow!r}"] * (dim - 2), "0"]),
                         body=json.dumps(["0", *between, f"{-slow**2!r}"]),
                         velocity=json.dumps([f"{across * slow!r}", *[f"{0.2 * slow!r}"] * (dim - 2), f"{-speed * slow!r}"]))  # fmt: skip


def cases(folder: Path, throws: int) -> Iterator[tuple[dict, str]]:
    """Rows without results, and their scenes."""
    generator = np.random.default_rng(1)

    def case(mesh: str, size: float, friction: float, courant: float, young: float, steps: int, scheme: str, moved: Callable) -> tuple[dict, str]:
        step = float(courant * size / np.sqrt(young * 0.7 / (1.3 * 0.4)))
        scene = SCENE.format(folder=folder, mesh=mesh, size=size, step=step, end=steps * step, scheme=scheme, young=young, friction=friction)
        return {"mesh": mesh, "friction": friction, "courant": courant, "young": young, "scheme": scheme}, scene + moved(steps * step)

    for (mesh, (size, dim)), friction, courant, young in itertools.product(BODIES.items(), FRICTION, COURANT, YOUNG):
        if mesh == "ribbon" and not (friction in FEW["friction"] and courant in FEW["courant"]):
            continue
        for seed in range(throws if mesh in ("block", "cube") else 1):
            pressed = mesh == "ribbon" or courant >= 100 and (seed % 2 == 1 or mesh in ("strip", "slab"))
            yield case(mesh, size, friction, courant, young, FEW["steps"] if mesh == "ribbon" else STEPS, SCHEMES[seed % 2],
                       partial(motion, dim, pressed, generator))  # fmt: skip
    for friction, courant, scheme in itertools.product(STIFF["friction"], STIFF["courant"], SCHEMES):
        turned = TURNED.format(turn=STIFF["turn"])
        yield case("cube", STIFF["size"], friction, courant, STIFF["young"], STIFF["steps"], scheme, lambda _, turned=turned: turned)


def main() -> int:
    parser = program.options("bench friction", __doc__)
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="throws of the small bodies for each combination, default 3")
    given = parser.parse_args()
    rows, failures = [], []
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        geometries(folder)
        for row, text in cases(folder, given.seeds):
            scene, out = folder / "scene.toml", folder / "out"
            scene.write_text(text)
            said = program.output("signorini", "simulate", scene, "--out", out, "--replace", "--quiet", allowed=(0, 3))
            if not (out / "steps.csv").exists():
                failures.append(row)
                print("failed:", row, said, flush=True)
                continue
            table = np.genfromtxt(out / "steps.csv", delimiter=",", names=True)
            touching = table["slip"] + table["stick"] > 0
            rows.append(row | {"problems": int(touching.sum()), "iterations": [int(n) for n in table["vi_iterations"][touching]],
                               "slip": int(table["slip"].sum()), "stick": int(table["stick"].sum()),
                               "largest": int((table["slip"] + table["stick"]).max())})  # fmt: skip
            (out / "steps.csv").unlink()
    kinds = {
        "plane": lambda r: BODIES[r["mesh"]][1] == PLANE,
        "space": lambda r: BODIES[r["mesh"]][1] == SPACE and r["young"] != STIFF["young"],
        "stiff cube": lambda r: r["young"] == STIFF["young"],
    }
    for (kind, belongs), low in itertools.product(kinds.items(), (True, False)):
        chosen, failed = ([r for r in all if belongs(r) and (r["friction"] <= 1) == low] for all in (rows, failures))
        if not chosen:
            continue
        every = np.concatenate([r["iterations"] for r in chosen])
        print(f"{kind}, coefficients {'up to' if low else 'above'} 1: {len(every)} problems of up to "
              f"{np.max([r['largest'] for r in chosen])} candidates, {sum(r['slip'] for r in chosen)} slips and "
              f"{sum(r['stick'] for r in chosen)} sticks; {every.mean():.2f} iterations, at most {every.max():.0f}; "
              f"{(every > 20).sum()} took more than 20; {len(failed)} runs failed")  # fmt: skip
    program.write(given.json, rows + failures)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
