# SPDX-License-Identifier: GPL-3.0-or-later
"""Every source file names the licence in its first lines, and LICENSE is that licence."""

import sys
from pathlib import Path

LINE = "SPDX-License-Identifier: GPL-3.0-or-later"
SOURCES = ("*.h", "*.h.in", "*.cpp", "*.c", "*.py", "*.js", "*.sh", "*.cmake", "*.cmake.in", "CMakeLists.txt", "dev")
FOLDERS = ("cpp", "forms", "postprocess", "python", "tests", "docs", "packaging")


def sources(root: Path) -> list[Path]:
    found = [path for pattern in SOURCES for path in root.glob(pattern)]
    return found + [path for folder in FOLDERS for pattern in SOURCES for path in (root / folder).rglob(pattern)]


def main() -> int:
    root = Path(sys.argv[1])
    files = sources(root)
    if len(files) < 100:
        print(f"{root} is not the source folder")
        return 1
    without = [path for path in files if LINE not in "".join(path.read_text().splitlines()[:3])]
    for path in without:
        print(f"{path.relative_to(root)}: its first lines do not have {LINE}")
    if "GNU GENERAL PUBLIC LICENSE" not in (root / "LICENSE").read_text():
        print("LICENSE is not the GNU General Public License")
        return 1
    return 1 if without else 0


sys.exit(main())
