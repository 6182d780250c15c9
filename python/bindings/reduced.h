// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "arrays.h"
#include "bindings.h"
#include "drivers/search.h"
#include "problem/motion_block.h"
#include "problem/scenarios.h"
#include "rows.h"
#include "scene.h"
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace signorini::python {
using control::Control;

/// J of a scene's control, its derivatives, and the motions of the last two controls. A derivative is that by
/// the entries of u; the optimizer's product turns it into a control.
class Reduced final : public Open {
  struct Modules {
    explicit Modules(Scene& from)
        : scene(from.scene()), modules(from.discretisation(), scene, problem::search_needs(scene), timers),
          problem(with_steps(modules, silent), silent), batch(modules, problem) {}

    static const signorini::problem::Problem& with_steps(signorini::problem::Problem& problem,
                                                         const Console& console) {
      problem::choose_steps(problem, console);
      return problem;
    }

    scene::Scene scene;
    Timers timers;
    Console silent{false, false};
    signorini::problem::Problem modules;
    signorini::problem::ControlProblem problem;
    signorini::problem::MotionBlock batch;
  };
  /// Control whose motion the reduced problem has stored.
  struct Known {
    Control u;
    std::optional<Control> gradient{};
  };

public:
  /// Sets up the problem. Collective. Throws UserError, SolverFailure, Interrupted.
  explicit Reduced(Scene& scene)
      : all_(compute([&] {
          drivers::require_control_problem(MPI_COMM_WORLD, scene.scene(), {});
          return std::make_unique<Modules>(scene);
        })) {}
  ~Reduced() override { drop(release()); }
  std::shared_ptr<const void> release() override { return std::move(all_); }

private:
  [[nodiscard]] Modules& all() const {
    if (!all_)
      throw std::runtime_error("the problem is closed, since Python is about to end");
    return *all_;
  }

  /// Calls `sweep`, and counts its seconds.
  template <class Sweep>
  auto swept(Sweep&& sweep) {
    struct Clock {
      ~Clock() { sum += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
      double& sum;
      std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    };
    const Clock clock{seconds_};
    return sweep();
  }

  /// Returns the result of `work` once the given control is the current one; a stored motion is not
  /// recomputed.
  template <class Work>
  auto at(Control u, Work&& work) {
    return compute([&] {
      go_to(std::move(u));
      return work();
    });
  }

  void go_to(Control u) {
    std::array<int, 2> known{is(current_, u), is(trial_, u)};
    MPI_Allreduce(MPI_IN_PLACE, known.data(), 2, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (known[0])
      return;
    if (!known[1]) {
      trial_.reset(); // overwritten, even if the sweep fails
      swept([&] { reduced().simulate(u); });
      trial_.emplace(std::move(u));
    }
    reduced().accept();
    std::swap(current_, trial_);
  }

  static bool is(const std::optional<Known>& known, const Control& u) {
    if (!known)
      return false;
    const std::span<const double> a = std::as_const(known->u).values(), b = u.values();
    return a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  }

  const Control& gradient() {
    if (!current_->gradient)
      current_->gradient = reduced().gradient().u;
    return *current_->gradient;
  }

  std::unique_ptr<Modules> all_;         ///< empty once Python ends
  double seconds_ = 0;                   ///< time of the sweeps for J and its derivative
  std::optional<Known> current_, trial_; ///< the reduced problem's current point and trial

public:
  [[nodiscard]] const control::ControlSpace& controls() const { return all().problem.controls; }
  [[nodiscard]] const signorini::problem::Problem& modules() const { return all().modules; }
  [[nodiscard]] control::ReducedProblem& reduced() const { return all().problem.reduced; }
  [[nodiscard]] double seconds() const { return seconds_; }

  /// Makes a control of given values; with `order` the given ones are those of a whole control. Collective.
  /// Throws std::invalid_argument on every rank if one rank's array has another shape, nan or inf.
  [[nodiscard]] Control control(const Given& given, const Rows* order = nullptr) const {
    const std::span<const double> all = values_of(given);
    const int count = controls().count();
    std::string wrong;
    try {
      if (order)
        require_shape(given, {order->size()}, "one entry for each value of the control on all ranks");
      else
        require_shape(given, {static_cast<std::size_t>(count), controls().size()},
                      "intervals x values of this rank");
      if (!std::ranges::all_of(all, [](double x) { return std::isfinite(x); }))
        wrong = "found nan or inf; expected finite numbers";
    } catch (const std::invalid_argument& error) {
      wrong = error.what();
    }
    const int any = compute([&] {
      int anywhere = !wrong.empty();
      MPI_Allreduce(MPI_IN_PLACE, &anywhere, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
      return anywhere;
    });
    if (any)
      throw std::invalid_argument(wrong.empty() ? "the array of another rank has a wrong shape, nan or inf"
                                                : wrong);
    return {order ? order->of(all) : std::vector<double>(all.begin(), all.end()), count};
  }

  /// Makes the controls of a batch (controls × intervals × values). Collective. Throws as control().
  [[nodiscard]] std::vector<Control> several(const Given& given) const {
    const auto count = static_cast<std::size_t>(controls().count()), size = controls().size();
    const std::size_t number = given.ndim() == 3 ? given.shape(0) : 0; // another shape is refused below
    std::string wrong;
    try {
      require_shape(given, {number, count, size}, "controls x intervals x values of this rank");
    } catch (const std::invalid_argument& error) {
      wrong = error.what();
    }
    const std::span<const double> all = values_of(given);
    if (wrong.empty() && !std::ranges::all_of(all, [](double x) { return std::isfinite(x); }))
      wrong = "found nan or inf; expected finite numbers";
    std::array<int, 2> differs{!wrong.empty(), static_cast<int>(number)};
    const bool any = compute([&] {
      std::array<int, 3> most{differs[0], differs[1], -differs[1]};
      MPI_Allreduce(MPI_IN_PLACE, most.data(), 3, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
      return most[0] != 0 || most[1] != -most[2];
    });
    if (any)
      throw std::invalid_argument(
          wrong.empty()
              ? "the array of another rank has a wrong shape, another number of controls, nan or inf"
              : wrong);
    std::vector<Control> controls_of_batch;
    for (std::size_t i = 0; i < number; ++i) {
      const auto own = all.subspan(i * count * size, count * size);
      controls_of_batch.emplace_back(std::vector<double>(own.begin(), own.end()), controls().count());
    }
    return controls_of_batch;
  }

  [[nodiscard]] Control first_guess() const {
    return compute([&] { return all().problem.first_guess(all().scene); });
  }

  double value(const Given& given, const Rows* order) {
    return at(control(given, order), [&] { return reduced().value().total(); });
  }

  /// Returns J and its derivative.
  std::pair<double, Array> value_and_derivative(const Given& given, const Rows* order) {
    double value = 0;
    Control derivative = at(control(given, order), [&] {
      value = reduced().value().total();
      return swept([&] { return controls().dual(gradient()); });
    });
    return {value, array_of(std::move(derivative))};
  }

  /// J of several controls (controls × intervals × values) and, if `derivatives`, its derivatives by them.
  /// Motions are made together.
  std::pair<Array, std::optional<Array>> batch(const Given& given, bool derivatives) {
    const std::vector<Control> all = several(given);
    std::vector<double> values(all.size()), entries;
    std::vector<Control> found(derivatives ? all.size() : 0, controls().zero());
    (void)compute([&] {
      if (!all_->batch.unites())
        trial_.reset();
      all_->batch.run(all, [&](std::size_t i, control::ReducedProblem& reduced) {
        reduced.simulate(all[i]);
        values[i] = reduced.trial_value().total();
        if (derivatives)
          found[i] = controls().dual(reduced.trial_gradient().u);
      });
      return true;
    });
    Array of_values = array_of(std::move(values));
    if (!derivatives)
      return {std::move(of_values), std::nullopt};
    for (const Control& one : found)
      entries.insert(entries.end(), one.values().begin(), one.values().end());
    const auto count = static_cast<std::size_t>(controls().count());
    return {std::move(of_values), array_of(std::move(entries), {all.size(), count, controls().size()})};
  }

  /// Gradient as Riesz representative in the optimizer's product.
  Array representative(const Given& given) {
    return array_of(at(control(given), [&] { return gradient(); }));
  }

  Array hessian_product(const Given& given, const Given& direction, const Rows* order) {
    const Control d = control(direction, order);
    return array_of(
        at(control(given, order), [&] { return controls().dual(reduced().hessian_product(d).u); }));
  }

  std::tuple<double, double, double> parts(const Given& given) {
    return at(control(given), [&] {
      const control::ObjectiveValue& value = reduced().value();
      return std::tuple(value.tracking, value.terminal, value.control_cost);
    });
  }

  /// Displacements of `count` steps from the step `first` on (steps × nodes × dim), m.
  Array displacements(const Given& given, int first, int count) {
    const auto dim = static_cast<std::size_t>(modules().space.dim());
    std::vector<double> values = at(control(given), [&] {
      std::vector<double> all;
      for (int k = first; k < first + count; ++k) {
        const petsc::ReadArray y(reduced().trajectory().at(k).y());
        const auto entries = std::span<const double>(y).first(modules().space.layout().mesh_dofs());
        all.insert(all.end(), entries.begin(), entries.end());
      }
      return all;
    });
    const auto steps = static_cast<std::size_t>(count);
    return array_of(std::move(values), {steps, static_cast<std::size_t>(modules().space.owned_nodes()), dim});
  }

  /// Numbers of candidates in contact, on all ranks, after each step; step 0: the initial state.
  std::vector<std::size_t> active(const Given& given) {
    return at(control(given), [&] {
      std::vector<std::size_t> counts;
      for (const contact::ContactLinearisation& sets : reduced().trajectory().contact())
        counts.push_back(sets.active.size());
      return counts;
    });
  }
};

} // namespace signorini::python
