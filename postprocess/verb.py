# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the script of a verb of the program signorini, under the verb's name: verb.py report FOLDER…

A package that is missing is reported in one sentence, with exit status 2.
"""

import argparse
import importlib
import os
import sys

if not __package__:  # called by its file
    from as_package import NAME as __package__

MOST_THREADS = 1024
SCRIPTS = {"report": "report", "figures": "figures", "plot": "watch"}


def main() -> int:
    verb, *words = sys.argv[1:]
    sys.argv = [f"signorini {verb}", *words]  # usage texts and errors begin with it
    shared = shared_options()
    given, sys.argv[1:] = shared.parse_known_args(words)
    if given.threads is not None and not 1 <= given.threads <= MOST_THREADS:
        print(f"{sys.argv[0]}: --threads: found {given.threads}; expected 1 to {MOST_THREADS}", file=sys.stderr)
        return 2
    if given.threads:
        # Read when the libraries are loaded.
        os.environ.update({name: str(given.threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")})
    if given.quiet:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")
    try:
        script = importlib.import_module(f".{SCRIPTS[verb]}", __package__)
    except ModuleNotFoundError as missing:
        print(f"signorini {verb}: the Python package {missing.name} is missing ({sys.executable}); use a python3 with numpy, h5py, "
              "matplotlib, jinja2 and plotly", file=sys.stderr)  # fmt: skip
        return 2
    return script.main([shared])


def shared_options() -> argparse.ArgumentParser:
    """Makes the options of all verbs."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--threads", type=int, metavar="N",
                        help="threads of numerical libraries (default: OMP_NUM_THREADS, else one per core)")  # fmt: skip
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    return parser


if __name__ == "__main__":
    sys.exit(main())
