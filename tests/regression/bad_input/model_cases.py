# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad models of bodies in the plane, and scenes that a model excludes."""

from pathlib import Path

from case import GROUPS, LINE, SIDE, TO_SPACE, Case, Expected, cube2, msh2, square_elements, square_points, write

MESH = 'file = "square.msh"'
AXIS = 5
OBSTACLE = '{ shape = "half-space", point = [0, -0.1], normal = [0, 1] }'
VISCOSITY = "viscosity = { bulk = 1e4, shear = 1e4 }"
OBJECTIVE = '[objective]\ndesired = { control = ["0", "-1"] }\nalpha = 1e-2\ngamma = 7.5e-4\n'


def section_of_cylinder() -> str:
    """The square moved to 0 <= x <= 1 as format 2.2, with a group "axis" of its edges at x = 0."""
    points = [(x + 0.5, y, z) for x, y, z in square_points()]
    elements = [
        (kind, AXIS, AXIS, nodes) if group == SIDE and all(points[n - 1][0] == 0 for n in nodes) else (kind, group, entity, nodes)
        for kind, group, entity, nodes in square_elements()
    ]
    assert sum(kind == LINE and group == AXIS for kind, group, _, _ in elements) == 2
    return msh2(points, elements, (*GROUPS, (1, AXIS, "axis")))


