# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/definitions.md is what the program does: each statement that a number can tell is told by one.

    definitions.py SIGNORINI SOURCE
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from harness import SOURCE, signorini, stored, table  # noqa: E402
from studies import study  # noqa: E402

SQUARE = f"""
[mesh]
file = "{SOURCE}/meshes/block.geo"
size = 0.1
[time]
end = 0.5
step = 0.1
[material]
density = 1.0
young = 1e3
poisson = 0.3
[[output.probe]]
name = "body"
body = true
"""
CONTACT = """
[contact]
on = "bottom"
obstacle = { shape = "half-space", point = [0, -0.1], normal = [0, 1] }
[initial]
velocity = ["0", "-1"]
"""
TAU = 0.1
failures = 0


def check(statement: str, found: object, expected: object) -> None:
    global failures
    if np.shape(found) != np.shape(expected) or not np.allclose(found, expected, rtol=1e-9, atol=1e-12):
        failures += 1
        print(f"FAIL  {statement}: found {found}, expected {expected}", flush=True)
    else:
        print(f"ok    {statement}", flush=True)


class Runs:
    def __init__(self, folder: Path):
        self.folder, self.number = folder, 0

    def __call__(self, text: str, verb: str = "simulate", **overrides: object) -> Path:
        self.number += 1
        scene = self.folder / f"{self.number}.toml"
        scene.write_text(SQUARE + text)
        out = self.folder / str(self.number)
        signorini(verb, scene, out, **overrides)
        return out


def manifest(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())


def acts_in_time(run: Runs, folder: Path) -> None:
    """Time series and moving clamps."""
    (folder / "series.csv").write_text("time,push\n0,0\n0.15,3\n0.5,-1\n")
    series = run(f'[load]\nbody = ["0", {{ file = "{folder}/series.csv", column = "push" }}]\n')
    fine = np.linspace(0, 0.5, 1001)  # so that trapezoids are exact: 0.15 is among them
    push = np.interp(fine, [0, 0.15, 0.5], [0, 3, -1])
    impulse = np.concatenate([[0], np.cumsum((push[1:] + push[:-1]) / 2 * np.diff(fine))])[::200]
    check("a time series is linear between its times, and gives its exact impulse", table(series / "probes.csv")["body.momentum_y"], impulse)
    moved = run('[[clamp]]\non = "left"\nvalue = ["0.01*t^2", "0"]\n[[output.probe]]\nname = "left"\non = "left"\n')
    t, probes = TAU * np.arange(6), table(moved / "probes.csv")
    check("a clamp has its value at the end of a step", probes["left.displacement_x"], 0.01 * t**2)
    check("and its derivative", probes["left.velocity_x"], 0.02 * t)


def active_and_weak(run: Runs) -> None:
    stands = CONTACT.split("[initial]")[0].replace("-0.1", "0")
    for load, weak in (("0", 11), ("-1", 0)):
        steps = table(run(stands + f'[load]\nbody = ["0", "{load}"]\n', time__scheme="contact-stabilized") / "steps.csv")
        what = "without a force" if weak else "under its weight"
        check(f"of a body that stands {what} all candidates are active, {weak} of them weak",
              [steps["active"][1:].tolist(), steps["weak"][1:].tolist()], [[11] * 5, [weak] * 5])  # fmt: skip


