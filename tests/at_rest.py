# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes at rest after one step, and what tests of their pressure share.

With a viscosity of T = 1000 s times the elastic moduli and steps of 2T the step solves the static problem, but for a share
ρ L²/(E τ²) < 1e-8 of the inertia.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from harness import SOURCE

E, NU, DENSITY, LAG = 200.0, 0.3, 1e-2, 1e3
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
SCHEMES = {"contact-implicit": ("contact-implicit", "consistent"), "contact-stabilized": ("contact-stabilized", "consistent"),
           "massless": ("contact-implicit", "massless")}  # fmt: skip

SCENE = f"""
[mesh]
file = "{{mesh}}"
{{size}}
degree = {{degree}}
[time]
end = {6 * LAG}
step = {2 * LAG}
scheme = "{{scheme}}"
[material]
density = {DENSITY}
young = {E}
poisson = {NU}
viscosity = {{{{ bulk = {LAG * (LAMBDA + 2 * MU / 3)}, shear = {LAG * MU} }}}}
{{tables}}
[output]
fields = ["strain", "stress", "von_mises", "pressure"]
"""

RUNS = [*((scheme, 1) for scheme in SCHEMES), ("contact-implicit", 2)]  # on so many ranks

RADIUS, MODULUS = 8.0, E / (1 - NU**2)
PRESS = SOURCE / "meshes" / "press.geo"
GROUPS = {2: ("Curve", "Surface"), 3: ("Surface", "Volume")}
Field = Callable[[np.ndarray], np.ndarray]  # values at places


def box(dim: int, folder: Path) -> Path:
    """Unit square or cube, an unstructured mesh; groups x0, x1, y0, … of its sides."""
    side, body = GROUPS[dim]
    text = 'SetFactory("OpenCASCADE");\n' + ("Rectangle(1) = {0, 0, 0, 1, 1};\n" if dim == 2 else "Box(1) = {0, 0, 0, 1, 1, 1};\n")
    text += f'e = 1e-6;\nPhysical {body}("body") = {{1}};\n'
    for axis, name in enumerate("xyz"[:dim]):
        for at in (0, 1):
            low = ", ".join(f"{at} - e" if c == axis else "-e" for c in range(3))
            high = ", ".join(f"{at} + e" if c == axis else "1 + e" for c in range(3))
            text += f'Physical {side}("{name}{at}") = {side} In BoundingBox {{{low}, {high}}};\n'
    file = folder / f"box-{dim}.geo"
    file.write_text(text)
    return file


def hat_means(nodes: np.ndarray, facets: np.ndarray, exact: Field, weight: Field = lambda places: np.ones(len(places))) -> np.ndarray:
    """Mean of a pressure at each node, weighted with the node's hat function and a given weight, by midpoints of the facets' parts."""
    corners = facets.shape[1]
    n = 24
    if corners == 2:
        s = (np.arange(n) + 0.5) / n
        weights = np.column_stack([1 - s, s])
    else:  # midpoints of n² triangles
        up = [(3 * i + 1, 3 * j + 1) for i in range(n) for j in range(n - i)]
        down = [(3 * i + 2, 3 * j + 2) for i in range(n - 1) for j in range(n - 1 - i)]
        st = np.array(up + down) / (3 * n)
        weights = np.column_stack([1 - st.sum(axis=1), st])
    sums = np.zeros((2, len(nodes)))
    for facet in facets:
        places = weights @ nodes[facet]
        hats = weights * weight(places)[:, None]
        edges = nodes[facet[1:]] - nodes[facet[0]]
        size = np.linalg.norm(np.cross(*edges)) / 2 if corners == 3 else np.linalg.norm(edges[0])
        sums[0, facet] += size * (hats * exact(places)[:, None]).mean(axis=0)
        sums[1, facet] += size * hats.mean(axis=0)
    return sums[0] / np.where(sums[1] > 0, sums[1], 1)
