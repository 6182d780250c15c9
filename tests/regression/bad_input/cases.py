# SPDX-License-Identifier: GPL-3.0-or-later
"""The bad inputs, theme by theme."""

import re
from collections.abc import Callable
from pathlib import Path

from case import (
    BODY, BOTTOM, Case, Expected, GEO, GROUPS, LINE, LINE_3, PRISM, QUADRILATERAL, SPACE_GEO, SPACE_GROUPS, TETRAHEDRON,
    TETRAHEDRON_10, TOP, TRIANGLE, TRIANGLE_6, before, cube2, cube_elements, cube_points, edited, keep_tables,
    meshed, moved, moved_corner, occupy, overridden, prepend, solid, square2, square4, square_elements,
    square_of_halves, square_points, stored_run, typed, with_element, with_space_element, write,
)

FIRST_TABLE = re.compile(r"\bmesh\b")


def scene_file_cases() -> list[Case]:
    """What is no scene."""
    unreadable = ("the scene file cannot be read", "give the path of a TOML file")
    return [
        typed("scene missing", "simulate nowhere.toml --out results", "nowhere.toml: ", *unreadable),
        typed("scene missing, two ranks", "simulate nowhere.toml --out results", "nowhere.toml: ", *unreadable, ranks=2),
        typed("scene missing, quiet", "optimize nowhere.toml --quiet", "nowhere.toml: ", *unreadable),
        typed("scene is a folder", "simulate .", *unreadable),
        Case("scene is empty", ("scene.toml", "mesh: missing"), scene=b"", earlier=True),
        Case("scene is prose", (re.compile(r"scene\.toml:1: not valid TOML: ."),), scene=b"Push the disc down.\n"),
        Case("scene is binary", (re.compile(r"scene\.toml:\d+: not valid TOML: ."),), scene=bytes(range(256)) * 8),
        edited("bracket left open", "[time]", "[time", "not valid TOML"),
        edited("text left open", 'file = "square.msh"', 'file = "square.msh', "not valid TOML"),
        edited("decimal comma", "poisson = 0.3", "poisson = 0,3", "not valid TOML"),
        edited("key twice", "step = 5e-5", "step = 5e-5\nstep = 1e-5", "not valid TOML", "step", at="step = 1e-5"),
        edited("table twice", "[output]", "[time]\n[output]", "not valid TOML", "time", at="[time]\n[output]"),
        edited("key without a value", "step = 5e-5", "step =", "not valid TOML"),
    ]


def key_cases() -> list[Case]:
    """Names that are not known, and names that are missing."""
    return [
        edited("unknown table", "[output]", "[gravity]\ng = 9.81\n[output]", "gravity: unknown", "contact, control",
               "optimizer, output, run"),
        edited("misspelt table", "[contact]", "[contcat]", "contcat: unknown", 'did you mean "contact"?', earlier=True),
        edited("misspelt required table", "[material]", "[matrial]", "matrial: unknown", 'did you mean "material"?'),
        edited("table in British spelling", "[optimizer]", "[optimiser]", "optimiser: unknown", 'mean "optimizer"?'),
        edited("misspelt list of tables", "[[clamp]]", "[[clamps]]", "clamps: unknown", 'did you mean "clamp"?'),
        edited("misspelt key", "gamma =", "gama =", "objective.gama: unknown", 'did you mean "gamma"?'),
        edited("key of two lines", "every = 1", '"eve\\nry" = 1', "output.eve ry: unknown", at='"eve'),
        edited("misspelt key, two ranks", "gamma =", "gama =", "objective.gama: unknown", 'mean "gamma"?', ranks=2),
        edited("misspelt required key", "density =", "densty =", "material.densty: unknown", 'mean "density"?'),
        edited("misspelt key of an inline table", "shear = 1e4", "sheer = 1e4", "material.viscosity.sheer: unknown",
               'did you mean "shear"?'),
        edited("key of another table", "every = 1", "every = 1\nalpha = 1.0", "output.alpha: unknown", "every",
               at="alpha = 1.0"),
        edited("friction wanted", "[contact]\n", "[contact]\nfriction = 0.3\n", "contact.friction: not in this model: friction;",
               "docs/modelling.md", at="friction = 0.3", never=("unknown", "allowed"), earlier=True),
        edited("large rotation wanted, two ranks", "[output]", "[kinematics]\nlarge = true\n[output]", "kinematics: not in this model: large rotations",
               at="[kinematics]", never=("unknown",), ranks=2),
        edited("second body wanted", "[contact]\n", '[contact]\nagainst = "top"\n', "contact.against: not in this model: contact between bodies",
               at="against =", never=("unknown",)),
        edited("table missing", "[time]\nend = 1.5e-4\nstep = 5e-5\n", "", "scene.toml", "time: missing",
               never=(re.compile(r"\.toml:\d"),)),
        edited("key missing", "young = 1e8\n", "", "material.young: missing", at="[material]"),
        edited("mesh.file missing beside a size", 'file = "square.msh"', "size = 4", "mesh.file: missing",
               never=("unknown",), at="[mesh]"),
    ]


def type_cases() -> list[Case]:
    """Values of the wrong type."""
    return [
        edited("text for a number", "young = 1e8", 'young = "1e8"', "material.young: found", "1e8", "a number"),
        edited("truth for a number", "young = 1e8", "young = true", "material.young: found true", "a number"),
        edited("list for a number", "young = 1e8", "young = [1e8, 1e8]", "material.young: found", "a number"),
        edited("number for a text", 'on = "bottom"', "on = 3", "contact.on: found 3", "a text"),
        edited("text that is empty", 'on = "bottom"', 'on = ""', "contact.on: found", "not empty"),
        edited("float for an integer", "max_iterations = 1", "max_iterations = 1.5",
               "optimizer.max_iterations: found 1.5", "a whole number"),
        edited("table for a list of tables", "[[clamp]]", "[clamp]", "clamp: found", "[[clamp]]"),
        edited("value for a list of tables", '[[clamp]]\non = "top"', "", "clamp: found", "top", "[[clamp]]",
               prepare=lambda folder: prepend(folder / "scene.toml", 'clamp = "top"\n'), never=(FIRST_TABLE,)),
        edited("list for a table", "[load]", "[[load]]", "load: found", "a table"),
        overridden("values for tables of contact", "contact=[1, 2]", "contact: found [1, 2]", "tables headed [[contact]]"),
        edited("value for a table", 'obstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }',
               'obstacle = "half-space"', "contact.obstacle: found", "half-space", "a table"),
        edited("table for a text", 'file = "square.msh"', '[mesh.file]\nname = "square"\nkind = "msh"',
               "mesh.file: found", "a text", at="[mesh.file]"),
        edited("text of several lines", 'on = "bottom"', 'on = """bot\ntom"""', "contact.on: ", "bot"),
        edited("choice of several lines", 'vi = "condensed"', 'vi = """con\ndensed"""', "solver.vi: found", "con densed", "one line"),
        edited("expression of several lines", '["0", "-9.81"]', '["0", """1 +\n+* 2"""]', "load.body: found", "1 + +* 2",
               at="body ="),
        edited("truth for an expression", 'body = ["0", "-9.81"]', 'body = [true, "0"]', "load.body: found true",
               "expression"),
        edited("one expression for a list", 'body = ["0", "-9.81"]', 'body = "-9.81"', "load.body: found", '["0", "-9.81"] in the plane',
               "an array of one expression per space dimension"),
        edited("one velocity for a list", 'velocity = ["0", "0"]', "velocity = -3", "initial.velocity: found -3", '["0", -3] in the plane',
               never=("9.81",)),
        edited("control that changes too fast", "scale = 1e6", 'scale = 1e6\ninitial = ["sin(1e12*t)", "0"]', "control.initial: the expression changes too fast to be integrated",
               "use a slower one or a time series", at=""),
        edited("one expression for a control", "scale = 1e6", 'scale = 1e6\ninitial = "sin(t)"', "control.initial: found",
               '["0", "0", "sin(t)"] in space', never=("9.81",), at="initial ="),
        edited("table for a list", 'velocity = ["0", "0"]', "velocity = { x = 1 }", "initial.velocity: found", "2 in the plane and 3 in space",
               never=("9.81",)),
        edited("text for a bound", "lower = -2.0", 'lower = "-2"', "control.lower: found", "-2", "a number"),
    ]


