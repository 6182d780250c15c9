# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the cases of the verification manual and writes its pages, docs/verification/*.md.

usage: python3 docs/verification.py [CASE…]        with the built `signorini` on PATH; half a minute for all of them

A case is a scene, a reference and tolerances. With names of cases only these are run; the table of all cases is made from their
pages. tests/regression/manual.py runs every case and compares it with its page.
"""

import json
import re
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
PAGES = HERE / "verification"
sys.path.insert(0, str(HERE.parent / "tests"))

from harness import signorini, stored, table  # noqa: E402
from standard_solid import Solid, at_ends, over_steps  # noqa: E402


@dataclass(frozen=True)
class Figure:
    """A number of a case beside its reference. The tolerance is relative, or absolute where the reference is 0."""

    name: str
    unit: str
    reference: float
    got: float
    tolerance: float

    @property
    def deviation(self) -> float:
        return self.got / self.reference - 1 if self.reference else self.got

    @property
    def holds(self) -> bool:
        return abs(self.deviation) <= self.tolerance

    def cells(self) -> list[str]:
        """The texts of a table: name with unit, reference, got, deviation, tolerance."""
        name = f"{self.name}, {self.unit}" if self.unit else self.name
        deviation = f"{100 * self.deviation:+.2g} %" if self.reference else f"{self.deviation:.2g}"
        tolerance = f"{100 * self.tolerance:g} %" if self.reference else f"{self.tolerance:g}"
        return [name, f"{self.reference:.5g}", f"{self.got:.5g}", deviation, tolerance]


@dataclass(frozen=True)
class Case:
    """A page of the manual. `figures` takes the folders of the runs, one for each of `runs`, which are overrides of the scene."""

    name: str
    title: str
    problem: str
    reference: str
    kind: str
    tolerance: str
    figures: Callable[..., list[Figure]]
    runs: tuple[dict[str, object], ...] = ({},)
    scene: str = ""  # relative to the pages; else of the case's name

    @property
    def file(self) -> str:
        return self.scene or f"{self.name}.toml"


def impact(out: Path) -> dict:
    return json.loads((out / "run.json").read_text())["impact"]["all"]


def mean_force(out: Path, start: float, end: float) -> float:
    """Mean contact force over the middle half of a contact."""
    steps = table(out / "steps.csv")
    inside = abs(steps["time"] - (start + end) / 2) < (end - start) / 4
    return steps["normal_force"][inside].mean()


def truss(out: Path) -> list[Figure]:
    length, area, young, density, speed, gap = 2, 0.2, 200e9, 7800, 1.5, 1e-3
    c, found = np.sqrt(young / density), impact(out)
    start, lasts = gap / speed, 2 * length / c
    force = density * c * speed * area
    return [
        Figure("touch", "ms", 1e3 * start, 1e3 * found["start"], 4e-3),
        Figure("contact lasts", "ms", 1e3 * lasts, 1e3 * found["duration"], 1e-2),
        Figure("force", "MN", force / 1e6, mean_force(out, start, start + lasts) / 1e6, 5e-3),
        Figure("impulse", "N s", force * lasts, found["impulse"][1], 1e-2),
    ]


def rod(out: Path) -> list[Figure]:
    length, radius, young, density, speed = 0.254, 0.0127, 200e9, 7850, 4.4287
    c, found = np.sqrt(young / density), impact(out)
    nodes, cells, stress = stored(out, "state", "stress")
    with h5py.File(out / "state.h5") as file:
        times = file["times"][:]
    lower = nodes[cells][:, :, 2].mean(axis=1) < length / 2
    full = stress[np.argmin(abs(times - length / c))].reshape(len(cells), 9)[lower, 8].mean()
    return [
        Figure("contact lasts", "ms", 2e3 * length / c, 1e3 * found["duration"], 1e-2),
        Figure("force", "kN", density * c * speed * np.pi * radius**2 / 1e3, mean_force(out, 0, 2 * length / c) / 1e3, 5e-3),
        Figure("stress of the rod at rest", "MPa", -density * c * speed / 1e6, full / 1e6, 5e-3),
    ]


def clamped_bar(out: Path) -> list[Figure]:
    steps = table(out / "steps.csv")
    t, width = steps["time"], 0.1
    phase = t % 3
    exact = np.select([phase < 1, phase < 2], [(1 - phase) / 2, 0], (phase - 2) / 2)
    error = np.linalg.norm(steps["min_gap"] - exact) / np.linalg.norm(exact)
    energy = steps["kinetic_energy"] + steps["elastic_energy"]
    return [
        Figure("force of the first contact", "N/m", width / 2, mean_force(out, 1, 2), 5e-3),
        Figure("impulse of four contacts", "N s/m", 4 * width / 2, impact(out)["impulse"][1], 2e-2),
        Figure("error of the gap over 12 s, in L2", "", 0, error, 2e-2),
        Figure("energy lost after four contacts", "", 0, 1 - energy[-1] / energy[0], 1e-2),
    ]


def roller(out: Path) -> list[Figure]:
    load, radius, modulus = 35e6, 0.05, 70e9 / (1 - 0.3**2)
    width = np.sqrt(4 * load * radius / (np.pi * modulus))
    contact = table(out / "contact.csv")
    last = contact["step"] == contact["step"][-1]
    x, force = contact["x"][last], contact["force"][last]
    # The second moment of Hertz's pressure is P a²/4.
    return [
        Figure("force", "kN/mm", load / 1e6, 2 * force.sum() / 1e6, 5e-3),
        Figure("half-width", "mm", 1e3 * width, 1e3 * 2 * np.sqrt((x**2 * force).sum() / force.sum()), 2e-2),
        Figure("pressure in the middle", "MPa", 2 * load / (np.pi * width) / 1e6, contact["pressure"][last][np.argmin(x)] / 1e6, 2e-2),
    ]


SIZES = (0.25, 0.125, 0.0625)  # m, of the hammered bar's elements


def hammered_bar(*outs: Path) -> list[Figure]:
    impedance, depth, period = 30, 0.03, 0.4  # N s/m³, m, s
    position = lambda t: depth * np.sin(np.pi * np.minimum(t, period / 2) / period) ** 2  # noqa: E731
    work = impedance * (np.pi * depth / period) ** 2 * period / 4
    reflected = []
    for out in outs:
        steps = table(out / "steps.csv")
        reflected.append((steps["kinetic_energy"] + steps["elastic_energy"])[-1] / work)
        if out == outs[1]:
            exact = impedance * np.diff(position(steps["time"])) / np.diff(steps["time"])
            force = steps["normal_force"][1:]
            work_done, impulse = steps["contact_work"].sum(), abs(impact(out)["impulse"][1])
    return [
        Figure("impulse", "N s/m", impedance * depth, impulse, 1e-3),
        Figure("largest force", "N/m", impedance * np.pi * depth / period, force.max(), 5e-3),
        Figure("error of the force over time, in L2", "", 0, np.linalg.norm(force - exact) / np.linalg.norm(exact), 3e-2),
        Figure("work of the hammer", "J/m", work, work_done, 1e-3),
        *(Figure(f"energy left, elements of {size:g} m", "", 0, left, limit)
          for size, left, limit in zip(SIZES, reflected, (1e-4, 2.5e-5, 6e-6))),
    ]  # fmt: skip


def bar_on_springs(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    t, momentum = probe["time"], probe["bar.momentum_y"]
    turn = np.flatnonzero(np.sign(momentum[1:-1]) * np.sign(momentum[2:]) < 0)[-1] + 1
    turned = t[turn] + (t[turn + 1] - t[turn]) * momentum[turn] / (momentum[turn] - momentum[turn + 1])
    found = 3 * np.pi / turned  # the third time that it is at rest after the start, 1.5 periods
    stiffness, mass, young, length, x = 9, 10, 900, 10, 0.3110528482002977  # x tan x = stiffness · length / young
    return [
        Figure("frequency", "rad/s", x * np.sqrt(young / (mass / length)) / length, found, 1e-3),
        Figure("frequency by springs and a third of the bar in series", "rad/s",
               1 / np.sqrt(mass * (1 / stiffness + length / (3 * young))), found, 1e-3),
        Figure("frequency of a rigid bar, √(k/m)", "rad/s", np.sqrt(stiffness / mass), found, 2e-2),
    ]  # fmt: skip


SOLID = Solid.of(1e3, 0.3, [{"g": 0.5, "k": 0.2, "time": 1.0}])
RISE = 0.5  # s


def of_steps(t: np.ndarray, found: np.ndarray, exact: np.ndarray, times: tuple[float, ...], name: str, unit: str) -> list[Figure]:
    """Figures of the steps that begin at some times, and the largest difference relative to the largest value."""
    steps = [int(np.argmin(abs(t[:-1] - time))) for time in times]
    return [
        *(Figure(f"{name} at {(t[k] + t[k + 1]) / 2:.2f} s", unit, exact[k], found[k], 1e-3) for k in steps),
        Figure("largest difference / largest value", "", 0, abs(found - exact).max() / abs(exact).max(), 1e-3),
    ]


def relaxation(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    t, exact = probe["time"], at_ends(lambda s: 0.01 * SOLID.relaxation(s, RISE), probe["time"])
    return of_steps(t, probe["top.reaction_y"][1:], exact, (0.5, 1, 2, 4.98), "stress", "Pa")


def creep(out: Path) -> list[Figure]:
    probe = table(out / "probes.csv")
    t, moved = probe["time"], 1e3 * probe["top.displacement_y"]
    exact = over_steps(lambda s: 1e4 * SOLID.creep(s, RISE), t)
    return of_steps(t, (moved[1:] + moved[:-1]) / 2, exact, (0.5, 1, 2, 7.98), "displacement of the top", "mm")


FRONTS = """The touch is resolved to one step. Dispersion spreads wave fronts over some elements (with the order 2/3 of the element
size), by which contact ends about 1 % early or late, and its impulse is wrong by as much."""
SOLID_TEXT = """The branch has half of the instantaneous shear modulus G₀, a fifth of the bulk modulus K₀ and the time t₁ = 1 s, with E₀
= 1 kPa and ν₀ = 0.3. The block cannot move sideways, so that its modulus is M = K + 4 G/3, at first M₀ = 1,346 Pa, in the end M∞ = 923
Pa. The scheme is dynamic; the block is so light (0.1 g/m³, waves cross it within 0.3 ms) that its inertia is below 1e-6 of the stress.
A jump would make it ring: the {what} rises within 0.5 s as (1 − cos 2πt)/2."""

CASES = [
    Case(
        "truss", "A truss hits a rigid wall",
        """A truss of 2 m, 0.2 m², E = 200 GPa and 7,800 kg/m³ flies at 1.5 m/s onto a rigid wall 1 mm away. Its plane model is a strip
        with ν = 0.""",
        """Abaqus Benchmarks Manual, 1.3.15, *Truss impact on a rigid wall*: touch at 6.67e-4 s, contact for 7.9e-4 s, force 11.8 MN,
        momentum 9,360 kg m/s. These are the closed forms d/v, 2L/c, ρ c v A and 2ρ L A v with c = √(E/ρ) = 5,064 m/s. (The manual has
        c+v in place of c, 0.03 % more, which small strain leaves out.)""",
        "closed form", FRONTS, truss),
    Case(
        "rod", "A dropped rod lands on its end",
        """A steel rod of 254 mm and 25.4 mm diameter, E = 200 GPa and 7,850 kg/m³, is dropped from 1 m and lands on its end at 4.43
        m/s. Its model in space is a prism of 12 sides with the rod's area, and ν = 0.""",
        """M. Ozen's example of a drop test (SimuTech), by the theory of waves in a rod: contact for 2L/c = 0.1006 ms, force ρ c v A =
        88.9 kN, stress ρ c v = 175 MPa, under which the whole rod is at rest after 50.3 µs.""",
        "closed form", FRONTS + " The stress is the mean over the lower half of the rod.", rod),
    Case(
        "clamped-bar", "A clamped bar hits an obstacle again and again",
        """A bar of 1 m with the wave speed 1 m/s, clamped at its upper end, is released from the uniform compression u = (1 − y)/2. Its
        lower end moves down at 0.5 m/s, touches after 1 s, rests for 1 s and returns within 1 s.""",
        """The program demo_dynamic_contact_1D of GetFEM has this problem and its solution by characteristics: the period is 3 s; in its
        three seconds the gap is (1 − t)/2, 0 and (t − 2)/2, and the stress in contact is 0.5 Pa.""",
        "closed form",
        """Fronts run through the bar for 12 s. They spread on the way, and the gap's error grows, with the order 2/3 of the element
        size. Contact takes the kinetic energy of the nodes that hit.""",
        clamped_bar),
    Case(
        "roller", "A rigid roller is pressed into a block",
        """An aluminium block (E = 70 GPa, ν = 0.3), 200 mm wide and high, is pressed with 35 kN per mm of its depth against a rigid
        roller of 50 mm radius. Viscosity damps the motion, so that the block is at rest in the end. The scene has half of it.""",
        """NAFEMS R0094, *Advanced Finite Element Contact Benchmarks*, CB1, whose roller is of steel. For a rigid roller Hertz's theory
        gives the half-width a = √(4 P R (1 − ν²)/(π E)) = 5.382 mm and the pressure 2 P/(π a) = 4,140 MPa.""",
        "closed form",
        """Hertz replaces the circle by a parabola, the program the obstacle's normals by those at the undeformed nodes; each changes
        the figures by about (a/R)² = 1.2 %. The block is 37 half-widths wide.""",
        roller),
    Case(
        "hammered-bar", "A hammer strikes a bar with an absorbing end",
        """A hammer moves the upper end of an elastic bar, 1 m wide, by 3 cm within 0.2 s and goes back. The lower end is an absorbing boundary.""",
        """The bar behaves like an endless one: the force is Z v with Z = ρ c = 30 N s/m³ and the speed v of the hammer, the impulse is
        0.9 N s/m and the work ∫ Z v² dt. The whole work leaves through the lower end (Lysmer, Kuhlemeyer 1969).""",
        "closed form",
        """The force of contact-stabilized steps lags behind the hammer by about a quarter of the time in which a wave crosses an
        element, an error of the first order. The energy that is left in the bar falls at least with the square of the element size.""",
        hammered_bar, tuple({"mesh.size": size, "time.step": size / 60} for size in SIZES), "../../scenes/hammered-bar.toml"),
    Case(
        "bar-on-springs", "A bar swings on springs",
        """An elastic bar of 10 m and 10 kg/m stands on springs of 9 N/m³ and swings up and down in its first mode.""",
        """With x tan x = k L/E the mode is cos(x (1 − y/L)) and its frequency x c/L; here x = 0.31105. To first order the bar yields
        like a third of its length in series with the springs. A rigid bar has √(k/m).""",
        "closed form",
        """A step is a hundredth of the period, by which Newmark's scheme is slow by (ωτ)²/12 = 0.03 %. A rigid bar is faster by k L/(6
        E) = 1.7 %.""",
        bar_on_springs, scene="../../scenes/bar-on-springs.toml"),
    Case(
        "relaxation", "Stress relaxes at a fixed strain",
        "A block of a standard linear solid (one branch) is stretched by 1 % and held there. " + SOLID_TEXT.format(what="strain"),
        """σ = M∞ ε + (M₀ − M∞) q with q̇ = ε̇ − q/t₁, in closed form for this rise. At fixed strain q falls as exp(−t/t₁).""",
        "closed form",
        """The midpoint rule integrates the branch with steps of a fiftieth of its time: second order, 3e-5. Stresses are those of a
        step, beside the means of the exact ones at its ends.""",
        relaxation),
    Case(
        "creep", "Strain creeps at a fixed stress",
        "A block of a standard linear solid (one branch) is loaded by 10 Pa, and the load stays. " + SOLID_TEXT.format(what="load"),
        """ε = σ/M∞ − (1/M∞ − 1/M₀) r with ṙ = σ̇ − r/t₂, in closed form for this rise. The time of retardation t₂ = t₁ M₀/M∞ = 1.458 s
        is longer than that of relaxation.""",
        "closed form",
        """As for relaxation. Displacements are means of two successive times, beside the exact means over the step: next to no inertia
        leaves a ripple that alternates from step to step.""",
        creep),
]  # fmt: skip


