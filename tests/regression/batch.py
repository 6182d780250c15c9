# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch: its motions are those of single runs, and to the last bit the same in any company, order, shard and on any number of ranks."""

import csv
import json
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from harness import SIGNORINI, SOURCE, captured, signorini, table

DISC = SOURCE / "scenes" / "disc-drop.toml"
HALF_BALL = SOURCE / "scenes" / "half-ball.toml"
FALL = ["mesh.size=4", "time.step=0.02", "time.end=2", "time.scheme=contact-stabilized"]  # without chatter, in which rounding grows
KEYS = ["contact.obstacle.point", "initial.velocity", "load.body"]
DROPS = [
    ["[0, -20.1]", "[0, -0.5]", "['0', '-0.1']"],
    ["[0, -20.2]", "[0, -0.6]", "['0', '-0.1']"],
    ["[0, -20.05]", "[0, -0.4]", "['0.01', '-0.1']"],
    ["[0, -20.3]", "[0, -1]", ""],
    ["[0, -20.15]", "[0, -0.7]", "['0.02*t', '-0.1']"],
]  # fmt: skip


def write(file: Path, keys: list[str], rows: list[list[str]], names: list[str] | None = None) -> Path:
    with file.open("w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow([*(["name"] if names else []), *keys])
        writer.writerows([*([names[i]] if names else []), *row] for i, row in enumerate(rows))
    return file


def batch(scene: Path, cases: Path, out: Path, *options: str, ranks: int = 1, status: int = 0) -> list[dict[str, str]]:
    """Runs a batch and returns the rows of its table."""
    done = attempt(scene, cases, out, *options, ranks=ranks)
    assert done.returncode == status, done.stdout + done.stderr
    with next(out.glob("**/cases.csv")).open(newline="") as file:
        return list(csv.DictReader(file))


def attempt(scene: Path, cases: Path, out: Path, *options: str, ranks: int = 1) -> subprocess.CompletedProcess:
    mpirun = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    return captured([*mpirun, str(SIGNORINI), "batch", str(scene), "--cases", str(cases), "--out", str(out), *options])


def changes(*texts: str) -> list[str]:
    return [word for text in texts for word in ("--set", text)]


def impulse_alone(scene: Path, keys: list[str], row: list[str], out: Path, *more: str) -> float:
    """Impulse of contact in a single run, N s."""
    sets = changes(*more, *(f"{key}={value}" for key, value in zip(keys, row) if value))
    done = captured([str(SIGNORINI), "simulate", str(scene), "--out", str(out), *sets])
    assert done.returncode == 0, done.stderr
    steps = table(out / "steps.csv")
    forces = np.array([steps[name] for name in steps if name.startswith("contact_force_")])
    return float(np.linalg.norm((forces[:, 1:] * np.diff(steps["time"])).sum(axis=1)))


EFFECTS = {
    "contact-stabilized": [],
    "friction": ["contact.friction=0.3"],
    "massless": ["contact.mass=massless", "time.scheme=contact-implicit"],
    "obstacle with mass": ["contact.obstacle.mass=1e4"],
    "viscosity": ["material.viscosity={ bulk = 1.0, shear = 1.0 }"],
    "relaxation": ["material.prony=[{ time = 0.5, g = 0.3, k = 0.3 }]"],
    "clamp": ['clamp=[{ on = "contact", components = ["x"] }]'],
}  # fmt: skip


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_motions_are_those_of_single_runs(effect: list[str], tmp_path: Path) -> None:
    rows = batch(DISC, write(tmp_path / "cases.csv", KEYS, DROPS), tmp_path / "batch", *changes(*FALL, *effect))
    assert [row["outcome"] for row in rows] == ["done"] * len(DROPS)
    for i, row in enumerate(rows):
        alone = impulse_alone(DISC, KEYS, DROPS[i], tmp_path / f"alone-{i}", *FALL, *effect)
        assert alone > 10, "hardly any contact: the case says nothing"
        assert float(row["impulse"]) == pytest.approx(alone, rel=1e-9), row["case"]


def test_company_does_not_matter(tmp_path: Path) -> None:
    """Any number of motions together, in another order, in shards, on ranks."""
    names = [f"drop {i}" for i in range(len(DROPS))]
    sets = changes(*FALL[:3])  # with the chatter of contact-implicit steps, in which any difference grows
    cases = write(tmp_path / "cases.csv", KEYS, DROPS, names)
    all_together = batch(DISC, cases, tmp_path / "all", *sets)
    assert json.loads((tmp_path / "all" / "batch.json").read_text())["blocks"] == [5]
    assert len({row["impulse"] for row in all_together}) == len(DROPS), "the cases do not differ"
    assert batch(DISC, cases, tmp_path / "alone", *sets, "--together", "1") == all_together
    assert batch(DISC, cases, tmp_path / "pairs", *sets, "--together", "2", "--threads", "2") == all_together
    assert batch(DISC, cases, tmp_path / "ranks", *sets, "--together", "2", ranks=2) == all_together
    backwards = write(tmp_path / "backwards.csv", KEYS, DROPS[::-1], names[::-1])
    assert batch(DISC, backwards, tmp_path / "backwards", *sets) == all_together[::-1]
    for i in (1, 2):
        batch(DISC, cases, tmp_path / "shards", *sets, "--shard", f"{i}/2")
    merged = attempt(DISC, cases, tmp_path / "shards", *sets, "--resume")
    assert merged.returncode == 0 and "5 of 5 cases have their outcome already" in merged.stdout
    with (tmp_path / "shards" / "cases.csv").open(newline="") as file:
        assert list(csv.DictReader(file)) == all_together


def test_space(tmp_path: Path) -> None:
    """A factor with blocks of three, and an objective."""
    keys, rows = ["contact.obstacle.point", "control.initial"], [["[0, 0, -15.1]", '["0", "0", "-1"]'], ["[0, 0, -15.2]", '["0", "0.1", "-2"]']]
    sets = changes("mesh.size=3", "time.step=2.5e-4")
    cases = write(tmp_path / "cases.csv", keys, rows)
    together = batch(HALF_BALL, cases, tmp_path / "together", *sets)
    assert all(row["outcome"] == "done" and float(row["impulse"]) > 0 and float(row["J"]) > 0 for row in together)
    assert batch(HALF_BALL, cases, tmp_path / "alone", *sets, "--together", "1") == together
    for i, row in enumerate(together):
        out = tmp_path / f"single-{i}"
        signorini("simulate", HALF_BALL, out, mesh__size=3, time__step=2.5e-4, contact__obstacle__point=json.loads(rows[i][0]),
                  control__initial=json.loads(rows[i][1]))  # fmt: skip
        run = json.loads((out / "run.json").read_text())
        assert float(row["J"]) == pytest.approx(run["objective"]["value"], rel=1e-9)


def test_scene_of_the_folder(tmp_path: Path) -> None:
    """It is the scene without the cases, in as many dimensions as the mesh has."""
    cases = write(tmp_path / "cases.csv", KEYS, DROPS[:1])
    batch(DISC, cases, tmp_path / "out", *changes(*FALL, 'clamp=[{ on = "contact", components = ["x"] }]'))
    again = attempt(tmp_path / "out" / "scene.toml", cases, tmp_path / "again")
    assert again.returncode == 0, again.stderr
    assert table_of(tmp_path / "again")[0]["impulse"] == table_of(tmp_path / "out")[0]["impulse"]


def test_other_bodies(tmp_path: Path) -> None:
    """Cases with other matrices, steps or meshes have factors of their own."""
    keys = ["material.young", "time.step", "mesh.size"]
    rows = [["50", "", ""], ["60", "", ""], ["50", "0.01", ""], ["", "", "5"], ["60", "", ""]]
    fast = ["contact.obstacle.point=[0, -20.1]", "initial.velocity=[0, -1]"]
    found = batch(DISC, write(tmp_path / "cases.csv", keys, rows), tmp_path / "batch", *changes(*FALL, *fast))
    assert sorted(json.loads((tmp_path / "batch" / "batch.json").read_text())["blocks"]) == [1, 1, 1, 2]
    for i, row in enumerate(found):
        alone = impulse_alone(DISC, keys, rows[i], tmp_path / f"alone-{i}", *FALL, *fast)
        assert alone > 10 and float(row["impulse"]) == pytest.approx(alone, rel=1e-9), row["case"]
    assert found[1]["impulse"] == found[4]["impulse"] != found[0]["impulse"]


def test_probes_and_chosen_quantities(tmp_path: Path) -> None:
    probe = 'output.probe=[{ name = "top", point = [0, 20] }]'
    cases = write(tmp_path / "cases.csv", KEYS, DROPS[:2])
    found = batch(DISC, cases, tmp_path / "batch", *changes(*FALL, probe), "--quantity", "energy_loss,peak_force")
    assert list(found[0])[:8] == ["case", *KEYS, "outcome", "reason", "warnings", "steps"]
    assert [name for name in list(found[0])[8:] if "top" not in name] == ["energy_loss", "peak_force"]
    impulse_alone(DISC, KEYS, DROPS[0], tmp_path / "alone", *FALL, probe)
    alone = table(tmp_path / "alone" / "probes.csv")["top.displacement_y"]
    for end, value in (("min", alone.min()), ("max", alone.max()), ("end", alone[-1])):
        assert float(found[0][f"top.displacement_y.{end}"]) == pytest.approx(value, rel=1e-9)
    quantities = json.loads((tmp_path / "batch" / "batch.json").read_text())["quantities"]
    assert quantities["peak_force"]["unit"] == "N/m" and quantities["top.displacement_y.max"]["unit"] is None


def test_failed_cases_are_rows(tmp_path: Path) -> None:
    keys = ["material.poisson", "contact.obstacle.point"]
    rows = [["0.25", "[0, -20.1]"], ["0.6", "[0, -20.1]"], ["0.25", "[0, -19]"], ["0.3", "[0, -20.1]"]]
    done = attempt(DISC, write(tmp_path / "cases.csv", keys, rows), tmp_path / "out", *changes(*FALL))
    assert done.returncode == 0 and "4 of 4 cases have ended, 2 of them failed" in done.stdout and "failed, 1 of 4 cases, first case 2: " in done.stdout
    found = table_of(tmp_path / "out")
    assert [row["outcome"] for row in found] == ["done", "failed", "failed", "done"]
    assert "material.poisson" in found[1]["reason"] and "0.6" in found[1]["reason"] and found[1]["impulse"] == ""
    assert "inside" in found[2]["reason"]
    alone = attempt(DISC, write(tmp_path / "one.csv", keys, rows[2:3]), tmp_path / "one", *changes(*FALL))
    assert alone.returncode == 3 and table_of(tmp_path / "one")[0]["outcome"] == "failed"


def test_warnings(tmp_path: Path) -> None:
    """Those of a single run, counted at the end and kept by --resume."""
    cases = write(tmp_path / "cases.csv", ["initial.velocity"], [["[0, -0.3]"], ["[0, -5]"], ["[0, -0.2]"]])
    sets = changes(*FALL, "contact.obstacle.point=[0, -20.1]", "material.young=5000", "time.end=1")
    done = attempt(DISC, cases, tmp_path / "out", *sets)
    assert done.returncode == 0, done.stderr
    found = [row["warnings"].split("; ") for row in table_of(tmp_path / "out")]
    assert "large strain" in found[1] and "large strain" not in found[0] + found[2]
    assert "warning, 1 of 3 cases, first case 2: a principal strain is " in done.stdout
    listed = json.loads((tmp_path / "out" / "batch.json").read_text())["warnings"]
    assert [(one["case"], one["cases"]) for one in listed if one["name"] == "large strain"] == [("2", 1)]
    for i, velocity in enumerate(("[0, -0.3]", "[0, -5]")):
        alone = captured([str(SIGNORINI), "simulate", str(DISC), "--out", str(tmp_path / f"{i}"), *sets, *changes(f"initial.velocity={velocity}")])
        assert alone.returncode == 0, alone.stderr
        run = json.loads((tmp_path / f"{i}" / "run.json").read_text())
        assert sorted({one["name"] for one in run["warnings"]}) == [kind for kind in found[i] if kind]
    again = attempt(DISC, cases, tmp_path / "out", *sets, "--resume")
    assert again.returncode == 0 and [line for line in again.stdout.splitlines() if line.startswith("warning")] == \
        [line for line in done.stdout.splitlines() if line.startswith("warning")]  # fmt: skip
    assert json.loads((tmp_path / "out" / "batch.json").read_text())["warnings"] == listed


def test_restitution(tmp_path: Path) -> None:
    """That of a single run; empty where the body does not rebound."""
    cases = write(tmp_path / "cases.csv", ["initial.velocity"], [["[0, -4]"], ["[0, -6]"], ["[0, 1]"]])
    sets = changes(*FALL, "contact.obstacle.point=[0, -20.1]", "load.body=[\"0\", \"0\"]", "time.end=20")
    found = batch(DISC, cases, tmp_path / "out", *sets, "--quantity", "restitution,impulse")
    assert found[2]["restitution"] == "" and float(found[2]["impulse"]) == 0
    for row in found[:2]:
        alone = captured([str(SIGNORINI), "simulate", str(DISC), "--out", str(tmp_path / "alone"), *sets, *changes(f"initial.velocity={row['initial.velocity']}")])
        assert alone.returncode == 0, alone.stderr
        expected = json.loads((tmp_path / "alone" / "run.json").read_text())["impact"]["restitution"]
        assert 0.1 < expected < 1 and float(row["restitution"]) == pytest.approx(expected, rel=1e-9)
    study = captured([str(SIGNORINI), "study", str(DISC), *changes(*sets[1::2], "initial.velocity=[0, -6]"), "--sizes", "4", "--steps", "0.02",
                      "--quantity", "restitution", "--out", str(tmp_path / "study")])  # fmt: skip
    assert study.returncode == 0, study.stderr
    assert float(table(tmp_path / "study" / "study.csv")["restitution"][0]) == pytest.approx(float(found[1]["restitution"]), rel=1e-9)
    refused = captured([str(SIGNORINI), "simulate", str(DISC), *changes(*sets[1::2], "initial.velocity=[0, 1]"), "--accuracy", "0.1",
                        "--quantity", "restitution", "--out", str(tmp_path / "none")])  # fmt: skip
    assert refused.returncode == 2 and "has no coefficient of restitution: the body must leave what it hit before time.end" in refused.stderr


def table_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "cases.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_killed_and_resumed(tmp_path: Path) -> None:
    rows = [[f"[0, {-20 - 0.01 * i:.2f}]", f"[0, {-0.5 - 0.01 * i:.2f}]", ""] for i in range(40)]
    cases, sets = write(tmp_path / "cases.csv", KEYS, rows), changes(*FALL, "time.end=10")
    whole = batch(DISC, cases, tmp_path / "whole", *sets)
    command = [str(SIGNORINI), "batch", str(DISC), "--cases", str(cases), "--out", str(tmp_path / "out"), *sets, "--together", "4"]
    for sent, status in ((signal.SIGTERM, 130), (signal.SIGKILL, -signal.SIGKILL)):
        process = subprocess.Popen([*command, "--resume"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for line in process.stdout:
            if line.startswith("cases"):
                break
        process.send_signal(sent)
        process.communicate(timeout=60)
        assert process.returncode == status
        kept = len(table_of(tmp_path / "out"))
        assert 0 < kept < len(rows), "it was not killed in between"
    resumed = subprocess.run([*command, "--resume"], capture_output=True, text=True, check=True)
    assert f"{kept} of 40 cases have their outcome already" in resumed.stdout
    assert table_of(tmp_path / "out") == whole
    other = attempt(DISC, cases, tmp_path / "out", *sets, *changes("material.young=60"), "--resume")
    assert other.returncode == 2 and "another scene" in other.stderr
    assert table_of(tmp_path / "out") == whole


WRONG = {
    "no such file": (None, [], "nowhere.csv"),
    "no cases": ("material.young\n", [], "found no cases"),
    "unknown key": ("material.yuong\n50\n", [], "yuong"),
    "a key twice": ("material.young,material.young\n50,60\n", [], "twice"),
    "a column without name": ("material.young,\n50,60\n", [], "without a name"),
    "too few cells": ("material.young,mesh.size\n50\n", [], "line 2: found 1 cells below 2"),
    "numbers alone": ("50\n60\n", [], "found numbers"),
    "a name twice": ("name,material.young\na,50\na,60\n", [], "second case"),
    "an empty name": ("name,material.young\n,50\n", [], "without a name"),
    "binary": ("material.young\n5\0\n", [], "zero byte"),
    "unknown quantity": ("material.young\n50\n", ["--quantity", "impuls"], "did you mean"),
    "a field": ("material.young\n50\n", ["--quantity", "displacement"], "numbers of this scene"),
    "a wrong shard": ("material.young\n50\n", ["--shard", "3/2"], "expected i/n"),
    "end by the bounce": ("material.young\n50\n", ["--set", "time.end=auto"], "time.end"),
}  # fmt: skip


@pytest.mark.parametrize("text, options, words", WRONG.values(), ids=WRONG)
def test_wrong_tables(text: str | None, options: list[str], words: str, tmp_path: Path) -> None:
    cases = tmp_path / ("nowhere.csv" if text is None else "cases.csv")
    if text is not None:
        cases.write_text(text)
    done = attempt(DISC, cases, tmp_path / "out", *options)
    assert done.returncode == 2 and words in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert not (tmp_path / "out").exists()


def test_components_beyond_the_dimension(tmp_path: Path) -> None:
    """They are refused in each case, also in one that shares the mesh of a case before."""
    cases = write(tmp_path / "cases.csv", ["initial.velocity"], [["[0, -1]"], ["[0, -1, 5]"], ["[0, -2]"]])
    done = attempt(DISC, cases, tmp_path / "out", "--set", "time.end=1")
    assert done.returncode == 0, done.stderr  # as long as one case ends
    states = [row["outcome"] for row in csv.DictReader((tmp_path / "out" / "cases.csv").open())]
    assert states[0] == states[2] != states[1]
    assert "found 3 components" in (tmp_path / "out" / "cases.csv").read_text() + done.stdout + done.stderr


def test_folders(tmp_path: Path) -> None:
    """Each case has the results of a single run: fields to rounding, the same files and laws."""
    scene = SOURCE / "tests" / "data" / "block.toml"
    cases = write(tmp_path / "cases.csv", ["initial.velocity"], [["[0, -1.0]"], ["[0, -1.3]"], ["[0.1, -0.8]"], ["[0, -2.0]"]], names=["slow", "fast", "aside", "very fast"])
    options = changes("time.scheme=contact-stabilized", "output.every=5")
    rows = batch(scene, cases, tmp_path / "batch", "--folders", *options)
    for row in rows:
        own, alone = tmp_path / "batch" / row["case"], tmp_path / row["case"]
        done = captured([str(SIGNORINI), "simulate", str(scene), "--out", str(alone), *options, *changes(f"initial.velocity={row['initial.velocity']}")])
        assert done.returncode == 0, done.stderr
        assert {file.name for file in own.iterdir()} == {file.name for file in alone.iterdir()}
        found, expected = table(own / "steps.csv"), table(alone / "steps.csv")
        assert (found["active"] == expected["active"]).all() and found["active"].max() > 1
        for column in ("kinetic_energy", "elastic_energy"):
            assert np.allclose(found[column], expected[column], rtol=1e-9, atol=1e-12 * expected["kinetic_energy"].max())
        numbers = [json.loads((folder / "run.json").read_text()) for folder in (own, alone)]
        assert numbers[0]["impact"]["all"]["impulse"] == pytest.approx(numbers[1]["impact"]["all"]["impulse"], rel=1e-9)
        assert all(law["worst"] < 1e-10 for law in numbers[0]["invariants"].values())
    refused = attempt(scene, write(tmp_path / "odd.csv", ["initial.velocity"], [["[0, -1.0]"]], names=["a/b"]), tmp_path / "odd", "--folders", *options)
    assert refused.returncode == 2 and 'found the name "a/b"' in refused.stderr and not (tmp_path / "odd").exists()
    kept = attempt(scene, cases, tmp_path / "batch", "--resume", *options)
    assert kept.returncode == 2, "a table without folders is another one"
