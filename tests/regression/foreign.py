# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from elsewhere: what others' programs write into a .geo, a folder or a name must not change what is computed, in silence least."""

import json
import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, captured  # noqa: E402
from soft_scenes import soft  # noqa: E402

SQUARE = """Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {1, 1, 0}; Point(4) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
"""
GROUPS = 'Physical Surface("body") = {1}; Physical Curve("bottom") = {1};\n'
SIZES = (0.3, 0.1)


def run(folder: Path, *words: str, status: int = 0) -> str:
    done = captured([str(SIGNORINI), *words], cwd=folder)
    assert done.returncode == status, f"{words} ended with {done.returncode}: {done.stdout}{done.stderr}"
    return done.stdout if status == 0 else done.stderr


def cells(folder: Path, geo: str, size: float | None) -> int:
    """Of the mesh that is made of a .geo."""
    (folder / "body.geo").write_text(geo)
    text = soft("square.geo", size or 0.1, 0.1, 0.02)
    lines = [line for line in text.splitlines() if size or not line.startswith("size")]
    file = next(line for line in lines if line.startswith("file"))
    (folder / "scene.toml").write_text("\n".join(lines).replace(file, 'file = "body.geo"'))
    run(folder, "simulate", "scene.toml", "--out", "out", "--replace", "--quiet", "--set", "output.fields=[]")
    return json.loads((folder / "out" / "run.json").read_text())["cells"]


def meshes_itself(folder: Path) -> None:
    """A .geo that meshes when it is read has elements of mesh.size; a mesh that it merges has no other size than its own."""
    expected = [cells(folder, SQUARE + GROUPS, size) for size in SIZES]
    assert expected[1] > 5 * expected[0]
    for how in (GROUPS + "Mesh 1;", GROUPS + "Mesh 2;", "Mesh.MeshSizeMax = 0.5; Mesh 2;" + GROUPS + 'Save "own.msh";',
                GROUPS + "Mesh.MeshSizeMin = 0.01; Mesh 2; RefineMesh;"):  # fmt: skip
        found = [cells(folder, SQUARE + how, size) for size in SIZES]
        assert found == expected, f"{how}: {found} cells for {expected}"
    (folder / "body.geo").write_text('Merge "own.msh";\n' + GROUPS)
    said = run(folder, "info", "scene.toml", status=2)
    assert "mesh.size: has no effect" in said and "merges a mesh" in said, said
    merged = cells(folder, 'Merge "own.msh";\n' + GROUPS, None)
    print(f"a .geo that meshes itself: {expected} cells, as without; one that merges a mesh: {merged}, and no size")
    assert merged > 4


def options_of_petsc(folder: Path) -> None:
    """A file of options in the folder of a run is not read: it could load code and overwrite files."""
    cells(folder, SQUARE + GROUPS, 0.3)
    (folder / ".petscrc").write_text("-log_view :log.txt\n")
    run(folder, "simulate", "scene.toml", "--out", "out", "--replace", "--quiet")
    assert not (folder / "log.txt").exists(), ".petscrc was read"
    (folder / ".petscrc").unlink()
    run(folder, "simulate", "scene.toml", "--out", "out", "--replace", "--quiet", "--", "-log_view", ":log.txt")
    assert (folder / "log.txt").exists(), "options after -- are still PETSc's, or nothing is shown by this"


def names_in_bytes(folder: Path) -> None:
    """A scene whose name is not UTF-8 has results like any other."""
    cells(folder, SQUARE + GROUPS, 0.3)
    name = os.fsdecode(b"caf\xe9.toml")
    (folder / "scene.toml").rename(folder / name)
    run(folder, "simulate", name, "--out", "latin", "--quiet")
    run(folder, "study", name, "--out", "latin-study", "--sizes", "0.5,0.3", "--steps", "0.02", "--quantity", "displacement", "--quiet")
    told = [json.loads((folder / out).read_text())["scene"] for out in ("latin/run.json", "latin-study/study.json")]
    assert told == ["caf\ufffd"] * 2, told


def main() -> int:
    for test in (meshes_itself, options_of_petsc, names_in_bytes):
        with tempfile.TemporaryDirectory() as folder:
            test(Path(folder))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
