# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the pictures of docs/scenes.md: runs each scene of scenes/ and writes docs/pictures/<scene>.png.

usage: python3 docs/pictures.py [SCENE…]        with the built `signorini` on PATH; a minute for all of them

A picture is one frame of the film that `signorini figures` draws: that of the largest contact force, without contact that of
the largest displacement. Colours show the displacement, arrows the contact forces.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "postprocess"))

import as_package  # noqa: E402, F401  makes postprocess/ the package
from PIL import Image  # noqa: E402
from signorini.post import animation, control_magnitude  # noqa: E402
from signorini.post.run_folder import RunFolder  # noqa: E402

# Those whose motion without a control shows nothing, and what is run of them instead.
VERBS = {
    "billiard": ["optimize"],
    "beam": ["simulate", "--set", "solver.linear=direct"],
    "catch": ["optimize"],
    "catch-any": ["optimize"],
    "half-ball": ["simulate", "--set", 'control.initial=["0","0","-1"]'],
    "half-disc": ["optimize", "--set", "optimizer.max_iterations=60"],
    "incline-hold": ["optimize"],
    "slider": ["optimize"],
    "throw": ["optimize"],
}
WIDTH = 560  # pixels


def picture(run: RunFolder, name: str) -> Image.Image:
    """One frame of the run."""
    if name == "half-disc":
        return Image.open(control_magnitude.draw(run)[0]).convert("RGB")
    motion = animation.read_motion(run)
    size = motion.magnitude if motion.forces is None else motion.forces.sizes
    return animation.Stage(motion).picture(int(size.sum(axis=1).argmax()))


def draw(name: str, folder: Path) -> None:
    scene = HERE.parent / "scenes" / f"{name}.toml"
    out = folder / name
    verb, *options = VERBS.get(name, ["simulate"])
    subprocess.run([shutil.which("signorini"), verb, scene, *options, "--out", out, "--quiet"], check=True)
    image = picture(RunFolder(out), name)
    image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    path = HERE / "pictures" / f"{name}.png"
    colours = {} if name == "half-disc" else {"palette": animation.palette()}  # a palette makes a small file
    image.quantize(dither=Image.Dither.NONE, **colours).save(path, optimize=True)
    print(f"{path} {path.stat().st_size / 1000:.0f} kB", flush=True)


def main() -> None:
    names = sys.argv[1:] or sorted(path.stem for path in (HERE.parent / "scenes").glob("*.toml"))
    (HERE / "pictures").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            draw(name, Path(folder))


if __name__ == "__main__":
    main()
