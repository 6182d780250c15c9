# SPDX-License-Identifier: GPL-3.0-or-later
"""Every source file names the licence in its first lines, and LICENSE is that licence."""

from harness import SOURCE

LINE = "SPDX-License-Identifier: GPL-3.0-or-later"
SOURCES = ("*.h", "*.h.in", "*.cpp", "*.c", "*.py", "*.js", "*.sh", "*.cmake", "*.cmake.in", "CMakeLists.txt", "dev")
FOLDERS = ("cpp", "forms", "postprocess", "python", "tests", "docs", "packaging")


def test_first_lines() -> None:
    files = [path for pattern in SOURCES for path in SOURCE.glob(pattern)]
    files += [path for folder in FOLDERS for pattern in SOURCES for path in (SOURCE / folder).rglob(pattern)]
    assert len(files) >= 100, f"{SOURCE} is not the source folder"
    without = [str(path.relative_to(SOURCE)) for path in files if LINE not in "".join(path.read_text().splitlines()[:3])]
    assert not without, f"the first lines do not have {LINE} in:\n" + "\n".join(without)


def test_licence() -> None:
    assert "GNU GENERAL PUBLIC LICENSE" in (SOURCE / "LICENSE").read_text()
