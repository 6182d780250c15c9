# SPDX-License-Identifier: GPL-3.0-or-later
"""The half disc under the control (0, -1), stepped as docs/method.md says, with GetFEM's nodal contact brick.

usage: half_disc_getfem.py MESH OUTPUT TOP CONTACT
  MESH           .msh, format 2.2
  OUTPUT         in numpy's format: the nodes' coordinates, then their displacements at every time, each as (x, y) pairs
  TOP, CONTACT   the numbers of these physical groups in MESH
Prints the step loop's seconds and Newton steps.
"""

import sys
import time

import getfem as gf
import numpy as np

STEPS, TAU = 150, 5e-5
RHO, YOUNG, POISSON, BULK, SHEAR, SCALE, PLANE = 1, 1e8, 0.3, 1e4, 1e4, 1e6, -15.75
LAME, MU = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))

# Newton's method measures residuals of forces and gaps by one absolute number: forces in units of E are as large as gaps.
UNIT = 2 / (TAU**2 * YOUNG)
AUGMENTATION = 1.0  # of the size of the stiffness, in that unit
TOLERANCE = 1e-10


def form(mass: float, volume: float, shear: float) -> str:
    """The form ∫ mass y·w + volume tr ε(y) tr ε(w) + 2 shear ε(y):ε(w)."""
    return f"{mass!r}*y.Test_y + {volume!r}*Div_y*Div_Test_y + 2*{shear!r}*Sym(Grad_y):Sym(Grad_Test_y)"


def step_form(sign: int) -> str:
    """Of D (1) and R (-1)."""
    viscosity, stiffness = TAU / 2, sign * TAU**2 / 4
    return form(RHO, viscosity * (BULK - 2 * SHEAR / 3) + stiffness * LAME, viscosity * SHEAR + stiffness * MU)


def main() -> int:
    file, output = sys.argv[1:3]
    top, contact = (int(a) for a in sys.argv[3:5])
    gf.util_trace_level(0)
    mesh = gf.Mesh("import", "gmsh", file)
    mf = gf.MeshFem(mesh, 2)
    mf.set_classical_fem(1)
    mim = gf.MeshIm(mesh, 2)

    plain = gf.Model("real")
    plain.add_fem_variable("y", mf)
    D, R, M = (gf.asm_generic(mim, 2, f, -1, plain) for f in (step_form(1), step_form(-1), form(RHO, 0.0, 0.0)))
    load = gf.asm_generic(mim, 1, f"[0; {-SCALE * TAU**2 / 2!r}].Test_y", -1, plain)
    D.scale(UNIT)

    md = gf.Model("real")
    md.add_fem_variable("y", mf)
    md.add_explicit_matrix("y", "y", D, 1, 1)
    right_side = md.add_explicit_rhs("y", load)
    md.add_Dirichlet_condition_with_simplification("y", top)
    md.add_variable("force", len(mf.basic_dof_on_region(contact)) // 2)
    md.add_initialized_data("r", [AUGMENTATION])
    md.add_nodal_contact_with_rigid_obstacle_brick(mim, "y", "force", "r", contact, f"y - ({PLANE!r})", 2)

    y, v = np.zeros(mf.nbdof()), np.zeros(mf.nbdof())
    states, newton = [y], 0
    start = time.perf_counter()
    for _ in range(STEPS):
        md.set_private_rhs(right_side, UNIT * (R.mult(y) + TAU * M.mult(v) + load))
        steps, converged = md.solve("max_res", TOLERANCE, "max_iter", 50, "lsearch", "simplest", "lsolver", "mumps")
        if not converged:
            raise SystemExit("Newton's method did not converge")
        y0, y = y, md.variable("y")
        v = 2 / TAU * (y - y0) - v
        states.append(y)
        newton += steps
    print(time.perf_counter() - start, newton)
    with open(output, "wb") as file:
        np.save(file, np.vstack([mf.basic_dof_nodes().T[::2].ravel(), states]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
