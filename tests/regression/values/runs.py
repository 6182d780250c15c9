# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs whose numbers are recomputed: blocks thrown onto obstacles, one that is pressed, and searches."""

import functools
from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini
from recomputed import Run

BLOCK_SCENE = SOURCE / "tests" / "data" / "block.toml"
BLOCK = f"""
[mesh]
file = "{SOURCE}/tests/data/square.geo"
size = 0.25
[time]
end = 1.2
step = 0.01
[material]
density = 2.0
young = 50.0
poisson = 0.3
viscosity = {{ bulk = 0.05, shear = 0.02 }}
[initial]
velocity = ["0.2", "-1 + 0.3*x"]
[[output.probe]]
name = "body"
body = true
[[output.probe]]
name = "tip"
point = [0, 1]
[[output.probe]]
name = "side"
on = "left"
[output]
every = 1
fields = ["displacement", "velocity", "strain", "stress", "von_mises", "pressure"]
"""
# Thrown between a tilted plane and a ball; the load changes in time.
CENTRE, RADIUS = [2.1, 0.5], 0.9
THROWN = BLOCK + f"""
[load]
body = ["0.5", "-3 + t"]
[[output.probe]]
name = "below"
obstacle = "floor"
[[contact]]
on = "bottom"
obstacle = {{ name = "floor", shape = "half-space", point = [0, -0.05], normal = [0.3, 1] }}
[[contact]]
on = "rest"
obstacle = {{ name = "wall", shape = "ball", center = {CENTRE}, radius = {RADIUS} }}
"""
# Bounces on one plane.
BOUNCING = BLOCK + """
[load]
gravity = ["0", "-2"]
[[contact]]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.02], normal = [0, 1] }
"""
CUBE = BLOCK.split("[[output.probe]]")[0].replace("square.geo", "cube.geo").replace('"0.2", "-1 + 0.3*x"', '"-0.4", "0", "-1 + 0.3*x"')
IN_SPACE = CUBE + """
[load]
gravity = ["0", "0.3", "-2"]
[output]
every = 1
fields = ["displacement", "velocity", "strain", "stress", "von_mises", "pressure"]
[[contact]]
on = "bottom"
obstacle = { name = "bulge", shape = "ball", center = [0.4, 0.4, -1], radius = 0.95 }
[[contact]]
on = "left"
obstacle = { name = "wall", shape = "half-space", point = [-0.02, 0, 0], normal = [1, 0, 0] }
[[contact]]
on = "top"
obstacle = { name = "lid", shape = "half-space", point = [0, 0, 3], normal = [0, 0, -1] }
"""
# Clamped and pressed onto a floor; its displacements are drawn enlarged.
STIFF = BLOCK + """
[load]
body = ["0", "-30000"]
[[clamp]]
on = "top"
[[contact]]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.0005], normal = [0, 1] }
"""
SEARCH = {"control__scale": 2.0, "objective__alpha": 0.01, "objective__gamma": 0.02, "output__every": 1, "objective__tracking": 1.5}
WANTED = ["0.3", "-1 + x"]
# A control of the top.
PUSHED = {"control__scale": 3.0, "control__on": "top", "output__every": 1, "objective__desired": {"control": ["0.3", "-1"]}}
RUNS = {
    "thrown": ("simulate", THROWN, {}),
    "bouncing": ("simulate", BOUNCING, {"initial__velocity": ["0", "-1"], "time__scheme": "contact-implicit", "time__end": 2.6}),
    "space": ("simulate", IN_SPACE, {"time__end": 0.9, "time__step": 0.02, "mesh__size": 0.5}),
    "single": ("simulate", BOUNCING, {"time__end": 0.01}),
    "stiff": ("simulate", STIFF, {"initial__velocity": ["0", "0"], "material__young": 5e6, "time__end": 0.02, "time__step": 1e-4}),
    "search": ("optimize", BLOCK_SCENE, SEARCH | {"objective__desired": {"control": WANTED}, "optimizer__max_iterations": 3}),
    "wanted": ("simulate", BLOCK_SCENE, SEARCH | {"control__initial": WANTED}),
    "pushed": ("optimize", BLOCK_SCENE, PUSHED | {"optimizer__max_iterations": 2}),
}
# Uniform loads, per volume or per mass, in the middle of a step.
LOADS = {
    "thrown": ("volume", lambda t: [0.5, -3 + t]),
    "bouncing": ("mass", lambda _: [0, -2]),
    "single": ("mass", lambda _: [0, -2]),
    "space": ("mass", lambda _: [0, 0.3, -2]),
}
IMPACTS = pytest.mark.parametrize("run", ("thrown", "bouncing", "space"), indirect=True)


class SceneRun(Run):
    """The run of a name, and what it printed."""

    def __init__(self, name: str, folder: Path) -> None:
        verb, scene, overrides = RUNS[name]
        if isinstance(scene, str):
            text, scene = scene, folder / f"{name}.toml"
            scene.write_text(text)
        self.name, self.printed = name, signorini(verb, scene, folder / name, **overrides).stdout
        super().__init__(folder / name)

    @functools.cached_property
    def load(self) -> np.ndarray:
        """Nodal forces of each step (steps × nodes × dim), means over the step."""
        per, force = LOADS[self.name]
        matrix, time = self.body.W if per == "volume" else self.body.M, self.steps["time"]
        return np.array([(matrix @ np.tile(force(t), len(self.body.points))).reshape(-1, self.dim) for t in (time[1:] + time[:-1]) / 2])

    @property
    def axes(self) -> str:
        return "xyz"[: self.dim]
