# SPDX-License-Identifier: GPL-3.0-or-later
"""Another unit of the control (with its scale, bounds and cost) or of J must not change a search: not its iterates, nor its reason
to stop, nor its certificate.

By factors that are powers of two the numbers of a search change but their digits stay, so whole searches are held to be the same,
down to the certificate. Other factors round, and any rounding grows among kinks, as that of a cost changed in its last digit does
(on catch to 1e-4 of J within 12 iterations of newton-cg), so these are held to the same iterates for a few iterations.

Two pairs of factors of each kind; with a further argument, `whole`, all nine.
"""

import json
import sys
import tempfile
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SOURCE, Figures, signorini, stored, table  # noqa: E402

import numpy as np  # noqa: E402

WHOLE = sys.argv[3:] == ["whole"]
METHODS = ("projected-gradient", "lbfgs", "newton-cg")
LARGE = 2.0**30
EXACT = [pair for pair in product((1 / LARGE, 1, LARGE), repeat=2) if pair != (1, 1)] if WHOLE else [(LARGE, 1 / LARGE), (1 / LARGE, 1 / LARGE)]
ROUNDED = [pair for pair in product((1e-9, 1, 1e9), repeat=2) if pair != (1, 1)] if WHOLE else [(1e-9, 1e9), (1e9, 1e9)]
FEW = {"projected-gradient": 6, "lbfgs": 6, "newton-cg": 3}  # iterations: those of newton-cg are up to 200 products long
SAME = 1e-6

HALF = {"scale": 1e6, "alpha": 1e-2, "gamma": 7.5e-4, "desired": ["0", "-1"]}
CAUGHT = {"scale": 1.0, "alpha": 1e-4, "gamma": 0.1, "lower": -1.0, "upper": 1.0}
SCENES = {
    "half disc": (HALF_DISC, HALF, {"mesh__size": 2, "time__step": 1e-4}, 1000 if WHOLE else 20),
    "catch": (SOURCE / "scenes" / "catch.toml", CAUGHT, {"mesh__size": 0.2, "time__step": 1e-2}, 60 if WHOLE else 20),
}


def in_units(values: dict, control: float, objective: float) -> dict:
    """The scene with controls as many times as large, and J."""
    keys = {"control__scale": values["scale"] / control, "objective__tracking": objective,
            "objective__alpha": values["alpha"] * objective / control**2, "objective__gamma": values["gamma"] * objective}  # fmt: skip
    if "desired" in values:
        keys["objective__desired"] = {"control": [f"{control!r}*({e})" for e in values["desired"]]}
    return keys | {f"control__{bound}": values[bound] * control for bound in ("lower", "upper") if bound in values}


def searched(out: Path, scene: str, method: str, iterations: int, control: float, objective: float) -> dict:
    """A search, its figures in the scene's own units."""
    file, values, coarse, _ = SCENES[scene]
    signorini("optimize", file, out, output__fields=["control"], output__every=10, optimizer__method=method,
              optimizer__checkpoint=0, optimizer__max_iterations=iterations, **coarse, **in_units(values, control, objective))  # fmt: skip
    history, run = table(out / "history.csv"), json.loads((out / "run.json").read_text())
    kink = run.get("kink")
    step = control**2 / objective if method == "projected-gradient" else 1
    return {"J": history["objective"] / objective, "|g|": history["gradient_norm"] * control / objective,
            "step": history["step_length"] / step, "sweeps": history["forward_sweeps"] + history["adjoint_sweeps"],
            "control": stored(out, "control", "control")[2] / control, "stop": run["stop_reason"],
            "active": (table(out / "steps.csv")["active"] > 0).sum(),
            "kink": kink and [kink["radius"] / control, kink["shortest_combination"] * control / objective],
            "weak": kink and [(w["step"], w["candidate"]) for w in kink["weak_contact"]]}  # fmt: skip


def difference(a: dict, b: dict) -> float:
    """Of two searches, relative; infinite where they made other steps or ended otherwise."""
    if (a["stop"], a["weak"], len(a["J"])) != (b["stop"], b["weak"], len(b["J"])) or (a["sweeps"] != b["sweeps"]).any():
        return np.inf
    values = [(a[key], b[key]) for key in ("J", "|g|", "step", "control")] + ([(a["kink"], b["kink"])] if a["kink"] else [])
    return np.max([np.max(np.abs(np.subtract(x, y)) / np.max(np.abs(x))) for x, y in values])


def main() -> int:
    figures = Figures()
    kinks = 0
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        for (scene, (*_, most)), method in product(SCENES.items(), METHODS):
            # projected-gradient does not get to a certificate, of the others lbfgs gets there first
            enough = int(np.minimum(most, 100)) if method == METHODS[0] else 1000 if (scene, method) == ("half disc", "lbfgs") else most
            for iterations, pairs, allowed in ((enough, EXACT, 0), (FEW[method], ROUNDED, SAME)):
                given = searched(out, scene, method, iterations, 1, 1)
                kinks += bool(given["kink"])
                certified = f"; {given['kink'][1]:.1e} within {given['kink'][0]:.1e}" if given["kink"] else ""
                print(f"{scene}, {method}: {len(given['J']) - 1} iterations, {given['sweeps'][-1]:.0f} sweeps, J {given['J'][-1]:.8f}, "
                      f"{given['active']} steps in contact, {given['stop']}{certified}", flush=True)  # fmt: skip
                figures.least("steps in contact", given["active"], 5)
                for control, objective in pairs:
                    other = searched(out, scene, method, iterations, control, objective)
                    figures.show(f"u by {control:.3g}, J by {objective:.3g}", difference(given, other), 0, allowed)
    figures.least("certificates", kinks, 1)
    return 1 if figures.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
