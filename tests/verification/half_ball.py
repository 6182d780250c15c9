# SPDX-License-Identifier: GPL-3.0-or-later
"""The half ball at sizes that matter: derivatives, and the same J, gradient norm and contact on one, two and three ranks."""

import json
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from agreement import compare_ranks  # noqa: E402
from harness import HALF_BALL, signorini  # noqa: E402

# By the number of free unknowns. Finer elements call for shorter steps; the largest run ends well within contact.
SIZES = {8_000: {"mesh__size": 1.3},
         20_000: {"mesh__size": 0.92},
         140_000: {"mesh__size": 0.465, "time__step": 5e-5, "time__end": 2.5e-3}}  # fmt: skip
# MUMPS, on several ranks, first solves for each of the largest run's 1,120 candidates, and that takes ten minutes.
SOLVERS = {8_000: "direct", 20_000: "direct", 140_000: "iterative"}


def main() -> int:
    unknowns = int(sys.argv[3])
    overrides = SIZES[unknowns]
    start = time.perf_counter()
    print(signorini("check", HALF_BALL, **overrides).stdout, end="")
    print(f"derivatives: {time.perf_counter() - start:.0f} s")
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        holds = compare_ranks(Path(folder), HALF_BALL, iterations=0, control__initial=["0", "0", "-0.9"],
                              solver__linear=SOLVERS[unknowns], **overrides)  # fmt: skip
        print(f"ranks: {time.perf_counter() - start:.0f} s")
        for ranks in (1, 2, 3):
            run = json.loads((Path(folder) / f"ranks-{ranks}" / "run.json").read_text())
            # The mesher's next version may make a few elements more.
            assert abs(run["free_unknowns"] / unknowns - 1) < 0.1
            print(f"{ranks} ranks: {run['free_unknowns']} free unknowns, {run['solver'].partition(' (')[0]}, "
                  f"{run['peak_memory_bytes'] / 1e9:.2f} GB at most; seconds: "
                  + ", ".join(f"{phase} {run['timings'][phase]['seconds']:.2f}" for phase in ("solver", "forward", "adjoint")))  # fmt: skip
    return 0 if holds else 1


if __name__ == "__main__":
    raise SystemExit(main())
