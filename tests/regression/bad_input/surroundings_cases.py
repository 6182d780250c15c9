# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad foundations, damping and forces at points."""

from case import Case, Expected, edited

SPRINGS = "stiffness = { normal = 1.0 }"


def foundation(name: str, keys: str, *expect: Expected, **more: object) -> Case:
    return edited(name, "[initial]", f"[[foundation]]\n{keys}\n[initial]", *expect, **more)


def force(name: str, keys: str, *expect: Expected, **more: object) -> Case:
    return edited(name, "[initial]", f"[[load.point]]\n{keys}\n[initial]", *expect, **more)


def surroundings_cases() -> list[Case]:
    """Foundations, Rayleigh damping and forces at points that cannot be."""
    side, rayleigh = 'on = "side"\n', "poisson = 0.3\nrayleigh = "
    return [
        foundation("foundation of nothing", side, "foundation[0]: found none of stiffness, damping, absorbing", at="[[foundation]]"),
        foundation("springs of nothing", side + "stiffness = {}", "foundation[0].stiffness: found no number above 0", at="stiffness ="),
        foundation("dashpots of nothing", side + "damping = { normal = 0 }", "foundation[0].damping: found no number above 0", at="damping ="),
        foundation("foundation without a group", SPRINGS, "foundation[0].on: missing", at="[[foundation]]"),
        foundation("foundation on a missing group", f'on = "nowhere"\n{SPRINGS}', "foundation[0].on: ", 'no curve group "nowhere"', at=""),
        foundation("foundation on the body", f'on = "body"\n{SPRINGS}', "foundation[0].on: ", '"body"', at=""),
        foundation("foundation on the body, two ranks", f'on = "body"\n{SPRINGS}', "foundation[0].on: ", '"body"', at="", ranks=2),
        foundation("two foundations on a group", f"{side}{SPRINGS}\n[[foundation]]\n{side}{SPRINGS}",
                   'foundation[1].on: found "side", which is the group of foundation[0] too', "give a group one foundation", at='on = "side"\nstiffness = { normal = 1.0 }\n[initial]'),
        foundation("springs that push", side + "stiffness = { normal = -1 }", "foundation[0].stiffness.normal: found -1", "at least 0", at="stiffness ="),
        foundation("springs that push sideways", side + "stiffness = { tangential = -1 }", "foundation[0].stiffness.tangential: found -1", at="stiffness ="),
        foundation("dashpots that drive", side + "damping = { normal = -1 }", "foundation[0].damping.normal: found -1", "at least 0", at="damping ="),
        foundation("dashpots that drive sideways", side + "damping = { tangential = -1 }", "foundation[0].damping.tangential: found -1", at="damping ="),
        foundation("absorbing by a number", side + "absorbing = 1", "foundation[0].absorbing: found 1", at="absorbing ="),
        foundation("absorbing beside dashpots", side + "absorbing = true\ndamping = { normal = 1.0 }",
                   "foundation[0].damping: found together with absorbing = true", "remove one of them", at="damping ="),
        foundation("misspelt springs", side + "stifness = { normal = 1.0 }", "foundation[0].stifness: unknown", 'did you mean "stiffness"?', at="stifness ="),
        force("force nowhere", 'value = ["0", "1"]', "load.point[0].at: missing", at="[[load.point]]"),
        force("force of nothing", "at = [0, 0]", "load.point[0].value: missing", at="[[load.point]]"),
        force("force where there is no node", 'at = [0.2, 0.9]\nvalue = ["0", "1"]', "load.point[0].at: found (0.2, 0.9) m",
              "the nearest node is at (0, 1) m", at=""),
        force("force where there is no node, two ranks", 'at = [0.2, 0.9]\nvalue = ["0", "1"]', "load.point[0].at: found (0.2, 0.9) m",
              "the nearest node is at (0, 1) m", at="", ranks=2),
        force("force at a point in space", 'at = [0, 0, 0]\nvalue = ["0", "1"]', "load.point[0].at: found 3 components", at=""),
        force("force of three components", 'at = [0, 0]\nvalue = ["0", "1", "2"]', "load.point[0].value: found 3 components", at=""),
        force("force that depends on place", 'at = [0, 0]\nvalue = ["0", "x"]', "load.point[0].value: ", "x", at='value = ["0", "x"]'),
        edited("mass damping that drives", "poisson = 0.3", rayleigh + "{ alpha = -1 }", "material.rayleigh.alpha: found -1", "at least 0", at="rayleigh ="),
        edited("stiffness damping that drives", "poisson = 0.3", rayleigh + "{ beta = -1 }", "material.rayleigh.beta: found -1", at="rayleigh ="),
    ]
