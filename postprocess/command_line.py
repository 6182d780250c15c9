# SPDX-License-Identifier: GPL-3.0-or-later
"""Command line that all scripts of this folder share.

Exit status: 0, drawn; 2, the folder, a file or an option is wrong, or the run has nothing to draw.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from .files import NotInRun, Unreadable
from .run_folder import RunFolder

Parents = Sequence[argparse.ArgumentParser]  # of options that all verbs share


def arguments(description: str, timed: bool, parents: Parents = ()) -> argparse.Namespace:
    """Parses the arguments of a script: RUN_FOLDER and, if `timed`, the option --time."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter, parents=parents)
    parser.add_argument("run_folder", type=Path, metavar="RUN_FOLDER", help="folder of a run")
    if timed:
        parser.add_argument("--time", type=float, metavar="T",
                            help="time to show, s (default: 0.00175 if the body is in contact then, "
                                 "else the time of the largest contact force)")
    return parser.parse_args()


def complain(error: Exception) -> None:
    """Prints an error on stderr, in one line."""
    print(f"{Path(sys.argv[0]).name}: {error}", file=sys.stderr)


def say(*lines: object) -> None:
    """Prints lines on stdout; names of files may have bytes that no text has."""
    sys.stdout.reconfigure(errors="surrogateescape")
    print(*lines, sep="\n", flush=True)


def run_alone(draw: Callable[..., list[Path]], description: str, timed: bool = False) -> int:
    """Draws one figure into RUN_FOLDER/figures and prints the paths; returns the exit status."""
    given = arguments(description, timed)
    try:
        run = RunFolder(given.run_folder)
        paths = draw(run, given.time) if timed else draw(run)
    except (NotInRun, Unreadable, OSError) as error:
        complain(error)
        return 2
    say(*paths)
    return 0
