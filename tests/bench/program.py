# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmarks share: their options, running a program, and where the figures go too."""

import argparse
import json
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]


def options(name: str, description: str) -> argparse.ArgumentParser:
    """Of a benchmark `./dev name`, with the file for write()."""
    parser = argparse.ArgumentParser(prog=f"./dev {name}", description=description, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the figures go too")
    return parser


def output(*command: object, ranks: int = 1, allowed: tuple[int, ...] = (0,), **environment: object) -> str:
    """Standard output of a program, on several ranks by mpirun; ends this one with its status and messages if that
    is not among the allowed ones."""
    words = [*(["mpirun", "-n", str(ranks)] if ranks > 1 else []), *map(str, command)]
    done = subprocess.run(words, capture_output=True, text=True, env={**os.environ, **{k: str(v) for k, v in environment.items()}})
    if done.returncode not in allowed:
        raise SystemExit(f"{command[0]} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def sets(values: dict[str, object]) -> list[str]:
    """Scene keys as options of signorini."""
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


def write(file: Path | None, rows: list[dict]) -> None:
    """The figures as JSON, if they are to be kept."""
    if file:
        file.write_text(json.dumps(rows, indent=2) + "\n")
