# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of the verification manual and their figures (docs/verification.py)."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Figure:
    """A number of a case beside its reference. The tolerance is relative, or absolute where the reference is 0."""

    name: str
    unit: str
    reference: float
    got: float
    tolerance: float

    @property
    def deviation(self) -> float:
        return self.got / self.reference - 1 if self.reference else self.got

    @property
    def holds(self) -> bool:
        return abs(self.deviation) <= self.tolerance

    def cells(self) -> list[str]:
        """The texts of a table: name with unit, reference, got, deviation, tolerance."""
        name = f"{self.name}, {self.unit}" if self.unit else self.name
        deviation = f"{100 * self.deviation:+.2g} %" if self.reference else f"{self.deviation:.2g}"
        tolerance = f"{100 * self.tolerance:g} %" if self.reference else f"{self.tolerance:g}"
        return [name, f"{self.reference:.5g}", f"{self.got:.5g}", deviation, tolerance]


@dataclass(frozen=True)
class Case:
    """A page of the manual. `figures` takes the folders of the runs, one for each of `runs`, which are overrides of the scene."""

    name: str
    title: str
    problem: str
    reference: str
    kind: str
    tolerance: str
    figures: Callable[..., list[Figure]]
    runs: tuple[dict[str, object], ...] = ({},)
    scene: str = ""  # relative to the pages; else of the case's name

    @property
    def file(self) -> str:
        return self.scene or f"{self.name}.toml"


def impact(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())["impact"]["all"]
