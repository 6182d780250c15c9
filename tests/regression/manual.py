# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/verification/: every case is within its tolerance, and its page has the figures, the texts and the commands of docs/verification.py.

`./dev exec python3 docs/verification.py` writes the pages. The figures of a page may be those of another machine: they must be within the
tolerance too.
"""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from harness import SOURCE


def script() -> ModuleType:
    """docs/verification.py, whose name is also that of the pages' folder."""
    spec = importlib.util.spec_from_file_location("verification_manual", SOURCE / "docs" / "verification.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for it
    spec.loader.exec_module(module)
    return module


MANUAL = script()
each_case = pytest.mark.parametrize("case", MANUAL.CASES, ids=lambda case: case.name)


def shipped(case: object) -> str:
    return (MANUAL.PAGES / f"{case.name}.md").read_text()


def without_numbers(page: str) -> str:
    """A page without what another run may change."""
    return re.sub(r"(?m)^\|.*\|$", "", re.sub(r"(?m)^Seconds: .*$", "", page))


@each_case
def test_case(case: object, tmp_path: Path) -> None:
    found = MANUAL.run(case, tmp_path)
    for figure in found:
        print(*figure.cells(), sep="  ")
    assert not [figure.name for figure in found if not figure.holds], "outside of the tolerance"
    assert without_numbers(shipped(case)) == without_numbers(MANUAL.page(case, found, 0)), "write the pages by docs/verification.py"
    rows = MANUAL.cells(shipped(case))
    assert [(row[0], row[1], row[4]) for row in rows] == [(cells[0], cells[1], cells[4]) for cells in (figure.cells() for figure in found)]
    for figure, row in zip(found, rows):
        on_page = float(row[2])
        deviation = on_page / figure.reference - 1 if figure.reference else on_page
        assert abs(deviation) <= figure.tolerance * 1.001, f"{figure.name} on the page"  # five digits


def test_index() -> None:
    """The table of all cases has the figures of their pages."""
    pages = {case.name: shipped(case) for case in MANUAL.CASES}
    assert (MANUAL.PAGES / "index.md").read_text() == MANUAL.index(pages)


def test_every_page_is_a_case() -> None:
    names = {path.stem for path in MANUAL.PAGES.glob("*.md")} - {"index"}
    assert names == {case.name for case in MANUAL.CASES}
    assert {case.file for case in MANUAL.CASES if not case.scene} == {path.name for path in MANUAL.PAGES.glob("*.toml")}