def options(run: dict[str, object]) -> str:
    return "".join(f" --set {key}={value:.10g}" for key, value in run.items())


def commands(case: Case) -> str:
    path = (PAGES / case.file).resolve().relative_to(HERE.parent)
    many = len(case.runs) > 1
    return "".join(f"signorini simulate {path}{options(run)}" + (f" --out results/{case.name}-{i + 1}" if many else "") + "\n"
                   for i, run in enumerate(case.runs))  # fmt: skip


def run(case: Case, folder: Path) -> list[Figure]:
    """Makes the runs of a case below `folder`."""
    outs = [folder / f"{case.name}-{i + 1}" for i in range(len(case.runs))]
    for out, overrides in zip(outs, case.runs):
        signorini("simulate", PAGES / case.file, out, **{key.replace(".", "__"): value for key, value in overrides.items()})
    return case.figures(*outs)


def rows(lines: list[list[str]]) -> str:
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def page(case: Case, figures: list[Figure], seconds: float) -> str:
    head = ["figure", "reference", "got", "deviation", "tolerance"]
    texts = [f"**Problem.** {case.problem}", f"**Reference** ({case.kind}). {case.reference}", f"**Tolerance.** {case.tolerance}"]
    prose = "\n\n".join(textwrap.fill(" ".join(text.split()), 140) for text in texts)
    return (f"# {case.title}\n\n{prose}\n\n" + rows([head, ["---"] * len(head), *(figure.cells() for figure in figures)])
            + f"\nSeconds: {seconds:.1f}.\n\n```sh\n{commands(case)}```\n\n```{{literalinclude}} {case.file}\n```\n")  # fmt: skip