def model(name: str, which: str, *expect: Expected, edits: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
    """A scene with a model; in axial symmetry that of the cylinder."""
    if which == "axisymmetric":
        more.setdefault("mesh", section_of_cylinder())
    return Case(name, expect, edits=((MESH, f'{MESH}\nmodel = "{which}"'), *edits), **more)  # type: ignore[arg-type]


def round_body(name: str, old: str, new: str, *expect: Expected, **more: object) -> Case:
    """A cylinder in whose scene `new` stands for `old`; the message must name the line where `new` begins."""
    more.setdefault("at", new.splitlines()[0])
    return model(name, "axisymmetric", *expect, edits=((old, new),), **more)


def plate(name: str, new: str, *expect: Expected, **more: object) -> Case:
    """A plate whose material has `new` in place of its viscosity."""
    return model(name, "plane-stress", *expect, edits=((VISCOSITY, new),), at=new, **more)


def fit(name: str, which: str, unknown: str, measurement: str, *expect: Expected, obstacle: str = OBSTACLE, viscosity: str = "",
        **more: object) -> Case:  # fmt: skip
    """A fit of one unknown to one measurement, with another obstacle and viscosity if they are given."""
    tables = f"every = 1\n\n[[unknown]]\n{unknown}\n[[measurement]]\n{measurement}\n"
    own = ((OBSTACLE, obstacle), (VISCOSITY, viscosity))
    return model(name, which, *expect, edits=(("every = 1", tables), (OBJECTIVE, ""), *own), **more)


def model_cases() -> list[Case]:
    """Models that a mesh cannot have, and parts of scenes that a model cannot have."""
    ball = '{ shape = "ball", center = [0, -1], radius = 0.5 }'
    tube = '{ shape = "cylinder", point = [0, 0], radius = 2, side = "inside" }'
    moving = tube.replace("[0, 0]", '[0, "0.1*t"]')
    force = 'of = "force"\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1'
    no_area = "a group on the axis, which is inside the body and has no area; choose another group"
    ratio, series = "viscosity = { bulk = 2.16666667e4, shear = 1e4 }", "prony = [{ g = 0.3, k = 0.3, time = 1e-4 }]"
    elsewhere = "Choose another unknown, or use a mesh in space"

    def per_metre(folder: Path) -> None:
        write(folder / "force.csv", "time,value [N/m]\n0,0\n1e-4,1\n")

    def on_axis(name: str, old: str, new: str, key: str, **more: object) -> Case:
        return round_body(f"{name} on the axis", old, new, f'{key}: found "axis", {no_area}', at="", **more)

    return [
        model("model that is none", "axisymetric", 'mesh.model: found "axisymetric"', 'did you mean "axisymmetric"?',
              "choices: plane-strain, plane-stress, axisymmetric", at="model ="),
        model("model as other programs spell it", "plane_stress", 'mesh.model: found "plane_stress"', 'did you mean "plane-stress"?', at="model ="),
        Case("plane stress as a flag", ("mesh.plane_stress: unknown; give the model of a body in the plane as mesh.model",),
             never=("not in this model",), edits=((MESH, f"{MESH}\nplane_stress = true"),), at="plane_stress ="),
        Case("thickness of a plate", ("material.thickness: unknown; forces of a body in the plane are per metre of thickness",
                                      'mesh.model = "plane-stress"'),
             edits=((VISCOSITY, f"{VISCOSITY}\nthickness = 0.01"),), at="thickness ="),
        Case("model in space", ('mesh.model: found "plane-strain" with a mesh in space', "remove it"), mesh=cube2(), mesh_file="cube.msh",
             edits=(*TO_SPACE, ('file = "cube.msh"', 'file = "cube.msh"\nmodel = "plane-strain"'))),
        Case("model in space, two ranks", ('mesh.model: found "axisymmetric" with a mesh in space',), mesh=cube2(), mesh_file="cube.msh", ranks=2,
             edits=(*TO_SPACE[:1], ('file = "cube.msh"', 'file = "cube.msh"\nmodel = "axisymmetric"'))),
        *(model(f"negative radius{also}", "axisymmetric", 'mesh.model: found "axisymmetric" with a node at x = -0.5 m; x is the radius',
                "Move the body to x >= 0", mesh=None, **more) for also, more in (("", {}), (", two ranks", {"ranks": 2}))),
        round_body("tilted plane in axial symmetry", "normal = [0, 1] }", "normal = [0.3, 1] }",
                   "contact.obstacle.normal: found 0.3 for x, the radius", "is [0, 1] or [0, -1]", "use a cylinder", at="obstacle ="),
        round_body("ball beside the axis", f"obstacle = {OBSTACLE}", f"obstacle = {ball.replace('[0,', '[0.2,')}",
                   'contact.obstacle.center: found "0.2" for x, the radius; expected 0, since in axial symmetry', 'shape = "signed-distance"'),
        round_body("ball that leaves the axis", f"obstacle = {OBSTACLE}", f"obstacle = {ball.replace('[0, -1]', '[' + chr(34) + 't' + chr(34) + ', -1]')}",
                   'contact.obstacle.center: found "t" for x, the radius; expected 0'),
        round_body("tube beside the axis", f"obstacle = {OBSTACLE}", f"obstacle = {tube.replace('[0, 0]', '[0.2, 0]')}",
                   'contact.obstacle.point: found "0.2" for x, the radius; expected 0, since in axial symmetry'),
        round_body("tube that moves along the axis", f"obstacle = {OBSTACLE}", f"obstacle = {moving}",
                   "contact.obstacle.point: depends on t; in axial symmetry a cylinder is a tube around the axis"),
        round_body("tube with an axis", f"obstacle = {OBSTACLE}", f"obstacle = {tube.replace(' }', ', axis = [0, 1] }')}",
                   "contact.obstacle.axis: has no effect in axial symmetry, where a cylinder is around the axis y; remove it"),
        round_body("gravity across the axis", 'body = ["0", "-9.81"]', "gravity = [1, -9.81]",
                   'load.gravity: found "1" for x, the radius; expected 0, since in axial symmetry gravity acts along the axis y'),
        *(round_body(f"clamp that moves the axis radially{also}", 'on = "top"', 'on = "top"\nvalue = ["0.1*t", "0"]',
                     'value: found "0.1*t" for x of the node at (0, 1, 0)', "the node is on the axis, where the radial displacement is 0",
                     "End the group before the axis", at="", **more) for also, more in (("", {}), (", two ranks", {"ranks": 2}))),
        round_body("velocity across the axis", 'velocity = ["0", "0"]', 'velocity = ["1", "0"]', "initial.velocity: found values that differ by 1",
                   at=""),
        on_axis("contact", 'on = "bottom"', 'on = "axis"', "contact.on"),
        on_axis("control", "scale = 1e6", 'scale = 1e6\non = "axis"', "control.on"),
        on_axis("objective", "alpha = 1e-2", 'alpha = 1e-2\non = "axis"', "objective.on", verb="optimize"),
        on_axis("springs", "[initial]", '[[foundation]]\non = "axis"\nstiffness = { normal = 1 }\n\n[initial]', "foundation[0].on"),
        on_axis("springs on two ranks", "[initial]", '[[foundation]]\non = "axis"\nstiffness = { normal = 1 }\n\n[initial]', "foundation[0].on",
                ranks=2),
        on_axis("traction", "[initial]", '[[load.traction]]\non = "axis"\nvalue = ["0", "1"]\n\n[initial]', "load.traction[0].on"),
        on_axis("probe", "every = 1", 'every = 1\n\n[[output.probe]]\non = "axis"', "output.probe[0].on"),
        *(round_body(f"radial force at a point of the axis{also}", "[initial]", '[[load.point]]\nat = [0, 0.5]\nvalue = [1, 0]\n\n[initial]',
                     'load.point[0].value: found "1" for x, the radius, at a node on the axis; expected 0', at="", **more)
          for also, more in (("", {}), (", two ranks", {"ranks": 2}))),
        fit("tilt of a plane around an axis", "axisymmetric", 'of = "angle"', force,
            'unknown[0].of: found "angle"; in axial symmetry an obstacle cannot be tilted, so choose another unknown'),
        fit("centre across the axis", "axisymmetric", 'of = "center"\ncomponent = "x"', force,
            "unknown[0].component: found x, the radius; in axial symmetry a centre is on the axis", obstacle=ball),
        *(fit(f"radial {of}", "axisymmetric", f'of = "{of}"\ncomponent = "x"', force,
              "unknown[0].component: found x, the radius") for of in ("initial.velocity", "initial.displacement")),
        fit("centre of a tube", "axisymmetric", 'of = "center"\ncomponent = "y"', force,
            'unknown[0].of: found "center" of a cylinder; in axial symmetry it is a tube around the axis', obstacle=tube),
        fit("force per metre of a whole body", "axisymmetric", 'of = "young"', force, "measurement[0].file: ", '"value [N/m]"',
            "cannot be converted to N", verb="optimize", prepare=per_metre),
        fit("displacement of the axis", "axisymmetric", 'of = "young"', force.replace("force", "displacement", 1) + '\non = "axis"',
            f'measurement[0].on: found "axis", {no_area}', verb="simulate", options=("--measure",)),
        *(fit(f"radial {of}", "axisymmetric", 'of = "young"', force.replace("force", of, 1).replace('"y"', '"x"'),
              f'measurement[0].component: found x, the radius, along which the {of} around an axis has no resultant; use "y"')
          for of in ("force", "impulse")),
        plate("viscosity that thickens a plate", "viscosity = { bulk = 2e4, shear = 1e4 }", "material.viscosity: found bulk/shear = 2;",
              "in plane stress it must be the elastic K/G = 2.1666667", "For another ratio use a mesh in space"),
        plate("bulk viscosity alone in a plate", "viscosity = { bulk = 2e4, shear = 0 }", "material.viscosity: found bulk/shear = inf;"),
        plate("shear that relaxes in a plate", "prony = [{ g = 0.2, k = 0.2, time = 1e-4 }, { g = 0.3, k = 0.1, time = 1e-3 }]",
              "material.prony: found g = 0.3 and k = 0.1 in prony[1]; in plane stress they must be equal",
              "For other fractions use a mesh in space"),
        plate("shear that relaxes in a plate, two ranks", "prony = [{ g = 0.3, time = 1e-3 }]", "material.prony: found g = 0.3 and k = 0 in prony[0]",
              ranks=2),
        *(fit(f"{of} of a plate", "plane-stress", f'of = "{of}"', force, f'unknown[0].of: found "{of}"; in plane stress', elsewhere, viscosity=own)
          for of, own in (("bulk", ratio), ("shear", ratio), ("poisson", ratio), ("prony.g", series), ("prony.k", series))),
        fit("poisson of a plate that relaxes", "plane-stress", 'of = "poisson"', force, 'unknown[0].of: found "poisson"; in plane stress', elsewhere,
            viscosity=series),
    ]
