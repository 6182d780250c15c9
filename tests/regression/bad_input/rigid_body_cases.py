# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad masses of obstacles and what belongs to them, and what cannot be combined with a mass."""

from case import Case, Expected, edited

PLANE = '{ shape = "half-space", point = [0, -0.1], normal = [0, 1] }'


def heavy(name: str, keys: str, *expect: Expected, plane: str = PLANE, **more: object) -> Case:
    """An obstacle with more keys."""
    more.setdefault("at", "obstacle =")
    return edited(name, f"obstacle = {PLANE}", "obstacle = " + plane.replace(" }", f", {keys} }}"), *expect, **more)


def rigid_body_cases() -> list[Case]:
    """Masses that cannot be, or not there."""
    at = "contact.obstacle."
    no_estimate = "cannot be combined with contact.obstacle.mass, since the error estimate does not include the obstacle's motion"
    both = ((f"obstacle = {PLANE}", f"obstacle = {PLANE.replace(' }', ', mass = 1.0 }')}\n[[contact]]\non = \"side\"\nobstacle = "
             '{ shape = "half-space", point = [-0.6, 0], normal = [1, 0] }'), ("[contact]", "[[contact]]"))  # fmt: skip
    several = "contact[0].on: the node at (-0.5, 0, 0) is a candidate of another obstacle too, which obstacles with mass do not permit"
    return [
        *(heavy(name, "mass = 1", *expect, at="", options=("--set", f"objective={{{objective}}}")) for name, objective, *expect in (
            ("objective of no obstacle", 'obstacle="wall", desired={displacement=["0","0"]}', 'objective.obstacle: found "wall"', "obstacle 1"),
            ("objective of an obstacle and a group", 'obstacle="obstacle 1", on="body", desired={displacement=["0","0"]}',
             "objective.on: found together with obstacle"),
            ("objective of an obstacle in a run", 'obstacle="obstacle 1", desired={run="out"}', "objective.desired: found a run, which stores no motion"))),
        edited("objective of an obstacle without mass", "[objective]", '[objective]\nobstacle = "obstacle 1"',
               'objective.obstacle: found "obstacle 1", which does not move freely', at=""),
        heavy("negative mass", "mass = -1.0", at + "mass: found -1.0; expected a number of at least 0"),
        heavy("mass without end", "mass = inf", at + "mass: found inf", "finite"),
        heavy("mass in words", 'mass = "heavy"', at + "mass: found", "a number"),
        heavy("no mass and no spring", "mass = 0", at + "mass: found 0 without stiffness in every component; give stiffness"),
        heavy("no mass and one spring", "mass = 0, stiffness = [0, 1.0]", at + "mass: found 0 without stiffness in every component"),
        heavy("no mass in the projection", "mass = 0, stiffness = 1.0", at + 'mass: found 0 with time.scheme "contact-stabilized"',
              options=("--set", "time.scheme=contact-stabilized")),
        heavy("velocity without mass", "velocity = [0, 1]", at + "mass: missing"),
        heavy("inertia without mass", "inertia = 1.0", at + "mass: missing"),
        heavy("velocity in space", "mass = 1, velocity = [0, 1, 0]", at + "velocity: found 3 components; expected 2", at=""),
        heavy("velocity in space, two ranks", "mass = 1, velocity = [0, 1, 0]", at + "velocity: found 3 components; expected 2", at="", ranks=2),
        heavy("component in space", 'mass = 1, components = ["z"]', at + 'components: found "z"', at=""),
        heavy("no component", "mass = 1, components = []", at + "components: "),
        heavy("force in space", 'mass = 1, force = ["0", "1", "0"]', at + "force: found 3 components; expected 2", at=""),
        heavy("force by place", 'mass = 1, force = ["x", "0"]', at + "force", "t"),
        heavy("negative spring", "mass = 1, stiffness = -5.0", at + "stiffness: found -5; expected numbers at least 0"),
        heavy("three springs", "mass = 1, stiffness = [1, 1, 1]", at + "stiffness: found 3 components; expected 2", at=""),
        heavy("negative dashpot", "mass = 1, damping = [0, -1.0]", at + "damping: found -1; expected numbers at least 0"),
        heavy("three dashpots", "mass = 1, damping = [1, 1, 1]", at + "damping: found 3 components; expected 2", at=""),
        heavy("inertia zero", "mass = 1, inertia = 0", at + "inertia: found 0; expected numbers above 0"),
        heavy("inertia of space", "mass = 1, inertia = [1, 1, 1]", at + "inertia: found 3 numbers; expected 1", at=""),
        heavy("centre of what does not turn", "mass = 1, mass_center = [0, 0]", at + "mass_center: has no effect on an obstacle that does not"),
        heavy("centre in space", "mass = 1, inertia = 1, mass_center = [0, 0, 0]", at + "mass_center: found 3 components; expected 2", at=""),
        heavy("turning without a centre", "mass = 1, inertia = 1", at + "inertia: found without the point about which the obstacle turns",
              plane='{ shape = "signed-distance", distance = "y + 0.1" }'),
        heavy("mass of what moves", "mass = 1", at + "mass: found with an obstacle whose expressions contain t",
              plane='{ shape = "half-space", point = ["0", "-0.1-t"], normal = [0, 1] }'),
        heavy("mass in steps that the motion chooses", "mass = 1", at + 'mass: found together with time.step = "auto"',
              options=("--set", "time.step=auto"), verb="info"),
        heavy("mass in the full inequality", "mass = 1", 'solver.vi: found "full" with an obstacle that has mass', at="",
              options=("--set", "solver.vi=full")),
        heavy("mass and projection", "mass = 1", 'contact.initial: found "project" with an obstacle that has mass', at="",
              options=("--set", "contact.initial=project")),
        heavy("mass and static start", "mass = 1", "initial.static: found with an obstacle that has mass", at="",
              options=("--set", "initial={static=true}")),
        Case("mass at a corner", (several, "choose groups without common nodes"), edits=both),
        Case("mass at a corner, two ranks", (several,), edits=both, ranks=2),
        *(heavy(f"{what} with a mass", "mass = 1", f"{option}: {no_estimate}", instead, at="", verb=verb, options=(option, *more))
          for what, option, instead, verb, more in (
            ("accuracy of an optimum", "--accuracy", "compare sizes and steps by study", "optimize", ("1e-2",)),
            ("graded meshes", "--graded", "leave it out", "study", ()))),
    ]
