# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of steps that the motion chooses: the same steps, to the last bit, of bodies that are moved, mirrored, moved along the
plane or given in other units by powers of two, and on several ranks; in any other unit the same but for ties, which a change of the
tolerance in its ninth digit decides.
"""

import functools
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest
from harness import boundary, signorini, table
from written_mesh import write_mesh

SEEDS = range(6)
POWERS = "2^-20 m, 2^10 s, 2^7 kg"
FRAMES = {
    "moved": {"moved": (64.0, -128.0)},
    "mirrored": {"mirrored": True},
    "100 v along the plane": {"sideways": 100},
    POWERS: {"unit": (2.0**-20, 2.0**10, 2.0**7)},
    "2 ranks": {"ranks": 2},
    "3 ranks": {"ranks": 3},
}
OTHER_UNITS = {"mm, ms, g": (1e3, 1e3, 1e3), "inch, h, lb": (39.37, 1 / 3600, 2.2046)}
Steps = tuple[np.ndarray, np.ndarray]


def disc(rings: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """A mesh of a disc of radius 1 m: rings of 6, 12, 18 … nodes around its centre."""
    points, cells, before = [[0.0, 0.0]], [], [0]
    for ring in range(1, rings + 1):
        angles = 2 * np.pi * (np.arange(6 * ring) + 0.25) / (6 * ring)
        own = list(range(len(points), len(points) + 6 * ring))
        points += [[ring / rings * np.cos(angle), ring / rings * np.sin(angle)] for angle in angles]
        for side in range(6):
            for i in range(ring):
                outer = [own[(side * ring + i + j) % len(own)] for j in (0, 1)]
                inner = [before[(side * (ring - 1) + i + j) % len(before)] for j in (0, 1)]
                cells.append([outer[0], outer[1], inner[0]])
                if i < ring - 1:
                    cells.append([inner[0], outer[1], inner[1]])
        before = own
    return np.array(points), np.array(cells)


class Case:
    """A disc that falls onto a plane, in SI units times those of `unit` (m, s, kg), its frame moved and mirrored."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.wave, self.poisson = 10 ** rng.uniform(1, 3), rng.uniform(0, 0.4)
        self.speed = self.wave * 10 ** rng.uniform(-4, -1.5)
        self.gap = 2.0 ** rng.uniform(-8, 0) if seed % 3 else 0.0
        self.viscosity = 10 ** rng.uniform(-3, -1) if seed % 2 else 0.0
        self.scheme = ("contact-implicit", "contact-stabilized", "massless")[seed % 3]
        self.tolerance = (1e-2, 1e-3)[seed % 2]

    def run(self, folder: Path, unit: tuple[float, float, float] = (1, 1, 1), moved: tuple[float, float] = (0, 0), mirrored: bool = False,
            sideways: float = 0, ranks: int = 1, tolerance: float = 1) -> Steps:  # fmt: skip
        """Ends of the steps (in the unit) and levels below an eighth of the time; asserts contact."""
        length, second, kg = unit
        points, cells = disc()
        if mirrored:
            points, cells = points * [-1, 1], cells[:, [1, 0, 2]]
        facets = boundary(cells)
        low = points[facets][:, :, 1].max(axis=1) < 0.3
        points = (points + moved) * length
        write_mesh(folder / "disc.msh", points, cells, {"low": facets[low], "high": facets[~low]})
        end = (self.gap / self.speed + 40 / self.wave) * second
        density, modulus = 1000 * kg / length**2, 1000 * self.wave**2 * kg / second**2  # of the plane, per depth of 1
        scene = folder / "disc.toml"
        scheme = "contact-stabilized" if self.scheme == "contact-stabilized" else "contact-implicit"
        eta = self.viscosity * modulus * second / self.wave
        scene.write_text(f"""[mesh]
file = "disc.msh"
[time]
end = {end!r}
step = "auto"
tolerance = {self.tolerance * tolerance!r}
scheme = "{scheme}"
[material]
density = {density!r}
young = {modulus!r}
poisson = {self.poisson!r}
viscosity = {{ bulk = {eta!r}, shear = {eta!r} }}
[contact]
on = "low"
obstacle = {{ shape = "half-space", point = [{moved[0] * length!r}, {(moved[1] - 1 - self.gap) * length!r}], normal = [0, 1] }}
initial = "project"
mass = "{"massless" if self.scheme == "massless" else "consistent"}"
[initial]
velocity = ["{sideways * self.speed * length / second!r}", "{-self.speed * length / second!r}"]
""")
        signorini("simulate", scene, folder / "run", ranks=ranks, output__fields=[], output__tables=["steps"])
        rows = table(folder / "run" / "steps.csv")
        assert np.max(rows["normal_force"]) > 0, "no contact occurred"
        return rows["time"] / second, np.round(np.log2(end / 8 / np.diff(rows["time"]))).astype(int)


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Steps]:
    """The steps of each seed's case as it is; each motion is computed once."""
    return functools.cache(lambda seed: Case(seed).run(tmp_path_factory.mktemp("given")))


def same(one: np.ndarray, other: np.ndarray) -> bool:
    return len(one) == len(other) and bool((one == other).all())


def first_difference(one: np.ndarray, other: np.ndarray) -> str:
    k = next((k for k, (a, b) in enumerate(zip_longest(one, other)) if a != b), None)
    return "the same levels" if k is None else f"step {k + 1} of {len(one)} and {len(other)}: levels {one[k:k + 2]} and {other[k:k + 2]}"


def test_lengths_vary(given: Callable) -> None:
    assert sum(len(set(given(seed)[1])) > 1 for seed in SEEDS) > len(SEEDS) / 2, "one length alone says nothing"


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_same_steps(given: Callable, seed: int, frame: str, tmp_path: Path) -> None:
    (times, levels), (there, found) = given(seed), Case(seed).run(tmp_path, **FRAMES[frame])
    assert same(levels, found), first_difference(levels, found)
    # Powers of two change no digit of a length, though its decimal ones in the table.
    assert frame == POWERS or same(times, there)


@pytest.mark.parametrize("unit", OTHER_UNITS)
@pytest.mark.parametrize("seed", SEEDS)
def test_other_unit(given: Callable, seed: int, unit: str, tmp_path: Path) -> None:
    levels, (_, found) = given(seed)[1], Case(seed).run(tmp_path, unit=OTHER_UNITS[unit])
    if not same(levels, found):
        print(first_difference(levels, found))
        assert any(same(found, Case(seed).run(tmp_path, tolerance=1 + sign * 1e-9)[1]) for sign in (1, -1)), "no tie"
