# SPDX-License-Identifier: GPL-3.0-or-later
"""H1: a half disc pressed onto a plane, at rest, by three loads, against Hertz's pressure; pressed_disc.py derives the tolerances."""

from pathlib import Path

import pytest
from pressed_disc import HERTZ, SIZES, press


def test_order_of_the_profile(tmp_path: Path) -> None:
    coarse, fine = (press(size, "traction", tmp_path) for size in SIZES)
    assert fine - coarse / 2 <= HERTZ, "the error at h/2 is beyond half of that at h"


@pytest.mark.parametrize("load", ("body force", "moved clamp"))
def test_other_load(load: str, tmp_path: Path) -> None:
    press(SIZES[0], load, tmp_path)
