# SPDX-License-Identifier: GPL-3.0-or-later
"""Where contact is weak check knows that J has slopes to one side alone, and holds them against differences of J.

Under a block that stands on the plane without weight every candidate is in weak contact: it can be lifted, not pushed down.
"""

import re

import numpy as np
import pytest
from harness import SOURCE, attempt

STANDING = SOURCE / "tests" / "data" / "standing.toml"
# A second plane through a corner, not at right angles to the first: two candidates share the forces of that node.
CORNER = [{"on": group, "obstacle": {"shape": "half-space", "point": [0, 0], "normal": normal}}
          for group, normal in (("bottom", [0, 1]), ("left", [0.8, 0.6]))]  # fmt: skip
CASES = {
    "as it is": {},
    "fine": {"mesh__size": 0.125},
    "degree 2": {"mesh__degree": 2},
    "massless": {"contact__mass": "massless"},
    "iterative": {"solver__linear": "iterative"},
    "corner": {"contact": CORNER},
}


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("overrides", CASES.values(), ids=CASES)
def test_slopes_to_either_side(overrides: dict[str, object], ranks: int) -> None:
    done = attempt("check", STANDING, None, ranks, **overrides)
    # A body at rest is not what the other checks ask for, and they say so; nothing else may be wrong.
    rows = re.findall(r"^(ok|FAIL) +(\S.*?)  ", done.stdout, re.MULTILINE)
    failed = [name for result, name in rows if result == "FAIL"]
    assert done.returncode == 1 and failed == ["the body moved (largest energy)"], f"{done.stdout}{done.stderr}"
    weak = int(re.search(r"Contact is weak\D* (\d+) times", done.stdout).group(1))
    slopes = [float(x) for x in re.findall(r"Slope of J along [+-]d: ([-+.e\d]+)\.$", done.stdout, re.MULTILINE)]
    assert weak > 50 and len(slopes) == 2
    assert abs(slopes[0] + slopes[1]) > 0.1 * np.max(np.abs(slopes))
    assert "Verdict: J has a kink along d" in done.stdout
    # By the gradient of the piece of J on each side, and by the order of what is left of J there.
    wanted = {f"{what} along {side}d{more}" for side in "+-"
              for what, more in (("slope", ": gradient against linearised motion"), ("Taylor order", ""))}  # fmt: skip
    assert wanted <= {name for _, name in rows}
