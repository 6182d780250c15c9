# SPDX-License-Identifier: GPL-3.0-or-later
"""Control problems from a first guess far away and with hardly any cost of control: J never rises from one accepted iterate to
the next, and the reason for which the search stops is true.

Every method searches, the slow one for every scheme. The first guess presses the half disc onto the plane with a hundred times
the force behind the desired motion. The reason "gradient norm below tolerance" is true if the last gradient norm is; "iteration
limit" if that many iterates were accepted and the norm is above; "stationary at a kink" if a combination of gradients is as short
as the tolerance requires of one and contact is weak there; "no further decrease" if more steps were tried than accepted and the
last accepted ones gained next to nothing.
"""

import functools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from harness import HALF_DISC, signorini, table
from schemes import SCHEMES, run

FAR = ["0", "-100"]  # times the control behind the desired motion
SEARCHES = {  # scheme, method, iterations
    **{scheme: (scheme, "projected-gradient", 25) for scheme in SCHEMES},
    "lbfgs": ("contact-implicit", "lbfgs", 30),
    "newton-cg": ("contact-implicit", "newton-cg", 8),
}
CASES = {
    **{f"alpha {alpha:.0e}": {"objective__alpha": alpha} for alpha in (1e-2, 1e-4, 1e-6, 1e-8)},
    "alpha 1e-08, bounds": {"objective__alpha": 1e-8, "control__lower": -0.5, "control__upper": 0.5},
    "alpha 1e-08, loose tolerance": {"objective__alpha": 1e-8, "optimizer__tolerance": 0.05, "optimizer__max_iterations": 500},
    "alpha 1e+01, tolerance beyond rounding": {"objective__alpha": 10, "optimizer__tolerance": 1e-16},
}


def overrides(search: str, case: str) -> dict[str, object]:
    scheme, method, iterations = SEARCHES[search]
    given = {"optimizer__method": method, "optimizer__max_iterations": iterations, "optimizer__tolerance": 1e-6}
    return SCHEMES[scheme] | given | CASES[case]


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], tuple[dict, dict]]:
    """history.csv and run.json by search and case; each search is run once."""

    @functools.cache
    def found(search: str, case: str) -> tuple[dict, dict]:
        out = tmp_path_factory.mktemp("search")
        signorini("optimize", HALF_DISC, out, mesh__size=2.0, control__initial=FAR, output__fields=[], **overrides(search, case))
        return table(out / "history.csv"), json.loads((out / "run.json").read_text())

    return found


def reason(record: dict) -> str:
    return record["stop_reason"].split(":")[0]


def is_true(record: dict, history: dict, limit: int, tolerance: float) -> bool:
    """Whether the search stopped for the reason that it names."""
    objective, norm = history["objective"], history["gradient_norm"]
    iterations, below = len(objective) - 1, norm[-1] <= tolerance * norm[0]
    match reason(record):
        case "gradient norm below tolerance":
            return below
        case "iteration limit":
            return iterations == limit and not below
        case "stationary at a kink":
            return record["kink"]["shortest_combination"] <= tolerance * norm[0] and len(record["kink"]["weak_contact"]) > 0
        case "no further decrease":
            tried = record["counters"]["steps"] / 150  # of 5e-5 s each in a sweep
            return not below and tried >= iterations + 1 and objective[-2] - objective[-1] < 1e-12 * objective[-1]
    return False


def test_first_guess_touches(tmp_path: Path) -> None:
    touched = int((run(HALF_DISC, tmp_path, mesh__size=2.0, control__initial=FAR)["active"] > 0).sum())
    print(f"{touched} steps in contact")
    assert touched > 0, "no contact: the cases say nothing"


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("search", SEARCHES)
def test_decrease_and_stop_reason(searched: Callable, search: str, case: str) -> None:
    history, record = searched(search, case)
    objective, norm = history["objective"], history["gradient_norm"]
    rise = np.max(objective[1:] / objective[:-1]) - 1
    print(f"J {objective[0]:.2e} -> {objective[-1]:.4e} in {len(objective) - 1} iterations, |g| by {norm[-1] / norm[0]:.0e}, "
          f"least decrease of J {-rise:.0e}; {reason(record)}")  # fmt: skip
    given = overrides(search, case)
    assert rise <= 0, "J rises"
    assert is_true(record, history, given["optimizer__max_iterations"], given["optimizer__tolerance"]), record["stop_reason"]


def test_three_reasons_occur(searched: Callable) -> None:
    reasons = {reason(searched(search, case)[1]) for search in SEARCHES for case in CASES}
    print("; ".join(sorted(reasons)))
    assert len(reasons) >= 3
