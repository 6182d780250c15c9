# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the classes and functions of docs/reference/python.md from the signatures and docstrings of python/signorini.

    python_reference.py [--check]     # --check: fails where the page is another than it would be
"""

import ast
import re
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
PAGE = SOURCE / "docs" / "reference" / "python.md"
BEGIN, END = "<!-- python: docs/python_reference.py writes this -->\n", "<!-- end of python -->\n"
# Sections: of a module its own text (…), or a name within it.
SECTIONS = {
    "The module": [("__init__", ...), ("program", "versions")],
    "Scenes": [("scene", "Scene")],
    "Control problems": [("problem", ...), ("problem", "Problem"), ("problem", "Metric"), ("problem", "Replicated"), ("problem", "Sweeps"), ("problem", "Parts"), ("problem", "Batch")],
    "Fits": [("fit", "Fit")],
    "PyTorch and JAX": [("torch", "function"), ("jax", "function")],
    "Runs": [("run", "read"), ("run", "Run"), ("run", "Field")],
}


def markdown(docstring: str) -> str:
    """A docstring's literal blocks, which begin after two colons, are indented as Markdown's are."""
    return re.sub(r"::$", ":", docstring, flags=re.MULTILINE)


def signature(function: ast.FunctionDef, name: str, bound: bool) -> str:
    """A call as it is written in the source, without self."""
    arguments = ast.unparse(function.args)
    if bound:
        arguments = re.sub(r"^self(, )?", "", arguments)
    return f"{name}({arguments})"


def returned(function: ast.FunctionDef) -> str:
    found = ast.unparse(function.returns) if function.returns else "None"
    return "" if found == "None" else f" → `{found}`"


def member(function: ast.FunctionDef) -> str:
    """One entry of a class's list."""
    attribute = any("property" in ast.unparse(one) for one in function.decorator_list)
    name = function.name if attribute else signature(function, function.name, True)
    if function.name == "__getitem__":
        name = f"[{function.args.args[1].arg}]"
    text = markdown(ast.get_docstring(function))
    return f"- **`{name}`**{returned(function)}\n\n" + "".join(f"  {line}\n" if line else "\n" for line in text.splitlines())


def described(node: ast.FunctionDef | ast.ClassDef, package: str) -> str:
    """A function or class of a package with its public members."""
    text = markdown(ast.get_docstring(node))
    if isinstance(node, ast.FunctionDef):
        return f"### `{package}.{signature(node, node.name, False)}`{returned(node)}\n\n{text}\n"
    functions = [one for one in node.body if isinstance(one, ast.FunctionDef)]
    made = [one for one in functions if one.name == "__init__"] if node.name in ("Scene", "Problem", "Fit") else []
    title = signature(made[0], node.name, True) if made else node.name
    fields = [f"- **`{one.target.id}`** → `{ast.unparse(one.annotation)}`\n" for one in node.body if isinstance(one, ast.AnnAssign)]
    members = [member(one) for one in functions if (not one.name.startswith("_") or one.name == "__getitem__") and ast.get_docstring(one)]
    return f"### `{package}.{title}`\n\n{text}\n\n" + "\n".join(fields + members)


def reference() -> str:
    parts = []
    for title, names in SECTIONS.items():
        parts.append(f"## {title}\n")
        for module, name in names:
            tree = ast.parse((SOURCE / "python" / "signorini" / f"{module}.py").read_text(encoding="utf-8"))
            if name is ...:
                parts.append(markdown(ast.get_docstring(tree)) + "\n")
            else:
                package = f"signorini.{module}" if module in ("torch", "jax") else "signorini"  # others are parts of it
                parts += [described(one, package) for one in tree.body if getattr(one, "name", "") == name]
    return "\n" + "\n".join(parts) + "\n"


def main() -> None:
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    whole = before + BEGIN + reference() + END + rest.split(END)[1]
    if sys.argv[1:] == ["--check"]:
        sys.exit(None if whole == page else f"{PAGE}: differs from the docstrings; run ./dev exec python3 docs/python_reference.py")
    PAGE.write_text(whole, encoding="utf-8")


main()
