# SPDX-License-Identifier: GPL-3.0-or-later
"""The linear solver is chosen by time: for few steps of a body in space no factor is made, and the motion is the same."""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_BALL, signorini  # noqa: E402


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        runs = {}
        for linear in ("auto", "direct"):
            out = Path(folder) / linear
            # A factor takes as long as some tens of solves by conjugate gradients.
            signorini("simulate", HALF_BALL, out, mesh__size=0.9, time__end=2.5e-4, control__initial=["0", "0", "-0.9"],
                      solver__linear=linear, output__fields=[])  # fmt: skip
            runs[linear] = json.loads((out / "run.json").read_text())
        chosen = runs["auto"]["solver"]
        assert runs["direct"]["solver"].startswith("CHOLMOD"), runs["direct"]["solver"]
        assert chosen.startswith("CG") and "for 4 solves" in chosen, chosen  # two of the motion, two of the desired one
        values = [run["objective"]["value"] for run in runs.values()]
        assert values[1] > 0 and abs(values[0] / values[1] - 1) < 1e-8, values  # of the iterations
        print(f"{chosen}; J = {values[0]:.10g} and {values[1]:.10g}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
