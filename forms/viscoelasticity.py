# SPDX-License-Identifier: GPL-3.0-or-later
"""The bilinear forms of a linearly viscoelastic body (Kelvin-Voigt), small strain, and the fields of its stress.

Notation: displacement y, velocity v, test function phi in V, the continuous vector Lagrange
functions; eps(y) = sym grad y. In two dimensions one of three models determines eps_zz, the component out of the plane:

    plane strain         eps_zz = 0; a body of depth 1 m
    plane stress         eps_zz such that sigma_zz = 0: lambda becomes 2 lambda mu/(lambda + 2 mu) in the plane, and
                         kappa - 2 eta/3 changes by the same factor; depth 1 m. This holds for all times only
                         if kappa/eta is the ratio of bulk and shear modulus, which the program requires
    axial symmetry       x is the radius r, y the axis; the third direction is that around the axis:
                         eps_zz = y_r/r, and int stands for int 2 pi r over the half section: the whole body

    L2(y, phi) = int y . phi                                                  W
    L2_surface(y, phi) = int y . phi over a surface
    m (y, phi) = int rho y . phi                                              M
    a (y, phi) = int [lambda tr eps(y) I + 2 mu eps(y)] : eps(phi)            A
    b (v, phi) = int [(kappa - 2 eta/3) tr eps(v) I + 2 eta eps(v)] : eps(phi)  B
    d = m + tau/2 b + tau^2/4 a      the symmetric, coercive operator of a step  D
    d_elastic = m + tau^2/4 a        the same for a body without viscosity
    L2_cellwise(u, phi) = int u . phi   for u constant on each cell, _surface likewise
    springs(y, phi) = int k_n (y . n)(phi . n) + k_t (y_t . phi_t) over a surface with the normal n,
                      y_t = y - (y . n) n: the foundations of A and, with dashpots for springs, of B
    m_rho, a_young, a_poisson, b_kappa, b_eta   the derivatives of m, a, b by these constants, for fits

Fields of a displacement and a velocity, constants on a cell: their values at its midpoint, which are the means over
the cell for both degrees (strains of degree 2 are linear in it; y_r/r is not). They are tensors of three dimensions
in the plane too, with the out-of-plane stress (lambda tr eps(y) + (kappa - 2 eta/3) tr eps(v)) e_z e_z.

    strain     eps(y)
    stress     sigma = lambda tr eps(y) I + 2 mu eps(y) + (kappa - 2 eta/3) tr eps(v) I + 2 eta eps(v)
    von_mises  sqrt(3/2 dev sigma : dev sigma)

The measure dx(1) stands for the cells of one material or part, ds(1) for the facets of one surface, which are given
when a form is assembled. (Plain ufl.dx would be all cells, once for every material; the program refuses it.)

The build compiles this page for every cell, degree and model in forms/CMakeLists.txt (signorini_add_forms), and again
whenever it is edited. cpp/fem/compiled_forms.cpp uses the names of the forms and of the constants.
"""

import basix.ufl
import ufl


