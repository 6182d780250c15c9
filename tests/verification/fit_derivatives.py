# SPDX-License-Identifier: GPL-3.0-or-later
"""Derivatives of fits by every kind of unknown from every kind of measurement, by every scheme."""

import functools
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from fit_runs import EVERY, PLANE, SCHEMES, half_space, measure, thrown
from harness import SOURCE, attempt

IN_SPACE = [{"of": "initial.velocity", "start": 0.98}, {"of": "position", "start": 0.05},
            {"of": "angle", "component": "x", "start": 0.01}, {"of": "angle", "component": "y", "start": -0.01}]  # fmt: skip
ROUND = [{"of": "center", "component": "x", "start": 0.1}, {"of": "center", "component": "y", "start": -40.05},
         {"of": "radius", "start": 24.9}]  # fmt: skip
CASES = {
    "plane": (2, half_space(2), EVERY + PLANE),
    "ball": (2, '{ shape = "ball", center = [0, -40.2], radius = 25.0 }', [EVERY[0], EVERY[4], *ROUND]),
    "space": (3, half_space(3), [EVERY[0], EVERY[3], EVERY[4], *IN_SPACE]),
}
INSIDE = [{"of": "center", "component": "x", "start": 0.1}, {"of": "center", "component": "y", "start": 9.75},
          {"of": "radius", "start": 24.95}]  # fmt: skip
CASES |= {  # cylinders, and round obstacles around the body: once with each scheme
    "inside of a disc": (2, '{ shape = "ball", center = [0, 9.8], radius = 25.0, side = "inside" }', [EVERY[0], *INSIDE]),
    "inside of a cylinder": (2, '{ shape = "cylinder", point = [0, 9.8], radius = 25.0, side = "inside" }', [EVERY[4], *INSIDE]),
    "cylinder": (3, '{ shape = "cylinder", point = [0, 3, -40.2], axis = [0, 1, 0], radius = 25.0 }',
                 [{"of": "center", "component": "x", "start": 0.1}, {"of": "center", "component": "z", "start": -40.05}, ROUND[2]]),
    "inside of a tube": (3, '{ shape = "cylinder", point = [3, 0, 9.8], axis = [1, 0, 0], radius = 25.0, side = "inside" }',
                         [{"of": "center", "component": "y", "start": 0.3}, {"of": "center", "component": "z", "start": 9.7}, INSIDE[2]]),
    "inside of a ball": (3, '{ shape = "ball", center = [0, 0, 9.8], radius = 25.0, side = "inside" }',
                         [{"of": "center", "component": "y", "start": 0.3}, {"of": "center", "component": "z", "start": 9.7}, INSIDE[2]]),
}  # fmt: skip
SURROUNDED = [{"of": "young", "start": 1.05e8}, {"of": "poisson", "start": 0.29}, {"of": "density", "start": 1.02},
              {"of": "rayleigh.alpha", "start": 110.0}, {"of": "rayleigh.beta", "start": 1.2e-4},
              {"of": "stiffness.normal", "on": "side", "start": 1.1e6}, {"of": "stiffness.tangential", "on": "side", "start": 0.9e6},
              {"of": "damping.normal", "on": "side", "start": 1.1e3}, {"of": "damping.tangential", "on": "side", "start": 0.9e3}]  # fmt: skip
# Springs and dashpots on the sides, an absorbing top, Rayleigh damping.
SURROUNDINGS = """
[material.rayleigh]
alpha = 100.0
beta = 1e-4
[[foundation]]
on = "side"
stiffness = { normal = 1e6, tangential = 1e6 }
damping = { normal = 1e3, tangential = 1e3 }
[[foundation]]
on = "top"
absorbing = true
"""
CASES |= {"surroundings": (2, half_space(2), SURROUNDED), "surroundings in space": (3, half_space(3), SURROUNDED)}
# So far from the values of the data that J is more than what conjugate gradients leave of it; one fraction starts at its bound.
RELAXED = [{"of": "initial.velocity", "start": 0.95}, {"of": "young", "start": 1.25e8}, {"of": "poisson", "start": 0.29},
           {"of": "density", "start": 1.1}, {"of": "shear", "start": 1.9e4},
           {"of": "rayleigh.beta", "start": 1.2e-4},
           *({"of": f"prony.{name}", "branch": branch, "start": start}
             for branch, starts in enumerate(({"g": 0.28, "k": 0.22, "time": 1.1e-3}, {"g": 0.21, "k": 0.0, "time": 0.9e-2}))
             for name, start in starts.items())]  # fmt: skip
# Two branches, one about as fast as the impact and one slower, beside viscosity and an absorbing top.
RELAXATION = """
[[foundation]]
on = "top"
absorbing = true
[material.rayleigh]
beta = 1e-4
[[material.prony]]
g = 0.3
k = 0.2
time = 1e-3
[[material.prony]]
g = 0.2
k = 0.1
time = 1e-2
"""
CASES |= {"relaxing": (2, half_space(2), RELAXED), "relaxing in space": (3, half_space(3), RELAXED),
          "relaxing, long-term moduli": (2, half_space(2), RELAXED)}  # fmt: skip
