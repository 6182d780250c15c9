# SPDX-License-Identifier: GPL-3.0-or-later
"""Objective, gradient norm and step length over the optimizer's iterations, drawn again while a run goes on.

Draws RUN_FOLDER/figures/convergence.png whenever history.csv has grown, and says so in one line; ends with the run, or at
Ctrl-C. A run that is over is drawn once.
"""

import argparse
import sys
import time
from pathlib import Path

import style
from command_line import complain
from files import Table, Unreadable, read_csv
from matplotlib.figure import Figure


def draw(history: Table, path: Path) -> None:
    iteration = history["iteration"]
    figure = Figure(figsize=(style.WIDTH, 7.2))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, name, label, colour in zip(panels, ("objective", "gradient_norm", "step_length"),
                                         ("objective $J_i$", "gradient norm", "step length"),
                                         (style.BLUE, style.VERMILLION, style.GREEN)):  # fmt: skip
        values = history[name]
        shown = values > 0  # the first guess has no step
        axes.semilogy(iteration[shown], values[shown], color=colour, marker="." if len(iteration) < 60 else None)
        axes.set_ylabel(label)
    panels[-1].set_xlabel("iteration $i$")
    panels[0].set_title(f"after {history['seconds'][-1]:.0f} s", loc="left")
    style.save(figure, path)


def over(folder: Path) -> bool:
    """Whether run.json is of the run whose history.csv is there: it is written last."""
    manifest = folder / "run.json"
    return manifest.is_file() and manifest.stat().st_mtime_ns >= (folder / "history.csv").stat().st_mtime_ns


def watch(folder: Path, every: float) -> None:
    file, seen, waited = folder / "history.csv", None, 0.0
    while True:
        ended = file.is_file() and over(folder)
        stamp = file.stat().st_mtime_ns if file.is_file() else None
        if stamp != seen:
            history = read_csv(file)
            path = folder / "figures" / "convergence.png"
            draw(history, path)
            print(f"iteration {history['iteration'][-1]:.0f}: J = {history['objective'][-1]:.6e}, gradient norm "
                  f"{history['gradient_norm'][-1]:.2e}, {history['seconds'][-1]:.0f} s: {path}", flush=True)  # fmt: skip
            seen = stamp
        elif stamp is None and waited == 0:
            print(f"waiting for {file}", flush=True)
        if ended:
            return
        time.sleep(every)
        waited += every


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run_folder", type=Path, metavar="RUN_FOLDER", help="where a run leaves its files")
    parser.add_argument("--every", type=float, default=1, metavar="T", help="seconds from one look to the next (default: 1)")
    given = parser.parse_args()
    try:
        if not given.every > 0:
            raise Unreadable(f"--every: found {given.every:g}, allowed are times above 0")
        if not given.run_folder.is_dir():
            raise Unreadable(f"{given.run_folder}: there is no such folder")
        watch(given.run_folder, given.every)
    except (Unreadable, OSError, ValueError) as error:
        complain(error)
        return 2
    except KeyboardInterrupt:
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
