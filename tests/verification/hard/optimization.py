# SPDX-License-Identifier: GPL-3.0-or-later
"""Control problems from a first guess far away and with hardly any cost of control: J never rises from one accepted iterate to
the next, and the reason for which the search stops is true.

Each method is asked, the slow one for every scheme. The first guess presses the half disc onto the plane with a hundred times the force behind the desired motion. True is
"gradient norm below tolerance" if the last gradient norm is; "iteration limit" if that many iterates were accepted and the
norm is above; "stationary at a kink" if a combination of gradients is as short as the tolerance asks of one and contact is weak
there; "no further decrease" if more steps were tried than accepted and the last accepted ones gained next to nothing.
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from table import SCHEMES, Table

from harness import HALF_DISC, signorini, table

FAR = ["0", "-100"]  # times the control behind the desired motion
MOST = 25
FASTER = {"lbfgs": 30, "newton-cg": 8}  # iterations
CASES = {
    **{f"alpha {alpha:.0e}": {"objective__alpha": alpha} for alpha in (1e-2, 1e-4, 1e-6, 1e-8)},
    "alpha 1e-08, bounds": {"objective__alpha": 1e-8, "control__lower": -0.5, "control__upper": 0.5},
    "alpha 1e-08, loose tolerance": {"objective__alpha": 1e-8, "optimizer__tolerance": 0.05, "optimizer__max_iterations": 500},
    "alpha 1e+01, tolerance beyond rounding": {"objective__alpha": 10, "optimizer__tolerance": 1e-16},
}


def true_reason(run: dict, history: dict, limit: int, tolerance: float) -> bool:
    objective, norm = history["objective"], history["gradient_norm"]
    iterations, below = len(objective) - 1, norm[-1] <= tolerance * norm[0]
    match run["stop_reason"].split(":")[0]:
        case "gradient norm below tolerance":
            return below
        case "iteration limit":
            return iterations == limit and not below
        case "stationary at a kink":
            return run["kink"]["shortest_combination"] <= tolerance * norm[0] and len(run["kink"]["weak_contact"]) > 0
        case "no further decrease":
            tried = run["counters"]["steps"] / 150  # of 5e-5 s each in a sweep
            return not below and tried >= iterations + 1 and objective[-2] - objective[-1] < 1e-12 * objective[-1]
    return False


def main() -> int:
    lines = Table("optimization")
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "out"
        signorini("simulate", HALF_DISC, out, mesh__size=2.0, control__initial=FAR, output__fields=[])
        touched = int((table(out / "steps.csv")["active"] > 0).sum())
        lines.row("the first guess", f"{touched} steps in contact", touched > 0)
        reasons = set()
        asked = [(scheme, over, "projected-gradient") for scheme, over in SCHEMES.items()]
        asked += [("contact-implicit", {}, method) for method in FASTER]
        for scheme, over, method in asked:
            for case, more in CASES.items():
                given = {"optimizer__method": method, "optimizer__max_iterations": FASTER.get(method, MOST), "optimizer__tolerance": 1e-6} | more
                signorini("optimize", HALF_DISC, out, mesh__size=2.0, control__initial=FAR, output__fields=[], **(over | given))
                history, run = table(out / "history.csv"), json.loads((out / "run.json").read_text())
                objective, norm = history["objective"], history["gradient_norm"]
                rise = np.max(objective[1:] / objective[:-1]) - 1
                reasons.add(run["stop_reason"])
                lines.row(f"{scheme}, {method}, {case}",
                          f"J {objective[0]:.2e} -> {objective[-1]:.4e} in {len(objective) - 1} iterations, |g| by {norm[-1] / norm[0]:.0e}, "
                          f"least decrease of J {-rise:.0e}; {run['stop_reason'].split(':')[0]}",
                          rise <= 0 and true_reason(run, history, given["optimizer__max_iterations"], given["optimizer__tolerance"]))  # fmt: skip
        lines.row("three reasons occurred", "; ".join(sorted(reason.split(":")[0] for reason in reasons)), len(reasons) >= 3)
    return 1 if lines.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
