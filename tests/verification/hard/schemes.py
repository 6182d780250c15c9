# SPDX-License-Identifier: GPL-3.0-or-later
"""What the families of hard cases share: the schemes, a disc, a run's table and its rounding."""

from pathlib import Path

import numpy as np
from harness import signorini, table

SCHEMES = {
    "contact-implicit": {},
    "contact-stabilized": {"time__scheme": "contact-stabilized"},
    "massless": {"contact__mass": "massless"},
}
# A disc of radius 1 m; contact below.
DISC = """
Point(1) = {0, 0, 0};  Point(2) = {0, -1, 0};  Point(3) = {0.8, -0.6, 0};  Point(4) = {0, 1, 0};  Point(5) = {-0.8, -0.6, 0};
Circle(1) = {2, 1, 3};  Circle(2) = {3, 1, 4};  Circle(3) = {4, 1, 5};  Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("contact") = {4, 1};
"""
EPSILON = np.finfo(float).eps
ROW = 14  # entries of a row of D, each rounded


def run(scene: Path, out: Path, **overrides: object) -> dict[str, np.ndarray]:
    """Runs a scene, without stored fields unless an override asks for some; its steps.csv."""
    signorini("simulate", scene, out, **({"output__fields": []} | overrides))
    return table(out / "steps.csv")


def energy(steps: dict[str, np.ndarray]) -> np.ndarray:
    return steps["kinetic_energy"] + steps["elastic_energy"]


def rounding(courant: float, reach: float) -> float:
    """Change of energy by rounding, relative to the first energy, at most. A step solves D y = r to a residual ε |D| |y|, whose
    work is (2/τ²) ε |D| |y| |y_k − y_{k−1}|; |y| is `reach` times v τ, after so many steps of flight, and |D| is at most
    m (1 + (ωτ/2)²) with the largest frequency ω of the mesh, 12 c/h for the flattest of its linear triangles."""
    return 4 * ROW * EPSILON * reach * (1 + (6 * courant) ** 2)
