# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes signorini.1, the manual, and signorini.bash, what bash completes, from what the program says of itself.

    documents.py PROGRAM FOLDER
"""

import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

EXIT_STATUS = {
    0: "done",
    1: "a check failed",
    2: "the scene, the mesh or an option is wrong",
    3: "a solver failed",
    130: "interrupted, the checkpoint is written",
}
FILES = {
    "results/NAME/": "where a run of NAME.toml leaves its files, unless --out names another folder: scene.toml, the scene with every "
    "default written out; run.json, versions, times, warnings and results; tables (.csv) and fields (.xdmf, .h5); checkpoint.h5",
}
ENVIRONMENT = {
    "OMP_NUM_THREADS": "threads of each rank, unless --threads says otherwise",
    "PETSC_OPTIONS": "options of PETSc, as those after --",
}
EXAMPLES = (
    "signorini optimize {data}/scenes/half-disc.toml --set mesh.size=1",
    "signorini report results/half-disc",
    "signorini figures results/half-disc --time 2e-3",
    "mpirun -n 2 signorini simulate {data}/scenes/half-ball.toml",
)


def said(program: str, *words: str) -> str:
    env = os.environ | {"LC_ALL": "C.UTF-8", "COLUMNS": "200"}
    return subprocess.run([program, *words], check=True, stdout=subprocess.PIPE, env=env, text=True, encoding="utf-8").stdout


def roff(text: str) -> str:
    """Text as it is, on lines that roff takes for no request of its own."""
    text = text.replace("\\", r"\e")
    for character, name in (("-", r"\-"), ("'", r"\(aq"), ("`", r"\(ga"), ("^", r"\(ha"), ("~", r"\(ti")):
        text = text.replace(character, name)
    return re.sub(r"(?m)^\.", r"\\\&.", text)


def listed(lines: list[str]) -> list[tuple[str, str]]:
    """What a help text lists below a heading, and what it says of each, which may go on in lines that stand further in."""
    entries: list[tuple[str, str]] = []
    for line in lines:
        if match := re.match(r"  (\S.*?)(?:\s{2,}(.*))?$", line):
            entries.append((match[1], match[2] or ""))
        elif entries:
            entries[-1] = (entries[-1][0], f"{entries[-1][1]} {line.strip()}".strip())
    return entries


def parts(help_text: str) -> dict[str, list[str]]:
    """The indented lines below each heading, such as Options."""
    found: dict[str, list[str]] = {}
    heading = ""
    for line in help_text.splitlines():
        if match := re.fullmatch(r"(\w[\w ]*):", line):
            heading = match[1].lower()
        elif line.startswith("  ") and heading:
            found.setdefault(heading, []).append(line)
        else:
            heading = ""
    return found


def definitions(entries: list[tuple[str, str]]) -> str:
    return "".join(f".TP\n.B {roff(name)}\n{roff(text) or '...'}\n" for name, text in entries)


def plainer(option: str) -> str:
    """An option with the limits of its value in words."""
    option = re.sub(r"\b(\w+):\1 in \[(\S+) - (\S+)\]", r"\1 from \2 to \3", option)
    return re.sub(r"^-h, ?--help$", "-h, --help", option).replace("FLOAT:TIME", "TIME")


def manual(program: str) -> str:
    main = said(program, "--help")
    verbs = dict(listed(parts(main)["subcommands"]))
    with ThreadPoolExecutor() as pool:
        help_of = dict(zip(verbs, pool.map(lambda verb: said(program, verb, "--help"), verbs)))
    version = said(program, "--version").split()[1].rstrip(",")
    page = f'.\\" Made by documents.py.\n.TH SIGNORINI 1 "" "signorini {version}" "User Commands"\n'
    page += f".SH NAME\nsignorini \\- {roff(main.splitlines()[0].rstrip('.').lower())}\n.SH SYNOPSIS\n"
    page += "".join(f".B signorini {verb}\n{usage_of(verb, text)}\n.br\n" for verb, text in help_of.items())
    page += (".SH DESCRIPTION\nA scene is a file in TOML: a mesh, steps of time, a material, clamps, obstacles, loads and, for\n"
             ".BR optimize ,\na control or unknowns and what is desired or was measured. Every verb but\n"
             ".BR keys ,\n.BR completion ,\n.BR report ,\n.B figures\nand\n.B plot\ntakes one.\n")  # fmt: skip
    page += ".SH VERBS\n"
    for verb, text in help_of.items():
        page += f".SS signorini {verb}\n{roff(verbs[verb])}\n"
        page += "".join(definitions([(plainer(option), text) for option, text in listed(found)]) for name, found in parts(text).items() if name in ("options", "positionals", "positional arguments"))
    keys = re.split(r"\n(?=\S)", said(program, "keys").rstrip())
    page += ".SH KEYS OF A SCENE\n"
    for key in keys:
        name, *lines = key.splitlines()
        text = "\n.br\n".join(roff(line.strip()) for line in lines)
        page += f".TP\n.B {roff(name)}\n{text}\n" if lines else f".PP\n{roff(name)}\n"
    page += ".SH EXIT STATUS\n" + definitions([(str(status), text) for status, text in EXIT_STATUS.items()])
    page += ".SH ENVIRONMENT\n" + definitions(list(ENVIRONMENT.items()))
    page += ".SH FILES\n" + definitions(list(FILES.items()))
    page += ".SH EXAMPLES\n.nf\n" + "".join(f"{roff(line.format(data='/usr/share/signorini'))}\n" for line in EXAMPLES) + ".fi\n"
    page += ".SH SEE ALSO\n.BR mpirun (1),\n.BR gmsh (1),\n.BR paraview (1)\n"
    page += ".SH COPYRIGHT\nGNU General Public License, version 3 or any later version.\n"
    return page


def usage_of(verb: str, help_text: str) -> str:
    """What stands behind the verb."""
    found = re.search(rf"(?m)^[Uu]sage: signorini {verb} ?(.*(?:\n +.*)*)", help_text)
    return roff(" ".join(found[1].split())) if found else ""


def whole(file: Path, text: str) -> None:
    """Also where an installation by root left one."""
    partial = file.with_suffix(".partial")
    partial.write_text(text, encoding="utf-8")
    partial.replace(file)


def main() -> int:
    program, folder = sys.argv[1], Path(sys.argv[2])
    whole(folder / "signorini.1", manual(program))
    whole(folder / "signorini.bash", said(program, "completion"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
