# SPDX-License-Identifier: GPL-3.0-or-later
"""Work and precision of a study: error over seconds, a curve for each degree and scheme through its most accurate rungs."""

import argparse
import sys
from pathlib import Path

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import style
from .command_line import complain, say
from matplotlib.lines import Line2D
from .run_folder import Unreadable
from .study_folder import Method, StudyFolder, is_study

COLOURS = {("contact-implicit", "consistent"): style.BLUE, ("contact-stabilized", "consistent"): style.VERMILION,
           ("contact-implicit", "massless"): style.GREEN}  # fmt: skip
NAMES = {("contact-implicit", "consistent"): "contact-implicit", ("contact-stabilized", "consistent"): "contact-stabilized",
         ("contact-implicit", "massless"): "massless contact"}  # fmt: skip


def front(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Returns the points (seconds, error) for which no faster point is at least as accurate, in ascending order of seconds."""
    best: list[tuple[float, float]] = []
    for seconds, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((seconds, error))
    return best


def draw(study: StudyFolder, quantity: str) -> Path:
    """Draws all rungs as dots, the front of each method as a curve."""
    any_chosen = any(method.chosen for method in study.methods)
    methods: dict[Method, list[tuple[float, float]]] = {}
    for rung in study.rungs:
        if rung[f"{quantity}_error"] > 0:
            methods.setdefault(rung.method, []).append((rung["seconds"], rung[f"{quantity}_error"]))
    figure, axes = style.graph()
    for method, points in methods.items():
        colour = COLOURS[method.scheme, method.mass]
        axes.loglog(*zip(*points), "x" if method.chosen else ".", color=colour, alpha=0.3, markersize=5)
        line = ("-." if method.chosen else "-") if method.degree == 1 else (":" if method.chosen else "--")
        axes.loglog(*zip(*front(points)), line, color=colour, marker="o" if method.graded else None, fillstyle="none", markersize=4)
    axes.set_xlabel("seconds")
    axes.set_ylabel(f"error of {study.manifest['quantities'][quantity]['title']}")
    kinds = sorted({(method.scheme, method.mass) for method in methods}, key=list(COLOURS).index)
    handles = [Line2D([], [], color=COLOURS[kind], label=NAMES[kind]) for kind in kinds]
    if len({method.degree for method in methods}) > 1:
        handles += [Line2D([], [], color="0.3", ls=line, label=f"degree {degree}") for degree, line in ((1, "-"), (2, "--"))]
    if any_chosen:
        handles += [Line2D([], [], color="0.3", ls="-.", marker="x", label="steps chosen")]
    if any(method.graded for method in study.methods):
        handles += [Line2D([], [], color="0.3", marker="o", fillstyle="none", markersize=4, label="graded meshes")]
    figure.legend(handles=handles, loc="outside upper center", ncols=2, columnspacing=1.2, handlelength=1.8)
    return style.save(figure, study.path / "figures" / f"work_precision_{quantity}.png")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, metavar="STUDY_FOLDER", help="folder of a study")
    folder = parser.parse_args().folder
    if not is_study(folder):
        complain(Unreadable(f"{folder}: found no study.json; give the folder of a study"))
        return 2
    try:
        study = StudyFolder(folder)
        for quantity in study.manifest["quantities"]:
            if any(rung[f"{quantity}_error"] > 0 for rung in study.rungs):
                say(draw(study, quantity))
    except (Unreadable, KeyError) as error:
        complain(error)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
