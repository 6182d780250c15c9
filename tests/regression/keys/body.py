# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of the mesh, the time steps and the material: the effect of each on a small scene is that of docs/reference/keys.md."""

from pathlib import Path

import numpy as np
import pytest
from regression.keys.runs import DATA, FLAT, FREE, ROUNDING, Run, Runner, edited, near, same


@pytest.mark.key("mesh.file")
def test_mesh_file(plain: Run, simulate: Runner) -> None:
    near(plain.steps["kinetic_energy"][0], 0.5)
    near(simulate(mesh__file=str(DATA / "parts.geo")).steps["kinetic_energy"][0], 1.0)  # two squares


@pytest.fixture
def sized(tmp_path: Path) -> Path:
    """The block with a mesh that has a size of its own."""
    own = edited(tmp_path / "own.geo", (r"(Point.*), 0\}", r"\1, 0, 0.5}"), source=DATA / "square.geo")
    return edited(tmp_path / "own.toml", (r"(?m)^file = .*", f'file = "{own.name}"'), (r"(?m)^size = .*\n", ""))


@pytest.mark.key("mesh.size")
@pytest.mark.parametrize("size, nodes", ((None, 3), (0.25, 5), (0.125, 9)))  # of the lower side
def test_mesh_size(size: float | None, nodes: int, sized: Path, simulate: Runner) -> None:
    assert simulate(sized, **({"mesh__size": size} if size else {})).manifest["candidates"] == nodes


@pytest.mark.key("mesh.scale")
@pytest.mark.parametrize("scale, nodes", ((1, 3), (0.5, 5), (0.25, 9)))  # of the lower side
def test_mesh_scale(scale: float, nodes: int, sized: Path, simulate: Runner) -> None:
    assert simulate(sized, mesh__scale=scale).manifest["candidates"] == nodes


@pytest.mark.key("mesh.split")
def test_mesh_split(simulate: Runner, tmp_path: Path) -> None:
    """The square of quadrilaterals, each of which is two triangles."""
    quads = edited(tmp_path / "quads.geo", (r"\Z", "\nMesh.Algorithm = 8; Recombine Surface{1};\n"), source=DATA / "square.geo")
    done = simulate(mesh__file=str(quads), mesh__split=True)
    near(done.manifest["body"]["extent"], [1, 1])
    assert any("elements are divided into triangles" in note for note in done.manifest["body"]["notes"])
    near(done.steps["kinetic_energy"][0], 0.5)


@pytest.mark.key("mesh.unit")
@pytest.mark.parametrize("unit, length", (("m", 1), ("mm", 1e-3)))
def test_mesh_unit(unit: str, length: float, simulate: Runner) -> None:
    done = simulate(mesh__unit=unit, mesh__size=0.25 * length, time__step=0.02 * length, time__end=0.02 * length)
    near(done.manifest["body"]["extent"], [length, length])
    near(done.steps["kinetic_energy"][0], length**2 / 2)
    assert done.manifest["candidates"] == 5


@pytest.mark.key("mesh.unit")
def test_mesh_of_a_metre_in_millimetres(simulate: Runner, tmp_path: Path) -> None:
    large = edited(tmp_path / "large.geo", (r"= \{(\d), (\d), 0\}", r"= {1000*\1, 1000*\2, 0}"), source=DATA / "square.geo")
    done = simulate(mesh__file=str(large), mesh__unit="mm")
    near(done.steps["kinetic_energy"][0], 0.5)
    assert done.manifest["candidates"] == 5 and done.manifest["body"]["doubts"] == []


@pytest.mark.key("mesh.degree")
def test_mesh_degree(plain: Run, simulate: Runner) -> None:
    one, two = plain.manifest, simulate(mesh__degree=2).manifest
    vertices, cells = one["unknowns"] // 2, one["cells"]
    edges = vertices + cells - 1  # Euler
    assert two["cells"] == cells and two["unknowns"] == 2 * (vertices + edges)


YOUNG, POISSON, SHEAR = 50.0, 0.3, 0.05  # of the block: moduli, and viscosity
MU, LAMBDA = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
RATIO = (LAMBDA + 2 * MU / 3) / MU  # K/G, which the viscosities must have in plane stress
PLANE_WAVE = LAMBDA + 2 * MU
PLATE = YOUNG / (1 - POISSON**2)
MODELS = ("plane-strain", "plane-stress", "axisymmetric")


