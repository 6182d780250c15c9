# SPDX-License-Identifier: GPL-3.0-or-later
"""`check` fails, with exit status 1, where it has nothing to check: no contact, no motion, no size that keeps the sets."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SOURCE, attempt  # noqa: E402

BLOCK = SOURCE / "tests/data/block.toml"


def check(name: str, status: int, fragments: list[str], scene: Path, **overrides: object) -> bool:
    done = attempt("check", scene, **overrides)
    missing = [text for text in fragments if text not in done.stdout]
    holds = done.returncode == status and not missing
    print(f"{'ok' if holds else 'FAIL'}: {name}" + (f": exit {done.returncode}, missing {missing}" if not holds else ""))
    return holds


def main() -> int:
    coarse = {"mesh__size": 3}
    results = [
        check("contact never closed", 1, ["never: this checks nothing of contact", "A check failed."], HALF_DISC, **coarse,
              check__control=["0", "-0.3"]),
        check("nothing moves", 1, ["FAIL  the body moved"], HALF_DISC, **coarse, check__control=["0", "0"]),
        check("contact without control", 0, ["no derivatives to check", "contact included"], BLOCK_WITHOUT_CONTROL),
        check("no contact in the scene", 0, ["checks a linear problem", "contact was not checked"],
              SOURCE / "tests/data/manufactured.toml"),
        check("contact and control", 0, ["Taylor order", "|d| = |u|:", "All checks hold, contact included."], BLOCK),
        check("no control to be as long as", 0, ["|d| = 1, since u = 0:"], BLOCK, check__control=["0", "0"]),
    ]  # fmt: skip
    return 0 if all(results) else 1


def without_control(scene: Path) -> Path:
    """A copy of a scene without its control and objective."""
    import re
    import tempfile

    text = re.sub(r"(?ms)^\[(control|objective|optimizer)\].*?(?=^\[|\Z)", "", scene.read_text())
    copy = Path(tempfile.mkdtemp()) / scene.name
    copy.write_text(text.replace('"square.geo"', f'"{scene.parent / "square.geo"}"'))
    return copy


if __name__ == "__main__":
    BLOCK_WITHOUT_CONTROL = without_control(BLOCK)
    raise SystemExit(main())
