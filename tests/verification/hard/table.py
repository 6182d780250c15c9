# SPDX-License-Identifier: GPL-3.0-or-later
"""What the families of hard cases share: their table, one line for each case."""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from harness import Figures, signorini, table  # noqa: E402

import numpy as np  # noqa: E402

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


class Table:
    """Prints a line for each case of a family and remembers whether one failed."""

    def __init__(self, family: str) -> None:
        self.family = family
        self.failed = False

    def row(self, case: str, figures: str, holds: bool) -> None:
        self.failed |= not holds
        print(f"{'ok  ' if holds else 'FAIL'}  {self.family:18} {case:58} {figures}", flush=True)


class Worst(Figures):
    """Of many figures the one that is farthest off, in units of its tolerance."""

    def __init__(self) -> None:
        self.count, self.ratio, self.name = 0, 0.0, "none"

    def show(self, name: str, found: float, expected: float, tolerance: float) -> None:
        ratio = abs(found - expected) / tolerance
        self.count += 1
        self.failed |= not ratio <= 1
        if not ratio <= self.ratio:
            self.ratio, self.name = ratio, name

    def __str__(self) -> str:
        name = self.name.split(",")[0].split(":")[0].split(" / ")[0]
        return f"{self.count} figures, {name} worst, at {self.ratio:.2f} of its tolerance"


def run(verb: str, scene: Path, out: Path, **overrides: object) -> tuple[dict[str, np.ndarray], dict]:
    """A run without stored fields: steps.csv and run.json."""
    signorini(verb, scene, out, **({"output__fields": []} | overrides))
    return table(out / "steps.csv"), json.loads((out / "run.json").read_text())


def energy(steps: dict[str, np.ndarray]) -> np.ndarray:
    return steps["kinetic_energy"] + steps["elastic_energy"]