def free(model: str, **more: object) -> dict[str, object]:
    """The block far from a flat floor, by a model of the plane."""
    return {"mesh__model": model, "material__viscosity": {"bulk": RATIO * SHEAR, "shear": SHEAR}} | FLAT | FREE | more


@pytest.mark.key("mesh.model")
@pytest.mark.parametrize("model, size", zip(MODELS, (1, 1, np.pi)))
def test_mass_of_a_model(model: str, size: float, simulate: Runner) -> None:
    """The square is a slice or a plate 1 m thick, or a cylinder of the radius 1 m."""
    done = simulate(**free(model, initial__velocity=["0", "-1"]))
    near(done.steps["kinetic_energy"][0], size / 2)
    near(done.manifest["body"]["mass"], size)
    assert done.manifest["body"]["model"] == model
    assert (" kg/m;" in done.stdout) == (model != "axisymmetric") and " kg" in done.stdout


@pytest.mark.key("mesh.model")
@pytest.mark.parametrize("model, displacement, energy", (
    pytest.param("plane-strain", ["0", "0.1*y"], PLANE_WAVE / 2, id="plane strain"),
    pytest.param("plane-stress", ["0", "0.1*y"], PLATE / 2, id="plane stress"),
    pytest.param("plane-stress", ["-0.03*x", "0.1*y"], YOUNG / 2, id="plane stress, pulled along y only"),
    pytest.param("axisymmetric", ["0", "0.1*y"], np.pi * PLANE_WAVE / 2, id="axial symmetry, along the axis"),
    pytest.param("axisymmetric", ["0.1*x", "0"], np.pi * (2 * LAMBDA + 2 * MU), id="axial symmetry, across the axis"),
))  # fmt: skip
def test_strains_of_a_model(model: str, displacement: list[str], energy: float, simulate: Runner) -> None:
    done = simulate(**free(model, initial__displacement=displacement))
    near(done.steps["elastic_energy"][0], energy * 0.1**2)
    near(done.manifest["body"]["pressure_waves"], np.full(2, np.sqrt(PLATE if model == "plane-stress" else PLANE_WAVE)))


@pytest.mark.key("mesh.model")
def test_plane_strain_is_the_default(plain: Run, simulate: Runner) -> None:
    same(plain, simulate(mesh__model="plane-strain"))
    assert plain.manifest["body"]["model"] == "plane-strain"


@pytest.mark.key("time.end")
def test_time_end(plain: Run, simulate: Runner) -> None:
    half = simulate(time__end=0.3)
    assert len(plain.steps["time"]) == 31 and len(half.steps["time"]) == 16
    near(half.steps["kinetic_energy"], plain.steps["kinetic_energy"][:16], 0)


@pytest.mark.key("time.step")
@pytest.mark.parametrize("step, times", ((0.01, 61), (0.1, 7)))
def test_time_step(step: float, times: int, simulate: Runner) -> None:
    near(simulate(time__step=step).steps["time"], step * np.arange(times))


def varying(**more: object) -> dict[str, object]:
    """The block thrown back by the floor, in steps whose lengths the motion chooses."""
    time = {"end": 12, "step": "auto", "tolerance": 1e-2} | more
    return FLAT | {"contact__obstacle__point": [0, -1], "load__body": ["0", "0"], "time": time}


def lengths(done: Run) -> np.ndarray:
    return np.diff(done.steps["time"])


@pytest.mark.key("time.tolerance")
def test_time_tolerance(simulate: Runner) -> None:
    loose, usual, tight = (simulate(**varying(tolerance=tolerance)) for tolerance in (0.3, 1e-2, 1e-3))
    assert len(lengths(loose)) < len(lengths(usual)) < len(lengths(tight))
    near(usual.steps["time"][-1:], np.array([12.0]), 0)


@pytest.mark.key("time.longest", "time.shortest")
def test_bounds_of_steps(simulate: Runner) -> None:
    bounded = lengths(simulate(**varying(longest=0.2, shortest=0.0125)))
    assert abs(bounded.max() - 0.2) < 1e-12 and abs(bounded.min() - 0.0125) < 1e-12