ADDED = {name: SURROUNDINGS if wanted is SURROUNDED else RELAXATION for name, (_, _, wanted) in CASES.items()
         if wanted is SURROUNDED or wanted is RELAXED}  # fmt: skip
ON_SPRINGS = """
[[foundation]]
on = "side"
stiffness = { normal = 1e6, tangential = 1e6 }
damping = { normal = 1e4, tangential = 1e4 }
"""
SPRINGS = [{"of": "stiffness.normal", "on": "side", "start": 1.1e6}, {"of": "damping.tangential", "on": "side", "start": 1.5e4}]
# In plane stress g = k in each branch, and the viscosities have the ratio of the moduli, K/G = 13/6 at a Poisson's ratio of 0.3.
AS_MODULI = RELAXATION.replace("k = 0.2", "k = 0.3").replace("k = 0.1", "k = 0.2") + ON_SPRINGS
IN_PLATE = [one for one in RELAXED if one["of"] in ("initial.velocity", "young", "density", "rayleigh.beta", "prony.time")]
CASES |= {
    "revolved": (2, half_space(2), [*RELAXED, *SPRINGS, {"of": "position", "start": 0.05}, {"of": "load.gravity", "start": 0.95}]),
    "revolved, on a ball": (2, '{ shape = "ball", center = [0, -40.2], radius = 25.0 }', [EVERY[0], *ROUND[1:]]),
    "revolved, in a ball": (2, '{ shape = "ball", center = [0, 9.8], radius = 25.0, side = "inside" }', [EVERY[1], *INSIDE[1:]]),
    "plate": (2, half_space(2), [*IN_PLATE, *SPRINGS, PLANE[2]]),
    "elastic plate": (2, half_space(2), [EVERY[0], EVERY[1], SURROUNDED[4]]),
}
ADDED |= {"revolved": RELAXATION + ON_SPRINGS, "plate": AS_MODULI,
          "elastic plate": SURROUNDINGS.replace("alpha = 100.0\n", "")}  # fmt: skip
SECTION = {"mesh__model": "axisymmetric", "mesh__file": str(SOURCE / "meshes" / "half-ball-section.geo"), "measurement__1__component": "y"}
KEYS = {"relaxing, long-term moduli": {"material__moduli": "long-term"},
        "plate": {"mesh__model": "plane-stress", "material__viscosity__bulk": 13e4 / 6, "material__viscosity__shear": 1e4},
        "elastic plate": {"mesh__model": "plane-stress"}} | {name: SECTION for name in CASES if name.startswith("revolved")}  # fmt: skip
# The body is thrown obliquely onto a belt: it sticks, slips and opens.
BELT = ', surface_velocity = ["{}*(1 + 0.2*x/15)"{}] }}'
RUBBED = [{"of": "friction", "start": 0.32}, {"of": "surface_velocity", "start": 0.9}, {"of": "position", "start": 0.05},
          *(EVERY[i] for i in (0, 3, 4, 7)), {"of": "initial.velocity", "start": 0.97}]  # fmt: skip
CASES |= {
    "rubbed": (2, half_space(2)[:-2] + BELT.format(60, ', "0"'), RUBBED),
    "rubbed in space": (3, half_space(3)[:-2] + BELT.format(60, ', "20", "0"'), RUBBED),
    "rubbed by a ball": (2, '{ shape = "ball", center = [0, -40.2], radius = 25.0' + BELT.format(60, ', "0"'), RUBBED[:2]),
    "revolved, rubbed": (2, half_space(2), [RUBBED[0], *RUBBED[2:7]]),
}
BOUNDED = [{"of": "friction", "start": 1.1e5}, *RUBBED[1:]]
CASES |= {"rubbed, bounded": (2, CASES["rubbed"][1], BOUNDED), "rubbed in space, bounded": (3, CASES["rubbed in space"][1], BOUNDED),
          "rubbed, no tangential mass": CASES["rubbed"], "rubbed in space, no tangential mass": CASES["rubbed in space"],
          "rubbed, bounded, no tangential mass": (2, CASES["rubbed"][1], BOUNDED)}  # fmt: skip
KEYS |= {name: {"contact__friction": {"bound": 1e5} if "bounded" in name else 0.3} for name in CASES if "rubbed" in name}
for name in (name for name in CASES if "no tangential mass" in name):
    KEYS[name]["contact__mass"] = "massless-tangential"
KEYS["revolved, rubbed"] |= SECTION
# The body is thrown onto a plate that has mass, springs and dashpots, and turns.
HELD = ", mass = {mass}, velocity = {velocity}, stiffness = {stiffness}, damping = {damping}, {more} }}"
MASS = [{"of": "mass", "start": 430.0}, {"of": "velocity", "component": "y", "start": 95.0}, {"of": "stiffness", "component": "x", "start": 1.1e8},
        {"of": "stiffness", "component": "y", "start": 1.8e8}, {"of": "damping", "start": 1.1e4}, {"of": "inertia", "start": 4.2e4}]  # fmt: skip
