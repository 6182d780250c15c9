# SPDX-License-Identifier: GPL-3.0-or-later
"""clang-tidy's checks, those of .clang-tidy, find nothing in the units of cpp/.

The quick test takes those that are quick to parse: they see neither dolfinx nor PETSc, nor libraries of files and formats. The long one
takes all, as ./dev tidy does, and as long as compiling them.
"""

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from compiled_units import compiled_units
from harness import BUILD, SOURCE

SLOW = re.compile(r"dolfinx|basix|petsc|toml\+\+|gmsh|muParser|nlohmann|filesystem|fstream|regex")


def includes(file: Path, seen: set[Path]) -> set[str]:
    """The headers of others that a file includes, through our own too."""
    if file in seen:
        return set()
    seen.add(file)
    found: set[str] = set()
    for name in re.findall(r'^#include\s+[<"]([^>"]+)[>"]', file.read_text(), re.MULTILINE):
        own = SOURCE / "cpp" / name
        found |= includes(own, seen) if own.exists() else {name}
    return found


def quick(unit: Path) -> bool:
    return not any(SLOW.match(name) for name in includes(unit, set()))


@pytest.mark.parametrize("picked", (pytest.param(quick, id="quick"), pytest.param(lambda _: True, id="all", marks=pytest.mark.long)))
def test_no_complaint(picked: Callable[[Path], bool], tmp_path: Path) -> None:
    compiled = compiled_units(BUILD)
    (tmp_path / "compile_commands.json").write_text(json.dumps(compiled))

    def complaints(unit: Path) -> str:
        done = subprocess.run([shutil.which("clang-tidy"), "--quiet", "-p", tmp_path, unit], capture_output=True, text=True)
        return f"{unit}: ended with {done.returncode}\n{done.stdout}{done.stderr}" if done.returncode else ""

    units = [unit for unit in (Path(one["file"]) for one in compiled) if unit.is_relative_to(SOURCE / "cpp") and picked(unit)]
    assert len(units) >= 10, "hardly any unit was checked"
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as workers:
        found = [text for text in workers.map(complaints, units) if text]
    assert not found, "\n".join(found)