@pytest.mark.key("time.quantity")
def test_time_quantity(simulate: Runner) -> None:
    runs = [simulate(**varying(tolerance=0.3, quantity=quantity)) for quantity in ("displacement", "contact-force", "energy")]
    assert len({len(lengths(done)) for done in runs}) == 3


@pytest.mark.key("time.scheme")
def test_schemes_agree_in_flight(simulate: Runner) -> None:
    flying = [simulate(time__scheme=scheme, **FREE | {"initial__velocity": ["x", "y"]}) for scheme in
              ("contact-implicit", "contact-stabilized")]  # fmt: skip
    same(*flying, ROUNDING)


@pytest.mark.key("time.scheme")
def test_schemes_differ_from_the_first_contact(plain: Run, simulate: Runner) -> None:
    stabilized = simulate(time__scheme="contact-stabilized")
    touch = np.flatnonzero(plain.steps["active"])[0]
    for name in ("kinetic_energy", "elastic_energy"):
        near(stabilized.steps[name][:touch], plain.steps[name][:touch])
        assert abs(stabilized.steps[name] - plain.steps[name]).max() > 1e-3
    assert [done.manifest["counters"]["VI solvers"] for done in (plain, stabilized)] == [1, 2], "the predictor has its own"


@pytest.mark.key("material.density")
def test_density(simulate: Runner) -> None:
    near(simulate(material__density=3.0).steps["kinetic_energy"][0], 1.5)


@pytest.mark.key("material.young", "material.poisson")
@pytest.mark.parametrize("young, poisson", ((50.0, 0.3), (80.0, 0.3), (50.0, -0.2)))
def test_elasticity(young: float, poisson: float, simulate: Runner) -> None:
    modulus = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    found = simulate(material__young=young, material__poisson=poisson, **FREE | {"initial__displacement": ["0", "0.1*y"]})
    near(found.steps["elastic_energy"][0], modulus / 2 * 0.1**2)


@pytest.mark.key("material.viscosity.bulk", "material.viscosity.shear")
@pytest.mark.parametrize("velocity, bulk, shear, power", (
    pytest.param(["x", "y"], 0.07, 0, 4 * 0.07, id="swells: bulk (div v)²"),
    pytest.param(["x", "y"], 0.07, 0.03, 4 * (0.07 + 0.03 / 3), id="swells, nothing along z"),
    pytest.param(["y", "0"], 0.07, 0.03, 0.03, id="shears"),
))  # fmt: skip
def test_viscosity(velocity: list[str], bulk: float, shear: float, power: float, simulate: Runner) -> None:
    step = 1e-8  # so short that the velocity is still the initial one, but for 1e-6 of it
    done = simulate(material__viscosity={"bulk": bulk, "shear": shear}, time__step=step, time__end=step,
                    **FREE | {"initial__velocity": velocity})  # fmt: skip
    near(done.steps["viscous_dissipation"][1] / step, power, 1e-5)


@pytest.mark.key("material.viscosity.bulk", "material.viscosity.shear")
def test_without_viscosity(simulate: Runner, tmp_path: Path) -> None:
    elastic = simulate(edited(tmp_path / "elastic.toml", (r"(?m)^viscosity.*\n", "")))
    assert (elastic.steps["viscous_dissipation"] == 0).all()


@pytest.mark.key("material.viscosity.bulk", "material.viscosity.shear")
def test_dissipation_begins_with_contact(plain: Run) -> None:
    """In flight nothing strains, and what is left is rounding, of either sign."""
    lost, touched = plain.steps["viscous_dissipation"], np.argmax(plain.steps["active"] > 0)
    assert touched > 1 and (lost[touched:] > 0).all() and np.max(abs(lost[:touched])) < 1e-14 * np.max(lost)


@pytest.mark.key("material.on")
@pytest.mark.parametrize("groups, energy", ((("left", "right"), (3 / 3 + 7 / 3) / 2), (("right", "left"), (3 * 7 / 3 + 1 / 3) / 2)))
def test_material_on(groups: tuple[str, str], energy: float, simulate: Runner) -> None:
    """Kinetic energy where the first group, 0 < x < 1 if "left", has density 3 and the rest 1."""
    done = simulate(DATA / "two-materials.toml", material__0__on=groups[0], material__1__on=groups[1], initial__velocity=["0", "-x"])
    near(done.steps["kinetic_energy"][0], energy)
