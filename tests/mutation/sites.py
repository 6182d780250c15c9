# SPDX-License-Identifier: GPL-3.0-or-later
"""Where one token of a C++ source can be changed, and into what.

The changes, by name:

sign        + and -, += and -=, exchanged; a unary - left out
comparison  == and !=, && and ||, min and max exchanged; < > <= >= negated, of whole numbers also moved by one;
            ! left out; true and false exchanged
index       what stands in [ ] plus one; front and back exchanged
factor      * and /, *= and /= exchanged; a number with a point doubled; a whole number below 10 plus one
statement   an expression's statement, or break or continue, left out
argument    two neighbouring arguments of a call exchanged

Left alone is what has no effect on results, or is a choice where another would be as right: comments, texts, preprocessor lines,
template arguments and what they must fulfil, messages of errors (and, unless what is `printed` counts, other texts), counters, timers,
reserve() and errno before a call, calls that give back what a library lent, first values of variables that PETSc writes, numbers with an
exponent, constexpr values and those of structs of options (tolerances, limits), -1 where it says "none", and the arguments of functions
that are symmetric in them. The sources are taken to be formatted as .clang-format says: an operator of two operands has spaces around it,
brackets of a template have none.
"""

import re
from dataclasses import dataclass
from pathlib import Path

TOKEN = re.compile(
    r"""(?P<blank>\s+|//[^\n]*|/\*.*?\*/)
      | (?P<directive>^[ \t]*\#(?:[^\n\\]|\\.)*)
      | (?P<number>\d[\d']*(?:\.\d*)?(?:[eE][+-]?\d+)?[a-zA-Z]*)
      | (?P<text>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)')
      | (?P<word>[A-Za-z_]\w*)
      | (?P<sign><=>|<<|\+\+|--|->|::|&&|\|\||[-+*/|&=!<>]=|.)""",
    re.VERBOSE | re.DOTALL | re.MULTILINE)

EXCHANGED = {"+": ("sign", "-"), "-": ("sign", "+"), "+=": ("sign", "-="), "-=": ("sign", "+="),
             "==": ("comparison", "!="), "!=": ("comparison", "=="), "&&": ("comparison", "||"), "||": ("comparison", "&&"),
             "<": ("comparison", ">="), ">=": ("comparison", "<"), ">": ("comparison", "<="), "<=": ("comparison", ">"),
             "*": ("factor", "/"), "/": ("factor", "*"), "*=": ("factor", "/="), "/=": ("factor", "*=")}
EXCHANGED_WORDS = {"true": ("comparison", "false"), "false": ("comparison", "true"), "min": ("comparison", "max"),
                   "max": ("comparison", "min"), "front": ("index", "back"), "back": ("index", "front")}
MOVED_BY_ONE = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
SYMMETRIC = {"distance", "dot", "hypot", "max", "min", "swap", "product", "inner", "product_at"}
KEYWORDS = set("""alignas alignof asm auto case catch class const constexpr consteval constinit decltype default delete do else enum
    explicit extern for friend goto if inline mutable namespace new noexcept operator private protected public return sizeof static
    static_assert struct switch template throw try typedef typename union using virtual volatile while concept requires""".split())
RESTORED = re.compile(r"reserve$|.*(Restore|Destroy)")  # the latter are PETSc's names
NO_EFFECT = re.compile(rf"format$|{RESTORED.pattern}")  # on results, but for what is printed


@dataclass(frozen=True)
class Mutant:
    file: Path
    begin: int
    end: int
    new: str
    kind: str
    line: int

    def applied(self) -> str:
        text = self.file.read_text()
        return text[:self.begin] + self.new + text[self.end:]


@dataclass
class Token:
    kind: str
    text: str
    begin: int
    end: int
    skipped: bool = False


