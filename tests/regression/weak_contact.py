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


BLOCK = SOURCE / "tests" / "data" / "block.toml"
# A block that flies 0.2 m at 1 m/s in 50 steps: its lower side is on the plane at the end of step 50, to rounding.
ARRIVING = {"mesh__size": 0.25, "time__end": 0.3, "time__step": 4e-3, "time__scheme": "contact-stabilized", "load__body": ["0", "0"],
            "contact__obstacle": {"shape": "half-space", "point": [0, -0.2], "normal": [0, 1]},
            "objective__desired": {"displacement": ["0", "0.1"]}, "check__control": ["0", "0"]}  # fmt: skip


def push(force: float) -> dict[str, object]:
    """A body load in the step of the arrival alone, N/m³."""
    return {"load__body": ["0", f"t > 0.1965 && t < 0.2005 ? {force} : 0"], "time__end": 0.6}


@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("overrides, least", (({}, 0.03), ({"mesh__degree": 2}, 0.03), ({"contact__friction": 0.3}, 0.03), (push(-50), 0.03), (push(1), 0.02)),
                         ids=("plain", "degree 2", "friction", "pressed", "lifted"))  # fmt: skip
def test_slopes_where_a_side_arrives_at_the_end_of_a_step(overrides: dict[str, object], least: float, ranks: int) -> None:
    """Projection and step of contact-stabilized steps have their kink at the same control, and open together to one side of it. A force in
    this step that presses the side on the plane or lifts it leaves the kink of the projection, which shows as the block rebounds."""
    done = attempt("check", BLOCK, None, ranks, **(ARRIVING | overrides))
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"
    slopes = [float(x) for x in re.findall(r"Slope of J along [+-]d: ([-+.e\d]+)\.$", done.stdout, re.MULTILINE)]
    assert "Verdict: J has a kink along d" in done.stdout and len(slopes) == 2
    assert abs(slopes[0] + slopes[1]) > least * np.max(np.abs(slopes))
    orders = re.findall(r"^ok +Taylor order along ([+-])d", done.stdout, re.MULTILINE)
    assert orders == ["+", "-"]
