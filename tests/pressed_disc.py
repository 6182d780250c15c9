# SPDX-License-Identifier: GPL-3.0-or-later
"""scenes/hertz-press.toml: a half disc pressed onto a plane, at rest, and runs compared with Hertz's pressure in plane strain.

Hertz takes the disc for a half-space and its circle for a parabola, which is wrong by (a/R)², 0.7 % here. The mesh finds
the edges of the contact to within an element, and pressures near it with them: the profile is of order h/a in L2, half
its width and its peak, which answer to that only through the stresses, of order (h/a)².
"""

from pathlib import Path

import numpy as np
import pytest
from harness import SOURCE, signorini, table

RADIUS, LOAD, MODULUS = 8.0, 10.0, 200 / (1 - 0.3**2)  # m, N/m, N/m²
REST = np.exp(-10)  # what is left of a motion 10 s after the last change of the load, with the viscosity's 1 s
SIZES = (0.068, 0.034)  # m, elements in contact
MESH = SOURCE / "meshes" / "press.geo"


def hertz(load: float) -> tuple[float, float]:
    """Half-width and peak pressure."""
    half_width = 2 * np.sqrt(load * RADIUS / (np.pi * MODULUS))
    return half_width, 2 * load / (np.pi * half_width)


HERTZ = (hertz(LOAD)[0] / RADIUS) ** 2  # what Hertz leaves out


# Hertz's contact depends on the resultant only. In place of the scene's [load]: the same spread over the body, and the flat side
# moved down as far as makes about as much, by fixed places.
GROWTH = "(t < 2 ? sin(pi*t/4)^2 : 1)"
LOADS = {
    "traction": None,
    "body force": f'[load]\nbody = ["0", "-{LOAD / (np.pi * RADIUS**2 / 2)} * {GROWTH}"]\n',
    "moved clamp": f'[[clamp]]\non = "top"\nvalue = ["0", "-0.1 * {GROWTH}"]\n',
}


def scene(load: str, folder: Path) -> Path:
    """The scene with another load."""
    shipped = SOURCE / "scenes" / "hertz-press.toml"
    if not LOADS[load]:
        return shipped
    text = shipped.read_text()
    start, end = text.index("[load]"), text.index("[output]")
    other = folder / "hertz-press.toml"
    other.write_text(text[:start] + LOADS[load] + text[end:])
    return other


def mesh(size: float, folder: Path) -> Path:
    """The scene's mesh with elements of another size in contact."""
    finer = folder / f"press-{size}.geo"
    text = MESH.read_text().replace(f"fine = {SIZES[0]};", f"fine = {size};")
    assert f"fine = {size};" in text
    finer.write_text(text)
    return finer


def pressure(out: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, nodal lengths and forces at the end, the mean of the last two steps, without the group's end nodes."""
    contact = table(out / "contact.csv")
    last = contact["step"][-1]
    order = np.argsort(contact["x"][contact["step"] == last])
    x = contact["x"][contact["step"] == last][order]
    force = sum(contact["force"][contact["step"] == step][order] for step in (last - 1, last)) / 2
    assert force[0] == force[-1] == 0, "the contact reaches the ends of the candidates"
    return x[1:-1], (x[2:] - x[:-2]) / 2, force[1:-1]


def hertz_pressure(x: np.ndarray, load: float) -> np.ndarray:
    """Mean of the exact pressure that each inner node stands for, weighted with its linear shape function."""
    half_width, peak = hertz(load)
    places = np.linspace(-half_width, half_width, 100_001)
    exact = peak * np.sqrt(np.maximum(0, 1 - (places / half_width) ** 2))
    mean = np.zeros_like(x)
    for i in range(1, len(x) - 1):
        weight = np.interp(places, x[i - 1 : i + 2], [0, 1, 0], left=0, right=0)
        mean[i] = (weight * exact).sum() * (places[1] - places[0]) * 2 / (x[i + 1] - x[i - 1])
    return mean


def press(size: float, load: str, folder: Path, **overrides: object) -> float:
    """Runs the scene, checks its figures and returns the profile's relative error."""
    out = folder / "out"
    signorini("simulate", scene(load, folder), out, mesh__file=str(mesh(size, folder)), output__every=1, **overrides)
    x, length, force = pressure(out)
    assert (force > 0).sum() > 10, "hardly any contact: the case says nothing"
    p = force / length
    resultant = force.sum()
    centre = (x * force).sum() / resultant
    # The second moment of Hertz's pressure is P a² / 4.
    half_width = 2 * np.sqrt(((x - centre) ** 2 * force).sum() / resultant)
    exact_width, peak = hertz(resultant)
    exact = hertz_pressure(x, resultant)
    error = np.sqrt((length * (p - exact) ** 2).sum() / (length * exact**2).sum())
    h = size / exact_width
    print(f"{load}, elements of {size:g} m in contact, {(force > 0).sum()} nodes in contact: resultant {resultant:.5f} N/m, "
          f"half-width {half_width:.5f} of {exact_width:.5f} m, peak {p.max():.5f} of {peak:.5f} N/m² "
          f"(each ± {100 * (HERTZ + h**2):.1f} %), error of the profile {error:.5f} <= {HERTZ + h:.5f}")  # fmt: skip
    if load != "moved clamp":
        # Of a body force a part is lost between the circle and its chords, (1/8)²/6 at elements as long as R/8.
        assert resultant == pytest.approx(LOAD, rel=REST + (0 if load == "traction" else 1 / 384))
    assert half_width == pytest.approx(exact_width, rel=HERTZ + h**2)
    assert p.max() == pytest.approx(peak, rel=HERTZ + h**2)
    assert error <= HERTZ + h
    return error
