# SPDX-License-Identifier: GPL-3.0-or-later
"""Seconds of a gradient on one thread over those on several, in runs that take turns.

usage: ./dev bench threads [--threads N …] [--repeats N] [--json FILE]

A gradient is a forward and an adjoint step in contact, least times of `signorini-bench`. The half disc in the plane, the half ball
by CHOLMOD. About ten minutes.
"""

import json
from pathlib import Path

import numpy as np
import program

SCENES = program.ROOT / "scenes"
CASES = (
    ("half-disc", ["mesh.size=0.125", "time.step=1.25e-5", "time.end=5e-4", 'control.initial=["0", "-0.9"]', "contact.obstacle.point=[0, -15]"]),
    ("half-disc", ["mesh.size=0.0625", "time.step=6.25e-6", "time.end=2.5e-4", 'control.initial=["0", "-0.9"]', "contact.obstacle.point=[0, -15]"]),
    *(("half-ball", [f"mesh.size={size}", f"time.step={1e-4 * size:.4g}", f"time.end={2e-3 * size:.4g}", 'control.initial=["0", "0", "-0.9"]',
                     "contact.obstacle.point=[0, 0, -15]", "solver.linear=direct"]) for size in (0.72, 0.472)),
)  # fmt: skip


def gradient(scene: str, settings: list[str], threads: int) -> tuple[float, int]:
    """Seconds a step, and unknowns."""
    found = json.loads(program.output("signorini-bench", SCENES / f"{scene}.toml", "1", *settings, OMP_NUM_THREADS=threads))
    return found["seconds"]["forward_step"] + found["seconds"]["adjoint_step"], found["free_unknowns"]


def main() -> None:
    parser = program.options("bench threads", __doc__)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    rows = []
    for scene, settings in CASES:
        seconds, unknowns = {number: [] for number in options.threads}, 0
        for _ in range(options.repeats):
            for number in options.threads:
                taken, unknowns = gradient(scene, settings, number)
                seconds[number].append(taken)
        least = {number: np.min(taken) for number, taken in seconds.items()}
        rows.append({"scene": scene, "unknowns": unknowns, "seconds_per_step": seconds})
        print(f"{scene:10s} {unknowns:8d} unknowns: " + ", ".join(
            f"{number} thread{'s' if number > 1 else ''} {1e3 * least[number]:.2f} ms (median {1e3 * sorted(seconds[number])[len(seconds[number]) // 2]:.2f}),"
            f" {least[options.threads[0]] / least[number]:.2f} times as fast" for number in options.threads), flush=True)  # fmt: skip
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
