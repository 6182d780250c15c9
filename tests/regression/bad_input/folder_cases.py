# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad folders: earlier runs that lack what is needed, folders that cannot take results."""

from collections.abc import Callable
from pathlib import Path

from case import Case, edited, Expected, occupy, square_points, stored_run, write


def desired_run_cases() -> list[Case]:
    """Desired states that no earlier run left as they are needed."""
    by_run = (('desired = { control = ["0", "-1"] }', 'desired = { run = "earlier" }'),)
    other = [(x, 2 * y, z) for x, y, z in square_points()]

    def wrong(name: str, *expect: Expected, ranks: int = 1, **change: object) -> Case:
        return Case(name, ("objective.desired.run: ", *expect), edits=by_run, verb="optimize", earlier=True, ranks=ranks,
                    prepare=lambda folder: stored_run(folder / "earlier", **change))  # type: ignore[arg-type]

    stored = ("earlier/state.h5", "; ")
    return [
        Case("desired run that is missing", ("objective.desired.run: ", *stored, "no such file"), edits=by_run,
             verb="optimize", earlier=True),
        Case("desired run that is missing, check, two ranks", ("objective.desired.run: ", "no such file"), edits=by_run,
             verb="check", ranks=2),
        edited("desired run that is a number", 'control = ["0", "-1"]', "run = 3", "objective.desired.run: found 3", "a text",
               at="desired ="),
        edited("desired run and control", 'control = ["0", "-1"]', 'control = ["0", "-1"], run = "earlier"',
               "objective.desired: found control, run", "give one of", at="desired ="),
        Case("desired run that is text", ("objective.desired.run: ", *stored, "damaged"), edits=by_run, verb="optimize",
             prepare=lambda folder: write(folder / "earlier" / "state.h5", "fields") if not (folder / "earlier").mkdir() else None),
        wrong("desired run cut short", *stored, "damaged", cut=2000),
        wrong("desired run cut short, two ranks", *stored, "damaged", cut=2000, ranks=2),
        wrong("desired run without displacement", *stored, 'no field "displacement"', "output.fields", field="velocity"),
        wrong("desired run that ends early", *stored, "from 0 to 0.0001 s", "0.00015 s", times=(0.0, 1e-4)),
        wrong("desired run that starts late", *stored, "from 5e-05 to 0.00015 s", times=(5e-5, 1.5e-4)),
        wrong("desired run of another mesh", *stored, "no point at (", points=other),
        wrong("desired run of another mesh, three ranks", *stored, "no point at (", points=other, ranks=3),
        wrong("desired run of a larger mesh", *stored, "12 nodes in 2 dimensions", "9 nodes in 2",
              points=[*square_points(), (2.0, 0.0, 0.0), (2.0, 1.0, 0.0), (2.0, 0.5, 0.0)]),
        wrong("desired run in space", *stored, "9 nodes in 3 dimensions", "9 nodes in 2", dim=3),
        wrong("desired run with two nodes in one place", *stored, "two points at (-0.5, 0)",
              points=[square_points()[0], *square_points()[:-1]]),
        wrong("desired run with a value that is no number", *stored, '"displacement" at 0.00015 s is damaged', value=float("nan")),
        wrong("desired run with a value that is no number, two ranks", "is damaged", value=float("inf"), ranks=2),
        *(wrong(f"desired run that lists its times {how}", *stored, "damaged", listed=listed)
          for how, listed in (("backwards", (1.5e-4, 0.0)), ("with one missing", (0.0,)), ("as no numbers", (0.0, float("nan"))))),
        Case("desired run of degree 2", ("objective.desired.run: ", "mesh.degree = 2", "set it to 1"),
             edits=(*by_run, ("[time]", "degree = 2\n\n[time]")), verb="optimize"),
        Case("desired run in the folder of results", ("--out: ", "objective.desired.run", "choose another folder"), edits=(
            ('desired = { control = ["0", "-1"] }', 'desired = { run = "results" }'),), verb="optimize", earlier=True),
    ]