def forms(cell: str, degree: int, model: str = "plane_strain") -> dict[str, object]:
    """The forms and fields on `cell` ("triangle", "tetrahedron") for Lagrange functions of `degree`; in two dimensions
    by `model`: "plane_strain", "plane_stress" or "axisymmetric"."""
    dim = {"triangle": 2, "tetrahedron": 3}[cell]
    domain = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
    V = ufl.FunctionSpace(domain, basix.ufl.element("Lagrange", cell, degree, shape=(dim,)))
    U = ufl.FunctionSpace(domain, basix.ufl.element("Discontinuous Lagrange", cell, 0, shape=(dim,)))
    y, phi, u = ufl.TrialFunction(V), ufl.TestFunction(V), ufl.TrialFunction(U)

    rho = ufl.Constant(domain)  # density, kg/m^3
    young = ufl.Constant(domain)  # Young's modulus E, Pa
    poisson = ufl.Constant(domain)  # Poisson's ratio nu
    kappa = ufl.Constant(domain)  # bulk viscosity, Pa s
    eta = ufl.Constant(domain)  # shear viscosity, Pa s
    tau = ufl.Constant(domain)  # time step, s
    k_normal = ufl.Constant(domain)  # springs along the normal, N/m^3; dashpots, N s/m^3
    k_tangential = ufl.Constant(domain)  # springs across the normal, the same units

    # Cells and facets that are given at assembly, and the depth of the body there.
    r = ufl.SpatialCoordinate(domain)[0]
    if model == "axisymmetric":
        exact = {"quadrature_degree": 2 * degree + 2}  # for all terms without 1/r; points are inside the cells, r > 0
        depth, dx, ds = 2 * ufl.pi * r, ufl.dx(1, metadata=exact), ufl.ds(1, metadata=exact)
    else:
        depth, dx, ds = 1, ufl.dx(1), ufl.ds(1)

    density, E, nu, bulk, shear = (ufl.variable(constant) for constant in (rho, young, poisson, kappa, eta))
    lmbda = E * nu / ((1 + nu) * (1 - 2 * nu))
    mu = E / (2 * (1 + nu))
    # The out-of-plane strain of plane stress reduces the first modulus, lambda or kappa - 2 eta/3, by this factor.
    in_plane = (1 - 2 * nu) / (1 - nu) if model == "plane_stress" else 1

    def in_space(w):
        e = ufl.sym(ufl.grad(w))
        across = {"plane_strain": 0, "plane_stress": -nu / (1 - nu) * ufl.tr(e), "axisymmetric": w[0] / r}
        e_zz = across[model] if dim == 2 else e[2, 2]
        return ufl.as_tensor([[e[i, j] if max(i, j) < dim else e_zz if i == j else 0 for j in range(3)] for i in range(3)])

    def eps(w):
        return in_space(w) if model == "axisymmetric" else ufl.sym(ufl.grad(w))

    def isotropic(first, second, e):
        return first * ufl.tr(e) * ufl.Identity(e.ufl_shape[0]) + 2 * second * e

    L2 = depth * ufl.inner(y, phi) * dx
    L2_surface = depth * ufl.inner(y, phi) * ds
    L2_cellwise = depth * ufl.inner(u, phi) * dx
    L2_cellwise_surface = depth * ufl.inner(u, phi) * ds
    n = ufl.FacetNormal(domain)
    along = ufl.inner(y, n) * ufl.inner(phi, n)
    springs = depth * (k_normal * along + k_tangential * (ufl.inner(y, phi) - along)) * ds
    inertia = depth * (density * ufl.inner(y, phi))
    elasticity = depth * ufl.inner(isotropic(in_plane * lmbda, mu, eps(y)), eps(phi))
    viscosity = depth * ufl.inner(isotropic(in_plane * (bulk - 2 * shear / 3), shear, eps(y)), eps(phi))
    m, a, b = inertia * dx, elasticity * dx, viscosity * dx
    d_elastic = m + tau**2 / 4 * a
    d = d_elastic + tau / 2 * b

    m_rho = ufl.diff(inertia, density) * dx
    a_young, a_poisson = ufl.diff(elasticity, E) * dx, ufl.diff(elasticity, nu) * dx
    b_kappa, b_eta = ufl.diff(viscosity, bulk) * dx, ufl.diff(viscosity, shear) * dx

    displacement, velocity = ufl.Coefficient(V), ufl.Coefficient(V)

    strain = in_space(displacement)
    stress = isotropic(lmbda, mu, strain) + isotropic(bulk - 2 * shear / 3, shear, in_space(velocity))
    von_mises = ufl.sqrt(1.5 * ufl.inner(ufl.dev(stress), ufl.dev(stress)))
    midpoint = basix.geometry(basix.CellType[cell]).mean(axis=0, keepdims=True)

    return dict(rho=rho, young=young, poisson=poisson, kappa=kappa, eta=eta, tau=tau,
                k_normal=k_normal, k_tangential=k_tangential,
                L2=L2, L2_surface=L2_surface, L2_cellwise=L2_cellwise,
                L2_cellwise_surface=L2_cellwise_surface, springs=springs, m=m, a=a, b=b, d=d, d_elastic=d_elastic,
                m_rho=m_rho, a_young=a_young, a_poisson=a_poisson, b_kappa=b_kappa, b_eta=b_eta,
                forms=[L2, L2_surface, L2_cellwise, L2_cellwise_surface, springs, m, a, b, d, d_elastic,
                       m_rho, a_young, a_poisson, b_kappa, b_eta],
                displacement=displacement, velocity=velocity, strain=strain, stress=stress, von_mises=von_mises,
                expressions=[(field, midpoint) for field in (strain, stress, von_mises)])  # fmt: skip
