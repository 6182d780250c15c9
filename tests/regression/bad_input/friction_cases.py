# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad coefficients of friction, surface velocities and static starts, and what cannot be combined with friction."""

from case import Case, Expected, edited

PLANE = '{ shape = "half-space", point = [0, -0.1], normal = [0, 1] }'
BELT = PLANE.replace(" }", ', surface_velocity = ["1", "0"] }')
RUBS = "friction = 0.3\n"


def contact(name: str, keys: str, *expect: Expected, **more: object) -> Case:
    """A contact with more keys; the message must name the line of the first of them."""
    more.setdefault("at", keys.splitlines()[0])
    return edited(name, "[contact]\n", f"[contact]\n{keys}\n", *expect, **more)


def obstacle(name: str, text: str, *expect: Expected, friction: str = RUBS, **more: object) -> Case:
    """Another obstacle, with friction."""
    more.setdefault("at", "obstacle =")
    return edited(name, f"obstacle = {PLANE}", f"{friction}obstacle = {text}", *expect, **more)


def belt(name: str, velocity: str, *expect: Expected, **more: object) -> Case:
    """An obstacle whose surface moves."""
    return obstacle(name, BELT.replace('["1", "0"]', velocity), *expect, **more)


def friction_cases() -> list[Case]:
    """Friction that cannot be, or not there."""
    no_estimate = "cannot be combined with contact.friction, since the error estimate does not include slip"
    velocity = "contact.obstacle.surface_velocity: "
    both = (("[contact]", "[[contact]]"), (f"obstacle = {PLANE}", f'{RUBS}obstacle = {PLANE}\n[[contact]]\non = "side"\nobstacle = '
                                          '{ shape = "half-space", point = [-0.6, 0], normal = [1, 0] }'))  # fmt: skip
    fixed = ('[[clamp]]\non = "top"', '[[clamp]]\non = "top"\n[[clamp]]\non = "side"\ncomponents = ["x"]')
    tilted = (f"obstacle = {PLANE}", f"{RUBS}obstacle = {PLANE.replace('[0, -0.1], normal = [0, 1]', '[0, -0.4], normal = [0.1, 1]')}")
    several = "contact[0].friction: the node at (-0.5, 0, 0) is a candidate of several obstacles, where friction is not possible"
    held = "contact.friction: a clamp holds the node at (-0.5, 0, 0) along a part of the obstacle's tangent"
    return [
        contact("negative friction", "friction = -0.3", "contact.friction: found -0.3; expected a number of at least 0"),
        contact("truth for friction", "friction = true", "contact.friction: found true", "a number"),
        contact("friction without end", "friction = inf", "contact.friction: found inf", "finite"),
        contact("friction that cannot be read", 'friction = "0.3 +"', "contact.friction: ", '"0.3 +"', "x, y, z, t"),
        contact("friction that becomes negative along the body", 'friction = "0.3 - x"',
                "contact.friction: found -0.2 at the node at (0.5, 0, 0) and t = 0 s; a coefficient of friction must be at least 0", at=""),
        contact("friction that becomes negative, two ranks", 'friction = "0.3 - x"',
                "contact.friction: found -0.2 at the node at (0.5, 0, 0)", at="", ranks=2),
        contact("friction that becomes negative later", 'friction = "0.3 - t/3e-4"',
                "contact.friction: found -0.0333333 at the node at (-0.5, 0, 0) and t = 0.0001 s", "at least 0", at="", earlier=True),
        contact("friction that leaves the finite", 'friction = "0.1/(y + 0)"', "contact.friction: ", "y = 0", "finite", at=""),
        contact("negative bound", 'friction = { bound = -1.0 }', "contact.friction.bound: found -1", "expected a number of at least 0"),
        contact("bound without end", "friction = { bound = inf }", "contact.friction.bound: found inf", "finite"),
        contact("truth for a bound", "friction = { bound = true }", "contact.friction.bound: found true", "a number"),
        contact("bound that cannot be read", 'friction = { bound = "2e5 +" }', "contact.friction.bound: ", '"2e5 +"', "x, y, z, t"),
        contact("bound that becomes negative along the body", 'friction = { bound = "1e5*(0.3 - x)" }',
                "contact.friction.bound: found -20000 at the node at (0.5, 0, 0) and t = 0 s; a bound of friction must be at least 0", at=""),
        contact("bound that becomes negative, two ranks", 'friction = { bound = "1e5*(0.3 - x)" }',
                "contact.friction.bound: found -20000 at the node at (0.5, 0, 0)", at="", ranks=2),
        contact("bound that becomes negative later", 'friction = { bound = "0.3 - t/3e-4" }',
                "contact.friction.bound: found -0.0333333 at the node at (-0.5, 0, 0) and t = 0.0001 s", "at least 0", at="", earlier=True),
        contact("bound that leaves the finite", 'friction = { bound = "0.1/(y + 0)" }', "contact.friction.bound: ", "y = 0", "finite", at=""),
        contact("no bound", "friction = {}", "contact.friction.bound: missing"),
        contact("key beside the bound", "friction = { bound = 2e5, limit = 2e5 }", "contact.friction.limit: unknown key", "keys here: bound"),
        contact("coefficient beside the bound", "friction = { bound = 2e5, coefficient = 0.3 }",
                "contact.friction.coefficient: unknown; give Coulomb friction as contact.friction"),
        contact("bound as a stress", "friction = { stress = 2e5 }", "contact.friction.stress: unknown; give Tresca friction as",
                'contact.friction = { bound = "2e5" }'),
        contact("bound beside the friction", "bound = 2e5", "contact.bound: unknown; give Tresca friction as"),
        contact("friction by law", 'law = "Tresca"', "contact.law: unknown; give Tresca friction as", "in Pa", never=("not in",)),
        contact("two coefficients", "friction = { static = 0.4, kinetic = 0.3 }",
                ": unknown; give Coulomb friction as contact.friction, one coefficient for stick and slip"),
        contact("friction by its letter", "mu = 0.3", "contact.mu: unknown; give Coulomb friction as contact.friction", never=("not in",)),
        edited("friction of the material", "poisson = 0.3", "poisson = 0.3\nfriction = 0.3",
               "material.friction: unknown; give Coulomb friction as contact.friction", at="friction = 0.3"),
        obstacle("speed of a roller", PLANE.replace(" }", ", omega = 3.0 }"),
                 "contact.obstacle.omega: unknown; give the motion of a belt or of a roller's surface as",
                 "contact.obstacle.surface_velocity"),
        obstacle("belt without friction", BELT, velocity + "has no effect without friction; give contact.friction", friction=""),
        belt("belt of one component", '["1"]', velocity + 'found ["1"]', "2 in the plane and 3 in space"),
        belt("belt in space", '["1", "0", "0"]', velocity + "found 3 components; expected 2", at=""),
        belt("belt in space, two ranks", '["1", "0", "0"]', velocity + "found 3 components; expected 2", at="", ranks=2),
        belt("number for a belt", "1.0", velocity + "found 1.0", 'such as ["0", 1.0] in the plane'),
        belt("belt that cannot be read", '["1 +", "0"]', velocity, '"1 +"', "x, y, z, t"),
        belt("belt that leaves the finite", '["1/x", "0"]', velocity, '"1/x"', "x = 0", "finite", at=""),
        contact("friction in steps that the motion chooses", RUBS, 'contact.friction: found together with time.step = "auto"',
                "do not include slip; give a step length", at="friction =", options=("--set", "time.step=auto"), verb="info"),
        obstacle("friction with a distance that moves", '{ shape = "signed-distance", distance = "y + 0.1 - t" }',
                 "contact.friction: found with a signed distance that moves, whose motion along the surface is not defined",
                 at="friction ="),
        Case("friction at a corner", (several, "choose groups without common nodes"), edits=both),
        Case("friction at a corner, three ranks", (several,), edits=both, ranks=3),
        Case("friction across a clamp", (held, "clamp the whole node, or end the group before it"), edits=(fixed, tilted)),
        Case("friction across a clamp, two ranks", (held,), edits=(fixed, tilted), ranks=2),
        contact("bound in steps that the motion chooses", "friction = { bound = 2e5 }", 'contact.friction: found together with time.step = "auto"',
                at="friction =", options=("--set", "time.step=auto"), verb="info"),
        contact("friction in the full inequality", RUBS, 'solver.vi: found "full" with contact.friction', 'use "condensed"', at="",
                options=("--set", "solver.vi=full")),
        edited("traction of friction without friction", "every = 1", 'every = 1\nfields = ["friction"]',
               'output.fields: found "friction", which has no meaning without friction; give contact.friction above 0', at="fields ="),
        edited("static start beside a displacement", 'velocity = ["0", "0"]', "static = true",
               "initial.static: found together with initial.displacement, which it replaces; remove one of them"),
        edited("number for a static start", 'displacement = ["0", "0"]', "static = 1", "initial.static: found 1; expected true or false"),
        Case("static start of what turns", ("initial.static: found loads at t = 0 under which the body turns or leaves its supports",),
             edits=(('displacement = ["0", "0"]', "static = true"), ('[[clamp]]\non = "top"\n', ""),
                    ('body = ["0", "-9.81"]', 'body = ["y - 0.5", "0"]'))),
        *(contact(f"{what} with friction", RUBS, f"{option}: {no_estimate}", instead, at="", verb=verb, options=(option, *more))
          for what, option, instead, verb, more in (
            ("accuracy of an optimum", "--accuracy", "compare sizes and steps by study", "optimize", ("1e-2",)),
            ("graded meshes", "--graded", "leave it out", "study", ()),
            ("suggestion", "--suggest", "choose another --quantity", "study", ("1e-2",)))),
        Case("sizes chosen with friction", (f'--accuracy with mesh.size = "auto": {no_estimate}', "give mesh.size"),
             edits=(("[contact]\n", f"[contact]\n{RUBS}"), ('file = "square.msh"', 'file = "square.geo"\nsize = "auto"')),
             mesh_file="square.geo", verb="simulate", options=("--accuracy", "1e-2", "--quantity", "displacement")),
    ]