def range_cases() -> list[Case]:
    """Numbers that are not allowed."""
    bounds = "lower = -2.0\nupper = 2.0"
    return [
        edited("step of zero", "step = 5e-5", "step = 0", "time.step: found 0", "greater than 0", "s)"),
        edited("negative step", "step = 5e-5", "step = -5e-5", "time.step: found -5e-05", "greater than 0"),
        edited("step beyond the end", "step = 5e-5", "step = 1e-3", "time.step: found", "0.001 s", "choose 1 to"),
        edited("end between two steps", "end = 1.5e-4", "end = 1.6e-4", "time.end: found 0.00016 s, which is 3.2 steps of 5e-05 s; "
               "choose a whole multiple of time.step, such as 0.00015 s"),
        edited("too many steps", "step = 5e-5", "step = 1e-14", "time.step: found", "1e-14 s", "choose 1 to"),
        edited("a word for a step", "step = 5e-5", 'step = "automatic"', "time.step: found", "automatic", "auto"),
        edited("tolerance of equal steps", "step = 5e-5", "tolerance = 1e-2\nstep = 5e-5", "time.tolerance: ", "has no effect", "auto"),
        edited("tolerance of nothing", "step = 5e-5", 'tolerance = 0\nstep = "auto"', "time.tolerance: found 0", "at least"),
        edited("an unknown quantity", "step = 5e-5", 'quantity = "stress"\nstep = "auto"', "time.quantity: found", "contact-force"),
        edited("longest beyond the end", "step = 5e-5", 'longest = 1.0\nstep = "auto"', "time.longest: found 1 s", "time.end"),
        edited("shortest beyond the longest", "step = 5e-5", 'shortest = 1e-4\nlongest = 5e-5\nstep = "auto"',
               "time.shortest: found 0.0001 s", "time.longest"),
        edited("no part of the time", "scale = 1e6", "step = 4e-5\nscale = 1e6", "control.step: found 4e-05 s", "whole"),
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
        *(Case(f"size for more elements than can be, {what}", ("mesh.size: found 1e-05 m", "cells of a body of 1 m", "mesh.unit"), **more,
               edits=(*edits, ('.msh"', '.geo"\nsize = 1e-5'))) for what, edits, more in (  # type: ignore[arg-type]
            ("plane", (), {"mesh": GEO, "mesh_file": "square.geo"}),
            ("space", (('file = "square.msh"', 'file = "cube.msh"'),), {"mesh": SPACE_GEO + 'Physical Volume("body") = {1};\n', "mesh_file": "cube.geo"}),
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
        overridden("search without room", "optimizer.memory=100", "optimizer.memory: found 100 bytes", "16 controls in single", verb="optimize"),
        edited("negative memory of a search", "max_iterations = 1", "max_iterations = 1\nmemory = -1.0", "optimizer.memory: found -1",
               "bytes", at="memory ="),
        edited("tolerance of 2", "tolerance = 1e-6", "tolerance = 2", "optimizer.tolerance: found 2", "at most 1"),
        edited("every 0", "every = 1", "every = 0", "output.every: found 0", "from 1 to"),
        edited("every beyond an integer", "every = 1", "every = 99999999999", "output.every: found 99999999999",
               "from 1 to"),
        edited("misspelt field", "every = 1", 'every = 1\nfields = ["displacment"]', "output.fields: found", "displacment",
               'did you mean "displacement"?', "displacement, velocity, control, adjoint, strain, stress, von_mises, pressure", at="fields ="),
        edited("field that is no list", "every = 1", 'every = 1\nfields = "velocity"', "output.fields: found", "velocity",
               "a list", "[] for none", at="fields ="),
        edited("field that is a number", "every = 1", "every = 1\nfields = [1]", "output.fields: found 1", "choices: ",
               at="fields ="),
        Case("pressure without contact", ('output.fields: found "pressure"', "without contact", "[contact]"), edits=(
            ('[contact]\non = "bottom"\nobstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }\n', ""),
            ("every = 1", 'every = 1\nfields = ["stress", "pressure"]')), at="fields ="),
        edited("unknown table of output", "every = 1", 'every = 1\ntables = ["steps", "energies"]', "output.tables: found",
               "energies", "steps, contact, obstacles, probes, history", at="tables ="),
        *probe_cases(),
        *fit_cases(),
        edited("scale of zero", "scale = 1e6", "scale = 0", "control.scale: found 0", "greater than 0"),
        edited("negative alpha", "alpha = 1e-2", "alpha = -1e-2", "objective.alpha: found -0.01", "at least 0"),
        edited("negative gamma", "gamma = 7.5e-4", "gamma = -7.5e-4", "objective.gamma: found -0.00075", "at least 0"),
        edited("upper bound that is no number", "upper = 2.0", "upper = [2.0, nan]", "control.upper: found nan", "that is finite"),
        edited("lower above upper", bounds, "lower = 3.0\nupper = 2.0", "control.lower: found 3", "control.upper = 2", "lower it"),
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


def obstacle_cases() -> list[Case]:
    """Obstacles that are none, and contact with them that cannot begin."""
    plane = '{ shape = "half-space", point = [0, -0.1], normal = [0, 1] }'
    second = f'obstacle = {plane}\n\n[[contact]]\non = "side"\nobstacle = '

    def shaped(name: str, obstacle: str, *expect: object, **more: object) -> Case:
        more.setdefault("at", "obstacle =")
        return edited(name, plane, obstacle, *expect, **more)  # type: ignore[arg-type]

    def two(name: str, obstacle: str, *expect: object, more: tuple[tuple[str, str], ...] = (), **other: object) -> Case:
        return Case(name, expect, edits=(("[contact]", "[[contact]]"), (f"obstacle = {plane}", second + obstacle), *more),
                    **other)  # type: ignore[arg-type]

    ball = '{ shape = "ball", center = [0, -1], radius = 0.5 }'
    return [
        shaped("point of an expression of place", plane.replace("-0.1", '"-0.1 + x"'), "contact.obstacle.point: found",
               "-0.1 + x", "expressions of t alone"),
        shaped("point of an expression that cannot be read", plane.replace("-0.1", '"2*t +"'), "contact.obstacle.point: ",
               '"2*t +"'),
        shaped("point that leaves the finite", plane.replace("-0.1", '"-0.1/(1 - t/5e-5)"'), "contact.obstacle.point: ",
               "t = 5e-05", "finite", at=""),
        shaped("point that leaves the finite, two ranks", plane.replace("-0.1", '"-0.1/(1 - t/5e-5)"'),
               "contact.obstacle.point: ", "finite", at="", ranks=2),
        shaped("truth for a point", plane.replace("-0.1", "true"), "contact.obstacle.point: found true"),
        shaped("ball without a center", '{ shape = "ball", radius = 0.5 }', "contact.obstacle.center: missing"),
        shaped("ball by a point", ball.replace("center", "point"), "contact.obstacle.center: missing"),
        shaped("ball of radius zero", ball.replace("0.5", "0"), "contact.obstacle.radius: found 0", "greater than 0", "m)"),
        shaped("truth for a radius", ball.replace("0.5", "true"), "contact.obstacle.radius: found", "a number"),
        shaped("radius of an expression that cannot be read", ball.replace("0.5", '"0.5 +"'), "contact.obstacle.radius: ", '"0.5 +"'),
        shaped("radius of an expression of place", ball.replace("0.5", '"0.5 + x"'), "contact.obstacle.radius: found 0.5 + x",
               "expressions of t alone"),
        shaped("center of an expression of place", ball.replace("-1", '"y - 1"'), "contact.obstacle.center: found 0, y - 1",
               "expressions of t alone"),
        shaped("radius that vanishes", ball.replace("0.5", '"0.5 - t/2e-4"'), "contact.obstacle.radius: found 0 m at t = 0.0001 s; "
               "a radius must stay above 0", at="", ranks=2),
        shaped("center that leaves the finite", ball.replace("-1", '"-1 - 1/(1e-4 - t)"'), "contact.obstacle.center: ",
               "t = 0.0001", "finite", at=""),
        shaped("unknown side", ball.replace(" }", ', side = "within" }'), 'contact.obstacle.side: found "within"',
               "outside, inside"),
        shaped("ball with a normal", ball.replace(" }", ", normal = [0, 1] }"), "contact.obstacle.normal: unknown key"),
        shaped("ball in space", ball.replace("[0, -1]", "[0, 0, -1]"), "contact.obstacle.center: found 3 components",
               "2-dimensional", at=""),
        shaped("ball around a node", ball.replace("[0, -1]", "[0, 0]"), "contact.obstacle: ", "the node at (0, 0, 0) is at the centre or on the axis, where no direction leads out; move the body or the obstacle", at=""),
        shaped("ball around a node, two ranks", ball.replace("[0, -1]", "[0, 0]"), "contact.obstacle: ", "(0, 0, 0)", at="",
               ranks=2),
        shaped("body inside a ball", ball.replace("[0, -1]", "[0, -0.4]"), "contact: the node at (0, 0, 0)",
               "0.1 m inside the obstacle", at=""),
        shaped("body outside a ball that holds it", ball.replace(" }", ', side = "inside" }').replace("0.5", "1"),
               "contact: the node at", "inside the obstacle", "start outside", at=""),
        shaped("cylinder in space without an axis", '{ shape = "cylinder", point = [0, 0, 0], radius = 1 }',
               "contact.obstacle.axis: missing"),
        shaped("cylinder with an axis of length zero", '{ shape = "cylinder", point = [0, 0, 0], axis = [0, 0, 0], radius = 1 }',
               "contact.obstacle.axis: found", "length zero"),
        shaped("cylinder with a plane axis", '{ shape = "cylinder", point = [0, 0, 0], axis = [0, 1], radius = 1 }',
               "contact.obstacle.axis: found 2 components", "point has 3", "give as many"),
        shaped("disc with an axis", '{ shape = "cylinder", point = [0, -2], axis = [0, 1], radius = 1 }',
               "contact.obstacle.axis: ", "in the plane", "disc"),
        shaped("cylinder of a negative radius", '{ shape = "cylinder", point = [0, -2], radius = -1 }',
               "contact.obstacle.radius: found -1", "greater than 0"),
        shaped("cylinder in space for a plane body", '{ shape = "cylinder", point = [0, 0, 0], axis = [0, 1, 0], radius = 1 }',
               "contact.obstacle.point: found 3 components", "2-dimensional", at=""),
        shaped("distance that cannot be read", '{ shape = "signed-distance", distance = "y +" }',
               "contact.obstacle.distance: ", '"y +"', "x, y, z"),
        shaped("distance that loses its slope", '{ shape = "signed-distance", distance = "t > 9e-5 ? 1 : y + 1" }',
               "contact.obstacle.distance: ", "no slope", "t = 0.0001 s", at=""),
        shaped("list for a distance", '{ shape = "signed-distance", distance = ["y", "y"] }',
               "contact.obstacle.distance: found", "a text"),
        shaped("distance without a slope", '{ shape = "signed-distance", distance = "1" }', "contact.obstacle.distance: ",
               "no slope", "node at (-0.5, 0, 0)", at=""),
        shaped("distance that is not finite", '{ shape = "signed-distance", distance = "log(y)" }',
               "contact.obstacle.distance: ", '"log(y)"', "y = 0", "finite", at=""),
        shaped("distance that is not finite beside a node", '{ shape = "signed-distance", distance = "sqrt(y)" }',
               "contact.obstacle.distance: ", "around the node at (-0.5, 0, 0)", at="", ranks=2),
        edited("unknown way to begin", "[load]", 'initial = "inside"\n[load]', 'contact.initial: found "inside"',
               "outside, project", at="initial ="),
        two("misspelt group of the second contact", plane, "contact[1].on: ", '"sid"', 'did you mean "side"?',
            more=(('on = "side"', 'on = "sid"'),)),
        two("second contact with a wrong radius", ball.replace("0.5", "-1"), "contact[1].obstacle.radius: found -1"),
        two("second obstacle in space", ball.replace("[0, -1]", "[0, 0, -1]"), "contact[1].obstacle.center: found 3"),
        two("body inside the second obstacle", ball.replace("[0, -1]", "[0.9, 0.5]"), "contact[1]: the node at (0.5, 0.5, 0)",
            "inside the obstacle"),
        two("second contact's nodes all clamped", plane, "contact[1].on: ", '"top"', "clamped",
            more=(('on = "side"', 'on = "top"'),)),
        two("obstacles without room between them", '{ shape = "half-space", point = [0.5, -0.2], normal = [0, -1] }', "no room",
            "(-0.5, 0, 0)", "t = 0 s"),
        two("obstacles without room between them after a while",
            '{ shape = "half-space", point = ["0", "0.5 - 1e4*t"], normal = [0, -1] }', "no room", "t = 0.0001 s",
            more=(('on = "side"', 'on = "bottom"'),), ranks=2),
        two("several obstacles for the full VI", ball, "solver.vi: ", "2 obstacles", "(-0.5, 0, 0)", "condensed",
            options=("--set", "solver.vi=full")),
    ]


def expression_cases() -> list[Case]:
    """Expressions that cannot be read, or have no finite value."""
    body, start = 'body = ["0", "-9.81"]', 'displacement = ["0", "0"]'
    return [
        edited("syntax error", body, 'body = ["0", "3 + * x"]', "load.body: ", '"3 + * x"', "at position 4",
               "variables x, y, z, t"),
        edited("bracket left open in an expression", body, 'body = ["0", "sin(x"]', "load.body: ", '"sin(x"',
               "position"),
        edited("expression that is empty", body, 'body = ["0", ""]', "load.body: ", '""', re.compile("empty|position")),
        edited("unknown variable", body, 'body = ["0", "9.81*mass"]', "load.body: ", '"mass"', "at position 5",
               "variables x, y, z, t"),
        edited("unknown function", body, 'body = ["0", "sine(t)"]', "load.body: ", "sine", "position 0"),
        edited("decimal comma in an expression", body, 'body = ["0", "-9,81"]', "load.body: ", '"-9,81"'),
        edited("assignment in an expression", body, 'body = ["0", "x = 1"]', "load.body: ", '"x = 1"'),
        edited("time in an initial value", start, 'displacement = ["0", "t"]', "initial.displacement: ", '"t"',
               "variables x, y, z", never=("x, y, z, t",)),
        edited("division by zero", body, 'body = ["0", "1/0"]', "load.body", '"1/0" is inf', "finite", at=""),
        edited("root of a negative number", body, 'body = ["sqrt(-1)", "0"]', "load.body", '"sqrt(-1)" is', "nan",
               at=""),
        edited("pole at a node", body, 'body = ["0", "1/x"]', "load.body", '"1/x" is inf', "x = 0", "finite", at="",
               earlier=True),
        edited("pole at a node, two ranks", body, 'body = ["0", "1/x"]', "load.body", '"1/x" is inf', "x = 0", at="",
               ranks=2, earlier=True),
        edited("pole at a later time", body, 'body = ["0", "1/(t - 1.25e-4)"]', "load.body", "is ", "t = 0.000125",
               "finite", at="", earlier=True),
        edited("infinite at a later time", body, 'body = ["0", "1/(t > 1e-4 ? 0 : 1)"]', "load.body", "is inf",
               re.compile(r"t = 0\.00012\d*"), at="", earlier=True),
        edited("infinite at a later time, two ranks", body, 'body = ["0", "1/(t > 1e-4 ? 0 : 1)"]', "load.body",
               "is inf", re.compile(r"t = 0\.00012\d*"), at="", earlier=True, ranks=2),
        edited("infinite desired control", '["0", "-1"]', '["0", "1/(y - 0.5)"]', "objective.desired.control", "is inf",
               "y = 0.5", at="", verb="optimize", earlier=True),
        edited("gravity of an expression of place", body, 'gravity = ["0", "-9.81*x"]', "load.gravity: found 0, -9.81*x",
               "expressions of t alone", at="gravity ="),
        edited("gravity as a number", body, "gravity = 9.81", "load.gravity: found 9.81", '["0", 9.81]', at="gravity ="),
        edited("gravity that is not finite", body, 'gravity = ["0", "1/(t > 1e-4 ? 0 : 1)"]', "load.gravity: ", "is inf", at="",
               ranks=2),
        edited("initial displacement of a clamp", start, 'displacement = ["0", "1e-3"]', "initial.displacement",
               "found a difference of 0.001", "clamp", "make them equal", at="", earlier=True),
        edited("initial displacement of a clamp, two ranks", start, 'displacement = ["0", "1e-3"]',
               "initial.displacement", "found a difference of 0.001", "clamp", at="", ranks=2),
        edited("initial velocity of a clamp", 'velocity = ["0", "0"]', 'velocity = ["0", "-10"]', "initial.velocity",
               "found a difference of 10", "clamp", "make them equal", at=""),
    ]


def time_series_cases() -> list[Case]:
    """Tables that give no quantity over the time of the run."""
    good = "time,force,late\n0,1,2\n1e-4,2,2\n2e-4,3,x\n"

    def wrong(name: str, *expect: Expected, column: str = "force", text: str | bytes = good, **other: object) -> Case:
        given = f'{{ file = "loads.csv", column = "{column}" }}'
        return Case(name, ("load.body: ", *expect), edits=(('"-9.81"', given),), at="body =",
                    prepare=lambda folder: write(folder / "loads.csv", text), **other)  # type: ignore[arg-type]

    def at(name: str, old: str, new: str, *expect: Expected, **other: object) -> Case:
        series = '{ file = "loads.csv", column = "force" }'
        return Case(name, expect, edits=((old, new.replace("SERIES", series)),), prepare=lambda folder: write(
            folder / "loads.csv", good), **other)  # type: ignore[arg-type]

    return [
        Case("series that is missing", ("load.body: ", "loads.csv: cannot be read"), edits=(
            ('"-9.81"', '{ file = "loads.csv", column = "force" }'),), at="body ="),
        Case("series that is missing, two ranks", ("load.body: ", "loads.csv: cannot be read"), edits=(
            ('"-9.81"', '{ file = "loads.csv", column = "force" }'),), at="body =", ranks=2),
        Case("series that never ends", ("load.body: ", "/dev/zero: cannot be read"), edits=(
            ('"-9.81"', '{ file = "/dev/zero", column = "force" }'),), at="body ="),
        wrong("misspelt column", 'no column "forces"', 'mean "force"?', "time, force, late", column="forces", earlier=True),
        wrong("misspelt column, two ranks", 'no column "forces"', column="forces", ranks=2),
        wrong("series with a text", "loads.csv: line 4: ", '"x" in column 3', "a number", column="late"),
        wrong("series of one time", "1 line of numbers", text="t,force\n0,1\n"),
        wrong("series that is empty", "loads.csv", "empty", text=""),
        wrong("series of bytes", "loads.csv: ", text=bytes(range(256)) * 4),
        wrong("series with times that go back", "line 4: ", "found the time 0.0001 s after 0.0002 s; times must ascend",
              text="t,force\n0,1\n2e-4,1\n1e-4,1\n"),
        wrong("series that ends early", "from 0 to 0.0001 s", "0 to 0.00015 s", text="t,force\n0,1\n1e-4,1\n"),
        wrong("series that starts late", "from 1e-05 to 1 s", text="t,force\n1e-5,1\n1,1\n"),
        wrong("series with decimal commas", '"2,5" in column 2', "decimal point", text="t;force\n0;1\n1;2,5\n"),
        wrong("series with decimal commas between commas", "line 3: found 4 cells below 2 names", "decimal point",
              text="time,force\n0,0\n1,0,-1,5\n"),
        wrong("series with decimal commas between commas, two ranks", "line 3: found 4 cells below 2 names",
              text="time,force\n0,0\n1,0,-1,5\n", ranks=2),
        wrong("series with thousands separators", 'line 3: found "-1,000" in column 2', text='time,force\n0,0\n1,"-1,000"\n'),
        wrong("series with a column twice", 'found "force" in column 2 and "force" in column 3', text="time,force,force\n0,0,1\n1,1,2\n"),
        wrong("series in the unit of another quantity", '"force [mm]"', "cannot be converted to N/m³", text="time,force [mm]\n0,0\n1,1\n"),
        wrong("series in an unknown unit", 'unknown unit in "force [mV]"', "N, Pa", text="time,force [mV]\n0,0\n1,1\n"),
        wrong("series whose times are no times", 'times in the unit of "time [mm]"', text="time [mm],force\n0,0\n1,1\n"),
        Case("series without a column", ("load.body.column: missing",), edits=(('"-9.81"', '{ file = "loads.csv" }'),),
             at="body ="),
        Case("series of a number", ("load.body.column: found 3", "a text"), edits=(
            ('"-9.81"', '{ file = "loads.csv", column = 3 }'),), at="body ="),
        Case("series with an unknown key", ("load.body.unit: unknown key", "column, file"), edits=(
            ('"-9.81"', '{ file = "loads.csv", column = "force", unit = "N" }'),), at="body ="),
        at("series in an initial value", 'velocity = ["0", "0"]', 'velocity = ["0", SERIES]', "initial.velocity: found",
           "place alone", at="velocity ="),
        at("series for a control constant in time", "scale = 1e6", "scale = 1e6\nconstant_in_time = true\ninitial = [0, SERIES]",
           "control.initial: found", "place alone", at="initial = [0"),
        at("series for all components", 'body = ["0", "-9.81"]', "body = SERIES", "load.body: found", "an array of one expression",
           at="body ="),
    ]


def effect_cases() -> list[Case]:
    """Supports, loads, controls and objectives that cannot be."""
    traction = '[[load.traction]]\non = "side"\nvalue = ["0", "1"]\n[initial]'
    return [
        edited("traction without a group", "[initial]", traction.replace('on = "side"\n', ""), "load.traction", "on: missing",
               at="[[load.traction]]"),
        edited("traction of three components", "[initial]", traction.replace('"1"]', '"1", "2"]'), "load.traction[0].value: ",
               "found 3 components", "expected 2", at=""),
        edited("traction on a missing group", "[initial]", traction.replace('"side"', '"nowhere"'), "load.traction[0].on: ",
               '"nowhere"', at=""),
        edited("traction on the body", "[initial]", traction.replace('"side"', '"body"'), "load.traction[0].on: ", '"body"', at=""),
        edited("clamp of no component", 'on = "top"', 'on = "top"\ncomponents = []', "clamp[0].components: ", 'found []; expected at least one component, such as ["y"]',
               at="components ="),
        edited("clamp of z in the plane", 'on = "top"', 'on = "top"\ncomponents = ["z"]', 'clamp.components: found "z"',
               "choices: x, y", "2-dimensional", at=""),
        edited("motion of three components of the second clamp", '[[clamp]]\non = "top"', '[[clamp]]\non = "top"\n\n[[clamp]]\n'
               'on = "side"\nvalue = ["0", "0", "t"]', "clamp[1].value: found 3 components", "expected 2", at=""),
        edited("motion of one component, two values", 'on = "top"', 'on = "top"\ncomponents = ["y"]\nvalue = ["0", "t"]', "clamp[0].value: ",
               "1 expression", at="value ="),
        edited("motion that is not finite", 'on = "top"', 'on = "top"\nvalue = ["0", "1/t"]', "clamp.value: ", '"1/t" is inf', at=""),
        edited("start off a moving clamp", 'on = "top"', 'on = "top"\nvalue = ["0", "1e-3 + t"]', "initial.displacement: ", "0.001", "clamps",
               at=""),
        edited("control on a missing group", "scale = 1e6", 'scale = 1e6\non = "nowhere"', "control.on: ", '"nowhere"', at="",
               verb="optimize"),
        edited("control on a missing group, forward run", "scale = 1e6", 'scale = 1e6\non = "nowhere"', "control.on: ", '"nowhere"',
               at=""),
        edited("control on a missing group, info, two ranks", "scale = 1e6", 'scale = 1e6\non = "nowhere"', "control.on: ",
               '"nowhere"', at="", verb="info", ranks=2),
        edited("control of z in the plane", "scale = 1e6", 'scale = 1e6\ncomponents = ["y", "z"]', 'control.components: found "z"',
               "choices: x, y", "2-dimensional", at=""),
        edited("control of unknown space", "scale = 1e6", 'scale = 1e6\nspace = "P3"', "control.space: ", '"P3"', "nodal, cellwise",
               at="space ="),
        edited("control constant by text", "scale = 1e6", 'scale = 1e6\nconstant_in_time = "yes"', "control.constant_in_time: ",
               'found "yes"; expected true or false', at="constant_in_time ="),
        edited("control of an unknown component", "scale = 1e6", 'scale = 1e6\ncomponents = ["w"]', "control.components: ", "w",
               "x, y, z", at="components ="),
        Case("reference control of a component left out", ('objective.desired.control: found "-1" for y, which control.components leaves out; set it to "0"',),
             edits=(("scale = 1e6", 'scale = 1e6\ncomponents = ["x"]'),), at="desired ="),
        edited("first guess of a component left out", "scale = 1e6", 'scale = 1e6\ncomponents = ["y"]\ninitial = ["t", "0"]',
               'control.initial: found "t" for x', 'set it to "0"', at="initial ="),
        Case("check at a component left out", ('check.control: found "x" for x, which control.components leaves out; set it to "0"',), at='control = ["x"', edits=(
            ("scale = 1e6", 'scale = 1e6\ncomponents = ["y"]'), ("[output]", '[check]\ncontrol = ["x", "1"]\n[output]'))),
        Case("reference control of time, control constant in time", ('objective.desired.control: the expression "-t"',
             "variables x, y, z"), edits=(("scale = 1e6", "scale = 1e6\nconstant_in_time = true"),
                                          ('control = ["0", "-1"]', 'control = ["0", "-t"]')), at="desired ="),
        Case("check of time, control constant in time", ('check.control: the expression "t"', "variables x, y, z"), edits=(
            ("scale = 1e6", "scale = 1e6\nconstant_in_time = true"), ("[output]", '[check]\ncontrol = ["0", "t"]\n[output]')),
             at='control = ["0", "t"]'),
        edited("objective on a missing group", "gamma =", 'on = "nowhere"\ngamma =', "objective.on: ", '"nowhere"', at="",
               verb="optimize"),
        edited("objective on a missing group, forward run", "gamma =", 'on = "nowhere"\ngamma =', "objective.on: ", '"nowhere"',
               at=""),
        edited("negative tracking", "gamma =", "tracking = -1.0\ngamma =", "objective.tracking: ", "-1", at="tracking ="),
        edited("nothing desired", "gamma = 7.5e-4", "tracking = 0.0\ngamma = 0.0", "objective.tracking: found 0 where gamma is 0 too; set at least one of them",
               at="tracking ="),
    ]


def later_cases() -> list[Case]:
    """What the interface promises and this version does not have."""
    return [
        edited("unknown scheme", "[material]", 'scheme = "contact-stable"\n[material]', "time.scheme: ",
               '"contact-stable"', 'did you mean "contact-stabilized"', "contact-implicit"),
        Case("massless and stabilized", ('contact.mass: found "massless"', '"contact-stabilized"', 'set it to "consistent"'), edits=(
            ("[material]", 'scheme = "contact-stabilized"\n[material]'), ("[load]", 'mass = "massless"\n[load]')), at="mass ="),
        edited("unknown mass of contact", "[load]", 'mass = "lumped"\n[load]', 'contact.mass: found "lumped"',
               "consistent, massless"),
        overridden("unknown reaction to invariants", 'run.invariants="ignore"', "run.invariants: ", '"ignore"', "warn, stop, off"),
        overridden("tolerance of invariants", "run.tolerance=0", "run.tolerance: ", "greater than 0"),
        edited("misspelt linear solver", 'linear = "auto"', 'linear = "interactive"', "solver.linear: ", '"interactive"',
               "auto, direct, iterative"),
        edited("negative memory", 'linear = "auto"', 'linear = "auto"\nmemory = -1.0', "solver.memory: ", "-1", "bytes",
               at="memory ="),
        edited("memory as text", 'linear = "auto"', 'linear = "auto"\nmemory = "8 GB"', "solver.memory: ", "8 GB", "bytes",
               at="memory ="),
        edited("misspelt storage", "[output]", '[trajectory]\nstorage = "dsik"\n[output]', 'trajectory.storage: found "dsik"',
               'did you mean "disk"?', "memory, disk, checkpoints", at="storage ="),
        edited("budget without checkpoints", "[output]", '[trajectory]\nbudget = 1e9\n[output]', "trajectory.budget: has no effect",
               '"memory"', '"checkpoints"', at="budget ="),
        edited("budget of nothing", "[output]", '[trajectory]\nstorage = "checkpoints"\nbudget = 0\n[output]', "trajectory.budget: ",
               "0", "bytes", at="budget ="),
        overridden("budget for less than a checkpoint", ('trajectory.storage="checkpoints"', "trajectory.budget=500"),
                   "trajectory.budget: found 500 bytes", "expected at least 576, since a checkpoint takes 0.000288 MB", "desired motion", verb="optimize"),
        overridden("budget for less than a checkpoint, two ranks", ('trajectory.storage="checkpoints"', "trajectory.budget=500"),
                   "trajectory.budget: found 500 bytes", "expected at least 576", verb="optimize", ranks=2),
        overridden("disk full of states", 'trajectory.storage="disk"', "the states of a motion", "cannot be written",
                   re.compile("File too large|HDF5 failed"), "TMPDIR", verb="optimize", largest_file=1000),
        edited("misspelt start", "[optimizer]", '[optimizer]\nstart = "corse"', "optimizer.start: ", '"corse"', 'mean "coarse"?', "coarse, guess",
               at="start ="),
        edited("coarse start on a .msh", "[optimizer]", '[optimizer]\nstart = "coarse"', 'optimizer.start: found "coarse" with a .msh',
               "use a .geo and mesh.size", at="start ="),
        Case("coarse start without a size", ('optimizer.start: found "coarse" without mesh.size', "give one"), mesh=GEO, mesh_file="square.geo",
             edits=(('file = "square.msh"', 'file = "square.geo"'), ("[optimizer]", '[optimizer]\nstart = "coarse"')), at="start ="),
        Case("coarse start to a run's motion", ('optimizer.start: found "coarse" with objective.desired.run', 'set it to "guess"'), mesh=GEO,
             mesh_file="square.geo", at="start =", edits=(
                 ('file = "square.msh"', 'file = "square.geo"\nsize = 0.5'), ("[optimizer]", '[optimizer]\nstart = "coarse"'),
                 ('desired = { control = ["0", "-1"] }', 'desired = { run = "earlier" }'))),  # fmt: skip
        edited("misspelt optimizer", "[optimizer]", '[optimizer]\nmethod = "lbgfs"', "optimizer.method: ", '"lbgfs"',
               'mean "lbfgs"?', "lbfgs, newton-cg, projected-gradient", at="method ="),
        Case("study of a quantity that the scene has not", ("--quantity: found \"heat\"", "displacement"), verb="study",
             options=("--quantity", "heat")),
        Case("study of searches to no tolerance", ("--search-tolerances: 0 is no part of the first gradient; give numbers above 0 and up to 1",),
             verb="study", options=("--search-tolerances", "1e-3,0")),
        Case("study of searches beside a suggestion", ("--search-tolerances excludes --suggest",), verb="study",
             options=("--search-tolerances", "1e-3", "--suggest", "1e-2")),
        Case("resume of a verb without checkpoints", ("--resume: simulate writes no checkpoints", "optimize"), options=("--resume",), earlier=True),
        Case("resume of a verb without checkpoints, two ranks", ("--resume: simulate writes no checkpoints", "optimize"), options=("--resume",),
             ranks=2),
    ]


def material_cases() -> list[Case]:
    """Materials that do not cover the body once."""
    def table(on: str) -> str:
        return f'[[material]]\non = "{on}"\ndensity = 1.0\nyoung = 1e8\npoisson = 0.3\n\n'

    one = "[material]\ndensity = 1.0\nyoung = 1e8\npoisson = 0.3\nviscosity = { bulk = 1e4, shear = 1e4 }\n\n"
    halves = {"mesh": square_of_halves(), "mesh_file": "square.msh"}
    overlap = GEO + 'Physical Surface("disc") = {1};\n'
    geo = {"mesh": overlap, "mesh_file": "square.geo"}
    to_geo = ('file = "square.msh"', 'file = "square.geo"\nsize = 4')

    def on(name: str, groups: tuple[str, ...], *expect: Expected, **more: object) -> Case:
        edits = ((one, "".join(table(group) for group in groups)), *more.pop("edits", ()))
        return Case(name, expect, edits=edits, **more)  # type: ignore[arg-type]

    return [
        edited("material of a group in one table", "density = 1.0", 'density = 1.0\non = "body"',
               "material.on: has no effect", "[[material]]", at='on = "body"'),
        edited("materials without a group", "[material]", "[[material]]", "material[0].on: missing", "required"),
        edited("misspelt group key of a material", "[material]", '[[material]]\nonn = "body"',
               "material[0].onn: unknown", 'did you mean "on"?', at="onn ="),
        edited("list of no materials", one, "", "material: found []", "[[material]]",
               prepare=lambda folder: prepend(folder / "scene.toml", "material = []\n")),
        edited("one table and several", one, one + table("body"), "not valid TOML", at="[[material]]"),
        on("group of two materials", ("body", "body"), 'material[1].on: found "body"', "material[0]", "another group"),
        on("unknown group of a material", ("left", "rigth"), "material[1].on: ", "square.msh", 'no surface group "rigth"',
           'did you mean "right"?', "surface groups of the file: left, right", **halves, earlier=True),
        on("unknown group of a material, two ranks", ("left", "rigth"), "material[1].on: ", '"rigth"', **halves, ranks=2),
        on("boundary as a material's group", ("left", "top"), "material[1].on: ", '"top"', "dimension 1",
           "surface groups of the file: left, right", **halves),
        on("cells without a material", ("left",), "material: the cell at (0.", "no group of a material (left)",
           "give every cell one material", **halves, earlier=True),
        on("cells without a material, two ranks", ("left",), "material: the cell at (0.", "(left)", **halves, ranks=2),
        on("cells of two materials", ("body", "disc"), "material: the cell at (", '"body" and "disc"', "two materials",
           **geo, edits=(to_geo,)),
        on("negative density of one material", ("left", "right"), "material[1].density: found -1", "greater than 0",
           **halves, options=("--set", "material.1.density=-1")),
        on("set on materials without a number", ("left", "right"), "--set material.young=1", "list of 2 tables",
           "material.0.on", **halves, options=("--set", "material.young=1")),
        on("set beyond the materials", ("left", "right"), "--set material.2.young=1", "list of 2 tables", **halves,
           options=("--set", "material.2.young=1")),
    ]


def option_cases() -> list[Case]:
    """Command lines that are wrong, and overrides that do not fit the scene."""
    verbs = ("simulate", "optimize", "check", "info", "keys")
    objective = '[objective]\ndesired = { control = ["0", "-1"] }\nalpha = 1e-2\ngamma = 7.5e-4\n\n'
    optimizer = "[optimizer]\nmax_iterations = 1\ntolerance = 1e-6\n\n"
    return [
        overridden("set without =", "mesh.size", '--set: found "mesh.size"', "key.path=value"),
        overridden("set without a key", "=4", '--set: found "=4"', "key.path=value"),
        overridden("set of an unknown key", "material.yong=1e8", "--set material.yong: unknown", 'did you mean "young"?'),
        overridden("set of an unknown table", "materail.young=1e8", "--set materail: unknown", 'did you mean "material"?'),
        overridden("set ending in a dot", "material.=1e8", "--set material.=1e8", "ends in a dot"),
        overridden("set beginning with a dot", ".young=1e8", "--set .young=1e8", "dot"),
        overridden("set with two dots", "material..young=1e8", "--set material..young=1e8", "dot"),
        overridden("set on a list without an index", "clamp.on=bottom", "--set clamp.on=bottom", "list of 1 table",
                   "clamp.0.on"),
        overridden("set beyond the list", "clamp.1.on=bottom", "--set clamp.1.on=bottom", "list of 1 table",
                   "clamp.0.on"),
        overridden("set on a component", "load.body.1=0", "--set load.body.1=0", "load.body",
                   never=("tables", "body.0.on")),
        overridden("set below a value", "material.young.x=1", "--set material.young.x=1", '"young" is not a table'),
        overridden("set of the wrong type", "material.young=soft", "--set material.young: found", "soft", "a number"),
        overridden("set to nothing", "material.young=", "material.young: found", "a number"),
        overridden("set out of range", "material.poisson=0.7", "material.poisson: found 0.7", "less than 0.5"),
        overridden("set out of range, two ranks", "material.poisson=0.7", "--set material.poisson: found 0.7", ranks=2),
        overridden("set of a key of a table of its own", "exact={impulse = 0}", "--set exact.impulse: found 0"),
        overridden("set of a table without a required key", "check={}", "--set check.control: missing"),
        overridden("set of too many components", 'initial.velocity=["0", "0", "0"]', "--set initial.velocity: found 3 components",
                   "2-dimensional", never=("scene.toml",)),
        overridden("set of too many components of a clamp", 'clamp.0.value=["0", "0", "t"]', "--set clamp.value: found 3", never=("scene.toml",)),
        overridden("set of a component of space", 'control.components=["z"]', '--set control.components: found "z"', never=("scene.toml",)),
        edited("too many components beside a set", 'velocity = ["0", "0"]', 'velocity = ["0", "0", "0"]', "scene.toml: initial.velocity: found 3",
               at="", options=("--set", "initial.displacement=[0, 0]")),
        overridden("set of a table to a value", "contact=bottom", "contact: found", "bottom", "a table"),
        overridden("set of two keys, the second wrong", ("material.young=1e7", "solver.vi=ful"),
                   'solver.vi: found "ful"', 'did you mean "full"?'),
        typed("unknown verb", "solve scene.toml", "solve", *verbs),
        typed("unknown verb, two ranks", "solve scene.toml", "solve", *verbs, ranks=2),
        typed("misspelt verb", "simulat scene.toml", "simulat", '"simulate"'),
        typed("no verb", "", *verbs),
        typed("no verb but a scene", "scene.toml", "scene.toml", *verbs),
        typed("no scene", "simulate", "scene", "required"),
        typed("keys of a scene", "keys scene.toml", "scene.toml", "not expected"),
        typed("two scenes", "simulate scene.toml scene.toml", 'unexpected "scene.toml"; give one scene and the options'),
        Case("option in no encoding", ("--set contact.on: ", "UTF-8"), options=("--set", "contact.on=\udcff")),
        Case("unknown option", ('unexpected "--color"; give one scene and the options',), options=("--color",), earlier=True),
        Case("misspelt option", ("--quite", '"--quiet"'), options=("--quite",)),
        typed("out without a folder", "simulate scene.toml --out", "--out"),
        typed("set without a word", "simulate scene.toml --out results --set", "--set"),
        edited("optimize without an objective", objective + optimizer, "", "scene.toml", "optimize needs", "[objective]",
               verb="optimize", earlier=True),
        edited("trajectory without an objective", objective + optimizer, '[trajectory]\nstorage = "disk"\n\n',
               "trajectory: has no effect without an objective", at="[trajectory]"),
        edited("optimizer without an objective", objective, "", "optimizer: has no effect without an objective", at="[optimizer]"),
        edited("objective that is a list", "[objective]", "[[objective]]", "objective: found", "a table"),
        edited("optimize without a control", "", "", "optimize needs", "[control] and [objective]", verb="optimize",
               prepare=lambda folder: keep_tables(folder / "scene.toml", ("mesh", "time", "material"))),
        edited("objective without a control", "[control]\nscale = 1e6\nlower = -2.0\nupper = 2.0\n", "",
               "objective: needs a control", "[control]", at="[objective]"),
        edited("both desired kinds", 'control = ["0", "-1"]', 'control = ["0", "-1"], displacement = ["0", "0"]',
               "objective.desired: found control, displacement", "give one of", at="desired ="),
        edited("no desired kind", 'control = ["0", "-1"]', "", "objective.desired: found none",
               "control, displacement", at="desired ="),
        edited("misspelt desired kind", 'control = ["0", "-1"]', 'contrl = ["0", "-1"]', "objective.desired", "contrl",
               at="desired ="),
        edited("check without a control", "[control]\nscale = 1e6\nlower = -2.0\nupper = 2.0\n\n" + objective + optimizer,
               '[check]\ncontrol = ["0", "1"]\n', "check: ", "[control]", verb="check"),
    ]


def mesh_file_cases() -> list[Case]:
    """Mesh files that are missing or cannot be read."""
    file, old, new = 'file = "square.msh"', square2(), square4()
    cut = re.compile("(?i)end of|ends|truncat|incomplete|cut short|missing|expected|read")
    geo = {"mesh_file": "square.geo", "edits": ((file, 'file = "square.geo"\nsize = 4'),)}
    return [
        edited("mesh missing", file, 'file = "nowhere.msh"', "mesh.file: ", "nowhere.msh", "cannot be read", "give the path",
               at="", earlier=True),
        edited("mesh missing, two ranks", file, 'file = "nowhere.msh"', "mesh.file: ", "nowhere.msh", at="", ranks=2),
        edited("mesh is a folder", file, 'file = "folder.msh"', "mesh.file: ", "folder.msh", "cannot be read", at="",
               prepare=lambda folder: (folder / "folder.msh").mkdir()),
        edited("mesh behind a link to itself", file, 'file = "loop/square.msh"', "mesh.file: ", "cannot be followed", at="file =",
               prepare=lambda folder: (folder / "loop").symlink_to("loop")),
        edited("mesh of a name beyond all limits", file, f'file = "{"a" * 5000}.msh"', "mesh.file: ", "cannot be followed", at="file ="),
        edited("mesh of another format", file, 'file = "square.vtk"', 'mesh.file: found "square.vtk"', ".geo or .msh"),
        edited("size in millimetres", file, 'file = "square.geo"\nunit = "mm"\nsize = 8', "mesh.size: found 8 m", "at most 0.01 m for a body of 0.001 m",
               "in metres", at="", mesh_file="square.geo", mesh=GEO),
        edited("size of a mesh that is meshed", file, file + "\nsize = 4", "mesh.size: ", "no effect on a .msh",
               "use it with a .geo", at="size = 4"),
        meshed("geometry with a syntax error", GEO.replace("Line(2) = {2, 3};", "Line(2) = {2, 3;"), "line 6", "syntax",
               **geo),
        meshed("geometry with a syntax error, two ranks", GEO.replace("Line(2) = {2, 3};", "Line(2) = {2, 3;"),
               "line 6", "syntax", ranks=2, **geo),
        meshed("geometry with an unknown variable", GEO.replace("0.5, 0, 0", "width, 0, 0"), "width", **geo),
        meshed("geometry with an unknown point", GEO.replace("{2, 3}", "{2, 33}"), "33", **geo),
        meshed("geometry that includes a missing file", 'Include "points.geo";\n' + GEO, "points.geo", **geo),
        meshed("geometry that is empty", "", re.compile("no elements|empty"), **geo),
        meshed("geometry without surface", before(GEO, "Curve Loop"), "curve", "triangles", **geo),
        meshed("geometry without groups", before(GEO, "Physical"), "contact.on: ", '"bottom"', "curve groups of the file: boundary", **geo),
        meshed("geometry that ends gmsh", GEO + "Exit;\n", "gmsh ended before the end of this file", "take out", "Exit", **geo),
        meshed("geometry that ends gmsh at once, two ranks", "Exit 3;\n" + GEO, "gmsh ended", "Exit", ranks=2, **geo),
        meshed("geometry of a surface in space", GEO + "Rotate { {1, 0, 0}, {0, 0, 0}, Pi/2 } { Surface{1}; }\n",
               "plane z = 0", "1 m", "tetrahedra", **geo),
        meshed("mesh is empty", "", re.compile("empty|no elements|cannot read")),
        meshed("mesh is prose", "A square of eight triangles.\n" * 20, re.compile("cannot read|no elements|not a")),
        meshed("mesh is prose, two ranks", "A square of eight triangles.\n" * 20,
               re.compile("cannot read|no elements|not a"), ranks=2, earlier=True),
        meshed("mesh is binary", bytes(range(256)) * 16, re.compile("cannot read|no elements|not a")),
        # gmsh runs as a script what does not begin as a mesh; the folder of the case would then hold a file more.
        *(meshed(f"mesh that begins with {what}", beginning + 'SystemCall "touch trace";\n' + end, "not a .msh file", "$MeshFormat", **ranks)
          for what, beginning, end, ranks in (
              ("a command", "", old, {}), ("a command, two ranks", "", old, {"ranks": 2}), ("a command and an end", "", "$EndElements\n", {}),
              ("a comment of scripts", "// $MeshFormat\n", old, {}), ("a blank line", "\n", old, {}),
              ("blanks", " $MeshFormat\n", old, {}), ("an order mark", "\ufeff$MeshFormat\n", old, {}),
              ("more than $MeshFormat", "$MeshFormat;\n", old, {}), ("a post-processing view", "$View\n$EndView\n", old, {}))),
        meshed("mesh of an unknown version", new.replace("4.1 0 8", "9.7 0 8"), re.compile("9.7|version")),
        meshed("old mesh cut short in the nodes", before(old, "$Nodes", 6), cut, earlier=True),
        meshed("old mesh cut short after the nodes", before(old, "$Elements"), cut),
        meshed("old mesh cut short in the elements", before(old, "$Elements", 6), cut),
        meshed("old mesh cut short in a row", before(old, "$Elements", 6).rstrip()[:-2], cut),
        meshed("old mesh cut short in its last number", old[: old.index("\n$EndElements") - 1], cut),
        meshed("mesh cut short in the entities", before(new, "$Entities", 3), cut),
        meshed("mesh cut short in the nodes", before(new, "$Nodes", 15), cut),
        meshed("mesh cut short after the nodes", before(new, "$Elements"), cut),
        meshed("mesh cut short in the elements", before(new, "$Elements", 6), cut, earlier=True),
        meshed("mesh cut short in the elements, two ranks", before(new, "$Elements", 6), cut, ranks=2),
        meshed("mesh with fewer elements than announced", old.replace("$Elements\n16\n", "$Elements\n20\n"), cut, never=("/proc",)),
    ]


def mesh_content_cases() -> list[Case]:
    """Meshes that are no plane meshes of straight triangles with groups."""
    triangle = (TRIANGLE, BODY, 1)
    return [
        meshed("no groups", square2(groups=(), elements=[(kind, 0, entity, nodes) for kind, _, entity, nodes in
                                                         square_elements()]), "contact.on: ", '"bottom"', "curve groups of the file: boundary"),
        meshed("surface without a group", square2(points=[*square_points(), (0.0, -1.0, 0.0)], elements=with_element(
            (TRIANGLE, 0, 7, (1, 10, 2)))), "surface 7", "no physical group", "Physical Surface"),
        edited("misspelt group of contact", 'on = "bottom"', 'on = "botom"', "contact.on: ", "square.msh", '"botom"',
               'did you mean "bottom"?', "bottom, side, top", at="", earlier=True),
        edited("misspelt group of contact, two ranks", 'on = "bottom"', 'on = "botom"', "contact.on: ",
               'did you mean "bottom"?', at="", ranks=2),
        edited("misspelt group of a clamp", 'on = "top"', 'on = "topp"', "clamp", "square.msh", '"topp"',
               'did you mean "top"?', "bottom, side, top", at="", verb="info"),
        edited("misspelt group of the second clamp", '[[clamp]]\non = "top"',
               '[[clamp]]\non = "top"\n\n[[clamp]]\non = "sid"', "clamp[1].on: ", '"sid"', 'did you mean "side"?', at=""),
        edited("surface as a clamp", 'on = "top"', 'on = "body"', "clamp", '"body"', "dimension 2", "curve", at=""),
        edited("surface as contact, check", 'on = "bottom"', 'on = "body"', "contact.on: ", '"body"', "dimension 2",
               "bottom, side, top", at="", verb="check"),
        meshed("group that is only a name", square2(groups=(*GROUPS, (1, 5, "nothing"))), "contact.on: ", '"nothing"',
               "elements", edits=(('on = "bottom"', 'on = "nothing"'),)),
        meshed("group of a curve without elements", square4(empty_curve=True), "contact.on: ", '"nothing"',
               "has no elements", edits=(('on = "bottom"', 'on = "nothing"'),)),
        Case("a solid beside a plane body", ("contact.obstacle.point: ", "the mesh is 3-dimensional"), earlier=True, mesh=square2(
            points=[*square_points(), (0.0, 0.0, 1.0)], groups=(*GROUPS, (3, 9, "solid")), elements=with_element((TETRAHEDRON, 9, 1, (1, 2, 4, 10))))),
        meshed("mesh of curves", square2(elements=[e for e in square_elements() if e[0] == LINE]), "curve",
               "triangles"),
        meshed("mesh of a point", square2(elements=[(15, 0, 1, (1,))]), "point", "triangles"),
        meshed("mesh without elements", square2(elements=[]), "no elements"),
        meshed("quadrilaterals", square2(elements=[(QUADRILATERAL, BODY, 1, (1, 2, 5, 4))]), "Quadrilateral",
               "straight triangles"),
        meshed("a quadrilateral among triangles", square2(points=[*square_points(), (1.0, 0.0, 0.0), (1.0, 0.5, 0.0)],
                                                          elements=with_element((QUADRILATERAL, BODY, 1, (3, 10, 11, 6)))),
               "Quadrilateral", "straight triangles"),
        meshed("triangles of second order", square2(elements=[(TRIANGLE_6, BODY, 1, (1, 3, 7, 2, 5, 4))]), "Triangle 6",
               "straight triangles", "Mesh.ElementOrder = 1"),
        meshed("edges of second order", square2(elements=[e for e in square_elements() if e[1] != BOTTOM] +
                                                [(LINE_3, BOTTOM, BOTTOM, (1, 3, 2))]), "contact.on: ", "Line 3", "Mesh.ElementOrder = 1"),
        meshed("node off the plane", square2(points=moved(5, (0.0, 0.5, 0.1))), "plane z = 0", "0.1 m", "tetrahedra"),
        meshed("node off the plane, two ranks", square2(points=moved(5, (0.0, 0.5, 0.1))), "plane z = 0", "0.1 m",
               ranks=2),
        meshed("mesh in another plane", square2(points=[(x, y, 1.0) for x, y, _ in square_points()]), "plane z = 0",
               "1 m"),
        meshed("triangle on a line", square2(elements=with_element((*triangle, (1, 2, 3)))), "(-0.5, 0)", "no area"),
        meshed("triangle with a corner twice", square2(elements=with_element((*triangle, (1, 2, 2)))), "(-0.5, 0)",
               "no area"),
        meshed("two nodes in one place", square2(points=moved(5, (0.5, 0.5, 0.0))), "no area"),
        meshed("coordinate that is no number", square2(points=moved(5, (float("nan"), 0.5, 0.0))), "node 5", "nan",
               "finite"),
        meshed("infinite coordinate", square2(points=moved(5, (0.0, float("inf"), 0.0))), "node 5", "inf", "finite"),
        meshed("element with a node that is missing", square2(elements=with_element((*triangle, (1, 2, 77)))), "77"),
        meshed("edge with a node that is missing", square2(elements=with_element((LINE, BOTTOM, BOTTOM, (3, 77)))),
               "77"),
        meshed("edge with a node of no triangle", square2(points=[*square_points(), (1.0, 0.0, 0.0)], elements=with_element(
            (LINE, BOTTOM, BOTTOM, (3, 10)))), "contact.on: ", '"bottom"', "the edge at (0.5, 0)", "no triangle"),
        meshed("edge of no triangle", square2(elements=with_element((LINE, BOTTOM, BOTTOM, (2, 9)))), "bottom",
               "triangle"),
        meshed("group of edges of no triangle", square2(elements=[e for e in square_elements() if e[1] != BOTTOM] + [
            (LINE, BOTTOM, BOTTOM, (1, 3))]), "bottom", "triangle"),
        meshed("triangle twice", square2(elements=with_element((*triangle, (1, 2, 5)))), re.compile("twice|share|overlap")),
        meshed("triangles that overlap", square2(points=moved(5, (0.75, 0.5, 0.0))), "two triangles", "the edge at (",
               "overlap", "either side"),
        meshed("group named as the number of another", square2(groups=((2, BODY, "body"), (1, TOP, "top"), (1, BOTTOM, "4"))), "contact.on: ",
               '"4"', "no name but this number", "give that one a name", edits=(('on = "bottom"', 'on = "4"'),)),
        edited("all contact nodes clamped", 'on = "bottom"', 'on = "top"', "contact.on: ", '"top"', "clamped",
               "nodes that can move", at="", earlier=True),
        edited("all contact nodes clamped, two ranks", 'on = "bottom"', 'on = "top"', "contact.on: ", "clamped", at="",
               ranks=2),
        edited("body inside the obstacle", "point = [0, -0.1]", "point = [0, 0.25]", "contact: ", "node at", ", 0",
               "0.25 m inside the obstacle", "start outside", at="", earlier=True),
        edited("body inside the obstacle, two ranks", "point = [0, -0.1]", "point = [0, 0.25]", "contact: ",
               "0.25 m inside", at="", ranks=2),
        edited("body moved into the obstacle", 'displacement = ["0", "0"]', 'displacement = ["0", "-0.2*(1 - y)"]',
               "contact: ", "node at", "0.1 m inside the obstacle", at=""),
        edited("body in the obstacle by rounding", "point = [0, -0.1]", "point = [0, 1e-9]", "contact: ", "1e-09 m inside", "as do all 3 candidates",
               'contact.initial = "project"', at="", never=("reversed",)),
        Case("normal that points into the obstacle", ("contact: ", "inside the obstacle", "normal"),
             edits=(("normal = [0, 1]", "normal = [0, -1]"),)),
    ]


def space_cases() -> list[Case]:
    """Meshes of tetrahedra that are wrong, and vectors that do not fit one."""
    cube, tetrahedron = cube2(), (TETRAHEDRON, BODY, 1)
    outside, beyond = (1.5, 0.0, 0.5), (0.0, 0.0, 2.0)
    found, clamped_bottom = ("found 2 components", "3", "3-dimensional"), (('on = "bottom"', 'on = "top"'),)
    hexahedron = (5, BODY, 1, (1, 2, 4, 3, 5, 6, 8, 7))
    edges = [(x, 0.0, 0.0) for x in range(6)]  # the middles of a tetrahedron's edges; where they are does not matter
    no_bottom = [e for e in cube_elements() if e[1] != BOTTOM]
    return [
        solid("body load of two components in space", cube, "load.body", *found,
              edits=(('body = ["0", "0", "-9.81"]', 'body = ["0", "-9.81"]'),)),
        solid("velocity of two components in space, two ranks", cube, "initial.velocity", *found, ranks=2,
              edits=(('velocity = ["0", "0", "0"]', 'velocity = ["0", "0"]'),)),
        solid("desired control of two components in space", cube, "objective.desired.control", *found, verb="optimize",
              edits=(('control = ["0", "0", "-1"]', 'control = ["0", "-1"]'),), earlier=True),
        solid("bound of two components in space", cube, "control.lower", *found,
              edits=(("lower = -2.0", "lower = [-2, -2]"),)),
        solid("plane obstacle of a solid", cube, "contact.obstacle.point", *found,
              edits=(("point = [0, 0, -0.1], normal = [0, 0, 1]", "point = [0, -0.1], normal = [0, 1]"),)),
        solid("flat tetrahedron", cube2(elements=with_space_element((*tetrahedron, (1, 2, 4, 3)))), "(-0.5, -0.5, 0)",
              "no volume", "tetrahedra"),
        solid("tetrahedron with a corner twice", cube2(elements=with_space_element((*tetrahedron, (1, 2, 6, 6)))),
              "(-0.5, -0.5, 0)", "no volume"),
        solid("two corners in one place", cube2(points=moved_corner(7, (-0.5, 0.5, 0.0))), "no volume"),
        solid("tetrahedron twice", cube2(elements=with_space_element((*tetrahedron, (8, 4, 2, 1)))), "the tetrahedron at",
              "twice"),
        solid("tetrahedra that overlap", cube2(points=moved_corner(3, (1.5, -1.0, 0.0))), "two tetrahedra", "the face at (",
              "overlap", "either side"),
        solid("tetrahedra that overlap, two ranks", cube2(points=moved_corner(3, (1.5, -1.0, 0.0))), "overlap", ranks=2),
        solid("face of three tetrahedra", cube2(points=[*cube_points(), outside], elements=with_space_element(
            (*tetrahedron, (1, 4, 8, 9)))), "more than two tetrahedra", "the face at (-0.5, -0.5, 0)"),
        solid("hexahedra", cube2(elements=[hexahedron]), "Hexahedron", "straight tetrahedra"),
        solid("a prism among tetrahedra", cube2(points=[*cube_points(), outside, beyond], elements=with_space_element(
            (PRISM, BODY, 1, (2, 4, 9, 6, 8, 10)))), "Prism", "straight tetrahedra"),
        solid("tetrahedra of second order", cube2(points=[*cube_points(), *edges], elements=[
            (TETRAHEDRON_10, BODY, 1, (1, 2, 4, 8, 9, 10, 11, 12, 13, 14))]), "Tetrahedron 10", "straight tetrahedra"),
        solid("quadrilaterals for a side", cube2(elements=[*no_bottom, (QUADRILATERAL, BOTTOM, BOTTOM, (1, 2, 4, 3))]),
              "contact.on: ", "Quadrilateral", "straight triangles"),
        solid("face of no tetrahedron", cube2(elements=[*no_bottom, (TRIANGLE, BOTTOM, BOTTOM, (1, 2, 3))]),
              "the face at (-0.5, -0.5, 0)", '"bottom"', "the face of no tetrahedron"),
        solid("face with a node that is missing", cube2(elements=with_space_element((TRIANGLE, TOP, TOP, (5, 6, 77)))),
              "77"),
        solid("face with a node of no tetrahedron", cube2(points=[*cube_points(), beyond], elements=with_space_element(
            (TRIANGLE, TOP, TOP, (5, 6, 9)))), "clamp", '"top"', "the face at (-0.5, -0.5, 1)", "no tetrahedron"),
        solid("tetrahedron with a node that is missing", cube2(elements=with_space_element((*tetrahedron, (1, 2, 4, 77)))),
              "77"),
        solid("corner that is no number", cube2(points=moved_corner(7, (float("nan"), 0.5, 1.0))), "node 7", "nan",
              "finite"),
        solid("volume without a group", cube2(points=[*cube_points(), beyond], elements=with_space_element(
            (TETRAHEDRON, 0, 7, (5, 6, 8, 9)))), "volume 7", "no physical group", "Physical Volume"),
        solid("surfaces of a cube without its volume", cube2(elements=[e for e in cube_elements() if e[0] == TRIANGLE]),
              "plane z = 0", "1 m", "tetrahedra"),
        solid("misspelt surface of a clamp", cube, "clamp", '"topp"', 'did you mean "top"?', "surface groups", "bottom, top",
              edits=(('on = "top"', 'on = "topp"'),), earlier=True),
        solid("volume as a clamp", cube, "clamp", '"body"', "dimension 3", "surface groups",
              edits=(('on = "top"', 'on = "body"'),)),
        solid("curve as contact of a solid", cube2(groups=(*SPACE_GROUPS, (1, 9, "rim")), elements=with_space_element(
            (LINE, 9, 9, (1, 2)))), "contact.on", '"rim"', "dimension 1", "surface groups",
              edits=(('on = "bottom"', 'on = "rim"'),)),
        solid("all contact nodes of a solid clamped, two ranks", cube, "contact.on: ", "clamped", edits=clamped_bottom,
              ranks=2),
        solid("solid inside the obstacle", cube, "contact: ", "node at", ", 0)", "0.25 m inside the obstacle",
              edits=(("point = [0, 0, -0.1]", "point = [0, 0, 0.25]"),), earlier=True),
        solid("mesh of a solid cut short", before(cube, "$EndElements"), "cube.msh", re.compile("end of a section")),
    ]


def fit_cases() -> list[Case]:
    """Unknowns and measurements that a scene cannot have."""
    objective = '[objective]\ndesired = { control = ["0", "-1"] }\n\n[output]'
    no_objective = ('[objective]\ndesired = { control = ["0", "-1"] }\nalpha = 1e-2\ngamma = 7.5e-4\n', "")

    def fit(name: str, unknown: str, measurement: str, *expect: Expected, edits: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
        tables = f"[[unknown]]\n{unknown}\n" if unknown else ""
        tables += f"[[measurement]]\n{measurement}\n" if measurement else ""
        return Case(name, expect, edits=(("every = 1", f"every = 1\n\n{tables}"), no_objective, *edits), **more)

    force = 'of = "force"\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1'

    def unknown(name: str, keys: str, *expect: Expected) -> Case:
        return fit(name, keys, force, *expect)

    def measurement(name: str, keys: str, *expect: Expected, **more: object) -> Case:
        return fit(name, 'of = "young"', keys, *expect, **more)

    def data(name: str, text: str | None, *expect: Expected) -> Case:
        def prepare(folder: Path) -> None:
            if text is not None:
                write(folder / "force.csv", text)

        return measurement(name, force, "measurement[0].file: ", *expect, verb="optimize", prepare=prepare)

    return [
        measurement("accuracy of a fit", force, "--accuracy: has no effect on a fit, with tables [[unknown]]", "optimizer.tolerance", verb="optimize",
                    options=("--accuracy", "1e-2")),
        *(fit(f"sizes chosen for {verb} of a fit", 'of = "young"', force, 'mesh.size: "auto" cannot be combined with [[unknown]]; give a size in m, such as --set mesh.size=0.1',
              edits=(('file = "square.msh"', 'file = "square.geo"\nsize = "auto"'),), mesh=GEO, mesh_file="square.geo", verb=verb)
          for verb in ("optimize", "check")),
        unknown("unknown of nothing", 'name = "a"', "unknown[0].of: missing"),
        unknown("unknown that is not there", 'of = "yuong"', 'unknown[0].of: found "yuong"', "young"),
        unknown("unknown with a number for a name", 'of = "young"\nname = 1', "unknown[0].name: found 1"),
        unknown("unknown on a group where there is one material", 'of = "young"\non = "body"', "unknown[0].on: has no effect"),
        unknown("unknown of no obstacle", 'of = "position"\nobstacle = "wall"', 'unknown[0].obstacle: found "wall"', "obstacle 1"),
        unknown("radius of a half-space", 'of = "radius"', 'unknown[0].of: found "radius"', "position, angle"),
        unknown("component of a modulus", 'of = "young"\ncomponent = "x"', "unknown[0].component: has no effect"),
        unknown("angle about an axis in the plane", 'of = "angle"\ncomponent = "x"', "unknown[0].component: found x", "2-dimensional"),
        unknown("modulus that starts at zero", 'of = "young"\nstart = 0.0', "unknown[0].start: found 0", "greater than 0"),
        unknown("start below the bounds", 'of = "young"\nstart = 1.0\nlower = 2.0', "unknown[0].start: found 1", "within the bounds"),
        unknown("lower bound of a ratio", 'of = "poisson"\nlower = -2.0', "unknown[0].lower: found -2", "greater than -1"),
        unknown("upper bound of a ratio", 'of = "poisson"\nupper = 0.5', "unknown[0].upper: found 0.5", "less than 0.5"),
        unknown("scale that is none", 'of = "young"\nscale = "square"', 'unknown[0].scale: found "square"', "linear, log"),
        unknown("prior without a mean", 'of = "young"\nprior = { deviation = 0.1 }', "unknown[0].prior.mean: missing"),
        unknown("prior with a text for a mean", 'of = "young"\nprior = { mean = "a", deviation = 0.1 }', 'unknown[0].prior.mean: found "a"'),
        unknown("prior as sharp as a point", 'of = "young"\nprior = { mean = 1e8, deviation = 0 }', "unknown[0].prior.deviation: found 0"),
        unknown("weight of a scene without any", 'of = "load.gravity"', 'unknown[0].of: found "load.gravity"', "without"),
        unknown("unknown twice", 'of = "young"\n[[unknown]]\nof = "young"\nname = "E"', 'unknown[1].of: found "young"', "unknown[0] seeks too"),
        unknown("factor and component of one field", 'of = "initial.velocity"\n[[unknown]]\nof = "initial.velocity"\ncomponent = "y"',
                'unknown[1].of: found "initial.velocity"', "unknown[0] seeks too"),
        unknown("unknown along z in the plane", 'of = "initial.velocity"\ncomponent = "z"', 'unknown[0].component: found "z"', "2 components"),
        unknown("unknown called like a column", 'of = "young"\nname = "damping"', 'unknown[0].name: found "damping"', "history.csv"),
        fit("memory of a fit", 'of = "young"', force, "optimizer.memory: has no effect on a fit", edits=(("max_iterations = 1", "memory = 1e8"),)),
        fit("unknown without data", 'of = "young"', "", "unknown: needs data that determine it", "[[measurement]]"),
        fit("lbfgs for a fit", 'of = "young"', force, 'optimizer.method: found "lbfgs"', "gauss-newton",
            edits=(("max_iterations = 1", 'method = "lbfgs"\nmax_iterations = 1'),)),
        fit("gauss-newton for a control", 'of = "young"', force, 'optimizer.method: found "gauss-newton"', "lbfgs",
            edits=(("[output]", objective), ("max_iterations = 1", 'method = "gauss-newton"\nmax_iterations = 1'))),
        measurement("measurement of nothing", 'name = "a"', "measurement[0].of: missing"),
        measurement("measurement that is none", 'of = "weight"', 'measurement[0].of: found "weight"', "displacement"),
        measurement("measurement with a number for a name", force + "\nname = 1", "measurement[0].name: found 1"),
        measurement("displacement of nowhere", 'of = "displacement"', "measurement[0]: found neither", "point, on"),
        measurement("displacement outside of the body", 'of = "displacement"\npoint = [0, 9]\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1',
                    "measurement[0].point: found (0, 9)", verb="simulate", options=("--measure",)),
        measurement("displacement of a group that is not there",
                    'of = "displacement"\non = "topp"\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1', "measurement[0].on: ", '"topp"',
                    verb="simulate", options=("--measure",)),
        measurement("force of no obstacle", force + '\nobstacle = "wall"', 'measurement[0].obstacle: found "wall"', "obstacle 1"),
        measurement("force in no direction", 'of = "force"\nfile = "force.csv"', "measurement[0].component: missing"),
        measurement("force along z in the plane", force.replace('"y"', '"z"'), 'measurement[0].component: found "z"', "2-dimensional"),
        measurement("force without a file", 'of = "force"\ncomponent = "y"', "measurement[0].file: missing"),
        measurement("file that is a number", force.replace('"force.csv"', "1"), "measurement[0].file: found 1"),
        measurement("column that is a number", force + "\ncolumn = 1", "measurement[0].column: found 1"),
        measurement("contact time without a value", 'of = "contact-time"', "measurement[0].value: missing"),
        measurement("contact time below zero", 'of = "contact-time"\nvalue = -1', "measurement[0].value: found -1"),
        measurement("deviation of zero", force.replace("noise = 0.1", "deviation = 0"), "measurement[0].deviation: found 0"),
        measurement("noise of zero", force.replace("0.1", "0"), "measurement[0].noise: found 0"),
        measurement("noise beside a deviation", force + "\ndeviation = 1.0", "measurement[0].noise: found beside deviation"),
        data("data that are not there", None, "force.csv", "simulate --measure"),
        data("data without values", "time,force\n0,1\n1e-4,2\n", 'found no column "value"', "time, force"),
        data("data after the end", "time,value\n0,1\n1e-3,2\n", "found the time 0.001 s", "0 to 0.00015 s"),
        data("data with decimal commas between commas", "time,value\n0,0\n1e-4,-1,5\n", "force.csv: line 3: found 3 cells below 2 names"),
        data("data with thousands separators", 'time,value\n0,0\n1e-4,"-1,000"\n', '"-1,000" in column 2'),
        data("data with a column twice", "time,value,value\n0,0,1\n1e-4,1,1\n", 'found "value" in column 2 and "value" in column 3'),
        data("data in the unit of another quantity", "time,value [m/s]\n0,0\n1e-4,1\n", '"value [m/s]"', "cannot be converted to N or N/m"),
        measurement("deviations without a unit beside values with one", 'of = "force"\ncomponent = "y"\nfile = "force.csv"',
                    'measurement[0].file: ', 'found "deviation" without a unit beside "value [kN]"', '"deviation [kN]"', verb="optimize",
                    prepare=lambda folder: write(folder / "force.csv", "time,value [kN],deviation\n0,0,1\n1e-4,1,1\n")),
        data("data that are all zero", "time,value\n0,0\n1e-4,0\n", "all values are 0, to which no noise can be relative; give a deviation"),
        measurement("measuring without a deviation", 'of = "force"\ncomponent = "y"\nfile = "force.csv"', "--measure: measurement[0] has neither",
                    verb="simulate", options=("--measure",)),
        measurement("measuring over a record", force, "--measure: ", "force.csv was not written by simulate --measure", verb="simulate",
                    options=("--measure", "--replace"), prepare=lambda folder: write(folder / "force.csv", "time,value\n0,1\n")),
        measurement("measuring beside a file", force, "--measure: ", "force.csv exists and stays as it is, since a fit may use it; overwrite it with --replace", verb="simulate",
                    options=("--measure",), prepare=lambda folder: write(folder / "force.csv", "time,value\n0,1\n"), ranks=2),
        measurement("measuring into a table of the run", force.replace("force.csv", "results/steps.csv"), "--measure: ",
                    "steps.csv is a file of the run itself", verb="simulate", options=("--measure",)),
        measurement("measuring times", force + '\ncolumn = "time"', "--measure: measurement[0].column", '"time"', verb="simulate",
                    options=("--measure",)),
        typed("seed of nothing", "simulate scene.toml --seed 3", "--seed requires --measure"),
        typed("measuring nothing", "simulate scene.toml --measure", "--measure: the scene measures no values; add a table [[measurement]]"),
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
        probe("probe with a name that another one has", twice, 'output.probe[1].name: found "a"', "output.probe[0] has too",
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
        Case("obstacles with the same name", ("contact[1].obstacle.name: found", "obstacle 2", "contact[0] has too"), edits=(
            ("[contact]", '[[contact]]\non = "bottom"\nobstacle = { name = "obstacle 2", shape = "half-space", point = [0, -0.2], '
             "normal = [0, 1] }\n[[contact]]"),)),
    ]


def desired_run_cases() -> list[Case]:
    """Desired states that no earlier run left as they are needed."""
    by_run = (('desired = { control = ["0", "-1"] }', 'desired = { run = "earlier" }'),)
    other = [(x, 2 * y, z) for x, y, z in square_points()]

    def wrong(name: str, *expect: Expected, ranks: int = 1, **change: object) -> Case:
        return Case(name, ("objective.desired.run: ", *expect), edits=by_run, verb="optimize", earlier=True, ranks=ranks,
                    prepare=lambda folder: stored_run(folder / "earlier", **change))  # type: ignore[arg-type]

    stored = ("earlier/state.h5", "; ")
    return [
        Case("desired run that is missing", ("objective.desired.run: ", *stored, "no such file"), edits=by_run,
             verb="optimize", earlier=True),
        Case("desired run that is missing, check, two ranks", ("objective.desired.run: ", "no such file"), edits=by_run,
             verb="check", ranks=2),
        edited("desired run that is a number", 'control = ["0", "-1"]', "run = 3", "objective.desired.run: found 3", "a text",
               at="desired ="),
        edited("desired run and control", 'control = ["0", "-1"]', 'control = ["0", "-1"], run = "earlier"',
               "objective.desired: found control, run", "give one of", at="desired ="),
        Case("desired run that is text", ("objective.desired.run: ", *stored, "damaged"), edits=by_run, verb="optimize",
             prepare=lambda folder: write(folder / "earlier" / "state.h5", "fields") if not (folder / "earlier").mkdir() else None),
        wrong("desired run cut short", *stored, "damaged", cut=2000),
        wrong("desired run cut short, two ranks", *stored, "damaged", cut=2000, ranks=2),
        wrong("desired run without displacement", *stored, 'no field "displacement"', "output.fields", field="velocity"),
        wrong("desired run that ends early", *stored, "from 0 to 0.0001 s", "0.00015 s", times=(0.0, 1e-4)),
        wrong("desired run that starts late", *stored, "from 5e-05 to 0.00015 s", times=(5e-5, 1.5e-4)),
        wrong("desired run of another mesh", *stored, "no point at (", points=other),
        wrong("desired run of another mesh, three ranks", *stored, "no point at (", points=other, ranks=3),
        wrong("desired run of a larger mesh", *stored, "12 nodes in 2 dimensions", "9 nodes in 2",
              points=[*square_points(), (2.0, 0.0, 0.0), (2.0, 1.0, 0.0), (2.0, 0.5, 0.0)]),
        wrong("desired run in space", *stored, "9 nodes in 3 dimensions", "9 nodes in 2", dim=3),
        wrong("desired run with two nodes in one place", *stored, "two points at (-0.5, 0)",
              points=[square_points()[0], *square_points()[:-1]]),
        wrong("desired run with a value that is no number", *stored, '"displacement" at 0.00015 s is damaged', value=float("nan")),
        wrong("desired run with a value that is no number, two ranks", "is damaged", value=float("inf"), ranks=2),
        *(wrong(f"desired run that lists its times {how}", *stored, "damaged", listed=listed)
          for how, listed in (("backwards", (1.5e-4, 0.0)), ("with one missing", (0.0,)), ("as no numbers", (0.0, float("nan"))))),
        Case("desired run of degree 2", ("objective.desired.run: ", "mesh.degree = 2", "set it to 1"),
             edits=(*by_run, ("[time]", "degree = 2\n\n[time]")), verb="optimize"),
        Case("desired run in the way", ("--out: ", "objective.desired.run", "choose another folder"), edits=(
            ('desired = { control = ["0", "-1"] }', 'desired = { run = "results" }'),), verb="optimize", earlier=True),
    ]


def first_guess_cases() -> list[Case]:
    """First guesses that no earlier run left."""
    by_run = (("scale = 1e6", 'scale = 1e6\ninitial = { run = "earlier" }'),)

    def left(*files: str) -> Callable[[Path], None]:
        def make(folder: Path) -> None:
            (folder / "earlier").mkdir()
            for file in files:
                write(folder / "earlier" / file, "nothing of ours")

        return make

    neither = ("control.initial.run: ", "earlier has no control.h5 of its run, and there is no checkpoint.h5")
    return [
        Case("first guess of a run that is missing", neither, edits=by_run, earlier=True),
        Case("first guess of a run that is missing, two ranks", neither, edits=by_run, ranks=2),
        Case("first guess of a run without control", neither, edits=by_run, verb="optimize", prepare=left("scene.toml", "run.json")),
        Case("first guess of a damaged checkpoint", ("control.initial.run: ", "earlier/checkpoint.h5", "damaged"), edits=by_run,
             prepare=left("checkpoint.h5")),
        Case("first guess of a damaged checkpoint, two ranks", ("control.initial.run: ", "earlier/checkpoint.h5", "damaged"),
             edits=by_run, prepare=left("checkpoint.h5"), ranks=2),
        Case("first guess of a run with no scene", ("control.initial.run: ", "scene.toml: found no time.step"), edits=by_run,
             prepare=left("control.h5", "scene.toml")),
        edited("first guess of a run that is a number", "scale = 1e6", "scale = 1e6\ninitial = { run = 3 }",
               "control.initial.run: found 3", "a text", at="initial ="),
        edited("first guess by an unknown key", "scale = 1e6", 'scale = 1e6\ninitial = { runn = "earlier" }', "control.initial.runn: unknown",
               'mean "run"?', at="initial ="),
        edited("first guess in the way", "scale = 1e6", 'scale = 1e6\ninitial = { run = "results" }', "--out: ", "control.initial.run",
               "choose another", at="", earlier=True),
    ]


def folder_cases() -> list[Case]:
    """Folders that cannot take results."""
    return [
        Case("file in the way", ("--out: results cannot be written", "choose another folder"), prepare=lambda folder: write(
            folder / "results", "a file")),
        Case("file in the way, two ranks", ("--out: results cannot be written", "choose another folder"), ranks=2,
             prepare=lambda folder: write(folder / "results", "a file")),
        Case("file in the way of the parent", ("--out: scene.toml/results cannot be written",), out="scene.toml/results"),
        Case("mesh as the folder", ("--out: square.msh cannot be written",), out="square.msh", verb="optimize"),
        Case("folder in /proc", ("--out: /proc/signorini cannot be written",), out="/proc/signorini"),
        Case("folder that is read only", ("--out: /proc/self/task cannot be written",), out="/proc/self/task"),
        Case("device as the folder", ("--out: /dev/full cannot be written",), out="/dev/full"),
        Case("link to nowhere", ("--out: results cannot be written",), prepare=lambda folder: (
            folder / "results").symlink_to("nowhere/else")),
        Case("folder in place of state.h5", ("--out: results/state.h5 is a folder", "choose another folder"), earlier=True,
             prepare=lambda folder: occupy(folder / "results" / "state.h5")),
        Case("folder in place of run.json", ("--out: results/run.json is a folder", "choose another folder"), earlier=True,
             prepare=lambda folder: occupy(folder / "results" / "run.json")),
        Case("full disk, small files", ("results/", "cannot be written", "File too large"), largest_file=1500,
             earlier=True),
        Case("full disk, fields", ("results/state.", "cannot be written", "File too large"), largest_file=6000,
             earlier=True),
        Case("full disk, fields, first run", ("results/state.", "cannot be written", "File too large"),
             largest_file=6000),
        Case("full disk, control", ("results/", "cannot be written", "File too large"), largest_file=1500, options=("--set", "optimizer.checkpoint=0", "--set", 'output.tables=["steps"]'),
             verb="optimize", earlier=True),
    ]


def all_cases() -> list[Case]:
    """Every case, theme by theme."""
    return [
        *scene_file_cases(),
        *key_cases(),
        *type_cases(),
        *range_cases(),
        *dimension_cases(),
        *obstacle_cases(),
        *expression_cases(),
        *time_series_cases(),
        *effect_cases(),
        *later_cases(),
        *material_cases(),
        *option_cases(),
        *mesh_file_cases(),
        *mesh_content_cases(),
        *space_cases(),
        *desired_run_cases(),
        *first_guess_cases(),
        *folder_cases(),
    ]
