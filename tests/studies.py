# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of studies share."""

import subprocess
from pathlib import Path

from harness import SIGNORINI, SOURCE, captured, table

DATA = SOURCE / "tests" / "data"
IMPACT = SOURCE / "scenes" / "bar-impact.toml"


def study(scene: Path, out: Path | None, *options: object, ranks: int = 1, status: int = 0) -> subprocess.CompletedProcess:
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [str(SIGNORINI), "study", str(scene), *(["--out", str(out)] if out else []), *map(str, options)]
    done = captured(command, timeout=300)  # where none takes minutes
    assert done.returncode == status, done.stdout + done.stderr
    return done


PATCH = """
[mesh]
file = "{mesh}"
size = {size}
[time]
end = 10.0
step = 0.02
[material]
density = 1.0
young = 50.0
poisson = 0.0
viscosity = {{ bulk = 1.6666666666666667, shear = 2.5 }}   # the elastic moduli times 0.1 s
[[clamp]]
on = "top"
value = {value}
[contact]
on = "bottom"
obstacle = {{ shape = "half-space", point = {point}, normal = {normal} }}
[exact]
pressure = "2.5"   # 50 N/m2 times 0.1 m - 0.05 m over a height of 1 m
"""


def pressure(folder: Path, ranks: int = 1) -> None:
    """Uniform strain is in the space of every mesh, and so a uniform pressure must come out on each, of both degrees. The slowest
    motion, a quarter wave of shear, dies as exp(-3.1/s t) and leaves 1e-12 of it; see tests/verification/hard/discs.py."""
    moved = '"t < 1 ? -0.1 * sin(pi*t/2)^2 : -0.1"'
    for name, mesh, zeros in (("plane", "square.geo", 1), ("space", "cube.geo", 2)):
        scene = folder / f"patch-{name}.toml"
        zero = ", ".join(['"0"'] * zeros)
        scene.write_text(PATCH.format(mesh=DATA / mesh, size=0.5, value=f"[{zero}, {moved}]", point=[0] * zeros + [-0.05],
                                      normal=[0] * zeros + [1]))  # fmt: skip
        out = folder / f"patch-{name}-{ranks}"
        study(scene, out, "--sizes", "0.5", "--steps", "0.02", "--degrees", "1,2", "--quantity", "pressure", ranks=ranks)
        rows = table(out / "study.csv")
        print(f"uniform pressure, {name}, {ranks} ranks: off by", *(f"{error:.0e}" for error in rows["pressure_error"]))
        assert sorted(rows["degree"]) == [1, 2] and max(rows["pressure_error"]) < 1e-10  # 500 steps, each to about 1e-14 of the stiffest
