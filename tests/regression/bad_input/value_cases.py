# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad values: numbers out of range, vectors of the wrong dimension, probes of nothing."""

from case import Case, edited, Expected, GEO, overridden, SPACE_GEO


def range_cases() -> list[Case]:
    """Numbers that are not allowed."""
    bounds = "lower = -2.0\nupper = 2.0"
    return [
        edited("step of zero", "step = 5e-5", "step = 0", "time.step: found 0", "greater than 0", "s)"),
        edited("negative step", "step = 5e-5", "step = -5e-5", "time.step: found -5e-05", "greater than 0"),
        edited("step beyond the end", "step = 5e-5", "step = 1e-3", "time.step: found", "0.001 s", "choose a length that gives 1 to"),
        edited("end between two steps", "end = 1.5e-4", "end = 1.6e-4", "time.end: found 0.00016 s, which is 3.2 steps of 5e-05 s; "
               "choose a whole multiple of time.step, such as 0.00015 s"),
        edited("too many steps", "step = 5e-5", "step = 1e-14", "time.step: found", "1e-14 s", "choose a length that gives 1 to"),
        edited("a word for a step", "step = 5e-5", 'step = "automatic"', "time.step: found", "automatic", "auto"),
        edited("tolerance of equal steps", "step = 5e-5", "tolerance = 1e-2\nstep = 5e-5", "time.tolerance: ", "has no effect", "auto"),
        edited("tolerance of nothing", "step = 5e-5", 'tolerance = 0\nstep = "auto"', "time.tolerance: found 0", "at least"),
        edited("an unknown quantity", "step = 5e-5", 'quantity = "stress"\nstep = "auto"', "time.quantity: found", "contact-force"),
        edited("longest beyond the end", "step = 5e-5", 'longest = 1.0\nstep = "auto"', "time.longest: found 1 s", "time.end"),
        edited("shortest beyond the longest", "step = 5e-5", 'shortest = 1e-4\nlongest = 5e-5\nstep = "auto"',
               "time.shortest: found 0.0001 s", "time.longest"),
        edited("no part of the time", "scale = 1e6", "step = 4e-5\nscale = 1e6", "control.step: found 4e-05 s", "divides time.end"),
        edited("incompressible", "poisson = 0.3", "poisson = 0.5", "material.poisson: found 0.5", "less than 0.5",
               earlier=True),
        edited("negative density", "density = 1.0", "density = -1.0", "material.density: found -1.0", "greater than 0",
               "kg/m³"),
        edited("no stiffness", "young = 1e8", "young = 0.0", "material.young: found 0.0", "greater than 0", "Pa"),
        edited("infinite stiffness", "young = 1e8", "young = inf", "material.young: found inf", "a number"),
        edited("stiffness that is no number", "young = 1e8", "young = nan", "material.young: found nan", "a number"),
        edited("negative viscosity", "bulk = 1e4", "bulk = -1e4", "material.viscosity.bulk: found -1", "at least 0",
               at="viscosity ="),
        edited("negative shear viscosity", "shear = 1e4", "shear = -1e4", "material.viscosity.shear: found -1", "at least 0",
               "Pa s", at="viscosity ="),
        edited("degree 3", "[time]", "degree = 3\n[time]", "mesh.degree: found 3", "from 1 to 2"),
        edited("degree 0", "[time]", "degree = 0\n[time]", "mesh.degree: found 0", "from 1 to 2"),
        Case("size of zero", ("mesh.size: found 0", "greater than 0", "m)"), mesh=GEO, mesh_file="square.geo",
             edits=(('file = "square.msh"', 'file = "square.geo"\nsize = 0'),), at="size = 0"),
        Case("unknown unit", ('mesh.unit: found "millimetre"', "m, cm, mm, um, in"), edits=(
            ('file = "square.msh"', 'file = "square.msh"\nunit = "millimetre"'),), at="unit ="),
        *(Case(f"size for more elements than can be, {what}", ("mesh.size: found 1e-05 m", "cells for a body of 1 m", "mesh.unit"), **more,
               edits=(*edits, ('.msh"', '.geo"\nsize = 1e-5'))) for what, edits, more in (  # type: ignore[arg-type]
            ("plane", (), {"mesh": GEO, "mesh_file": "square.geo"}),
            ("space", (('file = "square.msh"', 'file = "cube.msh"'),),
             {"mesh": SPACE_GEO + 'Physical Volume("body") = {1};\n', "mesh_file": "cube.geo"}),
            ("two ranks", (), {"mesh": GEO, "mesh_file": "square.geo", "ranks": 2}))),
        Case("scale of zero", ("mesh.scale: found 0", "greater than 0"), mesh=GEO, mesh_file="square.geo",
             edits=(('file = "square.msh"', 'file = "square.geo"\nscale = 0'),), at="scale = 0"),
        Case("scale beside a size", ("mesh.scale: ", "beside mesh.size"), mesh=GEO, mesh_file="square.geo",
             edits=(('file = "square.msh"', 'file = "square.geo"\nsize = 1\nscale = 2'),), at="scale = 2"),
        edited("exact displacement of three components", "[output]", '[exact]\ndisplacement = ["0", "0", "0"]\n[output]',
               "exact.displacement: found 3 components", "expected 2", at=""),
        edited("exact pressure over time", "[output]", '[exact]\npressure = "t"\n[output]', "exact.pressure: ", '"t"', "variables x, y, z",
               never=("x, y, z, t",), at="pressure ="),
        *(edited(f"exact {name} of zero", "[output]", f"[exact]\n{name} = 0\n[output]", f"exact.{name}: found 0", "greater than 0",
                 at=f"{name} =") for name in ("impulse", "peak_force", "contact_start", "contact_time")),
        edited("negative iterations", "max_iterations = 1", "max_iterations = -1", "optimizer.max_iterations: found -1",
               "from 0 to"),
        edited("negative checkpoints", "max_iterations = 1", "max_iterations = 1\ncheckpoint = -1", "optimizer.checkpoint: found -1",
               at="checkpoint ="),
        overridden("search without room", "optimizer.memory=100", "optimizer.memory: found 100 bytes", "16 controls in single",
                   verb="optimize"),
        edited("negative memory of a search", "max_iterations = 1", "max_iterations = 1\nmemory = -1.0", "optimizer.memory: found -1",
               "bytes", at="memory ="),
        edited("tolerance of 2", "tolerance = 1e-6", "tolerance = 2", "optimizer.tolerance: found 2", "at most 1"),
        edited("every 0", "every = 1", "every = 0", "output.every: found 0", "from 1 to"),
        edited("every beyond an integer", "every = 1", "every = 99999999999", "output.every: found 99999999999",
               "from 1 to"),
        edited("misspelt field", "every = 1", 'every = 1\nfields = ["displacment"]', "output.fields: found", "displacment",
               'did you mean "displacement"?', "displacement, velocity, control, adjoint, strain, stress, von_mises, pressure",
               at="fields ="),
        edited("field that is no list", "every = 1", 'every = 1\nfields = "velocity"', "output.fields: found", "velocity",
               "a list", "[] for none", at="fields ="),
        edited("field that is a number", "every = 1", "every = 1\nfields = [1]", "output.fields: found 1", "choices: ",
               at="fields ="),
        Case("pressure without contact", ('output.fields: found "pressure"', "without contact", "[contact]"), edits=(
            ('[contact]\non = "bottom"\nobstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }\n', ""),
            ("every = 1", 'every = 1\nfields = ["stress", "pressure"]')), at="fields ="),
        edited("unknown format of output", "every = 1", 'every = 1\nformat = ["vtk"]', "output.format: found", "vtk", "xdmf, vtkhdf", at="format ="),
        edited("no format of output", "every = 1", "every = 1\nformat = []", "output.format: found []", "expected at least one format",
               at="format ="),
        edited("unknown table of output", "every = 1", 'every = 1\ntables = ["steps", "energies"]', "output.tables: found",
               "energies", "steps, contact, obstacles, bodies, probes, history", at="tables ="),
        edited("control scale of zero", "scale = 1e6", "scale = 0", "control.scale: found 0", "greater than 0"),
        edited("negative alpha", "alpha = 1e-2", "alpha = -1e-2", "objective.alpha: found -0.01", "at least 0"),
        edited("negative gamma", "gamma = 7.5e-4", "gamma = -7.5e-4", "objective.gamma: found -0.00075", "at least 0"),
        edited("upper bound that is no number", "upper = 2.0", "upper = [2.0, nan]", "control.upper: found nan", "that is finite"),
        edited("lower above upper", bounds, "lower = 3.0\nupper = 2.0", "control.lower: found 3", "control.upper = 2", "reduce it"),
        edited("lower above upper in one component", bounds, "lower = [0, 3]\nupper = 2.0", "control.lower: found 3",
               "control.upper = 2"),
        edited("infinite bound", bounds, "lower = -inf\nupper = 2.0", "control.lower: found -inf", "a number", "that is finite"),
    ]


