# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in a notebook, which a kernel of Jupyter executes: it shows itself as a table, and its page within a frame."""

import nbformat
import pytest
from common import SCENES
from nbclient import NotebookClient

CELLS = (
    f'import signorini\nrun = signorini.Scene("{SCENES / "half-disc.toml"}", {{"mesh.size": 3, "optimizer.max_iterations": 2}}).optimize()',
    "run",
    "run.show(400)",
    "print(run.field('displacement').values.shape)",
)


@pytest.fixture(scope="module")
def outputs() -> list[list[dict]]:
    """What each cell shows."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    return [cell.outputs for cell in notebook.cells]


def test_a_run_is_a_table(outputs: list[list[dict]]) -> None:
    (shown,) = outputs[1]
    table = shown["data"]["text/html"]
    assert "<th>J</th>" in table and "half-disc" in table and "<th>steps</th><td>150</td>" in table
    assert "signorini.Run" in shown["data"]["text/plain"]


def test_a_page_is_a_frame(outputs: list[list[dict]]) -> None:
    (shown,) = outputs[2]
    frame = shown["data"]["text/html"]
    assert frame.startswith("<iframe srcdoc=") and "height:400px" in frame and len(frame) > 1e6


def test_fields(outputs: list[list[dict]]) -> None:
    (shown,) = outputs[3]
    assert shown["text"].startswith("(151, ") and shown["text"].endswith(", 2)\n")
