# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad scenarios."""

from case import Case, Expected


def scenario_cases() -> list[Case]:
    """Scenarios that a scene cannot have."""

    def scenarios(name: str, tables: str, *expect: Expected, edits: tuple[tuple[str, str], ...] = (), **more: object) -> Case:
        return Case(name, expect, edits=(("every = 1", f"every = 1\n\n{tables}"), *edits), **more)

    def scenario(name: str, keys: str, *expect: Expected, **more: object) -> Case:
        return scenarios(name, f"[[scenario]]\n{keys}\n", *expect, **more)

    faster = 'set = { "initial.velocity" = ["0", "-1"] }'
    objective = ('[objective]\ndesired = { control = ["0", "-1"] }', '[objective]\nexponent = 2.0\ndesired = { control = ["0", "-1"] }')
    return [
        scenario("scenario without changes", "set = {}", "scenario[0].set: found {}; expected a table of keys and their values"),
        scenario("scenario that is no table", "set = 3", "scenario[0].set: found 3; expected a table"),
        scenario("weight of a scenario below zero", "weight = -1.0", "scenario[0].weight: found -1.0; expected a number of at least 0"),
        scenario("no weight", f"weight = 0\n{faster}", "scenario: found no weight above 0; give at least one"),
        scenario("step of a scenario", 'set = { "time.step" = 1e-5 }', 'scenario[0].set: found "time.step", which is the same in all scenarios'),
        scenario("actuator of a scenario", "set = { control.scale = 2.0 }", 'found "control.scale", which is the same in all scenarios'),
        scenario("unknown key of a scenario", 'set = { "initial.velocty" = ["0", "-1"] }', "scenario[0].set: initial.velocty: unknown key",
                 'did you mean "velocity"?'),  # fmt: skip
        scenario("bad value of a scenario", 'set = { "material.young" = -1 }', "scenario[0].set: material.young: found -1; expected a number greater than 0"),
        scenario("unknown group of a scenario", 'set = { contact.on = "bottm" }', 'contact.on: square.msh has no curve group "bottm"', verb="optimize"),
        scenario("scenario with mass", 'set = { contact.obstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1], mass = 1.0 } }',
                 "scenario[0].set: found another number of obstacles with mass", verb="optimize"),  # fmt: skip
        scenarios("equal names of scenarios", f'[[scenario]]\nname = "a"\n{faster}\n[[scenario]]\nname = "a"\n',
                  'scenario[1].name: found "a", which is the name of scenario[0] too'),  # fmt: skip
        scenario("scenario with chosen steps", faster, "scenario: found with steps of varying length", edits=(("step = 5e-5", 'step = "auto"'),)),
        scenario("scenario with checkpoints", f'{faster}\n[trajectory]\nstorage = "checkpoints"\n',
                 'scenario: found with trajectory.storage = "checkpoints" and objective.desired.control'),  # fmt: skip
        scenario("scenario and accuracy", faster, "--accuracy: cannot be combined with [[scenario]]", verb="optimize", options=("--accuracy", "0.1")),
        Case("exponent without scenarios", ("objective.exponent: has no effect without scenarios",), edits=(objective,)),
    ]  # fmt: skip
