"""Seconds per step and per gradient of the half disc over element sizes, all of one machine and one run.

usage: ./dev bench [SIZE …]    (element sizes in m, default 1 0.5 0.25 0.125)
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = Path(__file__).parents[2] / "scenes" / "half-disc.toml"
REPEATS = 3


def timings(size: float, folder: Path) -> dict:
    """run.json of REPEATS evaluations of J and its gradient near the reference control."""
    subprocess.run(["signorini", "optimize", str(SCENE), "--quiet", "--out", str(folder), "--set", f"mesh.size={size}",
                    "--set", 'control.initial=["0", "-0.9"]', "--set", f"optimizer.max_iterations={REPEATS - 1}",
                    "--set", "output.every=150"], check=True)  # fmt: skip
    return json.loads((folder / "run.json").read_text())


def main() -> int:
    sizes = [float(a) for a in sys.argv[1:]] or [1, 0.5, 0.25, 0.125]
    print("  size  unknowns  candidates   setup s   ms/forward step   ms/adjoint step   s/gradient   adjoint/forward")
    with tempfile.TemporaryDirectory() as folder:
        for size in sizes:
            run = timings(size, Path(folder))
            phases, steps = run["timings"], run["steps"]["asked"]
            forward, adjoint = (phases[p]["seconds"] / phases[p]["calls"] for p in ("forward", "adjoint"))
            objective = phases["objective"]["seconds"] / phases["objective"]["calls"]
            setup = sum(phases[p]["seconds"] for p in ("mesh", "assembly", "factorisation and condensation"))
            print(f"{size:6.3f}  {run['free_unknowns']:8d}  {run['candidates']:10d}  {setup:8.2f}  {1e3 * forward / steps:16.3f}"
                  f"  {1e3 * adjoint / steps:16.3f}  {forward + objective + adjoint:11.3f}  {adjoint / forward:16.2f}")  # fmt: skip
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
