# SPDX-License-Identifier: GPL-3.0-or-later
"""Page of a run: facts, the body in motion, contact, control, energies, probes, convergence and times."""

import numpy as np

from . import report_contact, report_control, report_fit, report_friction, report_motion, report_probes, style
from .files import NotInRun, Table as Columns, whole_text
from .report_impact import energy_account, impact
from .report_parts import GREY, Chart, Gathering, Page, Section, Table, dots, figure, line, quantity, time_axis, whole
from .energy_terms import dissipated_so_far, further_energies, potential_of_loads, stored_energy, work_of_others, works_of_friction
from .friction_force import has_friction
from .run_folder import RunFolder

FROM_ZERO = {"rangemode": "tozero"}
MODELS = {"axisymmetric": "of revolution, x is the radius; masses, forces and energies are those of the whole body",
          "plane-stress": "a thin plate in plane stress; masses, forces and energies are per metre of thickness"}  # fmt: skip
SHADES = ["#440154", "#414487", "#2a788e", "#22a884", "#7ad151", "#fde725"]  # viridis, of least shares first


def page(run: RunFolder) -> Page:
    """Makes the page. Raises NotInRun without run.json, Unreadable if a file is damaged."""
    gather = Gathering(run.path)
    return run.entry(lambda: Page(str(run.manifest["scene"]), run.verb, run.identity, facts(run), sections_of(run, gather),
                                 gather.left_out()))  # fmt: skip


def sections_of(run: RunFolder, gather: Gathering) -> list[Section]:
    """Makes all parts below the facts."""
    motion = gather("the body in motion", report_motion.motion, run)
    varying = "shortest" in run.manifest.get("steps", {})
    contact = [*gather("contact force", report_contact.contact_force, run),
               *(gather("length of the steps", step_lengths, run) if varying else []),
               *gather("candidates in contact", report_contact.active_candidates, run),
               *(gather("candidates that slip and stick", report_friction.slip_stick, run) if has_friction(run) else []),
               *gather("contact along the surface", report_contact.contact_surface, run)]  # fmt: skip
    control = gather("resultant of the control", report_control.resultant, run) if "control" in run.scene else []
    energy = [*gather("energies", energies, run), *gather("residuals", residuals, run)]
    convergence = [] if run.is_fit else [
        *gather("objective", objective, run),
        *(gather("scenarios", scenarios, run) if "scenario" in run.scene else []),
        *gather("gradient norm", gradient_norm, run),
        *gather("distance to the reference control", distance, run),
        *gather("distance to the desired state", tracking_error, run)]  # fmt: skip
    tables = [*energy_account(run), *gather("worst residuals", invariants, run)]
    return [
        *report_fit.sections(run, gather),
        Section("motion", "The body in motion", motions=motion),
        Section("contact", "Contact", contact, impact(run)),
        Section("control", "Control", [*control, *report_control.boundary(run)]),
        Section("energy", "Energy and what each step keeps", energy, tables),
        Section("probes", "Probes", report_probes.charts(run)),
        Section("convergence", "Convergence", convergence),
        Section("accuracy", "Accuracy", gather("error indicators", error_indicators, run) if run.has_indicators and run.dim == 2 else []),
        Section("time", "Where the time went", gather("times", timings, run)),
        Section("scene", "Scene", file=("scene.toml", whole_text(run.path / "scene.toml", with_names=True))),
    ]


