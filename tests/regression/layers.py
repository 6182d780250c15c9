# SPDX-License-Identifier: GPL-3.0-or-later
"""Data flows one way: a file of cpp/ includes only what stands before it in the order of the design."""

import re
import sys
from pathlib import Path

# The layers in the order in which data flows: each sees itself and those before it.
ORDER = ["base", "linalg", "scene", "mesh", "fem", "contact", "step", "trajectory", "adjoint", "diagnostics", "optimize", "control", "io", "problem",
         "drivers", "accuracy", "app"]  # fmt: skip
# What some of them do without.
WITHOUT = {"scene": {"linalg"}, "mesh": {"linalg"}, "diagnostics": {"adjoint"}, "optimize": set(ORDER) - {"base", "linalg", "optimize"},
           "control": {"diagnostics"}, "io": {"linalg", "adjoint", "optimize"}}  # fmt: skip
SEES = {layer: set(ORDER[: i + 1]) - WITHOUT.get(layer, set()) for i, layer in enumerate(ORDER)}
LIBRARIES_OUT_OF = {"optimize": re.compile(r"<(petsc|dolfinx)"), "scene": re.compile(r"<(petsc|dolfinx)")}
GENERATED_ONLY_IN = ("fem/forms.cpp", re.compile(r'"viscoelasticity_'))


def includes(path: Path) -> list[str]:
    return re.findall(r'^#include\s+([<"][^>"]+[>"])', path.read_text(), re.MULTILINE)


def violations(cpp: Path) -> list[str]:
    found = []
    for path in sorted([*cpp.rglob("*.h"), *cpp.rglob("*.cpp")]):
        name = path.relative_to(cpp).as_posix()
        layer = name.split("/")[0] if "/" in name else None
        if layer and layer not in SEES:
            found.append(f"{name}: the layer {layer} is not in the order")
            continue
        for include in includes(path):
            target = include.strip('"<>')
            first = target.split("/")[0]
            if layer and include.startswith('"') and "/" in target and first not in SEES[layer]:
                found.append(f"{name} includes {target}")
            if layer in LIBRARIES_OUT_OF and LIBRARIES_OUT_OF[layer].match(include):
                found.append(f"{name} includes {target}")
            if GENERATED_ONLY_IN[1].match(include) and name != GENERATED_ONLY_IN[0]:
                found.append(f"{name} includes generated {target}")
    return found


def main() -> int:
    cpp = Path(sys.argv[1]) / "cpp"
    if not (cpp / "fem/forms.cpp").exists():
        print(f"{cpp} is not the source folder")
        return 1
    found = violations(cpp)
    print("\n".join(found) or "every include points the right way")
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
