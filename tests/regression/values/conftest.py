# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of values share: runs, each made once."""

import functools
from collections.abc import Callable

import pytest
from regression.values.runs import SceneRun


@pytest.fixture(scope="session")
def run_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], SceneRun]:
    """The run of a name of runs.py."""
    folder = tmp_path_factory.mktemp("runs")
    return functools.cache(lambda name: SceneRun(name, folder))


@pytest.fixture
def run(request: pytest.FixtureRequest, run_of: Callable[[str], SceneRun]) -> SceneRun:
    """The run whose name is the test's parameter."""
    return run_of(request.param)