def gradient_norms(run: Runs) -> None:
    """By the adjoint state that is stored, in L2(0,T; L2); with bounds, by the lumped mass matrix, that which does not point out of them."""
    alpha, scale = 0.3, 2.0
    text = f'[control]\nscale = {scale}\ninitial = INITIAL\nBOUNDS[objective]\ndesired = {{ displacement = ["(sin(3*y) - 0.5)*t", "-x*t"] }}\n' \
           f"alpha = {alpha}\n[optimizer]\nmax_iterations = 0\n"  # fmt: skip
    for initial, bounds in (((0.1, -0.2), ""), ((0, 0), "lower = 0\nupper = 1e3\n")):
        out = run(text.replace("BOUNDS", bounds).replace("INITIAL", str([str(part) for part in initial])), "optimize", time__end=0.4)
        points, cells, p = stored(out, "adjoint", "adjoint")
        g = alpha * np.array(initial) + TAU * scale / 2 * p[..., :2]
        sides = points[cells[:, 1:], :2] - points[cells[:, :1], :2]
        area = abs(np.linalg.det(sides)) / 2
        mass = np.zeros((len(points), len(points)))
        for i in range(3):
            for j in range(3):
                np.add.at(mass, (cells[:, i], cells[:, j]), area / 12 * (1 + (i == j)))
        if bounds:  # the control is at the lower ones
            assert (g > 0).any() and (g < 0).any(), "all gradients point the same way"
            lumped = mass.sum(axis=1)
            g, mass = np.minimum(np.einsum("ij,kjc->kic", mass / lumped[:, None], g), 0), np.diag(lumped)
        norm = np.sqrt(TAU * np.einsum("kic,ij,kjc->", g, mass, g))
        check(f"gradient_norm {'with' if bounds else 'without'} bounds", table(out / "history.csv")["gradient_norm"][0], norm)


def studies(run: Runs) -> None:
    """Against statements that are wrong by a known part, and against the finest rung."""
    def rows(name: str, text: str, *options: str) -> dict[str, np.ndarray]:
        scene = run.folder / f"study-{name}.toml"
        scene.write_text(SQUARE + text)
        study(scene, run.folder / f"study-{name}", "--sizes", "0.25", *options)
        return table(run.folder / f"study-{name}" / "study.csv")

    flight = rows("flight", CONTACT.replace("-0.1", "-9") + '[exact]\ndisplacement = ["0", "-1.25*t"]\n', "--steps", "0.1", "--quantity", "displacement")
    check("the error of a field is relative to its norm", flight["displacement_error"], [0.2])
    hit = rows("hit", CONTACT.replace("-0.1", "-0.12") + "[exact]\nimpulse = 2\n", "--steps", "0.05,0.0125", "--quantity", "impulse,energy_loss")
    assert np.min(hit["impulse"]) > 0 and np.ptp(hit["energy_loss"]) > 1e-3, hit
    check("that of a number to its value", hit["impulse_error"], abs(hit["impulse"] / 2 - 1))
    check("that of energy_loss is a plain difference", hit["energy_loss_error"], hit["energy_loss"])  # exact: none


def intervals_of_contact(out: Path, length: float) -> list[list[float]]:
    """Begin and end of each interval of contact within the steps, by gaps continued linearly, from contact.csv."""
    contact = table(out / "contact.csv")
    times = np.unique(contact["time"])
    gaps, forces = (contact[name].reshape(len(times), -1) for name in ("gap", "force"))
    touching, found = (forces > 0).any(axis=1), []

    def crossing(near: np.ndarray, far: np.ndarray) -> float:
        """In steps, from the nearer gap; in the middle of the step where the two do not fall towards the contact."""
        falls = far > near
        return np.min(np.where(falls, np.clip(near / np.where(falls, far - near, 1), 0, 1), 0.5))

    for k in range(2, len(times)):
        if touching[k] and not touching[k - 1]:
            found.append([times[k - 1] + length * crossing(*(gaps[k - i][forces[k] > 0] for i in (1, 2))), times[k]])
        elif touching[k]:
            found[-1][1] = times[k]
        elif touching[k - 1] and k + 1 < len(times):
            found[-1][1] = times[k] - length * crossing(*(gaps[k + i][forces[k - 1] > 0] for i in (0, 1)))
    assert found and not touching[-2:].any()
    return found


