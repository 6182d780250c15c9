# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of keys share: the mark that names the keys a test shows, and runs in folders of the test's own."""

import functools
from pathlib import Path

import pytest

pytest.register_assert_rewrite("regression.keys.runs")
from regression.keys.runs import Run, Runner, optimize_in, simulate_in  # noqa: E402


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "key(*names): the test shows the effect of a key, or of some that have none without each other")


@pytest.fixture
def simulate(tmp_path: Path) -> Runner:
    return functools.partial(simulate_in, tmp_path)


@pytest.fixture
def optimize(tmp_path: Path) -> Runner:
    return functools.partial(optimize_in, tmp_path)


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run of the block as it is."""
    return simulate_in(tmp_path_factory.mktemp("plain"))
