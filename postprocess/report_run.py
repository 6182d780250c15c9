"""A run's page: what was run, the body in motion, contact forces, energies, convergence and times."""

import numpy as np

import report_motion
import style
from report_parts import GREY, Chart, Gathering, Page, Section, Table, dots, figure, line, packed, quantity, whole
from run_folder import Contact, NotInRun, RunFolder, Table as Columns

MOST_COLUMNS = 400  # times in a map of the contact surface
RINGS = 40  # distances in that of a body in space
FROM_ZERO = {"rangemode": "tozero"}


def page(run: RunFolder) -> Page:
    """Raises NotInRun where there is no run.json, Unreadable where a file is damaged."""
    gather = Gathering(run.path)
    return run.told(lambda: Page(str(run.manifest["scene"]), run.verb, facts(run), sections_of(run, gather), gather.left_out()))


def sections_of(run: RunFolder, gather: Gathering) -> list[Section]:
    """All parts below the facts."""
    motion = gather("the body in motion", report_motion.motion, run)
    contact = [*gather("contact force", contact_force, run), *gather("candidates in contact", active_candidates, run),
               *gather("contact along the surface", contact_surface, run)]  # fmt: skip
    energy = [*gather("energies", energies, run), *gather("residuals", residuals, run)]
    convergence = [*gather("objective", objective, run), *gather("gradient norm", gradient_norm, run),
                   *gather("distance to the reference control", distance, run),
                   *gather("distance to the desired state", tracking_error, run)]  # fmt: skip
    return [
        Section("motion", "The body in motion", motion=motion[0] if motion else None),
        Section("contact", "Contact", contact),
        Section("energy", "Energy and what each step keeps", energy, gather("worst residuals", invariants, run)),
        Section("convergence", "Convergence", convergence),
        Section("time", "Where the time went", gather("times", timings, run)),
        Section("scene", "Scene", file=("scene.toml", (run.path / "scene.toml").read_text(encoding="utf-8"))),
    ]


def facts(run: RunFolder) -> list[tuple[str, str]]:
    """What was run and what came of it, nothing that is the machine's alone."""
    given, scene = run.manifest, run.scene
    steps, time = given["steps"], scene["time"]
    found = []
    if "objective" in given:
        parts = [f"{name.replace('_', ' ')} {value:.4g}" for name, value in given["objective"].items() if name != "value"]
        found.append(("Objective", f"{given['objective']['value']:.6g} {objective_unit(run)} = {' + '.join(parts)}"))
    found.append(("Ended by", str(given["stop_reason"])))
    found += [("Warning", str(warning["message"])) for warning in given.get("warnings", [])]
    if "optimizer" in given:
        done = given["optimizer"]
        found.append(("Iterations", f"{whole(done['iterations'])}, with {whole(done['forward_sweeps'])} forward and "
                                    f"{whole(done['adjoint_sweeps'])} adjoint sweeps"))  # fmt: skip
    found.append(("Effects", ", ".join(name for name, on in given["effects"].items() if on) or "none"))
    found.append(("Size", f"{whole(given['unknowns'])} unknowns, {whole(given['free_unknowns'])} of them free; "
                          f"{whole(given['cells'])} cells of degree {scene['mesh']['degree']}; "
                          f"{whole(given['candidates'])} contact candidates"))  # fmt: skip
    asked = "" if steps["done"] == steps["asked"] else f" of {whole(steps['asked'])}"
    end = quantity(run.last_time, "s")
    found.append(("Time", f"{whole(steps['done'])}{asked} steps of {quantity(time['step'], 's')}, to {end}"))
    found.append(("Scheme", ", ".join([time["scheme"], *(f"{mass} mass" for mass in masses(scene))])))
    found.append(("Solver", str(given["solver"]).split(" (")[0]))
    found.append(("Ranks", whole(given["host"]["ranks"])))
    found.append(("Peak memory", quantity(given["peak_memory_bytes"], "B")))
    found.append(("Versions", ", ".join(f"{name} {version}" for name, version in given["versions"].items())))
    found.append(("Finished", str(given["finished"]).replace("T", " ").replace("Z", " UTC")))
    return found