def fits(run: Runs) -> None:
    """The statements on fits and on contact times within a step."""
    length = 0.011  # the block, 0.1 m above and with 1 m/s, touches within a step
    motion = {"time__step": length, "time__end": 25 * length, "mesh__size": 0.5, "material__poisson": 0.0}
    ends = length * np.arange(1, 25)
    (run.folder / "force.csv").write_text("time,value\n" + "".join(f"{t!r},{10.0 * k}\n" for k, t in enumerate(np.sort([*ends, *(ends - length / 2)]).tolist())))
    unknown = '[[unknown]]\nof = "young"\nstart = 1.1e3\nscale = "SCALE"\n'
    force = f'[[measurement]]\nof = "force"\ncomponent = "y"\nfile = "{run.folder / "force.csv"}"\ndeviation = DEVIATION\n'
    touch = '[[measurement]]\nof = "contact-start"\nvalue = 0.1\ndeviation = 1e-3\n[[measurement]]\nof = "contact-time"\nvalue = 0.06\n'
    outs = {}
    for scheme in ("contact-implicit", "contact-stabilized"):
        for scale, deviation in (("log", "2.0"), ("log", "4.0"), ("linear", "2.0")):
            text = CONTACT + unknown.replace("SCALE", scale) + force.replace("DEVIATION", deviation) + touch
            outs[scheme, scale, deviation] = run(text, "optimize", optimizer__max_iterations=0, time__scheme=scheme, **motion)
        out = outs[scheme, "log", "2.0"]
        data, F = table(out / "measurements.csv"), table(out / "obstacles.csv")["force_y"]
        assert F.max() > 10, "the body did not hit"
        at_ends, in_the_middle = data["simulated"][1::2], data["simulated"][::2]
        means = (F[1:-1] + F[2:]) / 2
        if scheme == "contact-stabilized":
            check("a measured force is F_k in the middle of step k", in_the_middle, F[1:-1])
            check("and linear between", at_ends, means)
        else:
            check("of contact-implicit steps it is the mean of F_k and F_{k+1} at t_k", at_ends, means)
            check("and linear between, too", in_the_middle[1:], (means[1:] + means[:-1]) / 2)
        residual = data["residual"]
        check("a residual is in standard deviations", residual, (data["simulated"] - data["value"]) / 2)
        misfits = [manifest(outs[scheme, "log", deviation])["fit"]["misfit"] for deviation in ("2.0", "4.0")]
        check("misfit is their root mean square, smaller where deviations are larger", misfits, np.sqrt(np.mean(residual**2)) * np.array([1, 0.5]))
        found = [[table(outs[scheme, *which] / "parameters.csv")[name][0] for name in ("standard_deviation", "gradient")]
                 for which in (("log", "2.0"), ("linear", "2.0"))]  # fmt: skip
        assert found[0][0] > 0
        check("deviations are told in the unknown's unit on a logarithmic scale too, and gradients", np.divide(*found), [1, 1])
        times = {one["name"]: one for one in manifest(out)["fit"]["contact_times"]}
        start, lasting = (one["simulated"] for one in times.values())
        intervals = intervals_of_contact(out, length)
        check("measured contact times are told within a step, by gaps continued linearly", [start, lasting],
              [intervals[0][0], sum(end - begin for begin, end in intervals)])  # fmt: skip
        check("a free fall touches when it does", start, 0.1)
        impact, steps = manifest(out)["impact"]["all"], np.flatnonzero(F > 0)
        check("in impact contact begins at the begin of the first step with a force and ends at the end of the last one",
              [impact["start"], impact["end"]], [(steps[0] - 1) * length, steps[-1] * length])  # fmt: skip


