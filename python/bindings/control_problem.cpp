// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/riesz.h"
#include "reduced.h"
#include <fmt/format.h>
#include <limits>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace nb = nanobind;

namespace signorini::python {
namespace {

/// Bounds of every value, absent where there is none.
std::optional<Array> bound(const Reduced& self, bool given, double beyond) {
  if (!given)
    return std::nullopt;
  return array_of(alone([&] {
    Control u = self.controls().constant(beyond);
    self.controls().project(u);
    return u;
  }));
}

std::vector<double> of_intervals(const control::ControlSpace& controls,
                                 double (control::ControlSpace::*number)(int j) const) {
  std::vector<double> numbers;
  for (int j = 1; j <= controls.count(); ++j)
    numbers.push_back((controls.*number)(j));
  return numbers;
}

/// Makes an array (n × dim) of points with three coordinates (n × 3).
Array points(const std::vector<double>& all, int dim) {
  const std::size_t n = all.size() / 3, d = static_cast<std::size_t>(dim);
  std::vector<double> own;
  for (std::size_t i = 0; i < n; ++i)
    own.insert(own.end(), all.begin() + static_cast<std::ptrdiff_t>(3 * i),
               all.begin() + static_cast<std::ptrdiff_t>(3 * i + d));
  return array_of(std::move(own), {n, d});
}

nb::dict timings(const Reduced& self) {
  nb::dict phases;
  const auto entries = alone([&] { return self.modules().timers.entries(); });
  for (const auto& [phase, entry] : entries)
    phases[phase.c_str()] = nb::make_tuple(entry.seconds, entry.calls);
  return phases;
}

void bind_places(nb::class_<Reduced>& bound_class) {
  bound_class.def_prop_ro("intervals", [](const Reduced& self) { return self.controls().count(); })
      .def_prop_ro("width", [](const Reduced& self) { return self.controls().size(); })
      .def_prop_ro("steps", [](const Reduced& self) { return self.modules().steps(); })
      .def("step_times",
           [](const Reduced& self) {
             std::vector<double> times;
             for (int k = 0; k <= self.modules().steps(); ++k)
               times.push_back(self.modules().grid.time(k));
             return array_of(std::move(times));
           })
      .def("times",
           [](const Reduced& self) {
             return array_of(of_intervals(self.controls(), &control::ControlSpace::middle));
           })
      .def("lengths",
           [](const Reduced& self) {
             return array_of(of_intervals(self.controls(), &control::ControlSpace::length));
           })
      .def("points",
           [](const Reduced& self) { return points(self.controls().points(), self.modules().space.dim()); })
      .def("nodes",
           [](const Reduced& self) {
             return points(self.modules().space.points(), self.modules().space.dim());
           })
      .def_prop_ro("components", [](const Reduced& self) { return self.controls().components(); })
      .def("lower",
           [](const Reduced& self) {
             return bound(self, self.modules().scene.control->lower.has_value(),
                          -std::numeric_limits<double>::infinity());
           })
      .def("upper", [](const Reduced& self) {
        return bound(self, self.modules().scene.control->upper.has_value(),
                     std::numeric_limits<double>::infinity());
      });
}

void bind_metric(nb::class_<Reduced>& bound_class) {
  bound_class
      .def("inner",
           [](const Reduced& self, const Given& u, const Given& w) {
             return alone(
                 [&, a = self.control(u), b = self.control(w)] { return self.controls().inner(a, b); });
           })
      .def("dual",
           [](const Reduced& self, const Given& u) {
             return array_of(alone([&, a = self.control(u)] { return self.controls().dual(a); }));
           })
      .def("riesz",
           [](const Reduced& self, const Given& d) {
             return array_of(alone(
                 [&, a = self.control(d)] { return control::riesz_representative(self.controls(), a); }));
           })
      .def_prop_ro("diagonal", [](const Reduced& self) { return self.controls().diagonal(); })
      .def("weights", [](const Reduced& self) {
        return array_of(alone([&] { return self.controls().diagonal_weights(); }));
      });
}

} // namespace

void bind_control_problem(nb::module_& module) {
  nb::class_<Reduced> bound_class(module, "ControlProblem");
  bound_class.def(nb::init<Scene&>())
      .def("zero", [](const Reduced& self) { return array_of(self.controls().zero()); })
      .def("first_guess", [](const Reduced& self) { return array_of(self.first_guess()); })
      .def("value", &Reduced::value, nb::arg("u"), nb::arg("order") = nb::none())
      .def("value_and_derivative", &Reduced::value_and_derivative, nb::arg("u"),
           nb::arg("order") = nb::none())
      .def("batch", &Reduced::batch, nb::arg("controls"), nb::arg("derivatives"))
      .def("representative", &Reduced::representative)
      .def("hessian_product", &Reduced::hessian_product, nb::arg("u"), nb::arg("d"),
           nb::arg("order") = nb::none())
      .def("parts", &Reduced::parts)
      .def("displacements", &Reduced::displacements)
      .def("active", &Reduced::active)
      .def("sweeps",
           [](const Reduced& self) {
             const control::ReducedProblem::Sweeps sweeps = alone([&] { return self.reduced().sweeps(); });
             return std::pair(sweeps.forward, sweeps.adjoint);
           })
      .def_prop_ro("seconds", [](const Reduced& self) { return alone([&] { return self.seconds(); }); })
      .def("timings", timings);
  bind_places(bound_class);
  bind_metric(bound_class);
}

} // namespace signorini::python
