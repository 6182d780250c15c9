# SPDX-License-Identifier: GPL-3.0-or-later
"""What the paper reports of its experiment (section 5, Figs. 5 to 9), statement by statement, on scenes/seed.toml. How many iterations the
search takes for what hangs on rounding: bounds are far from what was measured."""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from harness import SIGNORINI, SOURCE, Figures, captured, signorini, stored, table  # noqa: E402

import numpy as np  # noqa: E402

SCENE = SOURCE / "scenes" / "seed.toml"
STEP, STEPS, STEP_OF_FIGURES = 5e-5, 150, 35  # t = 0.00175 s
RADIUS, ALPHA, REFERENCE, GUESS = 15, 1e-2, 3, 5
ITERATIONS = 1000
LOOKED_AT = range(0, ITERATIONS + 1, 200)  # iterations whose forward problems are looked at
FLIGHT = 10  # steps without contact, at least, from a release to the next contact: what is shorter is chatter


def contacts(steps: dict) -> list[tuple[int, int]]:
    """First and last step of each contact."""
    touching = steps["step"][steps["active"] > 0].astype(int)
    apart = np.flatnonzero(np.diff(touching) > FLIGHT)
    return list(zip(touching[[0, *(apart + 1)]].tolist(), touching[[*apart, -1]].tolist(), strict=True)) if len(touching) else []


def pressures(out: Path) -> tuple[np.ndarray, np.ndarray]:
    """Positions and contact pressures of the step of the figures, from left to right."""
    contact = table(out / "contact.csv")
    now = contact["step"] == STEP_OF_FIGURES
    x, y, force = (contact[key][now] for key in ("x", "y", "force"))
    order = np.argsort(x)
    return x[order], force[order] / (RADIUS * np.gradient(np.arctan2(x, -y)[order]))


def oscillation(pressure: np.ndarray) -> float:
    """Distance of the pressures from the means over their neighbours, relative to them."""
    smooth = np.convolve(pressure, [0.25, 0.5, 0.25], "same")
    touching = pressure > 0
    return np.linalg.norm((pressure - smooth)[touching]) / np.linalg.norm(pressure)


def reference(out: Path, figures: Figures) -> None:
    """"resulting in a bouncing motion of the ball with contact being established and released several times while being damped by
    the viscose part"."""
    oscillations = []
    print("the reference control:")
    for size in (1.0, 0.25):
        signorini("optimize", SCENE, out, mesh__size=size, control__initial=["0", str(-REFERENCE)], optimizer__max_iterations=0,
                  output__fields=[])  # fmt: skip
        steps = table(out / "steps.csv")
        assert (steps["active"] > 0).sum() > 20, "hardly any contact: the case says nothing"
        made = contacts(steps)
        oscillations.append(oscillation(pressures(out)[1]))
        print(f"  size {size}: in contact in steps {', '.join(f'{a} to {b}' for a, b in made)}; pressures oscillate by {oscillations[-1]:.3f}")
        figures.least("contact is made, times", len(made), 2)
        if size == 1:
            figures.least("and released, times", sum(last < STEPS for _, last in made), 2)
            figures.least("of the work of forces, dissipated", steps["viscous_dissipation"].sum() / steps["external_work"].sum(), 0.05)
        figures.least("nodes in contact at t = 0.00175", steps["active"][STEP_OF_FIGURES], 3)
        figures.show("candidates in weak contact", steps["weak"].sum(), 0, 0)
    # Fig. 9: "The oscillatory behavior … can be attributed to the spatial discretization and the effect decreases with mesh refinements."
    figures.least("Fig. 9: pressures oscillate at size 1", oscillations[0], 0.1)
    figures.least("times less at size 0.25", oscillations[0] / oscillations[-1], 1.5)


def search(out: Path, figures: Figures) -> None:
    """"No weak contact occurred in the forward problems of our setting"."""
    weak = []
    print(f"{ITERATIONS} iterations:")
    for count in LOOKED_AT:
        done = captured([str(SIGNORINI), "optimize", str(SCENE), "--out", str(out), "--resume",
                         "--set", f"optimizer.max_iterations={count}", "--set", 'output.fields=["control", "adjoint"]'])  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        steps = table(out / "steps.csv")
        weak.append(steps["weak"].sum())
        assert steps["active"][STEP_OF_FIGURES] > 0, f"no contact at t = 0.00175 after {count} iterations"
    figures.show("candidates in weak contact, of all looked at", sum(weak), 0, 0)
    made = contacts(steps)
    print(f"  the result is in contact in steps {', '.join(f'{a} to {b}' for a, b in made)}")
    figures.least("of the result: contact is made, times", len(made), 2)


