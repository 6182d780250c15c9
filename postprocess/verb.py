# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the script of a verb of the program signorini, under the verb's name: verb.py report FOLDER…

A package that is missing is told in one sentence, with exit status 2.
"""

import importlib
import sys

SCRIPTS = {"report": "report", "figures": "figures", "plot": "watch"}


def main() -> int:
    verb, *words = sys.argv[1:]
    sys.argv = [f"signorini {verb}", *words]  # which usage texts and errors begin with
    try:
        script = importlib.import_module(SCRIPTS[verb])
    except ModuleNotFoundError as missing:
        print(f"signorini {verb}: found no Python package {missing.name} ({sys.executable}), allowed is a python3 with numpy, h5py, "
              "matplotlib, jinja2 and plotly", file=sys.stderr)  # fmt: skip
        return 2
    return script.main()


if __name__ == "__main__":
    sys.exit(main())