def dimension_cases() -> list[Case]:
    """Vectors that do not fit a plane mesh, and a plane without a normal."""
    found = ("found 3 components", "2", "2-dimensional")
    obstacle = "point = [0, -0.1], normal = [0, 1]"
    return [
        edited("bound of one component", "lower = -2.0", "lower = [-2.0]", "control.lower: found", "[-2.0]", "expected"),
        edited("bound of three components", "lower = -2.0", "lower = [-2, -2, -2]", "control.lower", *found, at=""),
        edited("upper bound of three components", "upper = 2.0", "upper = [2, 2, 2]", "control.upper: ", *found, at=""),
        edited("desired displacement of three components", 'control = ["0", "-1"]', 'displacement = ["0", "-t", "0"]',
               "objective.desired.displacement: ", *found, at="", verb="check"),
        edited("desired displacement that cannot be read", 'control = ["0", "-1"]', 'displacement = ["0", "-t*"]',
               "objective.desired.displacement: ", '"-t*"', "x, y, z, t", at="desired ="),
        edited("bounds of two and three components", "lower = -2.0\nupper = 2.0",
               "lower = [-2, -2]\nupper = [2, 2, 2]", "control.upper: found 3 components", "give as many", at="upper ="),
        edited("body load of three components", '["0", "-9.81"]', '["0", "0", "-9.81"]', "load.body", *found, at=""),
        edited("body load of three components, two ranks", '["0", "-9.81"]', '["0", "0", "-9.81"]', "load.body", *found,
               at="", ranks=2),
        edited("velocity of three components", 'velocity = ["0", "0"]', 'velocity = ["0", "0", "0"]',
               "initial.velocity", *found, at=""),
        edited("displacement of three components", 'displacement = ["0", "0"]', 'displacement = ["0", "0", "0"]',
               "initial.displacement", *found, at=""),
        edited("desired control of three components", 'control = ["0", "-1"]', 'control = ["0", "-1", "0"]',
               "objective.desired.control", *found, at="", verb="optimize", earlier=True),
        edited("obstacle in space", obstacle, "point = [0, 0, -1], normal = [0, 0, 1]", "contact.obstacle.point",
               *found, at=""),
        edited("point in space", obstacle, "point = [0, 0, -1], normal = [0, 1]", "contact.obstacle.point: ", *found, at=""),
        edited("normal in space", obstacle, "point = [0, -1], normal = [0, 0, 1]", "contact.obstacle.normal: ", *found, at=""),
        edited("gravity in space", 'body = ["0", "-9.81"]', "gravity = [0, 0, -9.81]", "load.gravity: ", *found, at=""),
        edited("expressions of four components", '["0", "-9.81"]', '["0", "0", "0", "0"]', "load.body: found",
               "one expression per space dimension", at="body ="),
        edited("normal of length zero", "normal = [0, 1]", "normal = [0, 0]", "contact.obstacle.normal: found",
               "length zero", at="obstacle ="),
        edited("unknown shape", '"half-space"', '"half-spcae"', 'contact.obstacle.shape: found "half-spcae"',
               'did you mean "half-space"?', at="obstacle ="),
        edited("shape of another kind", '"half-space"', '"sphere"', 'contact.obstacle.shape: found "sphere"',
               "choices: half-space, ball, cylinder, signed-distance", at="obstacle ="),
    ]


