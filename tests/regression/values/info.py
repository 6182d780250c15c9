# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory, counts and recomputed steps that `info` prints are those of the mesh and of formulas."""

import re
from math import comb

import numpy as np
import pytest
from harness import signorini, stored
from recomputed import near
from regression.values.runs import BLOCK_SCENE


@pytest.fixture(scope="module")
def printed() -> str:
    return signorini("info", BLOCK_SCENE).stdout


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and cells."""
    out = tmp_path_factory.mktemp("mesh") / "out"
    signorini("simulate", BLOCK_SCENE, out, time__end=0.02)
    return stored(out, "state", "displacement")[:2]


def effects(printed: str) -> dict[str, str]:
    """The memory of each effect, empty for those without matrices."""
    return {line[:22].strip(): line[46:56].strip() for line in printed.split("adds in each step")[1].split("off:")[0].splitlines()}


def size(text: str) -> float:
    """Bytes of a printed size."""
    number, unit = text.split()
    return float(number) * {"kB": 1e3, "MB": 1e6, "GB": 1e9}[unit]


def test_effects_with_memory(printed: str) -> None:
    rows = effects(printed)
    assert {"viscosity", "contact", "body load", "control", "objective", "tables"} <= set(rows)
    assert {name for name, memory in rows.items() if memory} == {"viscosity", "contact", "body load", "control", "objective"}


def test_memory_of_matrices(printed: str, mesh: tuple[np.ndarray, np.ndarray]) -> None:
    """8 bytes an entry and 4 an index, one index for a block of entries."""
    nodes, cells = mesh
    blocks = len({(a, b) for cell in cells for a in cell for b in cell if a <= b})  # of a symmetric matrix
    for name, found in (("A", re.search(r" A (\S+ .B)", printed)[1]), ("viscosity", effects(printed)["viscosity"])):
        near(f"memory of {name}", size(found), blocks * (4 * 8 + 4) + 4 * len(nodes), 5e-3)


def test_counts(printed: str, mesh: tuple[np.ndarray, np.ndarray]) -> None:
    nodes, cells = mesh
    found = re.search(r"unknowns: (\d+) \((\d+) free\), cells: (\d+), candidates: (\d+), steps: (\d+) of (\S+) s", printed).groups()
    expected = [2 * len(nodes), 2 * len(nodes), len(cells), int((nodes[:, 1] < 1e-9).sum()), 30, 0.02]
    near("counts", [float(one) for one in found], expected)


@pytest.mark.parametrize("budget", (10_000, 20_000))
def test_recomputed_steps(budget: int) -> None:
    """Griewank and Walther, Algorithm 799: revolve (2000): r l - C(s + r, r - 1) of l states from s checkpoints, the start among both."""
    printed = signorini("info", BLOCK_SCENE, trajectory__storage="checkpoints", trajectory__budget=budget).stdout
    again, slots = re.search(r"and (\S+) recomputed steps of each motion \((\d+) checkpoints\)", printed).groups()
    states, checkpoints, repeats = 31, int(slots) + 1, 0
    while comb(checkpoints + repeats, repeats) < states:
        repeats += 1
    assert 1 < checkpoints < states
    near("steps recomputed", float(again), (repeats * states - comb(checkpoints + repeats, repeats - 1)) / 30 - 1, 0.0051, 1)
