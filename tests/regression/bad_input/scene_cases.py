# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad scene files: no TOML, unknown keys, values of the wrong type."""

import re

from case import Case, edited, overridden, prepend, typed


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
        edited("rebound wanted", "[contact]\n", "[contact]\nrestitution = 0.3\n",
               "contact.restitution: not in this model: a prescribed coefficient of restitution;",
               "docs/modelling.md", at="restitution = 0.3", never=("unknown", "allowed"), earlier=True),
        edited("large rotation wanted, two ranks", "[output]", "[kinematics]\nlarge = true\n[output]",
               "kinematics: not in this model: large rotations",
               at="[kinematics]", never=("unknown",), ranks=2),
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
        edited("control that changes too fast", "scale = 1e6", 'scale = 1e6\ninitial = ["sin(1e12*t)", "0"]',
               "control.initial: the expression changes too fast to be integrated",
               "Use a slower expression or a time series", at=""),
        edited("one expression for a control", "scale = 1e6", 'scale = 1e6\ninitial = "sin(t)"', "control.initial: found",
               '["0", "0", "sin(t)"] in space', never=("9.81",), at="initial ="),
        edited("table for a list", 'velocity = ["0", "0"]', "velocity = { x = 1 }", "initial.velocity: found",
               "2 in the plane and 3 in space",
               never=("9.81",)),
        edited("text for a bound", "lower = -2.0", 'lower = "-2"', "control.lower: found", "-2", "a number"),
    ]