class Source:
    """The tokens of a file, with those marked that are left alone."""

    def __init__(self, file: Path, printed: bool = False):
        self.file, self.text = file, file.read_text()
        self.no_effect = RESTORED if printed else NO_EFFECT
        self.tokens = [Token(m.lastgroup, m.group(), *m.span()) for m in TOKEN.finditer(self.text)
                       if m.lastgroup not in ("blank", "directive")]
        self.inside: list[int] = []  # of each token: the bracket that it stands in
        self.closing = self.partners()
        self.mark()

    def partners(self) -> dict[int, int]:
        """The closing bracket of every opening one, templates' included, and the opening of every closing one."""
        found, open_ = {}, []
        for i, token in enumerate(self.tokens):
            self.inside.append(open_[-1] if open_ else -1)
            if token.kind == "text":
                continue
            opens_template = token.text == "<" and (not self.spaced(i) or self.at(i - 1) == "template")
            if token.text in ("(", "[", "{") or opens_template:
                open_.append(i)
            elif token.text in (")", "]", "}") or (token.text == ">" and open_ and self.at(open_[-1]) == "<"):
                found[open_[-1]], found[i] = i, open_[-1]
                open_.pop()
        return found

    def at(self, i: int) -> str:
        return self.tokens[i].text if 0 <= i < len(self.tokens) else ""

    def is_word(self, i: int) -> bool:
        return 0 <= i < len(self.tokens) and self.tokens[i].kind == "word"

    def spaced(self, i: int) -> bool:
        """Whether there is space on both sides of a token."""
        token = self.tokens[i]
        return self.text[token.begin - 1].isspace() and self.text[token.end].isspace()

    def end_of_statement(self, i: int) -> int:
        """The ; that ends what begins at i, or the { or } before it."""
        while i < len(self.tokens) and self.at(i) not in (";", "{", "}"):
            i = self.closing[i] if self.at(i) in ("(", "[") else i
            i += 1
        return i

    def end_of_requirement(self, i: int) -> int:
        while self.at(i) not in ("{", ";"):
            i += 1
        return self.closing.get(i, i)

    def skip(self, begin: int, end: int) -> None:
        for token in self.tokens[begin:end]:
            token.skipped = True

    def mark(self) -> None:
        counters = set(re.findall(r"&\s*(\w+) = count\(", self.text))
        for i, token in enumerate(self.tokens):
            if token.text == "<" and i in self.closing:
                self.skip(i, self.closing[i] + 1)
            elif token.kind != "word":
                continue
            elif token.text in ("throw", "constexpr", "static_assert", "virtual", "enum", "using", "friend"):
                self.skip(i, self.end_of_statement(i))
            elif token.text == "struct" and self.at(i + 1).endswith("Options") and self.at(i + 2) == "{":
                self.skip(i, self.closing[i + 2])
            elif token.text == "requires":
                self.skip(i, self.end_of_requirement(i))
            elif token.text.startswith("Petsc") and not self.at(i - 1) == "const":  # a value that PETSc writes over
                self.skip(i, self.end_of_statement(i) if self.is_word(i + 1) and self.at(i + 2) == "=" else i)
            elif token.text == "operator":
                self.skip(i, i + 2)
            elif token.text == "errno" and self.at(i + 1) == "=":
                self.skip(i, self.end_of_statement(i))
            elif token.text == "auto" and self.at(i + 1).startswith("timer"):
                self.skip(i, self.end_of_statement(i))
            elif token.text in ("reserve", "format") and self.no_effect.match(token.text) and self.at(i + 1) == "(":
                self.skip(i, self.closing[i + 1])
            elif token.text in counters:
                self.skip(i - 1, i + 2)  # with the operator before or behind it

    def mutants(self) -> list[list[Mutant]]:
        """What each token may become, for all that may."""
        found = [self.of_token(i) for i, token in enumerate(self.tokens) if not token.skipped and token.kind != "text"]
        return [choices for choices in found if choices]

    def mutant(self, first: int, last: int, new: str, kind: str) -> Mutant:
        begin, end = self.tokens[first].begin, self.tokens[last].end
        return Mutant(self.file, begin, end, new, kind, self.text.count("\n", 0, begin) + 1)

    def of_token(self, i: int) -> list[Mutant]:
        token = self.tokens[i]
        found = []
        if token.kind == "number":
            found += self.of_number(i)
        elif token.kind == "word":
            if token.text in EXCHANGED_WORDS and (token.text in ("true", "false") or self.at(i + 1) == "("):
                kind, new = EXCHANGED_WORDS[token.text]
                found.append(self.mutant(i, i, new, kind))
            found += self.exchanged_arguments(i)
        elif token.text in EXCHANGED and self.spaced(i):
            kind, new = EXCHANGED[token.text]
            found.append(self.mutant(i, i, new, kind))
            if token.text in MOVED_BY_ONE and self.of_whole_numbers(i):
                found.append(self.mutant(i, i, MOVED_BY_ONE[token.text], kind))
        elif token.text == "-" and not self.says_none(i):
            found.append(self.mutant(i, i, "", "sign"))
        elif token.text == "!":
            found.append(self.mutant(i, i, "", "comparison"))
        elif token.text == "]" and self.is_subscript(self.closing[i]) and self.closing[i] + 1 < i:
            if not (self.closing[i] + 2 == i and self.tokens[i - 1].kind == "number"):
                found.append(self.mutant(i, i, " + 1]", "index"))
        return found + self.dropped(i)

    def of_number(self, i: int) -> list[Mutant]:
        text = self.at(i)
        if re.fullmatch(r"\d+\.\d*", text):
            return [self.mutant(i, i, repr(2 * float(text)), "factor")] if float(text) else []
        if re.fullmatch(r"\d", text) and not (self.at(i - 1) == "-" and self.says_none(i - 1)):
            kind = "index" if self.at(i - 1) == "[" and self.at(i + 1) == "]" else "factor"
            return [self.mutant(i, i, str(int(text) + 1), kind)]
        return []

    def says_none(self, i: int) -> bool:
        """Whether the - at i begins a -1 that stands for "none"."""
        return self.at(i + 1) == "1" and self.at(i - 1) in ("=", "?", ":", "return", "==", "!=")

    def is_subscript(self, i: int) -> bool:
        return i > 0 and self.at(i - 1) not in KEYWORDS and (self.is_word(i - 1) or self.at(i - 1) in (")", "]"))

    def of_whole_numbers(self, i: int) -> bool:
        """Whether a comparison is one of whole numbers, as far as the text shows: in a loop's head, or beside a whole number or a size."""
        beside = [self.tokens[i + 1].text]
        beside.append(self.at(self.closing[i - 1] - 1) if self.at(i - 1) == ")" else self.at(i - 1))
        j = i
        while j < len(self.tokens) and self.at(j) not in ("(", ")", "{", ";"):
            if self.at(j) in ("size", "count"):
                return True
            j += 1
        if any(re.fullmatch(r"[1-9]\d*", text) or text in ("size", "count") for text in beside):
            return True
        while i >= 0 and self.at(i) not in ("{", "}", "("):
            i = self.closing[i] if self.at(i) in (")", "]") else i
            i -= 1
        return self.at(i) == "(" and self.at(i - 1) == "for"

    def declares(self, begin: int, end: int) -> bool:
        """Whether tokens declare something: two words in a row, but for & or * beside one of them."""
        for j in range(begin, end - 1):
            if self.at(j) in KEYWORDS and self.at(j) in ("const", "auto", "struct", "class", "typename"):
                return True
            behind_type = (self.is_word(j) and self.at(j) not in KEYWORDS) or (self.at(j) in (">", "*", "&", "&&") and not self.spaced(j))
            if behind_type and self.is_word(j + 1) and self.text[self.tokens[j].end] == " ":
                return True
            if behind_type and self.at(j + 1) in ("*", "&") and not self.spaced(j + 1) and self.is_word(j + 2):
                return True
            if self.at(j) in ("(", "=", "[", "{", "+=", "-=", "*=", "/=", ".", "->"):
                return False
        return False

    def arguments(self, i: int) -> list[tuple[int, int]]:
        """First and last token of each argument between the bracket at i and its partner."""
        spans, begin, j = [], i + 1, i + 1
        while j <= self.closing[i]:
            if self.at(j) == "," or j == self.closing[i]:
                spans.append((begin, j - 1))
                begin = j + 1
            elif j in self.closing:
                j = self.closing[j]
            j += 1
        return spans

    def exchanged_arguments(self, i: int) -> list[Mutant]:
        if self.at(i) in KEYWORDS | SYMMETRIC or self.no_effect.match(self.at(i)) or self.at(i + 1) != "(":
            return []
        spans = self.arguments(i + 1)
        if any(a > b or self.declares(a, b + 2) for a, b in spans):
            return []
        text = [self.text[self.tokens[a].begin:self.tokens[b].end] for a, b in spans]
        return [self.mutant(spans[n][0], spans[n + 1][1], f"{text[n + 1]}, {text[n]}", "argument")
                for n in range(len(spans) - 1) if text[n] != text[n + 1]]

    def begins_statement(self, i: int) -> bool:
        before = self.at(i - 1)
        if self.at(self.inside[i]) == "(":  # in a loop's head
            return False
        if before == ")":
            head = self.closing[i - 1] - 1
            return self.at(head) in ("if", "for", "while") or self.at(head) == "constexpr"
        return before in (";", "{", "}", "else", "do")

    def dropped(self, i: int) -> list[Mutant]:
        if not self.begins_statement(i) or not (self.is_word(i) or self.at(i) in ("++", "--", "*")):
            return []
        end = self.end_of_statement(i)
        if self.at(end) != ";":
            return []
        words = [token.text for token in self.tokens[i:end] if token.kind == "word"]
        if self.at(i) in ("break", "continue"):
            return [self.mutant(i, end, ";", "statement")]
        calls_or_changes = any(self.at(j) in ("(", "++", "--") or re.fullmatch(r"[-+*/|&]?=", self.at(j)) for j in range(i, end))
        if (self.at(i) in KEYWORDS or not calls_or_changes or self.declares(i, end) or any(map(self.no_effect.match, words))
                or (self.at(i + 1) == "(" and any(self.declares(a, b + 2) for a, b in self.arguments(i + 1)))  # a constructor
                or words[0].startswith("require")):
            return []
        return [self.mutant(i, end, ";", "statement")]
