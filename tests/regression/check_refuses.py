# SPDX-License-Identifier: GPL-3.0-or-later
"""`check` fails, with exit status 1, where it has nothing to check: no contact, no motion, no size that keeps the sets."""

import re
from pathlib import Path

import pytest
from harness import HALF_DISC, SOURCE, attempt

DATA = SOURCE / "tests" / "data"
BLOCK = DATA / "block.toml"
COARSE = {"mesh__size": 3}
CASES = {
    "contact never closed": (1, ["never; contact is not checked", "A check failed."], HALF_DISC,
                             COARSE | {"check__control": ["0", "-0.3"]}),
    "nothing moves": (1, ["FAIL  the body moved"], HALF_DISC, COARSE | {"check__control": ["0", "0"]}),
    "no contact in the scene": (0, ["the checks are those of a linear problem", "contact was not checked"], DATA / "manufactured.toml", {}),
    "contact and control": (0, ["Taylor order", "|d| = |u|:", "All checks hold, contact included."], BLOCK, {}),
    "no control to be as long as": (0, ["|d| = 1, since u = 0:"], BLOCK, {"check__control": ["0", "0"]}),
}  # fmt: skip


def check(status: int, fragments: list[str], scene: Path, **overrides: object) -> None:
    done = attempt("check", scene, **overrides)
    assert done.returncode == status and [text for text in fragments if text not in done.stdout] == [], done.stdout


@pytest.mark.parametrize("status, fragments, scene, overrides", CASES.values(), ids=CASES)
def test_status(status: int, fragments: list[str], scene: Path, overrides: dict[str, object]) -> None:
    check(status, fragments, scene, **overrides)


def test_contact_without_control(tmp_path: Path) -> None:
    text = re.sub(r"(?ms)^\[(control|objective|optimizer)\].*?(?=^\[|\Z)", "", BLOCK.read_text())
    scene = tmp_path / "block.toml"
    scene.write_text(text.replace('"square.geo"', f'"{DATA / "square.geo"}"'))
    check(0, ["no derivatives to check", "contact included"], scene)
