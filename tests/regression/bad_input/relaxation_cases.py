# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad Prony series, and what cannot be combined with them."""

from case import Case, Expected, edited

SERIES = "prony = [{ g = 0.3, time = 1e-4 }]"


def material(name: str, keys: str, *expect: Expected, **more: object) -> Case:
    """A material with more keys; the message must name the line of the first of them."""
    more.setdefault("at", keys.splitlines()[0])
    return edited(name, "poisson = 0.3", f"poisson = 0.3\n{keys}", *expect, **more)


def relaxation_cases() -> list[Case]:
    """Series that no material can have, and verbs that refuse those which it can."""
    tenths = ", ".join(["{ g = 0.1, time = 1e-4 }"] * 10)
    no_estimate = "cannot be combined with material.prony, since the error estimate does not include relaxation"
    return [
        material("shear fraction below zero", "prony = [{ g = -0.1, time = 1e-4 }]", "material.prony[0].g: found -0.1", "at least 0"),
        material("bulk fraction in percent", "prony = [{ g = 0.3, k = 10, time = 1e-4 }]", "material.prony[0].k: found 10", "at most 1"),
        material("relaxation in no time", "prony = [{ g = 0.3, time = 0 }]", "material.prony[0].time: found 0", "greater than 0", "(s)"),
        material("branch without a time", "prony = [{ g = 0.3 }]", "material.prony[0].time: missing"),
        material("time under its name in textbooks", "prony = [{ g = 0.3, tau = 1e-4 }]",
                 "material.prony[0].tau: unknown; a branch has g and k", "and time in s"),
        material("branch of nothing", "prony = [{ g = 0.3, time = 1e-4 }, { time = 1e-3 }]",
                 "material.prony[1]: found neither g nor k above 0", "give one of them"),
        material("misspelt fraction", "prony = [{ gg = 0.3, time = 1e-4 }]", "material.prony[0].gg: unknown key", 'did you mean "g"?'),
        material("nothing left in shear, but for rounding", f"prony = [{tenths}]", "material.prony: found fractions g that add up to 1;",
                 "expected a sum below 0.9999"),
        material("nothing left in shear, two ranks", f"prony = [{tenths}]", "material.prony: found fractions g that add up to 1;", ranks=2),
        material("less than nothing left in bulk", "prony = [{ k = 0.6, time = 1e-4 }, { k = 0.6, time = 1e-3 }]",
                 "material.prony: found fractions k that add up to 1.2;", "expected a sum below 0.9999"),
        material("branch without a list", "prony = { g = 0.3, time = 1e-4 }", "material.prony: found {g = 0.3, time = ",
                 "expected a list of tables", "tables headed [[material.prony]]"),
        material("series of numbers", "prony = [0.3, 1e-4]", "material.prony: found [0.3, ", "expected a list of tables"),
        material("series under its whole name", f"prony_series = {SERIES.removeprefix('prony = ')}",
                 "material.prony_series: unknown; give relaxation as material.prony"),
        material("moduli without a series", 'moduli = "long-term"', "material.moduli: has no effect without prony", "remove moduli"),
        material("moduli that are none", f'moduli = "relaxed"\n{SERIES}', 'material.moduli: found "relaxed"',
                 "choices: instantaneous, long-term"),
        *(material(f"{what} of a body that relaxes", SERIES, f"{option}: {no_estimate}", instead, at="", verb=verb, options=(option, *more))
          for what, option, instead, verb, more in (
            ("accuracy of an optimum", "--accuracy", "compare sizes and steps by study", "optimize", ("1e-2",)),
            ("graded meshes", "--graded", "leave it out", "study", ()),
            ("suggestion", "--suggest", "choose another --quantity", "study", ("1e-2",)))),
        Case("sizes chosen for a body that relaxes", (f'--accuracy with mesh.size = "auto": {no_estimate}', "give mesh.size"),
             edits=(("poisson = 0.3", f"poisson = 0.3\n{SERIES}"), ('file = "square.msh"', 'file = "square.geo"\nsize = "auto"')),
             mesh_file="square.geo", verb="simulate", options=("--accuracy", "1e-2", "--quantity", "displacement")),
        material("suggestion of a body that relaxes, two ranks", SERIES, f"--suggest: {no_estimate}", at="", verb="study",
                 options=("--suggest", "1e-2"), ranks=2),
    ]
