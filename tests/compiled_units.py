# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiler's commands for the units of a build folder, one for each source, whether or not it compiles several at a time."""

import json
import re
from pathlib import Path


def compiled_units(build: Path) -> list[dict[str, str]]:
    """Entries of compile_commands.json; that of a file which only includes sources becomes one for each of them."""
    units = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        file = Path(entry["file"])
        if file.parent.name != "Unity":
            units.append(entry)
            continue
        for source in re.findall(r'^#include "(.+)"$', file.read_text(), re.MULTILINE):
            units.append(entry | {"file": source, "command": entry["command"].replace(entry["file"], source)})
    return units
