# SPDX-License-Identifier: GPL-3.0-or-later
"""Every command and snippet of the documentation works: each page's are run in order, in a folder of their own.

Fenced blocks of README.md, CONTRIBUTING.md and docs/, by their language:

    sh            run by bash, with `signorini` on PATH and scenes/ and meshes/ of the checkout beside; must end with 0
    sh bench      too long for a test, or asks for a checkout: the verb, its options and its files must be there
    toml          `# name.toml` in its first line: written to that file; `# name.toml, continued`: added to it;
                  without a name, a part of a scene: it must parse, and the program must know its keys
    python        run; `# name.py` in its first line: written to that file too, for a command that follows
    c             `// name.geo` in its first line: written to that file
    text          what a program prints: not looked at

Commands within a line of prose (`./dev …`, `signorini VERB …`) are looked at like those of `sh bench`.

    docs_snippets.py SIGNORINI SOURCE [PAGE…]
"""

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path

SIGNORINI, SOURCE = (Path(a).resolve() for a in sys.argv[1:3])
FENCE = re.compile(r"(?ms)^( *)```([a-z]+)( bench)?\n(.*?)^ *```$")
COMMAND = re.compile(r"(?s)(?<!`)`((?:\./dev|signorini) [^`]+)`(?!`)")
PLACEHOLDER = re.compile(r"^[A-Z]+$|…")  # SCENE, FOLDER, TOL
NAMED = {"toml": r"# ([\w-]+\.toml)(, continued)?\n", "c": r"// ([\w-]+\.geo)()\n", "python": r"# ([\w-]+\.py)()\n"}
SECONDS = 300
FOUND = importlib.util.find_spec("signorini")
# Whether the Python module is built; where it is not its snippets are compiled alone.
MODULE = FOUND is not None and FOUND.origin is not None and any(Path(FOUND.origin).parent.glob("_signorini*"))


class Wrong(Exception):
    """What is wrong with a snippet."""


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
    found = [Block(page, text[: match.start()].count("\n") + 1, match[2], bool(match[3]), re.sub(f"(?m)^{match[1]}", "", match[4]))
             for match in FENCE.finditer(text)]  # fmt: skip
    fences = len(re.findall(r"(?m)^ *```", re.sub(r"(?ms)^```\{.*?^```$", "", text)))
    if fences != 2 * len(found):
        raise Wrong(f"{page.relative_to(SOURCE)}: {fences} fences, of which {2 * len(found)} enclose a block with a language")
    return found


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


class Page:
    """A page's scratch folder."""

    def __init__(self, page: Path, folder: Path):
        self.page, self.folder = page, folder
        self.env = os.environ | {"PATH": f"{SIGNORINI.parent}:{os.environ['PATH']}", "MPLBACKEND": "Agg"}
        for name in ("scenes", "meshes", "docs", "forms", "postprocess"):
            (folder / name).symlink_to(SOURCE / name)

    def run(self, command: list[str], text: str | None = None) -> None:
        done = subprocess.run(command, cwd=self.folder, env=self.env, input=text, capture_output=True, text=True, timeout=SECONDS)
        if done.returncode:
            raise Wrong(f"ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")

    def take(self, block: Block) -> str:
        """Runs or checks a block; what was done with it, for the count."""
        if block.language == "text":
            return "shown"
        if block.bench:
            for command in commands(block.text):
                look_at(command, self.folder)
            return "parsed"
        named = re.match(NAMED[block.language], block.text) if block.language in NAMED else None
        if named:
            with open(self.folder / named[1], "a" if named[2] else "w") as file:
                file.write(block.text + "\n")
        match block.language:
            case "sh" if not MODULE and ".py" in block.text:
                return "compiled"  # with the script that it names
            case "sh":
                self.run(["bash", "-euo", "pipefail", "-c", block.text])
                return "executed"
            case "python":
                compile(block.text, str(block), "exec")
                if "import signorini" in block.text and not MODULE:
                    return "compiled"
                self.run([sys.executable, "-"], block.text)
                return "executed"
            case "toml" if named:
                return "executed"  # by the commands that read it
            case "toml":
                look_at_keys(block.text)
                return "parsed"
            case "c" if named:
                return "executed"
        raise Wrong(f"nothing is known of the language {block.language}")


def commands(text: str) -> list[list[str]]:
    joined = text.replace("\\\n", " ")
    return [words for line in joined.splitlines() if (words := shlex.split(line, comments=True))]