def masses(scene: dict) -> list[str]:
    """What mass the candidates have, none without contact."""
    contact = scene.get("contact", [])
    return sorted({table["mass"] for table in (contact if isinstance(contact, list) else [contact])})


def objective_unit(run: RunFolder) -> str:
    """J is a time integral of squared L2 norms of a length."""
    return f"m{'⁴' if run.dim == 2 else '⁵'} s"


def time_axis(times: np.ndarray) -> tuple[np.ndarray, str]:
    """Times (s) in a short unit, and the axis' title."""
    factor, unit = style.prefixed(times, "s")
    return times * factor, f"time ({unit})"


def logarithmic(*values: np.ndarray) -> dict:
    """An axis of powers of ten, or of a few numbers where the values hardly span one."""
    shown = np.concatenate([part[part > 0] for part in values])
    decades = np.log10(shown.max() / shown.min())
    ticks = {"dtick": int(np.ceil(decades / 8))} if decades > 1.3 else {"nticks": 6}
    return {"type": "log", "exponentformat": "power"} | ticks


def contact_force(run: RunFolder) -> Chart:
    """Of every time step, alternating as it does, and the mean that converges."""
    run.require_contact()
    steps = run.steps
    try:
        force, what = run.normal_force, "normal contact force"
    except NotInRun:  # no one normal
        force, what = np.linalg.norm([steps[f"contact_force_{axis}"] for axis in "xyz"[: run.dim]], axis=0), "contact force"
    factor, unit = style.prefixed(force, style.per_depth("N", run.dim))
    times, title = time_axis(steps["time"])
    # Row 0 is the initial state, in which no force has acted yet.
    force, times = force[1:] * factor, times[1:]
    curves = [line("each step", times, force, GREY, width=1)]
    if len(force) > 1:
        curves.append(line("mean of two steps", (times[1:] + times[:-1]) / 2, (force[1:] + force[:-1]) / 2, style.VERMILLION))
    view = figure(curves, title, f"{what} ({unit})", xaxis={"range": [0, times[-1]]}, yaxis=FROM_ZERO)
    implicit = run.scene["time"]["scheme"] == "contact-implicit"
    note = "Single forces of contact-implicit steps alternate about the true one; the mean of two converges to it." * implicit
    return Chart.single("contact-force", "Contact force over time", view, note)


def active_candidates(run: RunFolder) -> Chart:
    """How many, of every time step."""
    run.require_contact()
    steps = run.steps
    times, title = time_axis(steps["time"])
    curves = [line("in contact", times, steps["active"], style.BLUE)]
    if steps["weak"].any():
        curves.append(line("in weak contact: no gap and no force", times, steps["weak"], style.ORANGE, "dot"))
    for curve in curves:
        curve["line"]["shape"] = "vh"  # row k holds for the step that ends there
    ticks = {"dtick": 1} if steps["active"].max() < 10 else {}  # else halves come up
    view = figure(curves, title, "candidates", yaxis=FROM_ZERO | ticks)
    return Chart.single("active", "Candidates in contact", view)


def contact_surface(run: RunFolder) -> Chart:
    """Force and gap over place and time."""
    run.require_contact()
    contact = merged(run.contact)
    place, rows, where = along_surface(contact.points) if run.dim == 2 else around_contact(contact)
    unit = style.per_depth("N", run.dim)
    views = {"force of each step": surface_map(contact.times, place, rows, contact.force, unit, "force", where)}
    if run.scene["output"]["every"] == 1 and len(contact.times) > 2:
        mean = (contact.force[1:] + contact.force[:-1]) / 2
        views = {"force, mean of two steps": surface_map(contact.times[1:], place, rows, mean, unit, "force", where)} | views
    views["gap"] = surface_map(contact.times, place, rows, contact.gap, "m", "gap", where)
    note = ("Forces are those of single nodes." if run.dim == 2 else
            "Of the nodes at about the same distance the largest force, or the least gap, is shown.")  # fmt: skip
    return Chart("contact-surface", "Contact along the surface", views, note)