def facts(run: RunFolder) -> list[tuple[str, str]]:
    """Returns facts about the run and its results, without those that depend on the machine alone."""
    given, scene = run.manifest, run.scene
    steps, time = given["steps"], scene["time"]
    found = []
    if "objective" in given:
        parts = [f"{name.replace('_', ' ')} {value:.4g}" for name, value in given["objective"].items() if name != "value"]
        found.append(("Objective", f"{given['objective']['value']:.6g} {objective_unit(run)} = {' + '.join(parts)}"))
    found += report_fit.facts(run)
    found.append(("Ended by", str(given["stop_reason"])))
    found += [("Warning", str(warning["message"])) for warning in given.get("warnings", [])]
    if "optimizer" in given:
        done = given["optimizer"]
        found.append(("Iterations", f"{whole(done['iterations'])}, with {whole(done['forward_sweeps'])} forward and "
                                    f"{whole(done['adjoint_sweeps'])} adjoint sweeps"))  # fmt: skip
    if run.model in MODELS:
        found.append(("Body", MODELS[run.model]))
    found.append(("Effects", ", ".join(name for name, on in given["effects"].items() if on) or "none"))
    found.append(("Size", f"{whole(given['unknowns'])} unknowns, {whole(given['free_unknowns'])} of them free; "
                          f"{whole(given['cells'])} cells of degree {scene['mesh']['degree']}; "
                          f"{whole(given['candidates'])} contact candidates"))  # fmt: skip
    asked = "" if steps["done"] == steps["asked"] else f" of {whole(steps['asked'])}"
    end = quantity(run.last_time, "s")
    length = (f"{quantity(steps['shortest'], 's')} to {quantity(steps['longest'], 's')}" if "shortest" in steps
              else quantity(time["step"], "s"))  # fmt: skip
    found.append(("Time", f"{whole(steps['done'])}{asked} steps of {length}, to {end}"))
    if "accuracy" in given:
        found.append(("Accuracy", accuracy(given["accuracy"])))
    found.append(("Scheme", ", ".join([time["scheme"], *(f"{mass} mass" for mass in masses(scene))])))
    found.append(("Solver", str(given["solver"]).split(" (")[0]))
    found.append(("Ranks", whole(given["host"]["ranks"])))
    found.append(("Peak memory", quantity(given["peak_memory_bytes"], "B")))
    found.append(("Versions", ", ".join(f"{name} {version}" for name, version in given["versions"].items())))
    return found


def accuracy(given: dict) -> str:
    """Describes the accuracy asked for and estimated."""
    met = "met" if given["met"] else f"not verified, {given['doubt']}" if given["doubt"] else "not met"
    return (f"relative error of {given['quantity']}: {given['asked']:g} requested, {given['estimated']:.2g} estimated: {met} "
            f"(space {given['space']:.1g}, time {given['time']:.1g}, search {given['search']:.1g})")  # fmt: skip


def step_lengths(run: RunFolder) -> Chart:
    """Makes the chart of step lengths over time, for runs with varying steps."""
    times = run.steps["time"]
    lengths = np.diff(times)
    factor, unit = style.prefixed(lengths, "s")
    shown, title = time_axis(times)
    curve = line("length of the steps", shown, lengths[[0, *range(len(lengths))]] * factor, style.BLUE)
    curve["line"]["shape"] = "vh"  # length of the step that ends there
    view = figure([curve], title, f"step length ({unit})", xaxis={"range": [0, shown[-1]]}, yaxis=logarithmic(lengths * factor))
    return Chart.single("step-lengths", "Length of the steps over time", view)


def error_indicators(run: RunFolder) -> Chart:
    """Makes the chart of the mesh, with cells coloured by their share in the error."""
    table = run.indicators
    share = table["indicator"]
    corners = [np.stack([table[f"x{i}"], table[f"y{i}"]], axis=1) for i in range(3)]
    outlines = np.stack([*corners, corners[0], np.full_like(corners[0], np.nan)], axis=1)  # each apart from the next
    bounds = share.max() * np.geomspace(1e-4, 1, len(SHADES) + 1)
    level = np.clip(np.searchsorted(bounds, share) - 1, 0, len(SHADES) - 1)
    traces = []
    for i, shade in enumerate(SHADES):
        x, y = outlines[level == i].reshape(-1, 2).T
        if len(x):
            name = f"{bounds[i]:.1g} to {bounds[i + 1]:.1g}" if i else f"below {bounds[1]:.1g}"
            traces.append(line(name, x, y, shade, width=1) | {"fill": "toself", "fillcolor": shade, "hoverinfo": "skip"})
    traces.append(line("mesh", *outlines.reshape(-1, 2).T, GREY, width=0.5))
    view = figure(traces, *(f"{name} (m)" for name in run.axis_names), yaxis={"scaleanchor": "x"})
    return Chart.single("error-indicators", "The mesh, and each cell's share in the error of J", view, "Absolute values, relative to J.")


def masses(scene: dict) -> list[str]:
    """Returns the kinds of mass of the candidates; none without contact."""
    contact = scene.get("contact", [])
    return sorted({table["mass"] for table in (contact if isinstance(contact, list) else [contact])})


def objective_unit(run: RunFolder) -> str:
    """Returns the unit of J, a time integral of squared L2 norms of a length."""
    return f"m{'⁵' if run.whole else '⁴'} s"


def logarithmic(*values: np.ndarray) -> dict:
    """Returns an axis of powers of ten, or of a few numbers where the values hardly span one."""
    shown = np.concatenate([part[part > 0] for part in values])
    decades = np.log10(shown.max() / shown.min())
    ticks = {"dtick": int(np.ceil(decades / 8))} if decades > 1.3 else {"nticks": 6}
    return {"type": "log", "exponentformat": "power"} | ticks


