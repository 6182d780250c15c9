# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes this folder the package signorini.post when one of its scripts is run, or a module imported, by its file."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

NAME = "signorini.post"
FOLDER = Path(__file__).resolve().parent

if NAME not in sys.modules:
    try:
        import signorini
    except ModuleNotFoundError:
        signorini = sys.modules["signorini"] = ModuleType("signorini")
        signorini.__path__ = []
    spec = importlib.util.spec_from_file_location(NAME, FOLDER / "__init__.py", submodule_search_locations=[str(FOLDER)])
    signorini.post = sys.modules[NAME] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(signorini.post)
