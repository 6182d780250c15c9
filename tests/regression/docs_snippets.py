# SPDX-License-Identifier: GPL-3.0-or-later
"""Every command and snippet of the documentation works: each page's are run in order, in a folder of their own.

Fenced blocks of README.md, CONTRIBUTING.md and docs/, by their language:

    sh            run by bash, with `signorini` on PATH and scenes/ and meshes/ of the checkout beside; must end with 0
    sh bench      too long for a test, or asks for a checkout: the verb, its options and its files must be there
    toml          `# name.toml` in its first line: written to that file; `# name.toml, continued`: added to it;
                  without a name, a part of a scene: it must parse, and the program must know its keys
    python        run; `# name.py` in its first line: written to that file too, for a command that follows
    c             `// name.geo` in its first line: written to that file
    text          what a program prints: not examined

Commands within a line of prose (`./dev …`, `signorini VERB …`) are examined like those of `sh bench`.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from dataclasses import dataclass
from functools import cache
from importlib.machinery import PathFinder
from pathlib import Path

import pytest
from harness import SIGNORINI, SOURCE

PAGES = [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", *sorted((SOURCE / "docs").rglob("*.md"))]
FENCE = re.compile(r"(?ms)^( *)```([a-z]+)( bench)?\n(.*?)^ *```$")
COMMAND = re.compile(r"(?s)(?<!`)`((?:\./dev|signorini) [^`]+)`(?!`)")
PLACEHOLDER = re.compile(r"^[A-Z]+$|…")  # SCENE, FOLDER, TOL
NAMED = {"toml": r"# ([\w-]+\.toml)(, continued)?\n", "c": r"// ([\w-]+\.geo)()\n", "python": r"# ([\w-]+\.py)()\n"}
SECONDS = 300
FOUND = PathFinder.find_spec("signorini")
# Whether the Python module is built; where it is not its snippets are compiled alone.
MODULE = FOUND is not None and FOUND.origin is not None and any(Path(FOUND.origin).parent.glob("_signorini*"))


@dataclass(frozen=True)
class Block:
    page: Path
    line: int
    language: str
    bench: bool
    text: str

    def __str__(self) -> str:
        return f"{self.page.relative_to(SOURCE)}:{self.line}"


def blocks(page: Path) -> list[Block]:
    text = page.read_text()
    return [Block(page, text[: match.start()].count("\n") + 1, match[2], bool(match[3]), re.sub(f"(?m)^{match[1]}", "", match[4]))
            for match in FENCE.finditer(text)]  # fmt: skip


def output(*command: str) -> str:
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    return done.stdout + done.stderr


@cache
def help_of(*verb: str) -> str:
    return output(str(SIGNORINI), *verb, "--help")


@cache
def known_keys() -> set[str]:
    names = set(re.findall(r"(?m)^\| `([a-z_.]+)` \|", output(str(SIGNORINI), "keys", "--markdown")))
    return names | {".".join(name.split(".")[:i]) for name in names for i in range(1, name.count(".") + 1)}


def named(block: Block) -> re.Match | None:
    """The file that a block is written to, and whether it is added to it."""
    return re.match(NAMED[block.language], block.text) if block.language in NAMED else None


def use_of(block: Block) -> str:
    """One of: shown, parsed, compiled, executed. What is compiled would be executed if the Python module were built."""
    match block.language:
        case "text":
            return "shown"
        case _ if block.bench:
            return "parsed"
        case "sh" if not MODULE and ".py" in block.text:
            return "compiled"  # with the script that it names
        case "python":
            return "compiled" if "import signorini" in block.text and not MODULE else "executed"
        case "toml" if not named(block):
            return "parsed"
        case "sh" | "toml" | "c":
            return "executed"  # a scene or a mesh by the commands that read it
    raise AssertionError(f"{block}: nothing is known of the language {block.language}")


def run(folder: Path, command: list[str], text: str | None = None) -> None:
    env = os.environ | {"PATH": f"{SIGNORINI.parent}:{os.environ['PATH']}", "MPLBACKEND": "Agg"}
    done = subprocess.run(command, cwd=folder, env=env, input=text, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, f"ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}"


def take(block: Block, folder: Path) -> None:
    """Writes, runs or examines a block."""
    use = use_of(block)
    if block.bench:
        for command in commands(block.text):
            examine(command)
        return
    if file := named(block):
        with open(folder / file[1], "a" if file[2] else "w") as out:
            out.write(block.text + "\n")
    if block.language == "python":
        compile(block.text, str(block), "exec")
        if use == "executed":
            run(folder, [sys.executable, "-"], block.text)
    elif block.language == "sh" and use == "executed":
        run(folder, ["bash", "-euo", "pipefail", "-c", block.text])
    elif block.language == "toml" and use == "parsed":
        examine_keys(block.text)
    elif block.language == "c":
        assert file, "a block of C without the name of a mesh"


def commands(text: str) -> list[list[str]]:
    joined = text.replace("\\\n", " ")
    return [words for line in joined.splitlines() if (words := shlex.split(line, comments=True))]


def examine(words: list[str]) -> None:
    """Asserts of a command that is not run that the program has its verb and options."""
    program, *rest = words
    if program == "./dev":
        examine_dev(rest)
    elif program == "signorini":
        examine_signorini(rest)
    elif program == "signorini-hard":
        for family in rest:
            assert (SOURCE / "tests" / "verification" / "hard" / f"{family}.py").is_file(), f"there is no family {family} of hard cases"
    elif "=" in program:  # a variable for the command
        examine(rest)
    else:
        assert shutil.which(program), f"there is no program {program}"


def examine_dev(words: list[str]) -> None:
    usage, verb = output("sh", str(SOURCE / "dev"), "help"), words[0]
    assert re.search(rf"(?m)^  {re.escape(verb)}\b", usage) or verb in ("help", "…"), f"./dev has no verb {verb}"
    if verb == "exec":
        examine(words[1:])
    suite = words[1] if verb == "bench" and len(words) > 1 else ""
    if suite and not suite.startswith("-") and not PLACEHOLDER.search(suite):
        script, bench = (SOURCE / "tests" / "bench" / f"{name}.py" for name in (suite, "bench"))
        assert script.is_file() or suite in (SOURCE / "dev").read_text() + bench.read_text(), f"there is no suite {suite} of ./dev bench"
        own = script if script.is_file() else bench
        for option in (word.split("=")[0] for word in words[2:] if word.startswith("--")):
            assert option in own.read_text() + (SOURCE / "tests/bench/program.py").read_text(), f"{own.name} has no option {option}"


def examine_signorini(words: list[str]) -> None:
    verb = words[0]
    if verb.startswith("-"):
        assert verb in help_of(), f"the program has no option {verb}"
    elif not PLACEHOLDER.search(verb):
        assert re.search(rf"(?m)^  {verb} ", help_of()), f"the program has no verb {verb}"
        for word in words[1 : words.index("--") if "--" in words else None]:
            assert not word.startswith("--") or word.split("=")[0] in help_of(verb), f"{verb} has no option {word}"
            assert not word.startswith("scenes/") or (SOURCE / word).is_file(), f"there is no scene {word}"


def examine_keys(text: str) -> None:
    """Asserts that the program has the keys of a part of a scene."""

    def names(value: object, path: str) -> list[str]:
        if isinstance(value, list):
            return [name for one in value for name in names(one, path)] if any(isinstance(one, dict) for one in value) else [path]
        if isinstance(value, dict) and "file" not in value:
            return [path, *(name for key, one in value.items() for name in names(one, f"{path}.{key}"))]
        return [path]

    for key, value in tomllib.loads(text).items():
        for name in names(value, key):
            known = name in known_keys() or any(name.startswith(f"{known}.") and known.endswith("value") for known in known_keys())
            assert known, f"a scene has no key {name}"


each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(SOURCE)))


@each_page
def test_fences_enclose_blocks_with_a_language(page: Path) -> None:
    fences = len(re.findall(r"(?m)^ *```", re.sub(r"(?ms)^```\{.*?^```$", "", page.read_text())))
    assert fences == 2 * len(blocks(page))


@each_page
def test_blocks(page: Path, tmp_path: Path) -> None:
    for name in ("meshes", "docs", "forms", "postprocess"):
        (tmp_path / name).symlink_to(SOURCE / name)
    shutil.copytree(SOURCE / "scenes", tmp_path / "scenes")  # paths in a scene are relative to its folder
    for block in blocks(page):
        print(f"{block}: {block.language}")  # the last one is wrong if this fails
        take(block, tmp_path)


@each_page
def test_commands_in_prose(page: Path) -> None:
    for command in COMMAND.findall(FENCE.sub("", page.read_text())):
        print(command)
        examine(shlex.split(command.replace("\n", " ")))


def test_much_is_executed() -> None:
    count = Counter(use_of(block) for page in PAGES for block in blocks(page))
    print(f"{len(PAGES)} pages: {count['executed']} snippets executed, {count['parsed']} parsed, {count['compiled']} of Python compiled")
    assert count["executed"] >= 30
