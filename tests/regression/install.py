# SPDX-License-Identifier: GPL-3.0-or-later
"""An installation works wherever it is moved: program, verbs that are scripts, completion, manual, and find_package(signorini)."""

import csv
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import BUILD, SOURCE

CMAKE = shutil.which("cmake")
# Nothing of the build is found by a name alone.
ENV = os.environ | {"PATH": ":".join(at for at in os.environ["PATH"].split(":") if Path(at).resolve() != BUILD)}
QUICK = ("mesh.size=3", "time.end=2e-3")


def run(*command: object, status: int = 0, **more: object) -> subprocess.CompletedProcess:
    done = subprocess.run([*map(str, command)], stdin=subprocess.DEVNULL, capture_output=True, text=True, **{"env": ENV} | more)
    assert done.returncode == status, f"{done.args} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
    return done


def sets(*settings: str) -> list[str]:
    return [word for setting in settings for word in ("--set", setting)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("install").resolve()


@pytest.fixture(scope="module")
def prefix(folder: Path) -> Path:
    """An installation, at another place than the one that it was installed to."""
    first, prefix = folder / "first place", folder / "second plàce" / "deeper"
    run(CMAKE, "--install", BUILD, "--prefix", first)
    prefix.parent.mkdir()
    first.rename(prefix)
    assert not list(prefix.rglob("__pycache__"))
    return prefix


@pytest.fixture(autouse=True)
def nothing_left_behind(prefix: Path) -> Iterator[None]:
    """No test leaves a file in the prefix."""
    before = set(prefix.rglob("*"))
    yield
    assert set(prefix.rglob("*")) == before


@pytest.fixture(scope="module")
def program(prefix: Path) -> Path:
    return prefix / "bin" / "signorini"


@pytest.fixture(scope="module")
def scene(prefix: Path) -> Path:
    return prefix / "share" / "signorini" / "scenes" / "half-disc.toml"


@pytest.fixture(scope="module")
def results(program: Path, scene: Path, folder: Path) -> Path:
    """A run's folder, in the current folder of the run."""
    work = folder / "work"
    work.mkdir()
    run(program, "optimize", scene, *sets(*QUICK, "optimizer.max_iterations=1"), cwd=work)
    assert (work / "results" / "half-disc" / "run.json").is_file()
    return work / "results" / "half-disc"


def test_names_no_other_place(prefix: Path, folder: Path) -> None:
    for file in [*prefix.rglob("*.cmake"), *prefix.rglob("share/**/*")]:
        text = file.read_bytes() if file.is_file() else b""
        for place in (SOURCE, BUILD, folder / "first place"):
            assert bytes(place) not in text, f"{file.relative_to(prefix)} names {place}"


@pytest.mark.parametrize("name", ("scenes/half-disc.toml", "meshes/half-disc.geo", "scenes/data", "forms/viscoelasticity.py", "postprocess/report.py"))
def test_has(name: str, prefix: Path) -> None:
    assert (prefix / "share" / "signorini" / name).exists()


def test_report(program: Path, results: Path) -> None:
    page = results / "report.html"
    assert page.as_posix().endswith(run(program, "report", "results/half-disc", cwd=results.parents[1]).stdout.split("\n")[1])
    assert page.stat().st_size > 1e6


def test_figures(program: Path, results: Path) -> None:
    run(program, "figures", "results/half-disc", "--time", "1e-3", cwd=results.parents[1])
    assert (results / "figures" / "objective.png").stat().st_size > 5000


def test_plot(program: Path, results: Path) -> None:
    assert "convergence.png" in run(program, "plot", results).stdout
    assert "usage: signorini plot " in run(program, "plot", "--help").stdout


def one_line(start: str, *command: object, **more: object) -> str:
    """What a command that fails says, in one line that starts like this."""
    said = run(*command, status=2, **more).stderr
    assert said.startswith(start) and said.count("\n") == 1
    return said


def test_no_such_folder(program: Path, tmp_path: Path) -> None:
    one_line(f"signorini report: {tmp_path / 'nothing'}: ", program, "report", tmp_path / "nothing")


def test_no_such_option(program: Path) -> None:
    assert "usage: signorini figures " in run(program, "figures", "--tim", "1", status=2).stderr


def test_no_python(program: Path, tmp_path: Path) -> None:
    one_line("signorini: report: no python3 on PATH ", program, "report", tmp_path, env=ENV | {"PATH": str(tmp_path)})


def test_no_package(program: Path, tmp_path: Path) -> None:
    (tmp_path / "jinja2.py").write_text("raise ModuleNotFoundError(name='jinja2')\n")
    one_line("signorini report: the Python package jinja2 is missing ", program, "report", tmp_path, env=ENV | {"PYTHONPATH": str(tmp_path)})


def test_no_scripts(prefix: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(prefix, tmp_path / "copy", symlinks=True)
    scripts = copy / "share" / "signorini" / "postprocess"
    shutil.rmtree(scripts)
    assert str(scripts) in one_line("signorini: report: the scripts of this verb were not found", copy / "bin" / "signorini", "report", tmp_path)


def test_completion(prefix: Path) -> None:
    completion = prefix / "share" / "bash-completion" / "completions" / "signorini"
    assert "-F _signorini" in run("bash", "-c", '. "$1" && complete -p signorini', "bash", completion).stdout


def test_manual(prefix: Path, program: Path) -> None:
    manual = prefix / "share" / "man" / "man1" / "signorini.1"
    made = run("man", "--warnings", "-E", "UTF-8", "-l", manual, env=ENV | {"MANWIDTH": "120", "MANROFFOPT": "-rHY=0"})
    assert not made.stderr
    page = re.sub(".\b", "", made.stdout)
    options = set(re.findall(r"--[a-z][a-z-]+", run(program, "simulate", "--help").stdout))
    keys = re.findall(r"(?m)^[a-z_.]+$", run(program, "keys").stdout)
    missing = [word for word in (*options, *keys, "signorini report", "signorini plot", "--time", "GNU General") if word not in page]
    assert len(options) > 8 and len(keys) > 60 and not missing
    print(f"the manual has {len(page.splitlines())} lines, {len(keys)} keys in them")


def test_program_by_find_package(prefix: Path, program: Path, scene: Path, tmp_path: Path) -> None:
    """J at the first guess, by a program of one's own: that of the first row of history.csv."""
    build, work = tmp_path / "own", tmp_path / "own work"
    work.mkdir()
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    run(CMAKE, "-S", SOURCE / "tests" / "package" / "own", "-B", build, *generator, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
    run(CMAKE, "--build", build)
    env = ENV | {"PATH": f"{prefix / 'bin'}:{ENV['PATH']}"}  # where the library finds signorini-gmsh
    found = re.fullmatch(r"J = (\S+), \|gradient\| = (\S+)\n", run(build / "own", scene, *QUICK, cwd=work, env=env).stdout)
    run(program, "optimize", scene, "--out", work / "run", *sets(*QUICK, "optimizer.max_iterations=0", "optimizer.start=guess"))
    with open(work / "run" / "history.csv") as file:
        row = next(csv.DictReader(file))
    # The same steps with the same numbers, summed in the same order.
    assert float(found[1]) == pytest.approx(float(row["objective"]), rel=1e-12, abs=0)
    assert float(found[2]) > 0
