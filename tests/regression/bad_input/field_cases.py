# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad expressions, tables over time, loads, controls, objectives and materials."""

import re

from case import Case, edited, Expected, GEO, prepend, square_of_halves, write


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
               "expressions in t only", at="gravity ="),
        edited("gravity as a number", body, "gravity = 9.81", "load.gravity: found 9.81", '["0", 9.81]', at="gravity ="),
        edited("gravity that is not finite", body, 'gravity = ["0", "1/(t > 1e-4 ? 0 : 1)"]', "load.gravity: ", "is inf", at="",
               ranks=2),
        edited("initial displacement of a clamp", start, 'displacement = ["0", "1e-3"]', "initial.displacement",
               "found values that differ by 0.001", "clamp", "make them equal", at="", earlier=True),
        edited("initial displacement of a clamp, two ranks", start, 'displacement = ["0", "1e-3"]',
               "initial.displacement", "found values that differ by 0.001", "clamp", at="", ranks=2),
        edited("initial velocity of a clamp", 'velocity = ["0", "0"]', 'velocity = ["0", "-10"]', "initial.velocity",
               "found values that differ by 10", "clamp", "make them equal", at=""),
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
        wrong("series with decimal commas between commas", "line 3: found 4 cells below 2 column names", "decimal point",
              text="time,force\n0,0\n1,0,-1,5\n"),
        wrong("series with decimal commas between commas, two ranks", "line 3: found 4 cells below 2 column names",
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
           "expressions of position only", at="velocity ="),
        at("series for a control constant in time", "scale = 1e6", "scale = 1e6\nconstant_in_time = true\ninitial = [0, SERIES]",
           "control.initial: found", "expressions of position only", at="initial = [0"),
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
        edited("clamp of no component", 'on = "top"', 'on = "top"\ncomponents = []', "clamp[0].components: ",
               'found []; expected at least one component, such as ["y"]',
               at="components ="),
        edited("clamp of z in the plane", 'on = "top"', 'on = "top"\ncomponents = ["z"]', 'clamp.components: found "z"',
               "choices: x, y", "2-dimensional", at=""),
        edited("motion of three components of the second clamp", '[[clamp]]\non = "top"', '[[clamp]]\non = "top"\n\n[[clamp]]\n'
               'on = "side"\nvalue = ["0", "0", "t"]', "clamp[1].value: found 3 components", "expected 2", at=""),
        edited("motion of one component, two values", 'on = "top"', 'on = "top"\ncomponents = ["y"]\nvalue = ["0", "t"]',
               "clamp[0].value: ",
               "1 expression", at="value ="),
        edited("motion that is not finite", 'on = "top"', 'on = "top"\nvalue = ["0", "1/t"]', "clamp.value: ", '"1/t" is inf', at=""),
        edited("start off a moving clamp", 'on = "top"', 'on = "top"\nvalue = ["0", "1e-3 + t"]', "initial.displacement: ", "0.001",
               "clamps",
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
        Case("reference control of a component left out",
             ('objective.desired.control: found "-1" for y, which control.components leaves out; set it to "0"',),
             edits=(("scale = 1e6", 'scale = 1e6\ncomponents = ["x"]'),), at="desired ="),
        edited("first guess of a component left out", "scale = 1e6", 'scale = 1e6\ncomponents = ["y"]\ninitial = ["t", "0"]',
               'control.initial: found "t" for x', 'set it to "0"', at="initial ="),
        Case("check at a component left out", ('check.control: found "x" for x, which control.components leaves out; set it to "0"',),
             at='control = ["x"', edits=(
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
        edited("nothing desired", "gamma = 7.5e-4", "tracking = 0.0\ngamma = 0.0",
               "objective.tracking: found 0, and gamma is 0 too; set at least one of them above 0",
               at="tracking ="),
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
