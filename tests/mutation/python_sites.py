# SPDX-License-Identifier: GPL-3.0-or-later
"""Where one token of a Python source can be changed, and into what: the changes of sites.py, by its names, and

sign        ~ left out
comparison  in and not in, is and is not, & and | of masks, any and all exchanged; `not` left out
index       argmin and argmax exchanged
statement   a call, an augmented assignment or one to an entry, break or continue, left out

Left alone is what has no effect on results, or would only raise a TypeError: annotations, decorators, imports, raise, constants in
capitals, the command line's options, looks (widths, sizes, opacities), the number that reshape finds itself, and sums and products of texts and lists.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

from sites import EXCHANGED, MOVED_BY_ONE, SYMMETRIC, Mutant

OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=",
             ast.Gt: ">", ast.GtE: ">=", ast.BitAnd: "&", ast.BitOr: "|", ast.In: "in", ast.NotIn: "not in", ast.Is: "is",
             ast.IsNot: "is not"}  # fmt: skip
OPPOSITES = {"&": "|", "|": "&", "in": "not in", "not in": "in", "is": "is not", "is not": "is"}
CALLED = {"min": ("comparison", "max"), "max": ("comparison", "min"), "minimum": ("comparison", "maximum"),
          "maximum": ("comparison", "minimum"), "any": ("comparison", "all"), "all": ("comparison", "any"),
          "argmin": ("index", "argmax"), "argmax": ("index", "argmin")}  # fmt: skip
SAME = SYMMETRIC | {"minimum", "maximum", "isclose", "allclose", "array_equal", "vdot", "isinstance", "getattr", "hasattr", "zip", "print"}
LOOKS = {"width", "size", "linewidth", "linewidths", "lw", "markersize", "markeredgewidth", "markevery", "alpha", "opacity", "s", "zorder",
         "columnspacing", "handlelength", "ncols", "borderpad", "handletextpad", "bbox_to_anchor", "figsize", "dpi", "indent", "exist_ok",
         "rasterized", "trim_blocks", "lstrip_blocks", "autoescape", "cliponaxis", "clip_on", "color", "colors", "nticks", "dtick"}  # fmt: skip
NO_EFFECT = {"add_argument", "ArgumentParser", "catch_warnings", "register", "simplefilter"}


class PythonSource:
    """The syntax tree of a file, and where in the text its nodes are."""

    def __init__(self, file: Path):
        self.file, self.text = file, file.read_text()
        self.tree = ast.parse(self.text)
        self.starts, lines = [0], self.text.splitlines(True)
        for one in lines:
            self.starts.append(self.starts[-1] + len(one))
        self.bytes = [one.encode() for one in lines]

    def mutants(self) -> list[list[Mutant]]:
        """What each token may become, for all that may and compile."""
        found = []
        for node in self.nodes(self.tree):
            of_node = self.of_node(node)
            found += [kept for choices in of_node if (kept := [one for one in choices if self.compiles(one)])]
        return sorted(found, key=lambda choices: (choices[0].begin, choices[0].end, choices[0].new))

    def compiles(self, mutant: Mutant) -> bool:
        try:
            ast.parse(self.text[: mutant.begin] + mutant.new + self.text[mutant.end :])
            return True
        except SyntaxError:
            return False

    def nodes(self, node: ast.AST) -> Iterator[ast.AST]:
        """All nodes but those that are left alone."""
        yield node
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "format_spec", "type_params"):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST) and not self.left_alone(node, child):
                    yield from self.nodes(child)

    def left_alone(self, parent: ast.AST, node: ast.AST) -> bool:
        if isinstance(node, (ast.Import, ast.ImportFrom, ast.Raise)):
            return True
        if isinstance(node, ast.If) and any(word in ast.unparse(node.test) for word in ("__name__", "TYPE_CHECKING")):
            return True
        if isinstance(node, ast.Assign) and isinstance(parent, ast.Module):
            constant = all(name.id.isupper() for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name))
            return constant and not any(isinstance(inner, ast.Lambda) for inner in ast.walk(node.value))
        if isinstance(node, ast.Call) and (name_of(node.func) in NO_EFFECT or "rcParams" in ast.unparse(node.func)):
            return True
        if isinstance(node, ast.keyword):
            return node.arg in LOOKS
        if isinstance(node, ast.UnaryOp) and isinstance(parent, ast.Call) and name_of(parent.func) == "reshape":  # any negative number
            return True
        if isinstance(parent, ast.Dict) and node in parent.values:
            key = parent.keys[parent.values.index(node)]
            return isinstance(key, ast.Constant) and key.value in LOOKS
        return False

    def span(self, node: ast.AST) -> tuple[int, int]:
        """First character of a node and the one after it; columns are counted in bytes."""
        return (self.place(node.lineno, node.col_offset), self.place(node.end_lineno, node.end_col_offset))

    def place(self, line: int, column: int) -> int:
        return self.starts[line - 1] + len(self.bytes[line - 1][:column].decode())

    def mutant(self, begin: int, end: int, new: str, kind: str) -> Mutant:
        return Mutant(self.file, begin, end, new, kind, self.text.count("\n", 0, begin) + 1)

    def operator(self, left: ast.AST, right: ast.AST, old: str, new: str, kind: str) -> Mutant:
        """The operator between two operands exchanged; brackets may stand beside it."""
        begin = self.text.index(old, self.span(left)[1], self.span(right)[0])
        return self.mutant(begin, begin + len(old), new, kind)

    def of_node(self, node: ast.AST) -> list[list[Mutant]]:
        match node:
            case ast.BinOp():
                return [self.of_operator(node.left, node.right, node.op, node)]
            case ast.AugAssign() if type(node.op) in OPERATORS and OPERATORS[type(node.op)] + "=" in EXCHANGED:
                old = OPERATORS[type(node.op)] + "="
                kind, new = EXCHANGED[old]
                return [[self.operator(node.target, node.value, old, new, kind), self.left_out(node)]]
            case ast.Compare() if len(node.ops) == 1:
                return [self.of_operator(node.left, node.comparators[0], node.ops[0], node)]
            case ast.Compare():
                operands = [node.left, *node.comparators]
                return [self.of_operator(a, b, op, node) for a, b, op in zip(operands, operands[1:], node.ops)]
            case ast.BoolOp():
                old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
                return [[self.operator(a, b, old, new, "comparison")] for a, b in zip(node.values, node.values[1:])]
            case ast.UnaryOp():
                begin, negated = self.span(node)[0], isinstance(node.op, ast.Not)
                return [[self.mutant(begin, begin + len("not " if negated else "-"), "", "comparison" if negated else "sign")]]
            case ast.Constant():
                return self.of_constant(node)
            case ast.Subscript():
                begin, end = self.span(node.slice)
                counts = isinstance(node.slice, ast.Name) and (len(node.slice.id) == 1 or node.slice.id == "index")
                return [[self.mutant(end, end, " + 1", "index")]] if counts else []
            case ast.Call():
                return self.of_call(node)
            case ast.Expr(value=ast.Call()) if name_of(node.value.func) not in NO_EFFECT:
                return [[self.left_out(node)]]
            case ast.Assign() if not any(isinstance(target, (ast.Name, ast.Tuple)) for target in node.targets):
                return [[self.left_out(node)]]
            case ast.Break() | ast.Continue():
                return [[self.left_out(node)]]
        return []

    def left_out(self, node: ast.AST) -> Mutant:
        return self.mutant(*self.span(node), "pass", "statement")

    def of_operator(self, left: ast.AST, right: ast.AST, op: ast.AST, node: ast.AST) -> list[Mutant]:
        old = OPERATORS.get(type(op))
        if old is None or (isinstance(node, ast.BinOp) and (joins(left) or joins(right))):
            return []
        if old in OPPOSITES:
            masks = old not in "&|" or any(isinstance(inner, (ast.Compare, ast.Invert)) for inner in ast.walk(node))
            return [self.operator(left, right, old, OPPOSITES[old], "comparison")] if masks else []
        kind, new = EXCHANGED[old]
        found = [self.operator(left, right, old, new, kind)]
        if old in MOVED_BY_ONE and (is_count(left) or is_count(right)):
            found.append(self.operator(left, right, old, MOVED_BY_ONE[old], kind))
        return found

    def of_constant(self, node: ast.Constant) -> list[list[Mutant]]:
        begin, end = self.span(node)
        text = self.text[begin:end]
        if node.value is True or node.value is False:
            return [[self.mutant(begin, end, repr(not node.value), "comparison")]]
        if isinstance(node.value, int) and 0 <= node.value < 10 and text.isdigit():
            return [[self.mutant(begin, end, str(node.value + 1), "factor")]]
        if isinstance(node.value, float) and node.value and "e" not in text:
            return [[self.mutant(begin, end, repr(2 * node.value), "factor")]]
        return []

    def of_call(self, node: ast.Call) -> list[list[Mutant]]:
        found, name = [], name_of(node.func)
        if name in CALLED:
            kind, new = CALLED[name]
            end = self.span(node.func)[1]
            found.append([self.mutant(end - len(name), end, new, kind)])
        if name not in SAME and not any(isinstance(one, ast.Starred) for one in node.args):
            for a, b in zip(node.args, node.args[1:]):
                if joins(a) == joins(b) and not isinstance(a, ast.Lambda) and not isinstance(b, ast.Lambda):
                    (begin, middle), (after, end) = self.span(a), self.span(b)
                    one, other = self.text[begin:middle], self.text[after:end]
                    if one != other:
                        found.append([self.mutant(begin, end, other + self.text[middle:after] + one, "argument")])
        return found


def name_of(function: ast.AST) -> str:
    return function.attr if isinstance(function, ast.Attribute) else function.id if isinstance(function, ast.Name) else ""


def joins(node: ast.AST) -> bool:
    """Whether an operand is a text or a list, by what is written."""
    if isinstance(node, ast.BinOp):
        return joins(node.left) or joins(node.right)
    text = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return text or isinstance(node, (ast.JoinedStr, ast.List, ast.ListComp, ast.Dict, ast.DictComp))


def is_count(node: ast.AST) -> bool:
    whole = isinstance(node, ast.Constant) and type(node.value) is int and node.value > 0
    return whole or (isinstance(node, ast.Call) and name_of(node.func) == "len") or (isinstance(node, ast.Attribute) and node.attr == "size")
