# SPDX-License-Identifier: GPL-3.0-or-later
"""objective.desired.run: the desired states of an earlier run's folder, on any number of ranks and between stored times."""

import json
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import HALF_DISC, SOURCE, signorini, table  # noqa: E402

import numpy as np  # noqa: E402

BLOCK = SOURCE / "tests/data/block.toml"


def scene(folder: Path, source: Path, name: str, desired: str) -> Path:
    """A copy of a scene in `folder` with another desired state, its mesh where it was."""
    text = source.read_text()
    mesh = tomllib.loads(text)["mesh"]["file"]
    text = text.replace(f'"{mesh}"', f'"{(source.parent / mesh).resolve()}"')
    lines = [f"desired = {desired}" if line.startswith("desired") else line for line in text.splitlines()]
    copy = folder / f"{name}.toml"
    copy.write_text("\n".join(lines))
    return copy


def history(verb_scene: Path, out: Path, ranks: int = 1, **overrides: object) -> dict[str, np.ndarray]:
    signorini("optimize", verb_scene, out, ranks, optimizer__max_iterations=2, output__fields=[], **overrides)
    return table(out / "history.csv")


def same(found: dict[str, np.ndarray], expected: dict[str, np.ndarray], rounding: float) -> None:
    for name in ("objective", "tracking", "terminal", "gradient_norm"):
        assert (expected[name] > 0).all()
        error = np.abs(found[name] / expected[name] - 1).max()
        assert error < rounding, f"{name}: {error:.1e}"


def run_is_its_control(folder: Path) -> None:
    """The state of the reference control, simulated before, is that which optimize computes itself."""
    by_control = scene(folder, HALF_DISC, "by-control", '{ control = ["0", "-1"] }')
    by_run = scene(folder, HALF_DISC, "by-run", '{ run = "earlier" }')  # relative to the scene
    size = {"mesh__size": 2}
    expected = history(by_control, folder / "c", **size)
    assert (table(folder / "c" / "steps.csv")["active"] > 0).any()
    for earlier, ranks in ((1, 1), (1, 3), (3, 1), (2, 2)):
        signorini("simulate", by_run, folder / "earlier", earlier, control__initial=["0", "-1"],
                  output__tables=[], output__fields=["displacement"], **size)  # fmt: skip
        found = history(by_run, folder / "r", ranks, **size)
        # Another partition rounds otherwise, and the line search passes that on.
        same(found, expected, 1e-13 if earlier == ranks == 1 else 1e-9)
    assert np.isnan(found["relative_distance_to_reference"]).all(), "there is no reference control"
    echo = tomllib.loads((folder / "r" / "scene.toml").read_text())
    assert echo["objective"]["desired"] == {"run": str((folder / "earlier").resolve())}
    again = history(folder / "r" / "scene.toml", folder / "again", 2)
    same(again, found, 1e-9)
    signorini("check", by_run, check__control=["0.1", "-0.8"], **size)
    print("desired by the run of a control = by that control, on 1 to 3 ranks each")


def zero_is_no_scale(folder: Path) -> None:
    """Distances relative to a reference control of zero are undefined: nan, neither infinite nor -nan, which 0/0 is."""
    for start in (["0", "0"], ["0", "-1"]):
        found = history(BLOCK, folder / "zero", objective__desired={"control": ["0", "0"]}, control__initial=start)
        assert np.isnan(found["relative_distance_to_reference"]).all(), found["relative_distance_to_reference"]
        assert "-nan" not in (folder / "zero" / "history.csv").read_text()
    assert found["objective"][-1] < found["objective"][0], "the search moves"


def between_stored_times(folder: Path) -> None:
    """A motion that is linear in time is met between its stored times too."""
    free = {"load__body": ["0", "0"], "contact__obstacle__point": [0, -10]}  # flies on: y = (0, -t)
    by_run = scene(folder, BLOCK, "flight", '{ run = "flown" }')
    signorini("simulate", by_run, folder / "flown", output__every=7, **free)
    by_displacement = scene(folder, BLOCK, "given", '{ displacement = ["0", "-t"] }')
    rounding = 1e-9  # of two sums, which the line search passes on

    def warned(out: str) -> list[float]:
        found = json.loads((folder / out / "run.json").read_text())["warnings"]
        return [one["value"] for one in found if one["name"] == "desired motion between stored times"]

    start = {"control__initial": ["0.3", "-0.5"]}
    expected = history(by_displacement, folder / "d", **free, **start)
    found = history(by_run, folder / "f", **free, **start)
    same(found, expected, rounding)
    assert np.allclose(warned("f"), [7], rtol=1e-9, atol=0) and not warned("d"), warned("f")
    for verb, ranks in (("simulate", 1), ("simulate", 2)):
        done = signorini(verb, by_run, folder / "once", ranks, **free, **start)
        assert len(warned("once")) == 1 and done.stdout.count("are up to 0.14 s apart") == 1, done.stdout
    signorini("simulate", by_run, folder / "flown-whole", output__every=1, **free)
    signorini("simulate", by_run, folder / "once", **free, **start, objective__desired={"run": str(folder / "flown-whole")})
    assert not warned("once")
    for storage in ("disk", "checkpoints"):  # desired states one by one, forwards and backwards
        for desired, usual in ((by_run, found), (by_displacement, expected)):
            one_by_one = history(desired, folder / "f", trajectory__storage=storage, **free, **start)
            assert all(np.array_equal(one_by_one[name], usual[name]) for name in ("objective", "gradient_norm")), storage
            calls = json.loads((folder / "f" / "run.json").read_text())["timings"]["desired state"]["calls"]
            sweeps = one_by_one["forward_sweeps"][-1] + one_by_one["adjoint_sweeps"][-1] - 2  # the Hessian product at the start asks for none
            assert calls > 30 * sweeps > 0, (calls, sweeps)
    half = history(by_run, folder / "f", time__end=0.3, time__step=0.01, **free, **start)  # other steps, ends earlier
    same(half, history(by_displacement, folder / "d", time__end=0.3, time__step=0.01, **free, **start), rounding)
    phases = json.loads((folder / "f" / "run.json").read_text())["timings"]
    assert phases["desired state"]["calls"] == 1
    print("stored times in between: linear in time, exact for a linear motion")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run_is_its_control(folder)
        between_stored_times(folder)
        zero_is_no_scale(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
