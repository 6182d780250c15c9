# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of cases on one factor, over single runs: drops of a disc from many heights, at many speeds and angles, and a half ball.

usage: ./dev bench batch [--drops N] [--balls N] [--singles N] [--together K …] [--json FILE]

Whole programs on one thread. Single runs are of the first of the cases, before and after the batches. Half an hour.
"""

import csv
import random
import tempfile
import time
from pathlib import Path

import program

SCENES = program.ROOT / "scenes"
# Cases differ in the angle of gravity, the speed and the height of the obstacle; all of them touch.
DISC = ("disc-drop", {"mesh.size": 1.0, "time.end": 3.0, "output.fields": "[]", "output.tables": "[]"})
BALL = ("half-ball", {"mesh.size": 1.5, "time.step": 1e-4, "time.end": 0.01, "clamp": "[]", "output.fields": "[]", "output.tables": "[]"})


def disc_case(pick: random.Random) -> dict[str, str]:
    tilt = pick.uniform(-0.3, 0.3)
    return {"contact.obstacle.point": f"[0, {-20 - pick.uniform(0.01, 0.5):.4f}]", "initial.velocity": f"[{pick.uniform(-0.2, 0.2):.4f}, {-pick.uniform(0.5, 1.5):.4f}]",
            "load.body": f"[{0.1 * tilt:.5f}, {-0.1 * (1 - tilt * tilt / 2):.5f}]"}  # fmt: skip


def ball_case(pick: random.Random) -> dict[str, str]:
    return {"contact.obstacle.point": f"[0, 0, {-15 - pick.uniform(0.01, 0.3):.4f}]",
            "initial.velocity": f"[{pick.uniform(-20, 20):.3f}, {pick.uniform(-20, 20):.3f}, {-pick.uniform(200, 400):.3f}]"}  # fmt: skip


def seconds(*command: object) -> float:
    start = time.perf_counter()
    program.output(*command, OMP_NUM_THREADS=1)
    return time.perf_counter() - start


def impulse_of(folder: Path) -> list[float]:
    with open(folder / "cases.csv") as file:
        rows = list(csv.DictReader(file))
    assert all(row["outcome"] == "done" for row in rows), "a case failed"
    return [float(row["impulse"]) for row in rows]


def main() -> None:
    parser = program.options("bench batch", __doc__)
    parser.add_argument("--drops", type=int, default=1000, metavar="N", help="drops of the disc")
    parser.add_argument("--balls", type=int, default=200, metavar="N", help="half balls")
    parser.add_argument("--singles", type=int, default=6, metavar="N", help="single runs, whose mean is compared")
    parser.add_argument("--together", nargs="+", type=int, default=[16], metavar="K", help="motions together; 1: one after another on one factor")
    given = parser.parse_args()
    rows = []
    for (name, changes), count, make in ((DISC, given.drops, disc_case), (BALL, given.balls, ball_case)):
        if count == 0:
            continue
        pick = random.Random(2017)
        cases = [make(pick) for _ in range(count)]
        scene, options = SCENES / f"{name}.toml", program.sets(changes)
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder) / "cases.csv"
            with open(table, "w", newline="") as file:
                writer = csv.DictWriter(file, list(cases[0]))
                writer.writeheader()
                writer.writerows(cases)
            singles = [seconds("signorini", "simulate", scene, "--out", f"{folder}/one", "--replace", *options, *program.sets(case))
                       for case in cases[: given.singles]]  # fmt: skip
            single = sum(singles) / len(singles)
            for together in given.together:
                out = Path(folder) / str(together)
                taken = seconds("signorini", "batch", scene, "--cases", table, "--out", out, "--together", together, "--quantity", "impulse", *options)
                impulse = impulse_of(out)
                assert all(one > 0 for one in impulse), "a body did not touch"
                rows.append({"scene": name, "cases": count, "together": together, "seconds": taken, "single": single})
                print(f"{name}: {count} cases, {together} together, in {taken:.1f} s, {taken / count:.3f} s each; single runs {single:.3f} s each, "
                      f"{count * single / taken:.1f} times as long", flush=True)  # fmt: skip
    program.write(given.json, rows)


if __name__ == "__main__":
    main()
