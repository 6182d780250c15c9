# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of all hard cases: signorini-hard [FAMILY …]; exit status 1 if a case fails."""

import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
SHARED = {"all", "table"}


def main() -> int:
    program, source, *wanted = sys.argv[1:]
    families = sorted(file.stem for file in FOLDER.glob("*.py") if file.stem not in SHARED)
    if unknown := set(wanted) - set(families):
        print(f"signorini-hard: found the family \"{unknown.pop()}\"; choose from {', '.join(families)}", file=sys.stderr)
        return 2
    failed = [family for family in wanted or families
              if subprocess.run([sys.executable, FOLDER / f"{family}.py", program, source]).returncode]  # fmt: skip
    print(f"failed: {', '.join(failed)}" if failed else "all hard cases hold")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