def index(pages: dict[str, str]) -> str:
    """The page of all cases, from their pages."""
    head = ["case", "figure", "kind", "reference", "got", "deviation", "tolerance", "seconds"]
    lines = [head, ["---"] * len(head)]
    for case in CASES:
        seconds = re.search(r"(?m)^Seconds: (\S+)\.$", pages[case.name])[1]
        for i, (name, *numbers) in enumerate(cells(pages[case.name])):
            first = [f"[{case.title}]({case.name}.md)", name, case.kind, *numbers, seconds]
            lines.append(first if i == 0 else ["", name, "", *numbers, ""])
    return f"""# Verification

These cases compare the program with closed forms, among them those of published examples. Each page has the problem, the reference and its kind, the
tolerance with its reason, what was got, the command and the scene. A test runs every case and compares it with its page
(`tests/regression/manual.py`); `./dev exec python3 docs/verification.py` writes the pages anew. Deviations are relative to the reference,
and absolute where it is 0. Seconds are those of all runs of a case, with the program's start, on a 2-core virtual machine.

{rows(lines)}
Other tests compare scenes with known solutions too: Hertz's pressure, bars that bounce, patch tests, discs
([Accuracy](../measurements/accuracy.md), [Hard cases](../measurements/hard-cases.md)).

```{{toctree}}
:hidden:

{chr(10).join(case.name for case in CASES)}
```
"""


def cells(text: str) -> list[list[str]]:
    """The rows of a page's table: figure, reference, got, deviation, tolerance."""
    return [line.strip("|\n ").split(" | ") for line in re.findall(r"(?m)^\| .*\|$", text)[2:]]


def main() -> None:
    names = sys.argv[1:] or [case.name for case in CASES]
    for case in (case for case in CASES if case.name in names):
        with tempfile.TemporaryDirectory() as folder:
            start = time.monotonic()
            figures = run(case, Path(folder))
            (PAGES / f"{case.name}.md").write_text(page(case, figures, time.monotonic() - start))
        for figure in figures:
            print(f"{case.name}: {', '.join(figure.cells())}{'' if figure.holds else '   OUTSIDE'}", flush=True)
    (PAGES / "index.md").write_text(index({case.name: (PAGES / f"{case.name}.md").read_text() for case in CASES}))


if __name__ == "__main__":
    main()
