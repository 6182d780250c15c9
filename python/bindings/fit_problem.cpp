// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"
#include "bindings.h"
#include "problem/parameter_problem.h"
#include "scene.h"
#include "scene/parameters.h"
#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace nb = nanobind;

namespace signorini::python {
namespace {

/// Least-squares problem of a scene's unknowns, by their values θ, with the residuals and derivatives at the
/// last θ cached.
class Fit final : public Open {
public:
  /// Sets up the problem. Collective. Throws UserError, Interrupted.
  explicit Fit(Scene& scene)
      : all_(compute([&] {
          if (scene.scene().unknowns.empty())
            throw UserError(
                fmt::format("{}: a fit needs tables [[unknown]] and [[measurement]], and the scene has none",
                            scene.scene().file.string()));
          return std::make_unique<Modules>(scene);
        })) {}
  ~Fit() override { drop(release()); }
  std::shared_ptr<const void> release() override { return std::move(all_); }

  [[nodiscard]] problem::ParameterProblem& problem() const { return all().problem; }
  [[nodiscard]] const scene::Scene& scene() const { return all().scene; }

  /// Returns the residuals (m).
  Array residuals(const Given& theta) {
    return compute_at(theta, [&] { return at_.residuals; });
  }

  /// Returns the derivatives ∂r_i/∂θ_j, column by column (n × m).
  Array jacobian(const Given& theta) {
    const std::size_t n = theta.size();
    std::vector<double> columns = compute([&, values = values(theta)] {
      go_to(values);
      std::vector<double> by_theta = at_.jacobian;
      const std::size_t m = at_.residuals.size();
      const std::vector<double> slopes = problem().misfit.slopes(x_);
      for (std::size_t i = 0; i < by_theta.size(); ++i)
        by_theta[i] /= slopes[i / m];
      return by_theta;
    });
    return array_of(std::move(columns), {n, at_.residuals.size()});
  }

  /// Returns the simulated values of the measured quantities (values).
  Array simulated(const Given& theta) {
    return compute_at(theta, [&] {
      std::vector<double> values;
      for (const control::Data& one : problem().misfit.data())
        for (std::size_t k = 0; k < one.times.size(); ++k)
          values.push_back(one.values[k] + one.deviations[k] * at_.residuals[values.size()]);
      return values;
    });
  }

private:
  struct Modules {
    explicit Modules(Scene& from) : scene(from.scene()), problem(from.discretisation(), scene, timers) {}

    scene::Scene scene;
    Timers timers;
    problem::ParameterProblem problem;
  };

  [[nodiscard]] Modules& all() const {
    if (!all_)
      throw std::runtime_error("the problem is closed, since Python is about to end");
    return *all_;
  }

  template <class Work>
  Array compute_at(const Given& theta, Work&& work) {
    return array_of(compute([&, values = values(theta)] {
      go_to(values);
      return work();
    }));
  }

  /// Copies θ. Throws std::invalid_argument unless it has one value of each unknown.
  [[nodiscard]] std::vector<double> values(const Given& theta) const {
    require_shape(theta, {scene().unknowns.size()}, "one value for each unknown");
    const std::span<const double> given = values_of(theta);
    return {given.begin(), given.end()};
  }

  void go_to(std::vector<double> theta) {
    // Made the same on every rank: last digits may differ.
    MPI_Bcast(theta.data(), static_cast<int>(theta.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
    if (theta == theta_)
      return;
    scene::require_possible(scene(), theta);
    theta_.clear();
    x_ = problem().misfit.on_scales(theta);
    at_ = problem().reduced.least_squares(control::Variables(x_));
    theta_ = theta;
  }

  std::unique_ptr<Modules> all_;  ///< empty once Python ends
  std::vector<double> theta_, x_; ///< values evaluated last; θ is empty before any
  optimize::LeastSquares at_;
};

/// Returns one kind of numbers of all measurements one after another.
Array data(const Fit& self, const std::vector<double> control::Data::* numbers) {
  std::vector<double> all;
  for (const control::Data& one : self.problem().misfit.data())
    all.insert(all.end(), (one.*numbers).begin(), (one.*numbers).end());
  return array_of(std::move(all));
}

} // namespace

void bind_fit_problem(nb::module_& module) {
  nb::class_<Fit>(module, "FitProblem")
      .def(nb::init<Scene&>())
      .def_prop_ro("names",
                   [](const Fit& self) {
                     std::vector<std::string> names;
                     for (const scene::Unknown& unknown : self.scene().unknowns)
                       names.push_back(unknown.name);
                     return names;
                   })
      .def("start", [](const Fit& self) { return array_of(scene::start_values(self.scene())); })
      .def("lower",
           [](const Fit& self) {
             return array_of(self.problem().misfit.values(self.problem().misfit.box().lower));
           })
      .def("upper",
           [](const Fit& self) {
             return array_of(self.problem().misfit.values(self.problem().misfit.box().upper));
           })
      .def("measurements",
           [](const Fit& self) {
             nb::list all; // name, number of values
             for (std::size_t i = 0; i < self.problem().misfit.data().size(); ++i)
               all.append(nb::make_tuple(self.scene().measurements[i].name,
                                         self.problem().misfit.data()[i].times.size()));
             return all;
           })
      .def("times", [](const Fit& self) { return data(self, &control::Data::times); })
      .def("measured", [](const Fit& self) { return data(self, &control::Data::values); })
      .def("deviations", [](const Fit& self) { return data(self, &control::Data::deviations); })
      .def("residuals", &Fit::residuals)
      .def("jacobian", &Fit::jacobian)
      .def("simulated", &Fit::simulated)
      .def("sweeps",
           [](const Fit& self) { return alone([&] { return self.problem().reduced.sweeps().forward; }); });
}

} // namespace signorini::python
