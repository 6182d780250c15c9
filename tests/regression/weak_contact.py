# SPDX-License-Identifier: GPL-3.0-or-later
"""Where contact is weak check knows that J has slopes to one side alone, and holds them against differences of J.

Under a block that stands on the plane without weight every candidate is in weak contact: it can be lifted, not pushed down.
"""

import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SOURCE, attempt  # noqa: E402

STANDING = SOURCE / "tests" / "data" / "standing.toml"
# A second plane through a corner, not at right angles to the first: two candidates share the forces of that node.
CORNER = [{"on": group, "obstacle": {"shape": "half-space", "point": [0, 0], "normal": normal}}
          for group, normal in (("bottom", [0, 1]), ("left", [0.8, 0.6]))]  # fmt: skip


def main() -> int:
    for ranks in (1, 2):
        for overrides in ({}, {"mesh__size": 0.125}, {"mesh__degree": 2}, {"contact__mass": "massless"}, {"solver__linear": "iterative"},
                          {"contact": CORNER}):  # fmt: skip
            done = attempt("check", STANDING, None, ranks, **overrides)
            # A body at rest is not what the other checks ask for, and they say so; nothing else may be wrong.
            rows = re.findall(r"^(ok|FAIL) +(\S.*?)  ", done.stdout, re.MULTILINE)
            failed = [name for result, name in rows if result == "FAIL"]
            assert done.returncode == 1 and failed == ["the body moved (largest energy)"], f"{done.stdout}{done.stderr}"
            weak = int(re.search(r"Contact is weak (\d+) times", done.stdout).group(1))
            slopes = [float(x) for x in re.findall(r"Slope of J along [+-]d: ([-+.e\d]+)\.$", done.stdout, re.MULTILINE)]
            assert weak > 50 and len(slopes) == 2
            assert abs(slopes[0] + slopes[1]) > 0.1 * np.max(list(map(abs, slopes))), slopes
            assert "Verdict: a kink along d" in done.stdout, done.stdout
            # By the gradient of the piece of J on each side, and by the order of what is left of J there.
            wanted = {f"{what} along {side}d{more}" for side in "+-"
                      for what, more in (("slope", ": gradient against linearised motion"), ("Taylor order", ""))}  # fmt: skip
            assert wanted <= {name for _, name in rows}, rows
            print(f"{ranks} ranks, {overrides or 'as it is'}: weak {weak} times, slopes {slopes}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
