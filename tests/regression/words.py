# SPDX-License-Identifier: GPL-3.0-or-later
"""What users and maintainers read is plain: no word that betrays a metaphor, no docstring without a subject, no long message.

Each test lists all complaints of its kind; -rP shows how many texts were read.
"""

import ast
import io
import re
import tokenize
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from harness import SOURCE

COLUMNS = 110  # of C++
LONGEST = 25  # words of a sentence of a message
# Data, searches and files do not do these things. A pattern, and the plain word.
WORDS = {
    r"tells?|told|telling": "report, determine, identify, estimate",
    r"made again": "repeated, recomputed",
    r"(?:goes|go|going|went) on": "continue, resume",
    r"look(?:s|ed)? at": "sample, inspect, evaluate",
    r"lets? go": "release, exit",
    r"by luck": "by coincidence",
    r"doubt\w*": "warning",
    r"vouch\w*": "guarantee",
    r"allowed (?:is|are)": "expected",
}
UNWANTED = re.compile(rf"\b(?:{'|'.join(WORDS)})\b", re.IGNORECASE)
# Names that scripts rely on.
PUBLIC = re.compile(r"(?:body|accuracy)\.doubts?|not_told|^doubts?$|[\"'`]doubts?[\"'`]")
# A docstring that begins like this has no subject.
NO_SUBJECT = re.compile(r"(?:Of|That|Those|Likewise|The same|By|As|To be|In words|With|Without)\b")
RAW = re.compile(r'R"(\w*)\(.*?\)\1"', re.DOTALL)
TOKEN = re.compile(r'//[^\n]*|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)\'')


@dataclass(frozen=True)
class Text:
    """A comment, a docstring, a message or a paragraph, and where it stands."""

    file: Path
    line: int
    kind: str
    words: str


def of_cpp(file: Path) -> Iterator[Text]:
    """Comments, of several lines as one, docstrings among them, and string literals, adjacent ones as one."""
    source = file.read_text()
    blanked = RAW.sub(lambda raw: re.sub(r"[^\n]", " ", raw.group()), source)
    last: list | None = None  # kind, first line, last line, end, words
    for match in TOKEN.finditer(blanked):
        token, line = match.group(), blanked.count("\n", 0, match.start()) + 1
        if token.startswith("'"):
            continue
        alone = not blanked[blanked.rfind("\n", 0, match.start()) + 1 : match.start()].strip()
        kind = "message" if token.startswith('"') else "docstring" if re.match(r"/// ", token) else "member" if token.startswith("///<") else "comment"
        words = token[1:-1] if kind == "message" else token.lstrip("/<! ")
        follows = last and (not blanked[last[3] : match.start()].strip() if kind == "message" else line == last[2] + 1 and alone)
        if last and follows and (last[0] == kind or last[0] == "member" and kind == "member"):
            last[2:] = [line, match.end(), last[4] + ("" if kind == "message" else " ") + words]
            continue
        if last:
            yield Text(file, last[1], last[0], last[4])
        last = [kind, line, line, match.end(), words]
    if last:
        yield Text(file, last[1], last[0], last[4])


def of_python(file: Path) -> Iterator[Text]:
    """Docstrings, comments and the constant parts of texts."""
    source = file.read_text()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield Text(file, node.lineno, "text", node.value)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield Text(file, token.start[0], "comment", token.string)


def of_page(file: Path) -> Iterator[Text]:
    """Lines outside of code blocks."""
    code = False
    for number, line in enumerate(file.read_text().splitlines(), 1):
        if line.lstrip().startswith("```"):
            code = not code
        elif not code:
            yield Text(file, number, "page", line)


@pytest.fixture(scope="module")
def cpp() -> list[Path]:
    return [file for folder in ("cpp", "python/bindings") for file in sorted((SOURCE / folder).rglob("*")) if file.suffix in (".h", ".cpp")]


@pytest.fixture(scope="module")
def texts(cpp: list[Path]) -> list[Text]:
    python = [file for folder in ("python/signorini", "postprocess") for file in sorted((SOURCE / folder).rglob("*.py"))]
    pages = [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", *sorted((SOURCE / "docs").rglob("*.md"))]
    found = [text for files, read in ((cpp, of_cpp), (python, of_python), (pages, of_page)) for file in files for text in read(file)]
    kinds = Counter(text.kind for text in found)
    print(", ".join(f"{count} of kind {kind}" for kind, count in kinds.items()))
    assert all(kinds[kind] > 100 for kind in ("docstring", "member", "comment", "message", "text", "page")), "hardly anything was read"
    return found


def unwanted(text: Text) -> Iterator[str]:
    for match in UNWANTED.finditer(PUBLIC.sub("", text.words)):
        plain = next(plain for word, plain in WORDS.items() if re.fullmatch(word, match.group(), re.IGNORECASE))
        yield f'"{match.group()}" ({plain})'


def without_subject(text: Text) -> Iterator[str]:
    if text.kind == "docstring" and NO_SUBJECT.match(text.words):
        yield f"a docstring without a subject: {text.words[:60]}"


def long_sentences(text: Text) -> Iterator[str]:
    """Sentences of messages; a placeholder is a word."""
    for sentence in re.split(r"(?<=[.!?])\s+|\\n", text.words) if text.kind == "message" else ():
        count = sum(bool(re.search(r"[A-Za-z{]", word)) for word in sentence.split())
        if count > LONGEST:
            yield f"a sentence of {count} words, at most {LONGEST} are meant: {sentence}"


@pytest.mark.parametrize("rule", (unwanted, without_subject, long_sentences))
def test_rule(rule: Callable[[Text], Iterator[str]], texts: list[Text]) -> None:
    found = [f"{text.file.relative_to(SOURCE)}:{text.line}: {complaint}" for text in texts for complaint in rule(text)]
    assert not found, f"{len(found)} complaints:\n" + "\n".join(found)


def test_columns(cpp: list[Path]) -> None:
    found = [f"{file.relative_to(SOURCE)}:{number}: {len(line)} columns, at most {COLUMNS} are meant" for file in cpp
             for number, line in enumerate(RAW.sub(lambda raw: re.sub(r"[^\n]", "", raw.group()), file.read_text()).splitlines(), 1)
             if len(line) > COLUMNS]  # fmt: skip
    assert not found, f"{len(found)} complaints:\n" + "\n".join(found)
