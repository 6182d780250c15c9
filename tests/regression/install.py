# SPDX-License-Identifier: GPL-3.0-or-later
"""What is installed works wherever it is moved: program, verbs that are scripts, completion, manual, and find_package(signorini).

    install.py SIGNORINI SOURCE CMAKE BUILD
"""

import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE, CMAKE, BUILD = Path(sys.argv[2]).resolve(), sys.argv[3], Path(sys.argv[4]).resolve()
# Nothing of the build is found by a name alone.
ENV = os.environ | {"PATH": ":".join(at for at in os.environ["PATH"].split(":") if Path(at).resolve() != BUILD)}
QUICK = ("mesh.size=3", "time.end=2e-3")


def run(*command: object, status: int = 0, **more: object) -> subprocess.CompletedProcess:
    done = subprocess.run([*map(str, command)], stdin=subprocess.DEVNULL, capture_output=True, text=True, **{"env": ENV} | more)
    if done.returncode != status:
        raise SystemExit(f"{done.args} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done


def installed(folder: Path) -> Path:
    """The prefix, at another place than the one that it was installed to."""
    first, prefix = folder / "first place", folder / "second plàce" / "deeper"
    run(CMAKE, "--install", BUILD, "--prefix", first)
    prefix.parent.mkdir()
    first.rename(prefix)
    for file in [*prefix.rglob("*.cmake"), *prefix.rglob("share/**/*")]:
        text = file.read_bytes() if file.is_file() else b""
        for place in (SOURCE, BUILD, first):
            assert bytes(place) not in text, f"{file.relative_to(prefix)} names {place}"
    for name in ("scenes/half-disc.toml", "meshes/half-disc.geo", "scenes/data", "forms/viscoelasticity.py", "postprocess/report.py"):
        assert (prefix / "share" / "signorini" / name).exists(), name
    assert not list(prefix.rglob("__pycache__"))
    return prefix


def files(prefix: Path) -> set[Path]:
    return set(prefix.rglob("*"))


def solves_and_draws(prefix: Path, work: Path) -> None:
    """In the current folder, and nothing is left beside the scene."""
    before = files(prefix)
    program = prefix / "bin" / "signorini"
    scene = prefix / "share" / "signorini" / "scenes" / "half-disc.toml"
    run(program, "optimize", scene, *(word for setting in (*QUICK, "optimizer.max_iterations=1") for word in ("--set", setting)), cwd=work)
    results = work / "results" / "half-disc"
    assert (results / "run.json").is_file()
    assert (results / "report.html").as_posix().endswith(run(program, "report", "results/half-disc", cwd=work).stdout.split("\n")[1])
    assert (results / "report.html").stat().st_size > 1e6
    run(program, "figures", "results/half-disc", "--time", "1e-3", cwd=work)
    assert (results / "figures" / "objective.png").stat().st_size > 5000
    assert "convergence.png" in run(program, "plot", results).stdout
    assert files(prefix) == before, f"left behind: {files(prefix) - before}"


def fails_in_a_sentence(prefix: Path, folder: Path) -> None:
    program = prefix / "bin" / "signorini"
    said = run(program, "report", folder / "nothing", status=2).stderr
    assert said.startswith(f"signorini report: {folder / 'nothing'}: ") and said.count("\n") == 1, said
    said = run(program, "figures", "--tim", "1", status=2).stderr
    assert "usage: signorini figures " in said, said
    assert "usage: signorini plot " in run(program, "plot", "--help").stdout
    empty = folder / "empty"
    empty.mkdir()
    said = run(program, "report", folder, status=2, env=ENV | {"PATH": str(empty)}).stderr
    assert said.startswith("signorini: report: no python3 on PATH ") and said.count("\n") == 1, said
    (empty / "python3").symlink_to(shutil.which("python3"))
    said = run(program, "report", folder, status=2, env=ENV | {"PYTHONPATH": str(without(folder, "jinja2"))}).stderr
    assert said.startswith("signorini report: found no Python package jinja2 ") and said.count("\n") == 1, said
    scripts = prefix / "share" / "signorini" / "postprocess"
    scripts.rename(folder / "away")
    said = run(program, "report", folder, status=2).stderr
    assert said.startswith("signorini: report: found none of its scripts") and str(scripts) in said and said.count("\n") == 1, said
    (folder / "away").rename(scripts)


def without(folder: Path, package: str) -> Path:
    """A folder for PYTHONPATH, by which a package is missing."""
    place = folder / "without"
    place.mkdir()
    (place / f"{package}.py").write_text(f"raise ModuleNotFoundError(name={package!r})\n")
    return place


def is_told(prefix: Path) -> None:
    """The completion and the manual."""
    completion = prefix / "share" / "bash-completion" / "completions" / "signorini"
    assert "-F _signorini" in run("bash", "-c", '. "$1" && complete -p signorini', "bash", completion).stdout
    manual = prefix / "share" / "man" / "man1" / "signorini.1"
    program = prefix / "bin" / "signorini"
    made = run("man", "--warnings", "-E", "UTF-8", "-l", manual, env=ENV | {"MANWIDTH": "120", "MANROFFOPT": "-rHY=0"})
    assert not made.stderr, made.stderr
    page = re.sub(".\b", "", made.stdout)
    options = set(re.findall(r"--[a-z][a-z-]+", run(program, "simulate", "--help").stdout))
    keys = re.findall(r"(?m)^[a-z_.]+$", run(program, "keys").stdout)
    missing = [word for word in (*options, *keys, "signorini report", "signorini plot", "--time", "GNU General") if word not in page]
    assert len(options) > 8 and len(keys) > 60 and not missing, f"not in the manual: {missing}"
    print(f"the manual has {len(page.splitlines())} lines, {len(keys)} keys in them")


def builds_others(prefix: Path, folder: Path) -> None:
    """J at the first guess, by a program of one's own: what the first row of history.csv says."""
    build, work = folder / "own", folder / "own work"
    work.mkdir()
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    run(CMAKE, "-S", SOURCE / "tests" / "package" / "own", "-B", build, *generator, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
    run(CMAKE, "--build", build)
    scene = prefix / "share" / "signorini" / "scenes" / "half-disc.toml"
    env = ENV | {"PATH": f"{prefix / 'bin'}:{ENV['PATH']}"}  # where the library finds signorini-gmsh
    said = run(build / "own", scene, *QUICK, cwd=work, env=env).stdout
    found = re.fullmatch(r"J = (\S+), \|gradient\| = (\S+)\n", said)
    assert found, said
    run(prefix / "bin" / "signorini", "optimize", scene, "--out", work / "run", *(word for setting in (*QUICK, "optimizer.max_iterations=0",
        "optimizer.start=guess") for word in ("--set", setting)))  # fmt: skip
    with open(work / "run" / "history.csv") as file:
        row = next(csv.DictReader(file))
    # The same steps with the same numbers, summed in the same order.
    assert abs(float(found[1]) / float(row["objective"]) - 1) < 1e-12, (said, row)
    assert float(found[2]) > 0
    print(f"by find_package: {said.strip()}")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        prefix = installed(folder)
        work = folder / "work"
        work.mkdir()
        solves_and_draws(prefix, work)
        fails_in_a_sentence(prefix, folder)
        is_told(prefix)
        builds_others(prefix, folder)
        print("program, scripts, completion, manual and library work in a prefix that was moved")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
