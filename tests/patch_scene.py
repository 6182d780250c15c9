# SPDX-License-Identifier: GPL-3.0-or-later
"""The patch test of contact: a block of 1 m is pressed down on its whole lower side, whose pressure is uniform on every mesh, since
uniform strain is in each space. The slowest motion, a quarter wave of shear at ω = 7.9/s with a lag of T = 0.1 s, dies as
exp(-T ω²/2 t), to 1e-12 in the 9 s after the top has stopped."""

from harness import SOURCE

PRESSURE = 50 * (0.1 - 0.05)  # N/m²: the top goes down 0.1 m, the gap is 0.05 m, the block is 1 m high


def patch(dim: int, size: float, step: float, degree: int = 1) -> str:
    """The scene, in the plane or in space."""
    still, zeros = '"0", ' * (dim - 1), "0, " * (dim - 1)
    return f"""
[mesh]
file = "{SOURCE / "tests" / "data" / ("square.geo" if dim == 2 else "cube.geo")}"
size = {size}
degree = {degree}
[time]
end = 10.0
step = {step}
[material]
density = 1.0
young = 50.0
poisson = 0.0
viscosity = {{ bulk = 1.6666666666666667, shear = 2.5 }}   # the elastic moduli times 0.1 s
[[clamp]]
on = "top"
value = [{still}"t < 1 ? -0.1 * sin(pi*t/2)^2 : -0.1"]
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = [{zeros}-0.05], normal = [{zeros}1] }}
"""
