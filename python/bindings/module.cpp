// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "base/scratch_file.h"
#include "bindings.h"
#include "io/manifest.h"
#include "session.h"
#include <nanobind/stl/string.h>

namespace nb = nanobind;
using namespace signorini;

namespace {

/// Translates the program's errors into Python's, with their messages.
void bind_errors(nb::module_& module) {
  nb::exception<UserError>(module, "SceneError", PyExc_ValueError);
  nb::exception<SolverFailure>(module, "SolverFailure", PyExc_RuntimeError);
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Interrupted&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    } catch (const OutputFailure& failure) {
      PyErr_SetString(PyExc_OSError, failure.what());
    } catch (const WriteFailure& failure) {
      PyErr_SetString(PyExc_OSError, failure.what());
    }
  });
}

} // namespace

NB_MODULE(_signorini, module) {
  // At exit libraries such as PyTorch keep objects alive, and with them those of this module.
  nanobind::set_leak_warnings(false);
  bind_errors(module);
  module.def("require_temporary_folder", require_temporary_folder);
  module.def("start", python::start);
  module.def("leave", python::leave);
  module.def("ranks", [] { return ranks(MPI_COMM_WORLD); });
  module.def("versions", io::version_line);
  python::bind_scene(module);
  python::bind_control_problem(module);
  python::bind_fit_problem(module);
  python::bind_rows(module);
}