def main() -> int:
    with tempfile.TemporaryDirectory() as scratch:
        run = Runs(Path(scratch))
        sums = (TAU * np.arange(6)) ** 3 / 3
        momentum = lambda out: table(out / "probes.csv")["body.momentum_y"]  # noqa: E731
        check("a load gives its exact impulse in a step", momentum(run('[load]\nbody = ["0", "t^2"]')), sums)
        check("gravity too", momentum(run('[load]\ngravity = ["0", "t^2"]')), sums)
        tracked = '[objective]\ndesired = { displacement = ["0", "t"] }\n[optimizer]\nmax_iterations = 0\n'
        control = '[control]\nscale = 1.0\ninitial = ["0", "t^2"]\n'
        check("a control too", momentum(run(control)), sums)
        wide = run(control + "step = 0.25\n")  # two intervals, which meet in the middle of the third step
        means = np.diff([0, 0.25**3, 0.5**3]) / 3 / 0.25
        check("with intervals of its own it is the mean over each, a step's the mean of what it overlaps",
              momentum(wide), TAU * np.cumsum([0, means[0], means[0], means.mean(), means[1], means[1]]))  # fmt: skip
        desired = run('[control]\nscale = 1.0\n' + tracked, "optimize")
        check("a desired displacement at its end", table(desired / "steps.csv")["tracking_error"], TAU * np.arange(6))
        zero = run('[load]\ntraction = [ { on = "bottom", value = ["0", "sin(10*pi*x)^2"] } ]')  # 0 at the nodes, every 0.1 m
        check("expressions are interpolated at the nodes", momentum(zero), np.zeros(6))

        at_vertices, with_middles = run(CONTACT), run(CONTACT, mesh__degree=2)
        check("candidates at degree 2 include the middles of edges",
              [manifest(out)["candidates"] for out in (at_vertices, with_middles)], [11, 21])  # fmt: skip
        held = run(CONTACT.replace("[initial]", '[[clamp]]\non = "left"\n[initial]').replace('"-1"', '"-x"'))
        check("a clamped node is no candidate", manifest(held)["candidates"], 10)
        sliding = run(CONTACT.replace("[initial]", '[[clamp]]\non = "left"\ncomponents = ["x"]\n[initial]'))
        check("one that a clamp holds in other directions alone is", manifest(sliding)["candidates"], 11)

        hit = run(CONTACT, time__step=5e-3)
        steps, obstacles, contact = (table(hit / f"{name}.csv") for name in ("steps", "obstacles", "contact"))
        assert steps["contact_force_y"].max() > 1, "the body did not hit"
        check("the force is that on the body", bool((steps["contact_force_y"] >= 0).all() and (contact["normal_y"] == 1).all()), True)
        impulse = 5e-3 * obstacles["force_y"].sum()
        moved = table(hit / "probes.csv")["body.momentum_y"]
        check("the sum of step times force is the impulse", impulse, moved[-1] - moved[0])
        energy = steps["kinetic_energy"] + steps["elastic_energy"]
        works = steps["external_work"] + steps["contact_work"] - steps["viscous_dissipation"]
        check("the energy law of a step", np.diff(energy) - works[1:], np.zeros(100))
        check("contact never does work", bool((steps["contact_work"] <= 1e-12).all()), True)

        pulled = run('[[clamp]]\non = "left"\nvalue = ["0.01*t^2", "0"]\n')
        steps = table(pulled / "steps.csv")
        energy = steps["kinetic_energy"] + steps["elastic_energy"]
        assert energy[-1] > 0
        check("external work includes the clamps'", steps["external_work"].sum(), energy[-1] - energy[0])
        check("load_work does not", steps["load_work"], np.zeros(6))

        found = run(CONTACT + '[control]\nscale = 1.0\nlower = -2.0\nupper = 2.0\n[objective]\ndesired = { control = ["0", "-2"] }\n'
                    'alpha = 1e-2\ngamma = 1e-2\n[optimizer]\nmax_iterations = 5\n', "optimize", time__step=5e-3)  # fmt: skip
        error = table(found / "steps.csv")["tracking_error"] ** 2
        J = manifest(found)["objective"]
        check("steps.csv after optimize belongs to the last iterate", 5e-3 / 4 * (error[1:] + error[:-1]).sum(), J["tracking"])
        check("the end state counts without a half", 1e-2 * error[-1], J["terminal"])
        history, search = table(found / "history.csv"), manifest(found)["optimizer"]
        assert history["forward_sweeps"][-1] > history["adjoint_sweeps"][-1] > 5
        check("sweeps in run.json are those of the search", [search["iterations"], search["forward_sweeps"], search["adjoint_sweeps"]],
              [history[name][-1] for name in ("iteration", "forward_sweeps", "adjoint_sweeps")])  # fmt: skip
        check("the last row of history.csv too", table(found / "history.csv")["objective"][-1], J["value"])

        acts_in_time(run, Path(scratch))
        active_and_weak(run)
        gradient_norms(run)
        studies(run)

        nodal = run(control + tracked, "optimize", control__space="nodal", mesh__degree=2)
        cells = run(control + tracked, "optimize", control__space="cellwise", mesh__degree=2)
        points, _, _ = stored(nodal, "control", "control")
        check("a control has values at the nodes, or one in each cell",
              [stored(out, "control", "control")[2].shape[1] for out in (nodal, cells)], [len(points), manifest(cells)["cells"]])  # fmt: skip
        fits(run)
    print(f"{run.number} runs, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    raise SystemExit(main())
