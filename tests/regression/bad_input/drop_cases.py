# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies that cannot be dropped, bounces without end, and bad accelerations of probes."""

from case import Case, Expected, edited



def dropped(name: str, *expect: Expected, drop: str = "{ height = 1.0 }", gravity: str = "[0, -9.81]", clamp: bool = False,
            edits: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
    """A body without clamps that is dropped."""
    held = () if clamp else (('[[clamp]]\non = "top"\n', ""),)
    falls = (('body = ["0", "-9.81"]', f"gravity = {gravity}" if gravity else ""),
             ('displacement = ["0", "0"]\nvelocity = ["0", "0"]\n', f"drop = {drop}\n"))  # fmt: skip
    return Case(name, expect, edits=(*edits, *held, *falls), **more)


def drop_cases() -> list[Case]:
    """Drops, ends and probes."""
    drop = "initial.drop: "
    auto = (("end = 1.5e-4", 'end = "auto"'),)
    uncontrolled = ((text, "") for text in (
        '[control]\nscale = 1e6\nlower = -2.0\nupper = 2.0\n', '[objective]\ndesired = { control = ["0", "-1"] }\nalpha = 1e-2\ngamma = 7.5e-4\n',
        "[optimizer]\nmax_iterations = 1\ntolerance = 1e-6\n"))  # fmt: skip
    free = (*auto, *uncontrolled)
    probe = 'every = 1\n[[output.probe]]\n'
    return [
        dropped("drop of nothing", "initial.drop.height: missing", drop="{ }"),
        dropped("drop from below", "initial.drop.height: found 0; expected a number greater than 0", drop="{ height = 0 }"),
        dropped("height in words", 'initial.drop.height: found "high"', drop='{ height = "high" }'),
        dropped("drop without gravity", drop + "needs the acceleration of its fall; give load.gravity", gravity="", edits=(("[load]\n", ""),)),
        dropped("drop in no gravity", drop + "needs the acceleration of its fall", gravity="[0, 0]"),
        dropped("drop in gravity that cancels", drop + "found with a load.gravity of 0", gravity='["0", "1 - 1"]'),
        dropped("gravity that changes", drop + "found with a load.gravity that contains t", gravity='["0", "-9.81*t"]'),
        dropped("drop of a held body", drop + "found with a clamp", clamp=True),
        dropped("drop and velocity", drop + "found together with initial.velocity", drop='{ height = 1.0 }\nvelocity = ["0", "-1"]'),
        dropped("drop and equilibrium", drop + "found together with initial.static", drop="{ height = 1.0 }\nstatic = true"),
        dropped("drop onto nothing", drop + "has no meaning without contact",
                edits=(('[contact]\non = "bottom"\nobstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }\n', ""),)),
        dropped("drop away from the floor", drop + "no node of contact.on is above an obstacle along load.gravity", gravity="[0, 9.81]"),
        dropped("drop away from the floor, two ranks", drop + "no node of contact.on is above an obstacle", gravity="[0, 9.81]", ranks=2),
        dropped("unknown gravity of a drop", 'unknown[0].of: found "load.gravity" with initial.drop',
                edits=(("every = 1", 'every = 1\n[[unknown]]\nof = "load.gravity"\n[[measurement]]\nof = "force"\ncomponent = "y"\n'
                        'file = "force.csv"\nnoise = 0.1'),)),
        edited("end that nothing sets", "end = 1.5e-4", 'end = "auto"', 'time.end: found "auto" without initial.drop', at=""),
        edited("end that does not exist", "end = 1.5e-4", 'end = "never"', 'time.end: found "never"; expected a number greater than 0'),
        dropped("end and steps", 'time.end: found "auto" together with time.step = "auto"', edits=auto, options=("--set", "time.step=auto")),
        dropped("end of a controlled drop", 'time.end: found "auto" with control', edits=auto),
        dropped("bounce of too many steps", "time.step: found 1e-12 s, which gives", "steps of a bounce at most",
                edits=free, options=("--set", "time.step=1e-12")),
        *(dropped(f"end of a bounce in {verb}", f'time.end: found "auto", which {verb} does not accept', edits=free, verb=verb)
          for verb in ("study",)),
        dropped("accuracy of a bounce", 'time.end: found "auto", which --accuracy does not accept', edits=free, options=("--accuracy", "1e-2", "--quantity", "impulse")),
        edited("acceleration of no mass", "every = 1", probe + 'obstacle = "obstacle 1"\nacceleration = true',
               'output.probe[0].obstacle: found "obstacle 1", which does not move freely', at=""),
        edited("acceleration without mass", 'normal = [0, 1] }', "normal = [0, 1], mass = 0, stiffness = 1.0 }",
               'output.probe[0].acceleration: has no meaning for "obstacle 1", whose mass is 0', at="",
               options=("--set", 'output.probe=[{obstacle="obstacle 1", acceleration=true}]')),
        edited("acceleration in words", "every = 1", probe + 'body = true\nacceleration = "yes"', 'output.probe[0].acceleration: found "yes"',
               at='acceleration = "yes"'),
        edited("filter of a displacement", "every = 1", probe + "body = true\nfilter = { cfc = 60 }",
               "output.probe[0].filter: has no effect on displacements", at="filter ="),
        edited("filter of long steps", "every = 1", probe + 'obstacle = "obstacle 1"\nfilter = { cfc = 6000 }',
               "output.probe[0].filter: found CFC 6000, which needs samples at least every 1.67e-05 s", at="filter ="),
        edited("filter of steps that vary", "every = 1", probe + 'obstacle = "obstacle 1"\nfilter = { cfc = 60 }',
               'output.probe[0].filter: found with time.step = "auto"', at="filter =", options=("--set", "time.step=auto")),
        edited("filter without a class", "every = 1", probe + 'obstacle = "obstacle 1"\nfilter = { cfc = 0 }',
               "output.probe[0].filter.cfc: found 0; expected a number greater than 0", at="filter ="),
    ]  # fmt: skip
