# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad unknowns and measurements."""

from pathlib import Path

from case import Case, Expected, GEO, typed, write


def fit_cases() -> list[Case]:
    """Unknowns and measurements that a scene cannot have."""
    objective = '[objective]\ndesired = { control = ["0", "-1"] }\n\n[output]'
    no_objective = ('[objective]\ndesired = { control = ["0", "-1"] }\nalpha = 1e-2\ngamma = 7.5e-4\n', "")

    def fit(name: str, unknown: str, measurement: str, *expect: Expected, edits: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
        tables = f"[[unknown]]\n{unknown}\n" if unknown else ""
        tables += f"[[measurement]]\n{measurement}\n" if measurement else ""
        return Case(name, expect, edits=(("every = 1", f"every = 1\n\n{tables}"), no_objective, *edits), **more)

    def branches(name: str, unknown: str, series: str, *expect: Expected) -> Case:
        """An unknown of a material whose series has branches of these fractions g."""
        tables = ", ".join(f"{{ g = {g}, time = 1e-4 }}" for g in series.split())
        return fit(name, unknown, force, *expect, edits=(("poisson = 0.3", f"poisson = 0.3\nprony = [{tables}]"),))

    force = 'of = "force"\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1'

    def rubbing(name: str, unknown: str, *expect: Expected, friction: str = "0.3") -> Case:
        """An unknown of a scene with friction."""
        return fit(name, unknown, force, *expect, edits=(("[contact]", f"[contact]\nfriction = {friction}"),))

    def hit(name: str, unknown: str, keys: str, *expect: Expected, measured: str = force, **more: object) -> Case:
        """An unknown of an obstacle with more keys."""
        return fit(name, unknown, measured, *expect, edits=(("normal = [0, 1] }", f"normal = [0, 1], {keys} }}"),), **more)

    motion = 'of = "displacement"\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1\nobstacle = "obstacle 1"'

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
        measurement("accuracy of a fit", force, "--accuracy: has no effect on a fit, which has tables [[unknown]]", "optimizer.tolerance",
                    verb="optimize",
                    options=("--accuracy", "1e-2")),
        *(fit(f"sizes chosen for {verb} of a fit", 'of = "young"', force,
              'mesh.size: "auto" cannot be combined with [[unknown]]; give a size in m, such as --set mesh.size=0.1',
              edits=(('file = "square.msh"', 'file = "square.geo"\nsize = "auto"'),), mesh=GEO, mesh_file="square.geo", verb=verb)
          for verb in ("optimize", "check")),
        unknown("mass of an obstacle without any", 'of = "mass"', 'unknown[0].of: found "mass" of an obstacle without mass; give obstacle.mass'),
        hit("springs of an obstacle without any", 'of = "stiffness"', "mass = 1", 'unknown[0].of: found "stiffness" of an obstacle without it'),
        hit("velocity without a component", 'of = "velocity"', "mass = 1, velocity = [0, 1]", "unknown[0].component: missing"),
        hit("velocity in space of an unknown", 'of = "velocity"\ncomponent = "z"', "mass = 1, velocity = [0, 1]",
            'unknown[0].component: found "z", but obstacle.velocity has 2 components'),
        hit("velocity that is held", 'of = "velocity"\ncomponent = "x"', 'mass = 1, velocity = [0, 1], components = ["y"]',
            'unknown[0].component: found "x", along which the obstacle does not move'),
        hit("component of a mass", 'of = "mass"\ncomponent = "x"', "mass = 1", "unknown[0].component: has no effect on one number"),
        hit("mass that starts at 0", 'of = "mass"', "mass = 0, stiffness = 5.0", "unknown[0].start: found 0; expected a number greater than 0"),
        hit("negative mass of an unknown", 'of = "mass"\nstart = -1.0', "mass = 1", "unknown[0].start: found -1; expected a number greater than 0"),
        hit("springs without mass that may vanish", 'of = "stiffness"\nscale = "linear"', "mass = 0, stiffness = 5.0",
            'unknown[0].scale: found "linear" for the stiffness of an obstacle with mass 0'),
        hit("two unknowns of one mass", 'of = "mass"\n[[unknown]]\nof = "mass"\nname = "other"', "mass = 1",
            'unknown[1].of: found "mass", which unknown[0] fits too'),
        measurement("motion of an obstacle without mass", motion, 'measurement[0].obstacle: found "obstacle 1", which does not move freely'),
        hit("motion of an obstacle and a point", 'of = "mass"', "mass = 1", "measurement[0]: found several; give one of point, on, obstacle",
            measured=motion + "\npoint = [0, 0]"),
        unknown("unknown of nothing", 'name = "a"', "unknown[0].of: missing"),
        unknown("unknown that is not there", 'of = "yuong"', 'unknown[0].of: found "yuong"', "young"),
        unknown("unknown with a number for a name", 'of = "young"\nname = 1', "unknown[0].name: found 1"),
        unknown("unknown on a group where there is one material", 'of = "young"\non = "body"', "unknown[0].on: has no effect"),
        unknown("springs of a scene without any", 'of = "stiffness.normal"', 'unknown[0].of: found "stiffness.normal"',
                "without [[foundation]]"),
        unknown("Rayleigh damping of a material without it", 'of = "rayleigh.beta"', 'unknown[0].of: found "rayleigh.beta"',
                "without rayleigh"),
        unknown("fraction of a material without a series", 'of = "prony.g"', 'unknown[0].of: found "prony.g"',
                "of a material without prony"),
        unknown("branch of a modulus", 'of = "young"\nbranch = 0', "unknown[0].branch: has an effect only on parameters of a Prony series"),
        branches("fraction of one of several branches", 'of = "prony.g"', "0.1 0.2", "unknown[0].branch: missing"),
        branches("fraction beyond the branches", 'of = "prony.g"\nbranch = 2', "0.1 0.2",
                 "unknown[0].branch: found 2; expected 0 to 1, since the material has 2 branches"),
        branches("fraction beyond the only branch", 'of = "prony.g"\nbranch = 1', "0.1", "unknown[0].branch: found 1; expected 0,"),
        branches("branch below zero", 'of = "prony.g"\nbranch = -1', "0.1 0.2", "unknown[0].branch: found -1", "a whole number"),
        branches("one branch twice", 'of = "prony.time"\n[[unknown]]\nof = "prony.time"\nbranch = 0\nname = "t"', "0.1",
                 'unknown[1].of: found "prony.time"', "unknown[0] fits too"),
        branches("fraction of more than all", 'of = "prony.g"\nbranch = 0\nstart = 1.5', "0.1 0.2", "unknown[0].start: found 1.5",
                 "at most 1"),
        branches("fractions that start above one together", 'of = "prony.g"\nbranch = 0\nstart = 0.9', "0.1 0.2",
                 "unknown: found start values of material.prony with fractions g that add up to 1.1", "expected a sum below 0.9999"),
        branches("relaxation time of zero", 'of = "prony.time"\nlower = 0.0', "0.1", "unknown[0].lower: found 0", "greater than 0"),
        branches("fraction of zero on a logarithmic scale", 'of = "prony.k"\nscale = "log"', "0.1", "unknown[0].start: found 0",
                 "greater than 0"),
        fit("dashpots of a foundation of springs", 'of = "damping.normal"', force, 'unknown[0].of: found "damping.normal"',
            "of a foundation without damping",
            edits=(("[initial]", '[[foundation]]\non = "side"\nstiffness = { normal = 1.0 }\n[initial]'),)),
        unknown("unknown of no obstacle", 'of = "position"\nobstacle = "wall"', 'unknown[0].obstacle: found "wall"', "obstacle 1"),
        unknown("radius of a half-space", 'of = "radius"', 'unknown[0].of: found "radius"', "position, angle"),
        unknown("friction of an obstacle without it", 'of = "friction"',
                'unknown[0].of: found "friction" of an obstacle without friction; give contact.friction'),
        unknown("surface velocity of an obstacle without friction", 'of = "surface_velocity"',
                'unknown[0].of: found "surface_velocity" of an obstacle without friction; give contact.friction'),
        rubbing("surface velocity of an obstacle without one", 'of = "surface_velocity"',
                'unknown[0].of: found "surface_velocity" of an obstacle without one; give obstacle.surface_velocity'),
        fit("place of an obstacle that turns about it", 'of = "position"', force,
            'unknown[0].of: found "position" of an obstacle that turns about this point; give obstacle.mass_center',
            edits=(("normal = [0, 1] }", "normal = [0, 1], mass = 1.0, inertia = 1.0 }"),)),
        rubbing("angle of a plane with friction", 'of = "angle"',
                'unknown[0].of: found "angle" of an obstacle of the shape "half-space" with friction;',
                "choices: position, friction, surface_velocity"),
        rubbing("friction that starts at zero", 'of = "friction"\nstart = 0.0', "unknown[0].start: found 0", "greater than 0"),
        rubbing("friction from zero", 'of = "friction"\nlower = 0.0', "unknown[0].lower: found 0", "greater than 0"),
        rubbing("friction along x", 'of = "friction"\ncomponent = "x"', "unknown[0].component: has no effect"),
        rubbing("friction that varies", 'of = "friction"', "unknown[0].start: missing", friction='"0.3 + 0.1*t"'),
        fit("modulus of a body that starts in equilibrium", 'of = "young"', force,
            'unknown[0].of: found "young" with initial.static, whose equilibrium would depend on the unknown; remove initial.static',
            edits=(('displacement = ["0", "0"]', "static = true"),)),
        unknown("component of a modulus", 'of = "young"\ncomponent = "x"', "unknown[0].component: has no effect"),
        unknown("angle about an axis in the plane", 'of = "angle"\ncomponent = "x"', "unknown[0].component: found x", "2-dimensional"),
        unknown("modulus that starts at zero", 'of = "young"\nstart = 0.0', "unknown[0].start: found 0", "greater than 0"),
        unknown("start below the bounds", 'of = "young"\nstart = 1.0\nlower = 2.0', "unknown[0].start: found 1", "within the bounds"),
        unknown("lower bound of a ratio", 'of = "poisson"\nlower = -2.0', "unknown[0].lower: found -2", "greater than -1"),
        unknown("upper bound of a ratio", 'of = "poisson"\nupper = 0.5', "unknown[0].upper: found 0.5", "less than 0.5"),
        unknown("scale that is none", 'of = "young"\nscale = "square"', 'unknown[0].scale: found "square"', "linear, log"),
        unknown("prior without a mean", 'of = "young"\nprior = { deviation = 0.1 }', "unknown[0].prior.mean: missing"),
        unknown("prior with a text for a mean", 'of = "young"\nprior = { mean = "a", deviation = 0.1 }',
                'unknown[0].prior.mean: found "a"'),
        unknown("prior as sharp as a point", 'of = "young"\nprior = { mean = 1e8, deviation = 0 }', "unknown[0].prior.deviation: found 0"),
        unknown("weight of a scene without any", 'of = "load.gravity"', 'unknown[0].of: found "load.gravity"', "without"),
        unknown("unknown twice", 'of = "young"\n[[unknown]]\nof = "young"\nname = "E"', 'unknown[1].of: found "young"',
                "unknown[0] fits too"),
        unknown("factor and component of one field", 'of = "initial.velocity"\n[[unknown]]\nof = "initial.velocity"\ncomponent = "y"',
                'unknown[1].of: found "initial.velocity"', "unknown[0] fits too"),
        unknown("unknown along z in the plane", 'of = "initial.velocity"\ncomponent = "z"', 'unknown[0].component: found "z"',
                "2 components"),
        unknown("unknown called like a column", 'of = "young"\nname = "damping"', 'unknown[0].name: found "damping"', "history.csv"),
        fit("memory of a fit", 'of = "young"', force, "optimizer.memory: has no effect on a fit",
            edits=(("max_iterations = 1", "memory = 1e8"),)),
        fit("unknown without data", 'of = "young"', "", "unknown: needs data to fit", "[[measurement]]"),
        fit("lbfgs for a fit", 'of = "young"', force, 'optimizer.method: found "lbfgs"', "gauss-newton",
            edits=(("max_iterations = 1", 'method = "lbfgs"\nmax_iterations = 1'),)),
        fit("gauss-newton for a control", 'of = "young"', force, 'optimizer.method: found "gauss-newton"', "lbfgs",
            edits=(("[output]", objective), ("max_iterations = 1", 'method = "gauss-newton"\nmax_iterations = 1'))),
        measurement("measurement of nothing", 'name = "a"', "measurement[0].of: missing"),
        measurement("measurement that is none", 'of = "weight"', 'measurement[0].of: found "weight"', "displacement"),
        measurement("measurement with a number for a name", force + "\nname = 1", "measurement[0].name: found 1"),
        measurement("displacement of nowhere", 'of = "displacement"', "measurement[0]: found none", "point, on, obstacle"),
        measurement("displacement outside of the body",
                    'of = "displacement"\npoint = [0, 9]\ncomponent = "y"\nfile = "force.csv"\nnoise = 0.1',
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
        measurement("noise beside a deviation", force + "\ndeviation = 1.0", "measurement[0].noise: found together with deviation"),
        data("data that are not there", None, "force.csv", "simulate --measure"),
        data("data without values", "time,force\n0,1\n1e-4,2\n", 'found no column "value"', "time, force"),
        data("data after the end", "time,value\n0,1\n1e-3,2\n", "found the time 0.001 s", "0 to 0.00015 s"),
        data("data with decimal commas between commas", "time,value\n0,0\n1e-4,-1,5\n", "force.csv: line 3: found 3 cells below 2 column names"),
        data("data with thousands separators", 'time,value\n0,0\n1e-4,"-1,000"\n', '"-1,000" in column 2'),
        data("data with a column twice", "time,value,value\n0,0,1\n1e-4,1,1\n", 'found "value" in column 2 and "value" in column 3'),
        data("data in the unit of another quantity", "time,value [m/s]\n0,0\n1e-4,1\n", '"value [m/s]"', "cannot be converted to N or N/m"),
        measurement("deviations without a unit beside values with one", 'of = "force"\ncomponent = "y"\nfile = "force.csv"',
                    'measurement[0].file: ', 'found "deviation" without a unit, but "value [kN]" with one', '"deviation [kN]"', verb="optimize",
                    prepare=lambda folder: write(folder / "force.csv", "time,value [kN],deviation\n0,0,1\n1e-4,1,1\n")),
        data("data that are all zero", "time,value\n0,0\n1e-4,0\n",
             "all values are 0, so noise relative to them is undefined; give a deviation"),
        measurement("measuring without a deviation", 'of = "force"\ncomponent = "y"\nfile = "force.csv"',
                    "--measure: measurement[0] has neither",
                    verb="simulate", options=("--measure",)),
        measurement("measuring over a record", force, "--measure: ", "force.csv was not written by simulate --measure", verb="simulate",
                    options=("--measure", "--replace"), prepare=lambda folder: write(folder / "force.csv", "time,value\n0,1\n")),
        measurement("measuring beside a file", force, "--measure: ",
                    "force.csv exists and is not overwritten, since a fit may use it; to overwrite it, add --replace", verb="simulate",
                    options=("--measure",), prepare=lambda folder: write(folder / "force.csv", "time,value\n0,1\n"), ranks=2),
        measurement("measuring into a table of the run", force.replace("force.csv", "results/steps.csv"), "--measure: ",
                    "steps.csv is a file of the run itself", verb="simulate", options=("--measure",)),
        measurement("measuring times", force + '\ncolumn = "time"', "--measure: measurement[0].column", '"time"', verb="simulate",
                    options=("--measure",)),
        typed("seed of nothing", "simulate scene.toml --seed 3", "--seed requires --measure"),
        typed("measuring nothing", "simulate scene.toml --measure", "--measure: the scene measures no values; add a table [[measurement]]"),
    ]
