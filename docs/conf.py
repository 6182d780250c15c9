# SPDX-License-Identifier: GPL-3.0-or-later
"""How Sphinx builds these pages; ./dev docs does."""

import re
import shutil
from pathlib import Path

HERE = Path(__file__).resolve().parent

project = "signorini"
release = re.search(r"VERSION (\d+\.\d+\.\d+)", (HERE.parent / "CMakeLists.txt").read_text())[1]
author = "the authors of signorini"
copyright = "the authors of signorini, GPL-3.0-or-later"

extensions = ["myst_parser", "sphinx.ext.mathjax"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 4
exclude_patterns = ["_build"]
nitpicky = True
smartquotes = False  # --set is no dash
highlight_language = "none"

html_theme = "furo"
html_title = f"signorini {release}"
html_static_path = ["_static"]
html_css_files = ["signorini.css"]
html_show_sphinx = False
html_copy_source = False

# Mathematics without the network: Debian's MathJax is copied beside the pages. Where there is none, that of the network is taken.
MATHJAX = Path("/usr/share/javascript/mathjax")
MATHJAX_PARTS = ("MathJax.js", "config/TeX-AMS_SVG.js", "extensions", "jax/element", "jax/input/TeX", "jax/output/SVG/autoload",
                 "jax/output/SVG/config.js", "jax/output/SVG/jax.js", "jax/output/SVG/fonts/TeX")  # fmt: skip
if (MATHJAX / MATHJAX_PARTS[0]).is_file():
    mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
    mathjax2_config = {"showMathMenu": False, "messageStyle": "none", "tex2jax": {"inlineMath": [["\\(", "\\)"]],
                       "displayMath": [["\\[", "\\]"]], "processClass": "math"}, "SVG": {"scale": 95, "linebreaks": {"automatic": True}}}  # fmt: skip


def copy_mathjax(app, error):
    if error or app.builder.format != "html" or not mathjax_is_local():
        return
    for part in MATHJAX_PARTS:
        source, target = MATHJAX / part, Path(app.outdir) / "_static" / "mathjax" / part
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, dirs_exist_ok=True)
        else:
            shutil.copyfile(source, target)


def mathjax_is_local():
    return "mathjax_path" in globals()


def outside_links_to_sources(app, docname, source):
    """Files of the checkout, which Markdown links to from here, are no pages: on these they are shown by name alone."""
    source[0] = re.sub(r"(?<!!)\[([^\]\n]+)\]\((\.\./)+(cpp|forms|scenes|postprocess|tests|dev|CONTRIBUTING\.md|README\.md|LICENSE)[^)]*\)",
                       lambda match: f"`{link_target(match[0])}`", source[0])  # fmt: skip


def link_target(link):
    return re.search(r"\]\((?:\.\./)+([^)]*)\)", link)[1]


def a_section_for_each_table(app, docname, source):
    """The table of all keys, which is as the program prints it, in parts: one for each table of a scene. "See …" becomes a link."""
    if docname != "reference/keys":
        return
    before, rows, after = re.fullmatch(r"(?s)(.*<!-- keys[^\n]*-->\n)(.*?)(<!-- end of keys -->.*)", source[0]).groups()
    links = dict(re.findall(r"\[([^\]]+)\]\(([^)]+)\)", before))
    rows = re.sub(r"\bsee (" + "|".join(links) + r")\b", lambda match: f"see [{match[1]}]({links[match[1]]})", rows)
    head, rows = rows.splitlines()[:2], rows.splitlines()[2:]
    tables = {}
    for row in rows:
        tables.setdefault(re.match(r"\| `(\w+)\.", row)[1], []).append(row)
    sections = [f"\n## {name}\n\n" + "\n".join(head + own) + "\n" for name, own in tables.items()]
    source[0] = before + "".join(sections) + "\n" + after


def setup(app):
    app.connect("build-finished", copy_mathjax)
    app.connect("source-read", a_section_for_each_table)
    app.connect("source-read", outside_links_to_sources)
