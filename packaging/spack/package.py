# SPDX-License-Identifier: GPL-3.0-or-later
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Signorini(CMakePackage):
    """Optimal control of dynamic contact with exact discrete gradients."""

    license("GPL-3.0-or-later")
    # Of a source archive that ./dev package --source made, in the folder from which Spack is called.
    url = "file://signorini-0.2.0.tar.gz"
    version("0.2.0", expand=True)

    variant("python", default=True, description="Build the Python module")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("boost")
    depends_on("cli11", type="build")
    depends_on("fenics-basix@0.9:")
    depends_on("fenics-dolfinx@0.9:0.11+petsc")
    depends_on("fmt")
    depends_on("gmsh+shared")
    depends_on("hdf5+mpi")
    depends_on("lapack")
    depends_on("mpi")
    depends_on("muparser")
    depends_on("nlohmann-json")
    depends_on("petsc+mpi~complex+mumps")
    depends_on("suite-sparse@7:")
    depends_on("tomlplusplus")
    depends_on("python@3.11:", type=("build", "run"))
    depends_on("py-fenics-ffcx@0.9:", type="build")
    depends_on("py-nanobind", type="build", when="+python")
    for package in ("py-h5py", "py-jinja2", "py-matplotlib", "py-meshio", "py-netcdf4", "py-numpy", "py-plotly"):
        depends_on(package, type="run")

    def cmake_args(self):
        return [
            self.define("BUILD_TESTING", False),
            self.define_from_variant("SIGNORINI_PYTHON", "python"),
            self.define("SIGNORINI_PYTHON_DIR", python_platlib if self.spec.satisfies("+python") else ""),
        ]
