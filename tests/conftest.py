# SPDX-License-Identifier: GPL-3.0-or-later
"""What pytest needs to know of these tests."""

import sys

import pytest

pytest.register_assert_rewrite("agreeing", "browser", "case_run", "common", "drawn", "exact_bar", "falling_disc", "fit_runs", "harness", "patch_scene",
                               "pressed_disc", "recomputed", "schemes", "soft_scenes", "studies", "table", "written_mesh")  # fmt: skip


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Ends all ranks where a test fails on one of several: the others would wait for it for ever."""
    if report.failed and "mpi4py.MPI" in sys.modules:
        comm = sys.modules["mpi4py.MPI"].COMM_WORLD
        if comm.size > 1:
            print(f"rank {comm.rank}: {report.nodeid}\n{report.longreprtext}{report.capstdout}", file=sys.stderr, flush=True)
            comm.Abort(1)