def merged(contact: Contact) -> Contact:
    """One row for each node: the sum of the forces and the least gap of a node that several obstacles may touch."""
    points, node = np.unique(contact.points, axis=0, return_inverse=True)
    shape = (len(contact.times), len(points))
    gap, force = np.full(shape, np.inf), np.zeros(shape)
    np.minimum.at(gap, (slice(None), node.ravel()), contact.gap)
    np.add.at(force, (slice(None), node.ravel()), contact.force)
    return Contact(contact.times, points, gap, force)


def along_surface(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, str]:
    """Positions along the surface (m), which of them each candidate has, and what they are."""
    order = chain(points)
    position = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[order], axis=0), axis=1))])
    return position - position[-1] / 2, np.argsort(order), "position along the surface,<br>from its middle (m)"


def chain(points: np.ndarray) -> list[int]:
    """Points of a curve from end to end, the one with the smaller x first: each joins the end that it is nearest to."""
    order, left = [0], np.arange(1, len(points))
    while left.size:
        apart = np.linalg.norm(points[left] - points[[order[0], order[-1]]][:, None], axis=2)
        end, which = np.unravel_index(np.argmin(apart), apart.shape)
        order.insert(0 if end == 0 else len(order), left[which])
        left = np.delete(left, which)
    return order if tuple(points[order[0]]) <= tuple(points[order[-1]]) else order[::-1]


def around_contact(contact: Contact) -> tuple[np.ndarray, np.ndarray, str]:
    """The same for rings around the candidate that is pushed the most."""
    apart = np.linalg.norm(contact.points - contact.points[np.argmax(contact.force.sum(axis=0))], axis=1)
    count = min(RINGS, max(1, round(np.sqrt(len(apart)))))
    ring = np.minimum((apart / (apart.max() or 1) * count).astype(int), count - 1)
    used, rows = np.unique(ring, return_inverse=True)
    return (used + 0.5) * apart.max() / count, rows, "distance from the node<br>pushed most (m)"


