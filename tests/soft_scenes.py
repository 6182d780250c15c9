# SPDX-License-Identifier: GPL-3.0-or-later
"""What scenes of the tests of pages and figures share: a soft block of the unit's size, in the plane or in space."""

from harness import SOURCE


def soft(mesh: str, size: float, end: float, step: float) -> str:
    """The tables that a scene needs, with a mesh of tests/data; lengths in m, times in s."""
    return f"""
[mesh]
file = "{SOURCE / "tests" / "data" / mesh}"
size = {size}

[time]
end = {end}
step = {step}

[material]
density = 1.0
young = 50.0
poisson = 0.3
viscosity = {{ bulk = 0.05, shear = 0.05 }}
"""


# A cube that comes down on a ball.
ON_A_BALL = soft("cube.geo", 0.34, 0.4, 0.02) + """
[contact]
on = "bottom"
obstacle = { shape = "ball", center = [0.5, 0.5, -0.62], radius = 0.6 }

[initial]
velocity = ["0", "0", "-1"]
"""

# The half section of a half ball that falls onto a floor, of which the run writes stresses too.
REVOLVED = soft("../../meshes/half-ball-section.geo", 4, 4.0, 0.1).replace("\nsize", '\nmodel = "axisymmetric"\nsize') + """
[contact]
on = "contact"
obstacle = { shape = "half-space", point = [0, -15.2], normal = [0, 1] }

[initial]
velocity = ["0", "-1"]

[output]
fields = ["displacement", "velocity", "stress", "von_mises", "pressure"]
"""

# Tables that throw a square onto a tilted plane, which its corner meets first.
ONTO_A_SLOPE = """
[contact]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.1], normal = [0.3, 1] }

[initial]
velocity = ["0", "-1"]
"""
