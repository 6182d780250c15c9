# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes one page of all results of a run, a study or a batch: FOLDER/report.html, which needs no other file and no network.

A run's page has the body in motion, contact forces, control, energies, probes, convergence and times; a study's page has the
costs of accuracy; a batch's page has its cases and their sensitivities. Parts without data in the folder are left out and listed.
With a second run's folder the page shows both side by side: OTHER/comparison.html.
"""

import argparse
import base64
import gzip
import json
import sys
from pathlib import Path

import jinja2
from plotly.offline import get_plotlyjs

if not __package__:  # called by its file
    from as_package import NAME as __package__

from . import report_batch, report_compare, report_run, report_study
from .batch_folder import BatchFolder, is_batch
from .command_line import Parents, complain, say
from .files import NotInRun, Unreadable
from .report_parts import Page
from .run_folder import RunFolder
from .style import whole_file
from .study_folder import StudyFolder, is_study

TEMPLATE = "report.html.jinja"


def page_of(folder: Path) -> Page:
    """Returns the page of a run's, a study's or a batch's folder."""
    if is_study(folder):
        return report_study.page(StudyFolder(folder))
    if is_batch(folder):
        return report_batch.page(BatchFolder(folder))
    if folder.is_dir() and not (folder / "scene.toml").is_file():
        inside = sorted({str(path.parent) for name in ("scene.toml", "study.json", "batch.json") for path in folder.glob(f"*/{name}")})
        raise Unreadable(f"{folder}: not the folder of a run, a study or a batch, since there is no scene.toml, "
                         f"study.json or batch.json in it{'; runs inside: ' if inside else ''}{', '.join(inside)}")
    return report_run.page(RunFolder(folder))


def comparison_of(folder: Path, other: Path) -> Page:
    """Returns the page that compares two runs' folders."""
    for one in (folder, other):
        if is_study(one) or is_batch(one):
            raise Unreadable(f"{one}: found a {'study' if is_study(one) else 'batch'}; give two runs")
    return report_compare.page((RunFolder(folder), RunFolder(other)))


def html(page: Page) -> str:
    """Returns the page as HTML that contains all that it needs."""
    templates = jinja2.Environment(loader=jinja2.FileSystemLoader(Path(__file__).parent), autoescape=True,
                                   trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    return templates.get_template(TEMPLATE).render(page=page, plotly=compressed(get_plotlyjs()),
                                                   data=compressed(json.dumps(page.data(), allow_nan=False)))


def compressed(text: str) -> str:
    """Compresses a text such that a browser can unpack it from within a page."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode()


def main(parents: Parents = ()) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, parents=parents)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="folder of a run, a study or a batch")
    parser.add_argument("other", type=Path, nargs="?", metavar="OTHER", help="folder of another run, to be shown beside the first")
    given = parser.parse_args()
    try:
        if given.other is None:
            page, file = page_of(given.folder), given.folder / "report.html"
        else:
            page, file = comparison_of(given.folder, given.other), given.other / "comparison.html"
        with whole_file(file) as partial:
            partial.write_bytes(html(page).encode("utf-8", "replace"))  # a folder's name need not be text
    except (NotInRun, Unreadable, OSError) as error:
        complain(error)
        return 2
    say(page.identity, file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