MASS_IN_SPACE = [{"of": "mass", "start": 6.3e3}, {"of": "velocity", "component": "z", "start": 95.0}, {"of": "damping", "component": "z", "start": 1.1e5},
                 {"of": "stiffness", "start": 2.1e9}, {"of": "inertia", "component": "y", "start": 4.2e5}]  # fmt: skip
IN_PLANE = half_space(2)[:-2] + HELD.format(mass=400.0, velocity=[20.0, 100.0], stiffness=[1e8, 2e8], damping=1e4, more="inertia = 4e4, mass_center = [2.0, -18.0]")
CASES |= {
    "plate with mass": (2, IN_PLANE, [*MASS, EVERY[0], EVERY[4], EVERY[7], RUBBED[2]]),
    "rubbing plate with mass": (2, IN_PLANE, [*MASS, RUBBED[0]]),
    "plate with mass in space": (3, half_space(3)[:-2] + HELD.format(mass=6e3, velocity=[20.0, 10.0, 100.0], stiffness=2e9, damping=[1e5] * 3,
                                 more="inertia = [4e5, 4e5, 8e5], mass_center = [1.0, 0.0, -20.0]"), [*MASS_IN_SPACE, RUBBED[0], RUBBED[2]]),
    "revolved, plate with mass": (2, half_space(2)[:-2] + HELD.format(mass=6e3, velocity=[0.0, 100.0], stiffness=2e9, damping=1e5, more='components = ["y"]'),
                                  [{"of": "mass", "start": 6.3e3}, MASS[1], {"of": "stiffness", "start": 2.1e9}, {"of": "damping", "start": 1.1e5}, EVERY[7]]),
}  # fmt: skip
KEYS |= {name: {"contact__friction": 0.3} for name in ("rubbing plate with mass", "plate with mass in space")}
KEYS["revolved, plate with mass"] = SECTION
for name in (name for name in CASES if "with mass" in name):
    ADDED[name] = "".join(f'''
[[measurement]]
of = "{of}"
component = "{"xyz"[CASES[name][0] - 1]}"
obstacle = "obstacle 1"
noise = 0.02
file = "plate.csv"
column = "{of}"
''' for of in ("displacement", "velocity"))
SETTINGS = {
    "as it is": ({}, 1),
    "degree 2": ({"mesh__degree": 2}, 1),
    "iterative": ({"solver__linear": "iterative"}, 1),
    "2 ranks": ({}, 2),
    "checkpoints": ({"trajectory__storage": "checkpoints"}, 1),
    "3 ranks": ({}, 3),
}
COARSE = {"mesh__size": 9.0}  # in space: of degree 2 there are eight times as many unknowns


def settings(name: str, scheme: str) -> list[str]:
    """All in the plane, and with one scheme on a ball and in space; three ranks with that scheme."""
    once = "contact-stabilized" if name in ("ball", "space", "relaxing in space", "plate with mass in space") or name.startswith("rubbed in space") else None
    if name not in ("plane", "surroundings", "relaxing", "revolved", "plate", "rubbed", "rubbed, bounded", "rubbed, no tangential mass", "plate with mass",
                    "revolved, plate with mass") and scheme != once:
        return ["as it is"]
    return [setting for setting in SETTINGS if setting != "3 ranks" or scheme == "contact-stabilized"]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """The scene of a case, with data that a scheme made; each is simulated once."""

    @functools.cache
    def file(name: str, scheme: str) -> Path:
        folder = tmp_path_factory.mktemp("case")
        text = thrown(*CASES[name], folder) + ADDED.get(name, "")
        if name.startswith("elastic"):
            text = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("viscosity"))
        (folder / "scene.toml").write_text(text)
        measure(folder / "scene.toml", folder / "made", SCHEMES[scheme] | KEYS.get(name, {}))
        return folder / "scene.toml"

    return file


RUNS = [(name, scheme, setting) for name in CASES for scheme in SCHEMES for setting in settings(name, scheme)
        if scheme == "contact-stabilized" or "no tangential mass" not in name]  # fmt: skip


@pytest.mark.parametrize("name, scheme, setting", RUNS)
def test_check(measured: Callable, name: str, scheme: str, setting: str) -> None:
    """Taylor orders by each unknown, adjoint sweep against linearised motions, contact not vacuous."""
    (dim, _, wanted), (more, ranks) = CASES[name], SETTINGS[setting]
    more = more | KEYS.get(name, {}) | (COARSE if dim == 3 and "mesh__degree" in more else {})
    done = attempt("check", measured(name, scheme), None, ranks, **SCHEMES[scheme], **more)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = re.findall(r"^(ok|FAIL)\s+(\S.*?)\s{2,}(\S.*?)\s{2,}", done.stdout, re.MULTILINE)
    assert "contact included" in done.stdout and len(rows) > 2 * len(wanted)
    orders = [row for row in rows if row[1].startswith("Taylor order")]
    assert len(orders) > len(wanted) / 2, "too few differences keep the active sets"