def energies(run: RunFolder) -> Chart:
    """Makes the chart of energies at the time steps; dissipation only if there is any, potential only where loads do work."""
    steps = run.steps
    kinetic, elastic, dissipated = steps["kinetic_energy"], steps["elastic_energy"], dissipated_so_far(steps)
    potential, further = potential_of_loads(steps), further_energies(steps)
    whole_energy = stored_energy(steps) + (0 if potential is None else potential)
    friction = works_of_friction(steps)
    largest = max(whole_energy.max(), dissipated[-1], *(np.abs(work).max() for work in friction.values()))
    factor, unit = style.prefixed(largest, style.per_depth("J", run.whole))
    times, title = time_axis(steps["time"])
    curves = [line("kinetic", times, kinetic * factor, style.BLUE),
              line("elastic", times, elastic * factor, style.ORANGE, "dash")]  # fmt: skip
    note = ""
    looks = {"foundations": (style.SKY, "longdashdot"), "branches": (style.ORANGE, "dot"), "obstacles": (style.GREEN, "longdash")}
    curves += [line(name, times, energy * factor, *looks[name]) for name, energy in further.items()]
    if potential is not None:
        curves.append(line("potential of the loads", times, potential * factor, style.GREEN, "dot"))
        note = "The potential of the loads falls by the work of the loads; its least value is set to 0. Of loads that change in time it is no stored energy."
    parts = " + ".join(["kinetic", "elastic", *further, *["potential"] * (potential is not None)])
    curves.append(line(parts, times, whole_energy * factor, "black"))
    other = work_of_others(run)
    if other is not None:
        curves.append(line("work of control and clamps so far", times, other * factor, "#CC79A7", "longdash"))
    if dissipated[-1] > 0:
        curves.append(line("dissipated so far", times, dissipated * factor, style.VERMILION, "dashdot"))
    looks = {"lost to friction so far": (style.VERMILION, "dot"), "work of moving surfaces so far": ("#CC79A7", "dash")}
    curves += [line(name, times, work * factor, *looks[name]) for name, work in friction.items()]
    view = figure(curves, title, f"energy ({unit})", yaxis=FROM_ZERO)
    return Chart.single("energies", "Energies over time", view, note)


def residuals(run: RunFolder) -> Chart:
    """Makes the chart of residuals of the laws that each step satisfies to rounding."""
    times, title = time_axis(run.steps["time"])
    laws = {name: law for name, law in relative_residuals(run.steps, run.has_contact).items() if (law > 0).any()}
    if not laws:
        raise NotInRun("all residuals are zero")
    looks = [(style.BLUE, "circle"), (style.VERMILION, "diamond"), (style.GREEN, "square")]
    curves = [dots(name, times, positive(law), *look) for (name, law), look in zip(laws.items(), looks)]
    tolerance = np.full(2, run.scene["run"]["tolerance"])
    curves.append(line("run.tolerance", times[[0, -1]], tolerance, GREY, "dash", 1.5))
    view = figure(curves, title, "relative residual", yaxis=logarithmic(*laws.values(), tolerance))
    note = "Residuals of the energy law are relative to the largest energy, those of the momentum law to the largest forces. Zeros have no mark."
    return Chart.single("residuals", "Residuals of each step", view, note)


def relative_residuals(steps: Columns, has_contact: bool) -> dict[str, np.ndarray]:
    """Returns the relative residuals of the energy law, the momentum law and the contact condition."""
    largest = stored_energy(steps).max()
    laws = {"energy law": np.abs(steps["energy_residual"]) / (largest or 1.0), "momentum law": steps["momentum_residual"]}
    return laws | ({"contact condition": steps["complementarity"]} if has_contact else {})


def positive(values: np.ndarray) -> np.ndarray:
    """Replaces values that are not positive by NaN, for logarithmic axes."""
    return np.where(values > 0, values, np.nan)


def invariants(run: RunFolder) -> Table:
    """Makes a table of the largest residuals of the run, as the program measured them."""
    watched = run.manifest.get("invariants")
    if not watched:
        raise NotInRun("the run did not check invariants (run.invariants = 'off')")
    return Table("Largest residuals of all steps, in excess of rounding errors", ["Law, residual / scale", "Worst", "Step"],
                 [[name, f"{defect['worst']:.2g}", whole(defect["step"])] for name, defect in watched.items()])


