# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion among 4, 16 and 64 that make their steps together, over one alone: a disc and a half ball that fall at different speeds.

usage: ./dev bench blocks [--sizes H …] [--ball H] [--threads N …] [--registers N …] [--repeats N] [--json FILE]

Least times of `signorini-bench-blocks`. Ten minutes. Registers of 4 numbers are those of machines with AVX2, of 8 those with AVX-512.
"""

import itertools
import json

import program


def main() -> None:
    parser = program.options("bench blocks", __doc__)
    parser.add_argument("--sizes", nargs="*", type=float, default=[1.0, 0.5, 0.25, 0.125], metavar="H", help="element sizes of the disc, m")
    parser.add_argument("--ball", nargs="*", type=float, default=[0.9], metavar="H", help="element sizes of the half ball, m")
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2], metavar="N")
    parser.add_argument("--registers", nargs="+", type=int, default=[8], metavar="N", help="largest numbers of doubles in a vector register")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    given = parser.parse_args()
    scenes = program.ROOT / "scenes"
    cases = [("disc", size, scenes / "disc-drop.toml",
              ["contact.obstacle.point=[0, -20.02]", "initial.velocity=[0, -1]", f"time.step={0.005 * size!r}", f"time.end={0.2 * size!r}"])
             for size in given.sizes]  # fmt: skip
    cases += [("half ball", size, scenes / "half-ball.toml",
               ["contact.obstacle.point=[0, 0, -15.02]", "initial.velocity=[0, 0, -500]", "clamp=[]", f"time.step={1e-4 * size!r}", f"time.end={4e-3 * size!r}"])
              for size in given.ball]  # fmt: skip
    rows = []
    for body, size, scene, changes in cases:
        for threads, registers in itertools.product(given.threads, given.registers):
            row = json.loads(program.output("signorini-bench-blocks", scene, str(given.repeats), f"mesh.size={size!r}", *changes,
                                            OMP_NUM_THREADS=threads, SIGNORINI_REGISTERS=registers))  # fmt: skip
            assert row["contact_steps"] > 10, "hardly any contact"
            rows.append(row | {"body": body, "threads": threads})
            together = ", ".join(f"{one['motions']} together {one['times']:.2f} times as quick ({one['megabytes']:.0f} MB)" for one in row["together"])
            print(f"{body}, {row['free_unknowns']} unknowns, {threads} thread{'s' if threads > 1 else ''}, registers of {row['registers']}: "
                  f"alone {1e3 * row['alone'] / row['steps']:.3f} ms a step; {together}", flush=True)  # fmt: skip
    program.write(given.json, rows)


if __name__ == "__main__":
    main()