def probe_cases() -> list[Case]:
    """What is to be followed over time, and names that stand in tables."""

    def probe(name: str, keys: str, *expect: Expected, at: str = "[[output.probe]]", **more: object) -> Case:
        return edited(name, "every = 1", f"every = 1\n\n[[output.probe]]\n{keys}", *expect, at=at, **more)

    twice = 'name = "a"\nbody = true\n\n[[output.probe]]\npoint = [0, 0.5]\nname = "a" # again'
    obstacle = "obstacle = { shape"
    return [
        probe("probe of nothing", 'name = "a"', "output.probe[0]: found none of them", "point, on, obstacle, body"),
        probe("probe of two things", 'on = "top"\npoint = [0, 0.5]', "output.probe[0]: found point, on", "give one of"),
        probe("misspelt key of a probe", "pont = [0, 0.5]", "output.probe[0].pont: unknown", '"point"', at="pont ="),
        probe("probe with a comma in its name", 'name = "a, b"\nbody = true', "output.probe[0].name: found 'a, b'", "without commas",
              at="name ="),
        probe("probe with a name that another one has", twice, 'output.probe[1].name: found "a"', "which is the name of output.probe[0] too",
              at='name = "a" # again'),
        probe("probe at a point of three components", "point = [0, 0.5, 0]", "output.probe[0].point: found 3 components",
              "expected 2", at=""),
        probe("probe outside of the body", "point = [0, 3]", "output.probe[0].point: found (0, 3)", "2 m outside of the body", at="",
              verb="simulate"),
        probe("probe outside of the body, two ranks", "point = [0, 3]", "output.probe[0].point: found (0, 3)", at="", ranks=2),
        probe("probe of a group that is not there", 'on = "topp"', "output.probe[0].on: ", '"topp"', "top", at=""),
        probe("probe of an obstacle that is not there", 'obstacle = "obstacel 1"', 'output.probe[0].obstacle: found "obstacel 1"',
              'did you mean "obstacle 1"?', "choices: obstacle 1", at='obstacle = "'),
        probe("probe of no body", "body = false", "output.probe[0].body: found false", "set it to true", at="body = false"),
        probe("probe of a body that is a number", "body = 1", "output.probe[0].body: found 1; expected true or false", at="body = 1"),
        edited("obstacle with a quote in its name", obstacle, "obstacle = { name = 'a \"', shape", "contact.obstacle.name: found",
               "without commas and quotes", at="obstacle ="),
        edited("obstacle with an empty name", obstacle, 'obstacle = { name = "", shape', "contact.obstacle.name: found \"\"",
               "not empty", at="obstacle ="),
        Case("obstacles with the same name", ("contact[1].obstacle.name: found", "obstacle 2", "which is the name of contact[0] too"), edits=(
            ("[contact]", '[[contact]]\non = "bottom"\nobstacle = { name = "obstacle 2", shape = "half-space", point = [0, -0.2], '
             "normal = [0, 1] }\n[[contact]]"),)),
    ]
