# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of one problem that must agree: the same active candidates, and the same J and gradient on one, two and three ranks."""

from pathlib import Path

import numpy as np
import pytest
from harness import signorini, table


def same_sets(a: Path, b: Path) -> bool:
    """Whether the same candidates carry a force at all steps. Asserts contact on every obstacle."""
    ta, tb = table(a / "contact.csv"), table(b / "contact.csv")
    for obstacle in np.unique(ta["obstacle"]) if "obstacle" in ta else [None]:
        own = ta["obstacle"] == obstacle if obstacle is not None else slice(None)
        assert (ta["force"][own] > 0).any(), "no contact: the comparison says nothing"
    places = all(np.allclose(ta[axis], tb[axis], rtol=0, atol=1e-9) for axis in "xyz" if axis in ta)
    return np.array_equal(ta["force"] > 0, tb["force"] > 0) and places


def optimize_on_ranks(folder: Path, scene: Path, iterations: int = 3, **overrides: object) -> None:
    """Asserts that J and |g| agree at a fixed control; after some iterations too, where the step lengths, which come from small
    differences of J, have amplified the rounding. The runs are in `folder`/ranks-1 to ranks-3."""
    histories = []
    for ranks in (1, 2, 3):
        out = folder / f"ranks-{ranks}"
        signorini("optimize", scene, out, ranks, optimizer__max_iterations=iterations, optimizer__start="guess", output__fields=[],
                  **overrides)  # fmt: skip
        histories.append(table(out / "history.csv"))
        first, history = histories[0], histories[-1]
        assert same_sets(folder / "ranks-1", out), f"{ranks} ranks: the active sets differ"
        for name in ("objective", "gradient_norm"):
            print(f"{ranks} ranks: {name} {history[name][0]:.15e}, after {iterations} iterations {history[name][iterations]:.15e}")
            assert history[name][0] == pytest.approx(first[name][0], rel=1e-9, abs=0), f"{name} on {ranks} ranks"
            assert history[name][iterations] == pytest.approx(first[name][iterations], rel=1e-6, abs=0), f"{name} on {ranks} ranks"
