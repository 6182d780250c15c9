# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad contact between parts of the body, and what cannot be combined with it."""

from case import BODY, LINE, TRIANGLE, Case, Element, Expected, msh2, square_elements, square_points

OBSTACLE = 'obstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }'
GROUPS = ((2, 1, "body"), (1, 2, "top"), (1, 3, "bottom"), (1, 4, "side"), (2, 11, "low"), (1, 12, "under"), (1, 13, "floor"), (1, 14, "walls"),
          (1, 15, "all"), (1, 16, "within"))  # fmt: skip


def two_squares(gap: float = 0.05) -> str:
    """The square above a second one like it, whose upper side is "under"; "all" are both sides between them, "within" is inside the lower one."""
    points = square_points()
    lower = [(x, y - 1 - gap, z) for x, y, z in points]
    groups = {BODY: 11, 2: 12, 3: 13, 4: 14}
    elements: list[Element] = list(square_elements())
    elements += [(kind, groups[group], groups[group], tuple(node + len(points) for node in nodes)) for kind, group, _, nodes in square_elements()]
    elements += [(LINE, 15, 15, nodes) for kind, group, _, nodes in elements if kind == LINE and group in (3, 12)]
    elements += [(LINE, 16, 16, (13, 14))]
    assert any(kind == TRIANGLE for kind, *_ in elements)
    return msh2([*points, *lower], elements, GROUPS)


def parts(name: str, keys: str, *expect: Expected, gap: float = 0.05, also: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
    """The two squares in contact."""
    more.setdefault("at", "")
    return Case(name, expect, edits=((OBSTACLE, keys), *also), mesh=two_squares(gap), **more)  # type: ignore[arg-type]


def parts_cases() -> list[Case]:
    """Surfaces that cannot be in contact, or not so."""
    under = 'against = "under"'
    estimate = "cannot be combined with contact.against, since the error estimate"
    return [
        parts("neither obstacle nor part", "", "contact.obstacle: missing", "against"),
        parts("obstacle and part", f"{OBSTACLE}\n{under}", "contact.against: found together with obstacle; remove one of them", at="against"),
        parts("part of no name", "against = 3", "contact.against: found 3", "text", at="against"),
        parts("part that is not there", 'against = "undr"', 'contact.against: ', 'has no curve group "undr"', 'did you mean "under"'),
        parts("part that is not there, two ranks", 'against = "undr"', 'has no curve group "undr"', ranks=2),
        parts("surface in contact with itself", 'against = "bottom"', "contact.against: found the group `on`; a surface in contact with itself",
              at="against"),
        parts("groups with common nodes", 'against = "all"', 'contact.against: the groups "bottom" and "all" have the node at', "in common"),
        parts("groups with common nodes, two ranks", 'against = "all"', "contact.against: the groups", "in common", ranks=2),
        parts("part inside the other", 'against = "within"', 'contact.against: the group "within" has facets inside the body'),
        parts("surface that faces away", 'against = "floor"', 'contact.against: no part of the group "bottom" faces the group "floor"'),
        parts("candidates on no side", f'{under}\nslave = "left"', 'contact.slave: found "left"', "choices: on, against", at="slave"),
        parts("candidates of an obstacle", f'{OBSTACLE}\nslave = "on"', "contact.slave: has no effect with an obstacle", at="slave"),
        parts("height of an obstacle", f"{OBSTACLE}\nheight = 0.1", "contact.height: has no effect with an obstacle", at="height"),
        parts("height in words", f'{under}\nheight = "low"', "contact.height: found", "a number", at="height"),
        parts("candidates that are clamped", f'{under}\nslave = "against"', 'contact.slave: a clamp holds the node at', "choose the other side",
              also=(('[[clamp]]\non = "top"', '[[clamp]]\non = "top"\n[[clamp]]\non = "under"'),)),
        parts("parts inside each other", under, "contact: the node at", "starts 0.02 m inside the other part", gap=-0.02),
        parts("massless parts in quadratic elements", f'{under}\nmass = "massless"', "contact.mass: found a massless surface with contact.against and mesh.degree = 2",
              options=("--set", "mesh.degree=2"), at="mass"),
        parts("parts in steps that the motion chooses", under, 'contact.against: found together with time.step = "auto"',
              options=("--set", "time.step=auto"), verb="info", at="against"),
        parts("parts in the full inequality", under, 'solver.vi: found "full" with contact.against', options=("--set", "solver.vi=full")),
        parts("dropped parts", under, "initial.drop: found with contact.against alone", "give initial.velocity", at="drop =",
              also=(("[load]\n", "[load]\ngravity = [0, -9.81]\n"),
                    ('displacement = ["0", "0"]\nvelocity = ["0", "0"]\n', "drop = { height = 1.0 }\n"))),  # fmt: skip
        parts("part that is too high", f"{under}\nheight = 0.08", "contact: the node at", "starts 0.03 m inside the other part", "lower contact.height, 0.08 m"),
        parts("accuracy of parts", under, estimate, options=("--accuracy", "0.1"), verb="optimize"),
        parts("part twice", f'{under}\n[[contact]]\non = "bottom"\n{under}', 'contact[1].against: found "under" on "bottom", as in contact[0]',
              also=(("[contact]", "[[contact]]"),)),
        parts("candidate of a part and an obstacle", f'{under}\n[[contact]]\non = "side"\nobstacle = {{ shape = "half-space", point = [-0.6, 0], normal = [1, 0] }}',
              "contact[0].on: the node at", "is a candidate of another contact too, which contact.against does not permit",
              also=(("[contact]", "[[contact]]"),)),
        parts("candidate opposite candidates", f'{under}\n[[contact]]\non = "under"\nobstacle = {{ shape = "half-space", point = [0, 9], normal = [0, -1] }}',
              "contact[0].against: the node at", "is a candidate of", "and opposite candidates of", also=(("[contact]", "[[contact]]"),)),
        parts("height of no part", OBSTACLE, 'unknown[0].of: found "height"', "choices", options=("--set", "unknown=[{of='height'}]"), verb="info"),
        parts("position of a part", under, 'unknown[0].of: found "position" of the contact of two parts; choices: height, friction',
              options=("--set", "unknown=[{of='position'}]"), verb="info"),
    ]  # fmt: skip
