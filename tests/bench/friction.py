# SPDX-License-Identifier: GPL-3.0-or-later
"""Iterations and failures of steps with friction, over coefficients, Courant numbers, bodies and stiffness.

A block is thrown obliquely onto a tilted plane with a belt; where steps are long, every other one is clamped at its upper side
instead, which presses it onto the plane and shears it to and fro. Each step in which it touches is a problem. The Courant number
is the length of a step over the time in which a pressure wave crosses an element. Long runs are slowed down, so that the body
moves by metres only: displacements of many kilometres would be gaps known to 1e-10 m only.
"""

import itertools
import json
import tempfile
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
PLANE, SPACE = 2, 3
# Mesh: element size, m, and dimension.
BODIES = {"block": (0.1, PLANE), "strip": (0.4, PLANE), "ribbon": (0.1, PLANE), "cube": (0.25, SPACE), "slab": (0.3, SPACE)}
FRICTION = (0.05, 0.2, 0.5, 1.0, 2.0, 3.0)
COURANT = (0.1, 1.0, 10.0, 100.0, 1e4)
YOUNG = (50.0, 1e6)
STEPS = 40
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


def motion(dim: int, end: float, pressed: bool, generator: np.random.Generator) -> str:
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


def main() -> int:
    parser = program.options("bench friction", __doc__)
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="throws of the small bodies for each combination, default 3")
    given = parser.parse_args()
    rows, failures = [], []
    generator = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        geometries(folder)
        for (mesh, (size, dim)), friction, courant, young in itertools.product(BODIES.items(), FRICTION, COURANT, YOUNG):
            if mesh == "ribbon" and not (friction in FEW["friction"] and courant in FEW["courant"]):
                continue
            steps = FEW["steps"] if mesh == "ribbon" else STEPS
            for seed in range(given.seeds if mesh in ("block", "cube") else 1):
                scheme = ("contact-implicit", "contact-stabilized")[seed % 2]
                wave = np.sqrt(young * 0.7 / (1.3 * 0.4))
                step = float(courant * size / wave)
                pressed = mesh == "ribbon" or courant >= 100 and (seed % 2 == 1 or mesh in ("strip", "slab"))
                scene = folder / "scene.toml"
                scene.write_text(SCENE.format(folder=folder, mesh=mesh, size=size, step=step, end=steps * step, scheme=scheme, young=young,
                                              friction=friction) + motion(dim, steps * step, pressed, generator))  # fmt: skip
                out = folder / "out"
                said = program.output("signorini", "simulate", scene, "--out", out, "--replace", "--quiet", allowed=(0, 3))
                row = {"mesh": mesh, "friction": friction, "courant": courant, "young": young, "pressed": pressed}
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
    for space, low in itertools.product((False, True), (True, False)):
        chosen = [r for r in rows if (BODIES[r["mesh"]][1] == SPACE) == space and (r["friction"] <= 1) == low]
        every = np.concatenate([r["iterations"] for r in chosen])
        failed = [r for r in failures if (BODIES[r["mesh"]][1] == SPACE) == space and (r["friction"] <= 1) == low]
        print(f"{'space' if space else 'plane'}, coefficients {'up to' if low else 'above'} 1: {len(every)} problems of up to "
              f"{np.max([r['largest'] for r in chosen])} candidates, {sum(r['slip'] for r in chosen)} slips and "
              f"{sum(r['stick'] for r in chosen)} sticks; {every.mean():.2f} iterations, at most {every.max()}; "
              f"{(every > 20).sum()} took more than 20; {len(failed)} runs failed")  # fmt: skip
    program.write(given.json, rows + failures)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
