# SPDX-License-Identifier: GPL-3.0-or-later
"""Data flows one way: a file of cpp/ includes only what stands before it in the order of the design."""

import re
from pathlib import PurePath

import pytest
from harness import SOURCE

CPP = SOURCE / "cpp"
# The layers in the order in which data flows: each sees itself and those before it.
ORDER = ["base", "linalg", "scene", "mesh", "fem", "contact", "step", "trajectory", "adjoint", "diagnostics", "optimize", "control", "io", "problem",
         "drivers", "accuracy", "batch", "app"]  # fmt: skip
# What some of them do without.
WITHOUT = {"scene": {"linalg"}, "mesh": {"linalg"}, "diagnostics": {"adjoint"}, "optimize": set(ORDER) - {"base", "linalg", "optimize"},
           "control": {"diagnostics"}, "io": {"linalg", "adjoint", "optimize"}}  # fmt: skip
SEES = {layer: set(ORDER[: i + 1]) - WITHOUT.get(layer, set()) for i, layer in enumerate(ORDER)}
LIBRARIES_OUT_OF = {"optimize": re.compile(r"<(petsc|dolfinx)"), "scene": re.compile(r"<(petsc|dolfinx)")}
GENERATED_ONLY_IN = ("fem/compiled_forms.cpp", re.compile(r'"viscoelasticity_'))


def includes() -> list[tuple[str, str | None, str]]:
    """Files of cpp/, their layers (None for a file in no folder) and what they include, with quotes or angle brackets."""
    files = [(path, path.relative_to(CPP)) for path in sorted([*CPP.rglob("*.h"), *CPP.rglob("*.cpp")])]
    assert PurePath("fem/forms.cpp") in [name for _, name in files], f"{CPP} is not the source folder"
    return [(name.as_posix(), name.parts[0] if len(name.parts) > 1 else None, include)
            for path, name in files for include in re.findall(r'^#include\s+([<"][^>"]+[>"])', path.read_text(), re.MULTILINE)]  # fmt: skip


def report(found: list[tuple[str, str]]) -> str:
    return "\n".join(f"{name} includes {include}" for name, include in found)


def test_every_folder_is_a_layer() -> None:
    assert {folder.name for folder in CPP.iterdir() if folder.is_dir()} <= set(ORDER)


def test_order() -> None:
    found = [(name, include) for name, layer, include in includes()
             if layer in SEES and include.startswith('"') and "/" in include and include.strip('"').split("/")[0] not in SEES[layer]]  # fmt: skip
    assert not found, report(found)


@pytest.mark.parametrize("layer", LIBRARIES_OUT_OF)
def test_no_library(layer: str) -> None:
    found = [(name, include) for name, of, include in includes() if of == layer and LIBRARIES_OUT_OF[layer].match(include)]
    assert not found, report(found)


def test_generated_code_in_one_file() -> None:
    file, generated = GENERATED_ONLY_IN
    including = [(name, include) for name, _, include in includes() if generated.match(include)]
    found = [(name, include) for name, include in including if name != file]
    assert including and not found, report(found)
