// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <nanobind/nanobind.h>

/// Parts of the module: each function adds classes, which those of the Python package wrap and document.
namespace signorini::python {

void bind_scene(nanobind::module_& module);
void bind_control_problem(nanobind::module_& module);
void bind_fit_problem(nanobind::module_& module);
void bind_rows(nanobind::module_& module);

} // namespace signorini::python
