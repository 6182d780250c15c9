# SPDX-License-Identifier: GPL-3.0-or-later
"""What a call from Python costs beside the sweeps that it makes.

usage: ./dev bench python [--size H …] [--repeats N] [--json FILE]

J and its derivative of the half disc's control, by Problem (arrays of the ranks) and by Replicated (whole vectors in an order of
places, for SciPy), and by PyTorch's autograd. The seconds of both sweeps are those that the solver itself counts within the call: each call is its own
comparison. Least and median of several.
"""

import statistics
import time

import numpy as np
import program
import torch

import signorini
import signorini.torch


def main() -> None:
    parser = program.options("bench python", __doc__)
    parser.add_argument("--size", type=float, nargs="+", default=[1.0, 0.5])
    parser.add_argument("--repeats", type=int, default=30)
    options = parser.parse_args()
    rows = []
    for size in options.size:
        problem = signorini.Scene(program.ROOT / "scenes/half-disc.toml", {"mesh.size": size, "control.initial": ["0", "-0.9"]}).problem()
        flat = problem.replicated()
        J = signorini.torch.function(problem)
        u, x = problem.first_guess(), flat.start

        def by_autograd(control: np.ndarray) -> None:
            J(torch.from_numpy(control).requires_grad_()).backward()

        taken = {"Problem": [], "Replicated": [], "PyTorch": []}
        for repeat in range(options.repeats):
            for i, (name, evaluate, at) in enumerate((("Problem", problem.value_and_gradient, u), ("Replicated", flat.value_and_gradient, x),
                                                      ("PyTorch", by_autograd, u))):  # fmt: skip
                changed = at * (1 + 1e-6 * (3 * repeat + i))
                before, start = problem.sweep_seconds, time.perf_counter()
                evaluate(changed)
                taken[name].append((time.perf_counter() - start, problem.sweep_seconds - before))
        for name, seconds in taken.items():
            least = np.min([s for _, s in seconds])
            more = [call - sweeps for call, sweeps in seconds]
            rows.append({"size": size, "values": problem.size, "by": name, "seconds": seconds})
            print(f"size {size:g}, {problem.size} values, {name:10s}: sweeps {1e3 * least:.2f} ms, a call {1e3 * np.min(more):.3f} ms more "
                  f"({100 * np.min(more) / least:.2f} %), in the median {100 * statistics.median(m / s for m, (_, s) in zip(more, seconds)):.2f} %",
                  flush=True)  # fmt: skip
    program.write(options.json, rows)


if __name__ == "__main__":
    main()
