# SPDX-License-Identifier: GPL-3.0-or-later
"""Objective, gradient norm and step length over the optimizer's iterations (decrement and damping of a fit), redrawn while a run continues.

Draws RUN_FOLDER/figures/convergence.png whenever history.csv has grown, and reports it in one line. Ends with the run, or at
Ctrl-C. A run that is over is drawn once.
"""

import argparse
import json
import os
import socket
import sys
import time
from pathlib import Path

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import Parents, complain, say
from .files import NotInRun, Table, Unreadable, read_csv
from matplotlib.figure import Figure
from .run_folder import RunFolder


# Columns of history.csv, with their labels; those of a fit and of a search differ.
PANELS = {"objective": ("objective $J_i$", style.BLUE), "gradient_norm": ("gradient norm", style.VERMILION),
          "decrement": ("decrement", style.VERMILION), "step_length": ("step length", style.GREEN), "damping": ("damping", style.GREEN)}  # fmt: skip


def draw(history: Table, path: Path) -> None:
    iteration = history["iteration"]
    shown = {name: look for name, look in PANELS.items() if name in history}
    figure = Figure(figsize=(style.WIDTH, 2.4 * len(shown)))
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, (label, colour)) in zip(panels, shown.items()):
        values = history[name]
        positive = values > 0  # the first guess has no step
        axes.semilogy(iteration[positive], values[positive], color=colour, marker="." if len(iteration) < 60 else None)
        axes.set_ylabel(label)
    panels[-1].set_xlabel("iteration $i$")
    panels[0].set_title(f"after {history['seconds'][-1]:.0f} s", loc="left")
    style.save(figure, path)


def last_line(history: Table) -> str:
    """Describes the last iteration in one line."""
    slope = next((name for name in ("gradient_norm", "decrement") if name in history), None)
    parts = [f"J = {history['objective'][-1]:.6e}", *([f"{slope.replace('_', ' ')} {history[slope][-1]:.2e}"] if slope else [])]
    return f"iteration {history['iteration'][-1]:.0f}: {', '.join(parts)}, {history['seconds'][-1]:.0f} s"


def over(folder: Path) -> bool:
    """Whether run.json belongs to the run of history.csv: it is written last."""
    manifest = folder / "run.json"
    return manifest.is_file() and manifest.stat().st_mtime_ns >= (folder / "history.csv").stat().st_mtime_ns


def at_work(folder: Path) -> bool:
    """Whether a running process has locked the folder: its lock file names the process."""
    try:
        holder = json.loads((folder / ".signorini-lock").read_text(encoding="utf-8"))
        if holder["host"] == socket.gethostname():
            os.kill(holder["process"], 0)
    except PermissionError:  # somebody else's
        return True
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return True


def require_search(folder: Path) -> None:
    """Raises NotInRun if the folder is that of a finished run without iterations, or of a study."""
    if (folder / "study.json").is_file():
        raise NotInRun(f"{folder}: found a study; plot shows the convergence of signorini optimize, signorini report a study")
    if not (folder / "run.json").is_file() or at_work(folder) or (folder / "history.csv").is_file():
        return
    verb = RunFolder(folder).verb
    cure = ('its output.tables does not contain "history"' if verb == "optimize"
            else f"plot shows the convergence of signorini optimize; try signorini report {folder}")  # fmt: skip
    raise NotInRun(f"{folder}: found a run of {verb} without history.csv; {cure}")


def watch(folder: Path, every: float) -> None:
    file, seen, waited = folder / "history.csv", None, 0.0
    while True:
        ended = file.is_file() and over(folder)
        stamp = file.stat().st_mtime_ns if file.is_file() else None
        if stamp is None:
            require_search(folder)
            if waited == 0:
                say(f"waiting for {file}")
        elif stamp != seen:
            history = read_csv(file)
            path = folder / "figures" / "convergence.png"
            draw(history, path)
            say(f"{last_line(history)}: {path}")
            seen = stamp
        if ended:
            return
        time.sleep(every)
        waited += every


def main(parents: Parents = ()) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, parents=parents)
    parser.add_argument("run_folder", type=Path, metavar="RUN_FOLDER", help="folder of a run")
    parser.add_argument("--every", type=float, default=1, metavar="T", help="seconds between updates (default: 1)")
    given = parser.parse_args()
    try:
        if not given.every > 0:
            raise Unreadable(f"--every: found {given.every:g}; expected a time above 0")
        if not given.run_folder.is_dir():
            raise Unreadable(f"{given.run_folder}: there is no such folder")
        watch(given.run_folder, given.every)
    except (NotInRun, Unreadable, OSError, ValueError) as error:
        complain(error)
        return 2
    except KeyboardInterrupt:
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