def objective(run: RunFolder) -> Chart:
    """Makes the chart of J and its parts over the iterations."""
    history = run.history
    looks = {"objective": ("J", "black", "solid"), "tracking": ("tracking", style.BLUE, "dash"),
             "terminal": ("end state", style.GREEN, "dot"),
             "control_cost": ("cost of the control", style.ORANGE, "dashdot")}  # fmt: skip
    shown = [column for column in looks if (history[column] > 0).any()]
    if not shown:
        raise NotInRun("the objective is zero")
    curves = []
    for column in shown:
        name, colour, dash = looks[column]
        curves.append(line(name, history["iteration"], positive(history[column]), colour, dash))
    axis = logarithmic(*(history[column] for column in shown))
    view = figure(curves, "iteration", f"objective ({objective_unit(run)})", yaxis=axis)
    return Chart.single("objective", "Objective and its parts", view)


def scenarios(run: RunFolder) -> Chart:
    """Makes the chart of J of each scenario at the control that was found, beside their mean."""
    found = run.manifest["scenarios"]
    names, J = [one["name"] for one in found], float(run.history["objective"][-1])
    bars = {"type": "bar", "x": names, "y": [one["objective"] for one in found], "name": "scenario", "marker": {"color": style.BLUE}}
    mean = {"type": "scatter", "mode": "lines", "x": names, "y": [J] * len(names), "name": "J", "line": {"color": "black", "dash": "dash"}}
    view = figure([bars, mean], "scenario", f"objective ({objective_unit(run)})", yaxis=FROM_ZERO)
    return Chart.single("scenarios", "Objective of each scenario", view, "Fields and other charts of this page are those of the scene itself.")


def gradient_norm(run: RunFolder) -> Chart:
    """Makes the chart of the gradient norm beside its tolerance."""
    iteration, norm = run.history["iteration"], run.history["gradient_norm"]
    if not (norm > 0).any():
        raise NotInRun("the gradient is zero")
    goal = np.full(2, run.scene["optimizer"]["tolerance"] * norm[0])
    curves = [line("gradient norm", iteration, positive(norm), style.BLUE),
              line("tolerance", iteration[[0, -1]], goal, GREY, "dash", 1.5)]  # fmt: skip
    view = figure(curves, "iteration", "gradient norm", yaxis=logarithmic(norm, goal))
    return Chart.single("gradient-norm", "Gradient norm", view)


def distance(run: RunFolder) -> Chart:
    """Makes the chart of the control's distance from the reference control over the iterations."""
    iteration, relative = run.history["iteration"], run.history["relative_distance_to_reference"]
    if not (relative > 0).any():
        raise NotInRun("the scene has no reference control (objective.desired.control)")
    curve = line("distance", iteration, positive(relative), style.BLUE)
    view = figure([curve], "iteration", "‖u − u<sub>ref</sub>‖ / ‖u<sub>ref</sub>‖", yaxis=logarithmic(relative))
    return Chart.single("distance", "Distance to the reference control", view)


def tracking_error(run: RunFolder) -> Chart:
    """Makes the chart of the distance between state and desired state over time."""
    error = run.steps.get("tracking_error", np.array([np.nan]))
    if not np.isfinite(error).any():
        raise NotInRun("the run has no desired state")
    times, title = time_axis(run.steps["time"])
    unit = "m<sup>5/2</sup>" if run.whole else "m²"
    view = figure([line("distance", times, error, style.BLUE)], title, f"‖y − y<sub>d</sub>‖ ({unit})", yaxis=FROM_ZERO)
    return Chart.single("tracking-error", "Distance to the desired state over time", view)


def timings(run: RunFolder) -> Chart:
    """Makes the chart of the seconds of each phase, the longest on top."""
    phases = sorted(run.manifest.get("timings", {}).items(), key=lambda phase: phase[1]["seconds"])
    if not phases:
        raise NotInRun("run.json has no timings")
    seconds = [phase["seconds"] for _, phase in phases]
    texts = [f"{quantity(phase['seconds'], 's')}, calls: {whole(phase['calls'])}" for _, phase in phases]
    bars = {"type": "bar", "orientation": "h", "x": seconds, "y": [name for name, _ in phases], "text": texts,
            "textposition": "outside", "cliponaxis": False, "hoverinfo": "skip", "marker": {"color": style.BLUE}}  # fmt: skip
    # The texts stand beside the bars.
    view = figure([bars], "time (s)", "", xaxis={"range": [0, 1.6 * max(seconds)]})
    return Chart.single("timings", "Seconds of each phase", view)