def figure_5(out: Path, figures: Figures, history: dict) -> None:
    """"the resulting control is being reduced to values close to zero where contact is active and where the body is clamped"; "the
    entire control being reduced to zero on the contact patch, instead of only its y-component"."""
    contact = table(out / "contact.csv")
    active = (contact["step"] == STEP_OF_FIGURES) & (contact["force"] > 0)
    points, _, u = stored(out, "control", "control")
    p = stored(out, "adjoint", "adjoint")[2][STEP_OF_FIGURES - 1, :, :2]
    u = u[STEP_OF_FIGURES - 1, :, :2]
    apart = np.linalg.norm(points[:, None, :2] - np.column_stack([contact["x"], contact["y"]])[active], axis=2)
    touching = (apart < 1e-9).any(axis=1)
    clamped = np.isclose(points[:, 1], points[:, 1].max(), rtol=0, atol=1e-9)
    size = np.linalg.norm(u, axis=1)
    usual = np.median(size)
    print(f"Fig. 5: control at t = 0.00175 at most {size.max():.3f}, at half of the nodes above {usual:.3f}")
    figures.least("nodes in contact", touching.sum(), 3)
    figures.show("on the clamp, of that", size[clamped].max() / usual, 0, 1 / 3)
    figures.show("largest at nodes in contact, of that", size[touching].max() / usual, 0, 1 / 3)
    figures.show("on the clamp, of the first guess", size[clamped].max() / GUESS, 0, 0.2)
    figures.show("at nodes in contact, of the first guess", size[touching].max() / GUESS, 0, 0.2)
    # Where p vanishes an iteration leaves 1 - α times its step of the control.
    left = np.prod(1 - ALPHA * history["step_length"][1:])
    figures.show("on the clamp / what the steps leave of it", abs(u[clamped, 1]).max() / GUESS / left, 1, 1e-8)
    figures.show("adjoint state normal to the plane, in contact", abs(p[touching, 1]).max() / abs(p).max(), 0, 1e-12)


def figure_6(figures: Figures, history: dict) -> None:
    """"the difference of the current iterate's value and the functional value of the resulting control after 1000 iterations …
    behaves almost linearly", on a logarithmic axis."""
    J = history["objective"]
    print(f"Fig. 6: J from {J[0]:.4f} to {J[-1]:.6f}")
    assert (np.diff(J) < 0).all(), "J rose"
    k = np.arange(50, 801)
    exponent = np.log10(J[k] - J[-1])
    figures.least("decades in iterations 50 to 800", exponent[0] - exponent[-1], 1)
    figures.least("square of the correlation with a line", np.corrcoef(k, exponent)[0, 1] ** 2, 0.98)


def figure_7(figures: Figures, history: dict) -> None:
    """"the distance of the iterates to the reference control decreases at first and starts increasing again after the first 200
    iterations … From 200 iterations on, the Tychonoff term in the costfunctional becomes increasingly relevant."""
    distance = history["relative_distance_to_reference"]
    turn = int(distance.argmin())
    motion, cost = history["tracking"] + history["terminal"], history["control_cost"]
    print(f"Fig. 7: distance to the reference control {distance[0]:.4f}, {distance[turn]:.4f} at iteration {turn}, {distance[-1]:.4f}")
    assert 50 <= turn <= 600, "it does not turn within the search"
    figures.least("it falls by a factor of", distance[0] / distance[turn], 3)
    figures.least("and rises by a factor of", distance[-1] / distance[turn], 2)
    every = distance[::50]
    assert (np.diff(every[: turn // 50 + 1]) < 0).all() and (np.diff(every[turn // 50 + 1 :]) > 0).all(), every
    # From there on the search pays for a cheaper control by a worse motion.
    figures.least("from there on the motion's part of J grows by", motion[-1] / motion[turn], 1.2)
    figures.least("and the control's falls by", cost[turn] / cost[-1], 1.1)


def figure_8(out: Path, scratch: Path, figures: Figures) -> None:
    """"Due to the end point observation …, the difference of the result state and the desired state is roughly of the same order over
    the entire time intervall … Omitting the final time observation, … the search directions have no input close to the end time."""
    error = table(out / "steps.csv")["tracking_error"][10:]  # both start from the same rest
    print(f"Fig. 8: difference of result and desired state from {error.min():.3f} to {error.max():.3f}")
    figures.least("least / largest from t = 0.0005 on", error.min() / error.max(), 0.1)
    last = []
    for gamma in (7.5e-4, 0.0):
        signorini("optimize", SCENE, scratch, control__initial=["0", "0"], objective__gamma=gamma, optimizer__max_iterations=0,
                  output__fields=["adjoint"])  # fmt: skip
        size = np.linalg.norm(stored(scratch, "adjoint", "adjoint")[2], axis=(1, 2))
        last.append(size[-1] / size.max())
    figures.least("direction in the last step, of the largest", last[0], 0.01)
    figures.least("times that without observation of the end", last[0] / last[1], 10)


def figure_9(out: Path, figures: Figures) -> None:
    """"the contact forces are symmetric, as the problem is symmetric itself"; oscillatory."""
    x, pressure = pressures(out)
    print(f"Fig. 9: pressures at t = 0.00175, MN/m²: {', '.join(f'{p / 1e6:.1f}' for p in pressure[pressure > 0])}")
    assert np.allclose(x, -x[::-1], rtol=0, atol=1e-6), "the candidates are not symmetric"
    left, right = pressure[x < -1e-6].sum(), pressure[x > 1e-6].sum()
    figures.show("left / right of the axis", left / right, 1, 0.1)
    figures.show("largest difference of mirrored nodes", abs(pressure - pressure[::-1]).max() / pressure.max(), 0, 0.2)
    figures.least("pressures oscillate by", oscillation(pressure), 0.1)


def main() -> int:
    figures = Figures()
    with tempfile.TemporaryDirectory() as folder:
        reference(Path(folder) / "reference", figures)
        out = Path(folder) / "out"
        search(out, figures)
        history = table(out / "history.csv")
        assert json.loads((out / "run.json").read_text())["stop_reason"] == "iteration limit" and len(history["objective"]) == ITERATIONS + 1
        figure_5(out, figures, history)
        figure_6(figures, history)
        figure_7(figures, history)
        figure_8(out, Path(folder) / "scratch", figures)
        figure_9(out, figures)
    return 1 if figures.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