def surface_map(times: np.ndarray, place: np.ndarray, rows: np.ndarray, values: np.ndarray, unit: str, what: str,
                where: str) -> dict:
    """Values (times × candidates) by colours over time and place: the largest force or the least gap there."""
    every = -(-len(times) // MOST_COLUMNS)
    extreme, start = (np.minimum, np.inf) if what == "gap" else (np.maximum, -np.inf)
    shown = np.full((len(place), len(times[::every])), start)
    extreme.at(shown, rows, values[::every].T)
    factor, unit = style.prefixed(shown, unit)
    times, title = time_axis(times[::every])
    colours = {"colorscale": "Viridis", "reversescale": what == "gap", "zmin": min(0, shown.min() * factor),
               "colorbar": {"title": {"text": f"{what} ({unit})", "side": "right"}, "thickness": 14, "outlinewidth": 0}}  # fmt: skip
    hover = f"%{{x:.4g}}, %{{y:.3g}} m<br>{what} %{{z:.3g}} {unit}<extra></extra>"
    field = {"type": "heatmap", "x": packed(times), "y": packed(place), "z": packed(shown * factor), "hovertemplate": hover}
    return figure([field | colours], title, where)


def energies(run: RunFolder) -> Chart:
    """At the time steps; the dissipation only of a body that has viscosity."""
    steps = run.steps
    kinetic, elastic, dissipated = steps["kinetic_energy"], steps["elastic_energy"], np.cumsum(steps["viscous_dissipation"])
    factor, unit = style.prefixed(max((kinetic + elastic).max(), dissipated[-1]), style.per_depth("J", run.dim))
    times, title = time_axis(steps["time"])
    curves = [line("kinetic", times, kinetic * factor, style.BLUE),
              line("elastic", times, elastic * factor, style.ORANGE, "dash"),
              line("kinetic + elastic", times, (kinetic + elastic) * factor, "black")]  # fmt: skip
    if dissipated[-1] > 0:
        curves.append(line("dissipated so far", times, dissipated * factor, style.VERMILLION, "dashdot"))
    return Chart.single("energies", "Energies over time", figure(curves, title, f"energy ({unit})", yaxis=FROM_ZERO))


def residuals(run: RunFolder) -> Chart:
    """What is left of the laws that each step keeps to rounding."""
    times, title = time_axis(run.steps["time"])
    laws = {name: law for name, law in relative_residuals(run.steps, run.has_contact).items() if (law > 0).any()}
    if not laws:
        raise NotInRun("each step keeps its laws without any rest")
    looks = [(style.BLUE, "circle"), (style.VERMILLION, "diamond"), (style.GREEN, "square")]
    curves = [dots(name, times, positive(law), *look) for (name, law), look in zip(laws.items(), looks)]
    tolerance = np.full(2, run.scene["run"]["tolerance"])
    curves.append(line("run.tolerance", times[[0, -1]], tolerance, GREY, "dash", 1.5))
    view = figure(curves, title, "relative residual", yaxis=logarithmic(*laws.values(), tolerance))
    note = "Of the energy law relative to the largest energy, of the momentum law to the largest forces. Zeros have no mark."
    return Chart.single("residuals", "Residuals of each step", view, note)


def relative_residuals(steps: Columns, has_contact: bool) -> dict[str, np.ndarray]:
    """Of the energy law, the momentum law and the contact condition."""
    largest = (steps["kinetic_energy"] + steps["elastic_energy"]).max()
    laws = {"energy law": np.abs(steps["energy_residual"]) / (largest or 1.0), "momentum law": steps["momentum_residual"]}
    return laws | ({"contact condition": steps["complementarity"]} if has_contact else {})


def positive(values: np.ndarray) -> np.ndarray:
    """NaN where a logarithm has no place."""
    return np.where(values > 0, values, np.nan)


def invariants(run: RunFolder) -> Table:
    """The worst of the run, as the program measured it."""
    watched = run.manifest.get("invariants")
    if not watched:
        raise NotInRun("the run did not look at invariants")
    return Table("The worst of all steps, beyond what rounding explains", ["Law, residual / scale", "Worst", "Step"],
                 [[name, f"{defect['worst']:.2g}", whole(defect["step"])] for name, defect in watched.items()])


def objective(run: RunFolder) -> Chart:
    """J and its parts over the iterations."""
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


def gradient_norm(run: RunFolder) -> Chart:
    """Beside what it must come down to."""
    iteration, norm = run.history["iteration"], run.history["gradient_norm"]
    if not (norm > 0).any():
        raise NotInRun("the gradient is zero")
    goal = np.full(2, run.scene["optimizer"]["tolerance"] * norm[0])
    curves = [line("gradient norm", iteration, positive(norm), style.BLUE),
              line("tolerance", iteration[[0, -1]], goal, GREY, "dash", 1.5)]  # fmt: skip
    view = figure(curves, "iteration", "gradient norm", yaxis=logarithmic(norm, goal))
    return Chart.single("gradient-norm", "Gradient norm", view)


def distance(run: RunFolder) -> Chart:
    """How far the control is from the one that made the desired state."""
    iteration, relative = run.history["iteration"], run.history["relative_distance_to_reference"]
    if not (relative > 0).any():
        raise NotInRun("the desired state was not given by a reference control")
    curve = line("distance", iteration, positive(relative), style.BLUE)
    view = figure([curve], "iteration", "‖u − u<sub>ref</sub>‖ / ‖u<sub>ref</sub>‖", yaxis=logarithmic(relative))
    return Chart.single("distance", "Distance to the reference control", view)


def tracking_error(run: RunFolder) -> Chart:
    """How far the state is from the desired one, over time."""
    error = run.steps.get("tracking_error", np.array([np.nan]))
    if not np.isfinite(error).any():
        raise NotInRun("the run has no desired state")
    times, title = time_axis(run.steps["time"])
    unit = "m²" if run.dim == 2 else "m<sup>5/2</sup>"
    view = figure([line("distance", times, error, style.BLUE)], title, f"‖y − y<sub>d</sub>‖ ({unit})", yaxis=FROM_ZERO)
    return Chart.single("tracking-error", "Distance to the desired state over time", view)


def timings(run: RunFolder) -> Chart:
    """Seconds of each phase, the longest on top."""
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
