# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts, tables and motions of pages, figures and films show the numbers of the run, recomputed by other code than postprocess/."""

from collections.abc import Callable
from pathlib import Path

import drawn
import numpy as np
import pytest
from regression.values.runs import SceneRun

NAMES = ("thrown", "bouncing", "space", "search", "pushed", "stiff")


@pytest.mark.parametrize("draw", (drawn.page, drawn.figures, drawn.film), ids=("page", "figures", "film"))
@pytest.mark.parametrize("run", NAMES, indirect=True)
def test_of_a_run(run: SceneRun, draw: Callable[[SceneRun], None]) -> None:
    draw(run)


@pytest.mark.parametrize("first, second", (("thrown", "bouncing"), ("search", "pushed")))
def test_page_of_two_runs(first: str, second: str, run_of: Callable[[str], SceneRun]) -> None:
    drawn.comparison(run_of(first), run_of(second))


def test_enlargements() -> None:
    drawn.enlargements()


@pytest.mark.parametrize("run", ("stiff",), indirect=True)
def test_stiff_body_hardly_moves(run: SceneRun) -> None:
    assert 1e-4 < np.max(np.abs(run.y)) < 0.01, "its displacements are not drawn enlarged"


def test_single_step(tmp_path: Path) -> None:
    """A single step is enough for a page with energies."""
    ballast = np.ones(3 * 10**7)  # of this process, not of the run
    run = SceneRun("single", tmp_path)
    assert run.manifest["peak_memory_bytes"] < ballast.nbytes
    views = drawn.views_of(drawn.report_run.page(drawn.RunFolder(run.path)))
    assert len(drawn.numbers(views["energies"][""]["data"][0]["x"])) == 2
