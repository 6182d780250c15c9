# SPDX-License-Identifier: GPL-3.0-or-later
"""No comparison of a Python test lets nan pass or has a tolerance that it does not state.

Python's max and min drop nan (max(0, nan) is 0), numpy's do not; numpy's default rtol of 1e-5 and atol of 1e-8 add to what is stated,
and pytest.approx without a tolerance has a relative one of 1e-6.
"""

import ast

import pytest
from harness import SOURCE

TESTS = SOURCE / "tests"
OWN = {"max", "min"}  # with a key they pick an object, which numpy's do not
CLOSE = {"allclose": 4, "isclose": 4}  # positional arguments that state all tolerances


def complaints(text: str, name: str) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.Call):
            continue
        stated = {keyword.arg for keyword in node.keywords}
        if isinstance(node.func, ast.Name) and node.func.id in OWN and "key" not in stated:
            found.append(f"{name}:{node.lineno}: {node.func.id}() drops nan; use np.{node.func.id}() or np.{node.func.id}imum()")
        called = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id if isinstance(node.func, ast.Name) else ""
        if called in CLOSE and len(node.args) < CLOSE[called]:
            found += [f"{name}:{node.lineno}: {called}() without {missing}: its default adds to the tolerance"
                      for missing in ("rtol", "atol") if missing not in stated]  # fmt: skip
        if called == "approx" and len(node.args) < 2 and not stated & {"rel", "abs", None}:  # None: by **
            found.append(f"{name}:{node.lineno}: approx() without rel or abs: its default is the tolerance")
    return found


EXAMPLES = {
    "max(0, x)": 1, "min(f(y) for y in x)": 1, "max(x, key=len)": 0, "np.max(x)": 0, "x.max()": 0, "np.allclose(a, b)": 2,
    "np.isclose(a, b, rtol=1e-9)": 1, "np.allclose(a, b, rtol=0, atol=1)": 0, "pytest.approx(a)": 1, "approx(a, abs=1)": 0,
    "approx(a, **b)": 0,
}  # fmt: skip


@pytest.mark.parametrize("text", EXAMPLES)
def test_rule(text: str) -> None:
    assert len(complaints(text, "example")) == EXAMPLES[text]


def test_all_scripts() -> None:
    files = sorted(TESTS.rglob("*.py"))
    found = [one for file in files for one in complaints(file.read_text(), file.relative_to(TESTS).as_posix())]
    assert len(files) > 80, "hardly anything was read"
    assert not found, "\n".join(found)