def first_guess_cases() -> list[Case]:
    """First guesses that no earlier run left."""
    by_run = (("scale = 1e6", 'scale = 1e6\ninitial = { run = "earlier" }'),)

    def left(*files: str) -> Callable[[Path], None]:
        def make(folder: Path) -> None:
            (folder / "earlier").mkdir()
            for file in files:
                write(folder / "earlier" / file, "nothing of ours")

        return make

    neither = ("control.initial.run: ", "earlier has no control.h5 that its run wrote, and there is no checkpoint.h5")
    return [
        Case("first guess of a run that is missing", neither, edits=by_run, earlier=True),
        Case("first guess of a run that is missing, two ranks", neither, edits=by_run, ranks=2),
        Case("first guess of a run without control", neither, edits=by_run, verb="optimize", prepare=left("scene.toml", "run.json")),
        Case("first guess of a damaged checkpoint", ("control.initial.run: ", "earlier/checkpoint.h5", "damaged"), edits=by_run,
             prepare=left("checkpoint.h5")),
        Case("first guess of a damaged checkpoint, two ranks", ("control.initial.run: ", "earlier/checkpoint.h5", "damaged"),
             edits=by_run, prepare=left("checkpoint.h5"), ranks=2),
        Case("first guess of a run with no scene", ("control.initial.run: ", "scene.toml: found no time.step"), edits=by_run,
             prepare=left("control.h5", "scene.toml")),
        edited("first guess of a run that is a number", "scale = 1e6", "scale = 1e6\ninitial = { run = 3 }",
               "control.initial.run: found 3", "a text", at="initial ="),
        edited("first guess by an unknown key", "scale = 1e6", 'scale = 1e6\ninitial = { runn = "earlier" }',
               "control.initial.runn: unknown",
               'mean "run"?', at="initial ="),
        edited("first guess in the folder of results", "scale = 1e6", 'scale = 1e6\ninitial = { run = "results" }', "--out: ",
               "control.initial.run",
               "choose another", at="", earlier=True),
    ]


def folder_cases() -> list[Case]:
    """Folders that cannot take results."""
    return [
        Case("file in place of the folder", ("--out: results cannot be written", "choose another folder"), prepare=lambda folder: write(
            folder / "results", "a file")),
        Case("file in place of the folder, two ranks", ("--out: results cannot be written", "choose another folder"), ranks=2,
             prepare=lambda folder: write(folder / "results", "a file")),
        Case("file in place of the parent", ("--out: scene.toml/results cannot be written",), out="scene.toml/results"),
        Case("mesh as the folder", ("--out: square.msh cannot be written",), out="square.msh", verb="optimize"),
        Case("folder in /proc", ("--out: /proc/signorini cannot be written",), out="/proc/signorini"),
        Case("folder that is read only", ("--out: /proc/self/task cannot be written",), out="/proc/self/task"),
        Case("device as the folder", ("--out: /dev/full cannot be written",), out="/dev/full"),
        Case("link to nowhere", ("--out: results cannot be written",), prepare=lambda folder: (
            folder / "results").symlink_to("nowhere/else")),
        Case("folder in place of state.h5", ("--out: results/state.h5 is a folder", "choose another folder"), earlier=True,
             prepare=lambda folder: occupy(folder / "results" / "state.h5")),
        Case("folder in place of run.json", ("--out: results/run.json is a folder", "choose another folder"), earlier=True,
             prepare=lambda folder: occupy(folder / "results" / "run.json")),
        Case("full disk, small files", ("results/", "cannot be written", "File too large"), largest_file=1500,
             earlier=True),
        Case("full disk, fields", ("results/state.", "cannot be written", "File too large"), largest_file=6000,
             earlier=True),
        Case("full disk, fields, first run", ("results/state.", "cannot be written", "File too large"),
             largest_file=6000),
        Case("full disk, control", ("results/", "cannot be written", "File too large"), largest_file=1500,
             options=("--set", "optimizer.checkpoint=0", "--set", 'output.tables=["steps"]'),
             verb="optimize", earlier=True),
    ]
