# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad obstacles."""

from case import Case, edited


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
               "-0.1 + x", "expressions in t only"),
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
               "expressions in t only"),
        shaped("center of an expression of place", ball.replace("-1", '"y - 1"'), "contact.obstacle.center: found 0, y - 1",
               "expressions in t only"),
        shaped("radius that vanishes", ball.replace("0.5", '"0.5 - t/2e-4"'), "contact.obstacle.radius: found 0 m at t = 0.0001 s; "
               "a radius must stay above 0", at="", ranks=2),
        shaped("center that leaves the finite", ball.replace("-1", '"-1 - 1/(1e-4 - t)"'), "contact.obstacle.center: ",
               "t = 0.0001", "finite", at=""),
        shaped("unknown side", ball.replace(" }", ', side = "within" }'), 'contact.obstacle.side: found "within"',
               "outside, inside"),
        shaped("ball with a normal", ball.replace(" }", ", normal = [0, 1] }"), "contact.obstacle.normal: unknown key"),
        shaped("ball in space", ball.replace("[0, -1]", "[0, 0, -1]"), "contact.obstacle.center: found 3 components",
               "2-dimensional", at=""),
        shaped("ball around a node", ball.replace("[0, -1]", "[0, 0]"), "contact.obstacle: ",
               "the node at (0, 0, 0) is at the centre or on the axis, where the outward direction is undefined; move the body or the obstacle", at=""),
        shaped("ball around a node, two ranks", ball.replace("[0, -1]", "[0, 0]"), "contact.obstacle: ", "(0, 0, 0)", at="",
               ranks=2),
        shaped("body inside a ball", ball.replace("[0, -1]", "[0, -0.4]"), "contact: the node at (0, 0, 0)",
               "0.1 m inside the obstacle", at=""),
        shaped("body outside a ball around it", ball.replace(" }", ', side = "inside" }').replace("0.5", "1"),
               "contact: the node at", "inside the obstacle", "start outside", at=""),
        shaped("cylinder in space without an axis", '{ shape = "cylinder", point = [0, 0, 0], radius = 1 }',
               "contact.obstacle.axis: missing"),
        shaped("cylinder with an axis of length zero", '{ shape = "cylinder", point = [0, 0, 0], axis = [0, 0, 0], radius = 1 }',
               "contact.obstacle.axis: found", "length zero"),
        shaped("cylinder with a plane axis", '{ shape = "cylinder", point = [0, 0, 0], axis = [0, 1], radius = 1 }',
               "contact.obstacle.axis: found 2 components", "point has 3", "give 3 components"),
        shaped("disc with an axis", '{ shape = "cylinder", point = [0, -2], axis = [0, 1], radius = 1 }',
               "contact.obstacle.axis: ", "in the plane", "disc"),
        shaped("cylinder of a negative radius", '{ shape = "cylinder", point = [0, -2], radius = -1 }',
               "contact.obstacle.radius: found -1", "greater than 0"),
        shaped("cylinder in space for a plane body", '{ shape = "cylinder", point = [0, 0, 0], axis = [0, 1, 0], radius = 1 }',
               "contact.obstacle.point: found 3 components", "2-dimensional", at=""),
        shaped("distance that cannot be read", '{ shape = "signed-distance", distance = "y +" }',
               "contact.obstacle.distance: ", '"y +"', "x, y, z"),
        shaped("distance that loses its slope", '{ shape = "signed-distance", distance = "t > 9e-5 ? 1 : y + 1" }',
               "contact.obstacle.distance: ", "is zero at the node", "t = 0.0001 s", at=""),
        shaped("list for a distance", '{ shape = "signed-distance", distance = ["y", "y"] }',
               "contact.obstacle.distance: found", "a text"),
        shaped("distance without a slope", '{ shape = "signed-distance", distance = "1" }', "contact.obstacle.distance: ",
               "is zero at the node", "node at (-0.5, 0, 0)", at=""),
        shaped("distance that is not finite", '{ shape = "signed-distance", distance = "log(y)" }',
               "contact.obstacle.distance: ", '"log(y)"', "y = 0", "finite", at=""),
        shaped("distance that is not finite beside a node", '{ shape = "signed-distance", distance = "sqrt(y)" }',
               "contact.obstacle.distance: ", "in the neighbourhood of the node at (-0.5, 0, 0)", at="", ranks=2),
        edited("unknown start of contact", "[load]", 'initial = "inside"\n[load]', 'contact.initial: found "inside"',
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