def look_at(words: list[str], folder: Path) -> None:
    """A command that is not run: does the program know its verb and options?"""
    program, *rest = words
    if program == "./dev":
        look_at_dev(rest, folder)
    elif program == "signorini":
        look_at_signorini(rest, folder)
    elif program == "signorini-hard":
        for family in rest:
            if not (SOURCE / "tests" / "verification" / "hard" / f"{family}.py").is_file():
                raise Wrong(f"there is no family {family} of hard cases")
    elif "=" in program:  # a variable for the command
        look_at(rest, folder)
    elif not shutil.which(program):
        raise Wrong(f"there is no program {program}")


def look_at_dev(words: list[str], folder: Path) -> None:
    usage = output("sh", str(SOURCE / "dev"), "help")
    verb = words[0]
    if not re.search(rf"(?m)^  {re.escape(verb)}\b", usage) and verb not in ("help", "…"):
        raise Wrong(f"./dev has no verb {verb}")
    if verb == "exec":
        look_at(words[1:], folder)
    suite = words[1] if verb == "bench" and len(words) > 1 else ""
    if suite and not suite.startswith("-") and not PLACEHOLDER.search(suite):
        script = SOURCE / "tests" / "bench" / f"{suite}.py"
        if not script.is_file() and suite not in (SOURCE / "dev").read_text() + (SOURCE / "tests/bench/bench.py").read_text():
            raise Wrong(f"there is no suite {suite} of ./dev bench")
        own = script if script.is_file() else SOURCE / "tests/bench/bench.py"
        for option in (word.split("=")[0] for word in words[2:] if word.startswith("--")):
            if option not in own.read_text() + (SOURCE / "tests/bench/program.py").read_text():
                raise Wrong(f"{own.name} has no option {option}")


def look_at_signorini(words: list[str], folder: Path) -> None:
    verb = words[0]
    if verb.startswith("-"):
        if verb not in help_of():
            raise Wrong(f"the program has no option {verb}")
        return
    if PLACEHOLDER.search(verb):
        return
    if not re.search(rf"(?m)^  {verb} ", help_of()):
        raise Wrong(f"the program has no verb {verb}")
    for word in words[1 : words.index("--") if "--" in words else None]:
        if word.startswith("--") and word.split("=")[0] not in help_of(verb):
            raise Wrong(f"{verb} has no option {word}")
        if word.startswith("scenes/") and not (SOURCE / word).is_file():
            raise Wrong(f"there is no scene {word}")


def look_at_keys(text: str) -> None:
    """A part of a scene: tables whose keys the program knows."""

    def names(value: object, path: str) -> list[str]:
        if isinstance(value, list):
            return [name for one in value for name in names(one, path)] if any(isinstance(one, dict) for one in value) else [path]
        if isinstance(value, dict) and "file" not in value:
            return [path, *(name for key, one in value.items() for name in names(one, f"{path}.{key}"))]
        return [path]

    for key, value in tomllib.loads(text).items():
        for name in names(value, key):
            if name not in known_keys() and not any(name.startswith(f"{known}.") and known.endswith("value") for known in known_keys()):
                raise Wrong(f"a scene has no key {name}")


def main() -> int:
    pages = [Path(page).resolve() for page in sys.argv[3:]]
    pages = pages or [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", *sorted((SOURCE / "docs").rglob("*.md"))]
    count, failed = Counter(), 0
    with tempfile.TemporaryDirectory() as scratch:
        for number, page in enumerate(pages):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            place = Page(page, folder)
            try:
                found = blocks(page)
            except Wrong as reason:
                failed += 1
                print(f"FAIL  {reason}", flush=True)
                continue
            for block in found:
                try:
                    count[place.take(block)] += 1
                except (Wrong, SyntaxError, tomllib.TOMLDecodeError, subprocess.TimeoutExpired) as reason:
                    failed += 1
                    print(f"FAIL  {block}: {reason}", flush=True)
            for command in COMMAND.findall(FENCE.sub("", page.read_text())):
                words = shlex.split(command.replace("\n", " "))
                try:
                    look_at(words, folder)
                    count["in prose"] += 1
                except Wrong as reason:
                    failed += 1
                    print(f"FAIL  {page.relative_to(SOURCE)}: `{command}`: {reason}", flush=True)
    print(f"{len(pages)} pages: {count['executed']} snippets executed, {count['parsed']} parsed, {count['compiled']} of Python compiled; "
          f"{count['in prose']} commands in prose; {failed} failures")  # fmt: skip
    if not sys.argv[3:] and count["executed"] < 30:
        print("hardly anything was executed")
        return 1
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
