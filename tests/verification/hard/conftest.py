# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the figures that a hard case prints beside its name, in the list of `pytest -vv`."""

import pytest


def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, str] | None:
    if report.when == "call" and report.passed and report.capstdout:
        return "passed", ".", f"ok: {'; '.join(report.capstdout.splitlines())}"
    return None
