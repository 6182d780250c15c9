# SPDX-License-Identifier: GPL-3.0-or-later
"""clang-tidy's checks, those of .clang-tidy, on the units of cpp/ that are quick to parse: they see neither dolfinx nor PETSc, nor libraries
of files and formats.

    tidy.py SOURCE BUILD CLANG_TIDY [--all]

--all: on every unit, which takes as long as compiling them."""

import json
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from compiled_units import compiled_units  # noqa: E402

SOURCE, BUILD = (Path(a).resolve() for a in sys.argv[1:3])
CLANG_TIDY = sys.argv[3]
SLOW = re.compile(r"dolfinx|basix|petsc|toml\+\+|gmsh|muParser|nlohmann|filesystem|fstream|regex")


def includes(file: Path, seen: set[Path]) -> set[str]:
    """What a file includes of others' headers, through our own too."""
    if file in seen:
        return set()
    seen.add(file)
    found: set[str] = set()
    for name in re.findall(r'^#include\s+[<"]([^>"]+)[>"]', file.read_text(), re.MULTILINE):
        own = SOURCE / "cpp" / name
        found |= includes(own, seen) if own.exists() else {name}
    return found


def complaints(commands: str, unit: Path) -> str:
    done = subprocess.run([CLANG_TIDY, "--quiet", "-p", commands, unit], capture_output=True, text=True)
    return done.stdout if done.returncode else ""


def main() -> int:
    compiled = compiled_units(BUILD)
    units = [unit for unit in (Path(one["file"]) for one in compiled) if unit.is_relative_to(SOURCE / "cpp")]
    if "--all" not in sys.argv:
        units = [unit for unit in units if not any(SLOW.match(name) for name in includes(unit, set()))]
    with tempfile.TemporaryDirectory() as commands, ThreadPoolExecutor(len(os.sched_getaffinity(0))) as workers:
        (Path(commands) / "compile_commands.json").write_text(json.dumps(compiled))
        found = [text for text in workers.map(partial(complaints, commands), units) if text]
    print("\n".join(found) or f"{len(units)} units: nothing to say")
    return 1 if found or len(units) < 10 else 0


if __name__ == "__main__":
    raise SystemExit(main())
