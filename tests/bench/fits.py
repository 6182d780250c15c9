# SPDX-License-Identifier: GPL-3.0-or-later
"""A gradient by eight unknowns of a fit over one by a control alone: a forward run and a backward sweep, factors made before. And a
forward run with the derivatives of the motion by all unknowns, as a Gauss-Newton step makes it, over a forward run.

usage: ./dev bench fits [--sizes H …] [--repeats N] [--json FILE]

The half disc falls onto a plane; unknown are the five numbers of its material, its speed, height and angle of the plane; measured are
the force, and displacement and velocity of a point. Least times of `signorini-bench-fits`. A minute.
"""

import json
import tempfile
from pathlib import Path

import program

SCENE = """
[mesh]
file = "{meshes}/half-disc.geo"
size = {size!r}
[time]
step = {step!r}
end = {end!r}
scheme = "contact-stabilized"
[material]
density = 1.0
young = 1e8
poisson = 0.3
viscosity = {{ bulk = 1e4, shear = 1e4 }}
[contact]
on = "contact"
obstacle = {{ shape = "half-space", point = [0, -15.01], normal = [0, 1] }}
[initial]
velocity = ["0", "-500"]
"""
UNKNOWNS = ["young", "poisson", "bulk", "shear", "density", "initial.velocity", "position", "angle"]
MEASURED = [{"of": "force"}, {"of": "displacement", "point": [5, -2]}, {"of": "velocity", "point": [5, -2]}]


def main() -> None:
    parser = program.options("bench fits", __doc__)
    parser.add_argument("--sizes", nargs="+", type=float, default=[0.5, 0.25, 0.125], metavar="H", help="element sizes, m")
    parser.add_argument("--repeats", type=int, default=5, metavar="N")
    given = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for size in given.sizes:
            step = 1e-4 * size
            text = SCENE.format(meshes=program.ROOT / "meshes", size=size, step=step, end=60 * step)
            text += "".join(f'[[unknown]]\nof = "{of}"\n' for of in UNKNOWNS)
            for one in MEASURED:
                keys = one | {"component": "y", "file": "none.csv", "deviation": 1.0}
                text += "[[measurement]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
            scene = Path(name) / "fit.toml"
            scene.write_text(text)
            row = json.loads(program.output("signorini-bench-fits", scene, str(given.repeats), OMP_NUM_THREADS=1))
            assert row["contact_steps"] > 30, "hardly any contact"
            rows.append(row)
            seconds = row["seconds"]
            print(f"{row['free_unknowns']:8d} unknowns of the motion: control alone {1e3 * seconds['control_alone'] / row['steps']:.3f} ms a step, "
                  f"{row['parameters']} parameters {1e3 * seconds['parameters'] / row['steps']:.3f} ms: {row['ratio']:.2f} times;"
                  f" a motion with its derivatives by all of them {row['jacobian_ratio']:.2f} times a motion", flush=True)  # fmt: skip
    program.write(given.json, rows)


if __name__ == "__main__":
    main()
