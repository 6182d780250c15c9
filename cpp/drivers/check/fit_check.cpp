// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/check/fit_check.h"
#include "base/error.h"
#include "base/log_slope.h"
#include "diagnostics/warnings.h"
#include "drivers/check/switches.h"
#include "drivers/fit_outcome.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

namespace signorini::drivers {
namespace {

class FitCheck {
public:
  FitCheck(problem::ParameterProblem& problem, double solver_tolerance, const Console& console)
      : problem_(problem), reduced_(problem.reduced), console_(console), x_(problem.misfit.start()),
        here_(reduced_.value(control::Variables(x_))),
        rounding_(1000 * std::numeric_limits<double>::epsilon() + 10 * solver_tolerance) {
    reduced_.accept();
    by_x_ = reduced_.gradient_by_parameters();
  }

  void run(std::vector<CheckRow>& rows) {
    const optimize::LeastSquares linearised = reduced_.least_squares(control::Variables(x_));
    const std::vector<double> g = linearised.gradient();
    const std::size_t m = linearised.residuals.size();
    const double size = std::sqrt(2 * linearised.value());
    double worst = 0;
    for (std::size_t j = 0; j < x_.size(); ++j) {
      lengths_.push_back(std::sqrt(std::inner_product(
          &linearised.jacobian[j * m], &linearised.jacobian[j * m] + m, &linearised.jacobian[j * m], 0.0)));
      if (size * lengths_[j] > 0)
        worst = std::max(worst, std::abs(by_x_[j] - g[j]) / (size * lengths_[j]));
    }
    measure_noise(linearised);
    rows.push_back(below("gradient: adjoint sweep against linearised motions", worst, sweeps_leave()));
    if (const int weak = kinks(reduced_.trajectory().contact()); weak > 0)
      console_.line(
          fmt::format("Contact is weak, closed without force or about to slip, {} times (candidates × "
                      "steps). J may have a kink at the first guess.",
                      weak));
    for (std::size_t j = 0; j < x_.size(); ++j) {
      jacobian(j, linearised.residuals, {&linearised.jacobian[j * m], m}, rows);
      taylor(j, rows);
    }
    const optimize::Identified known = optimize::identified(linearised.normal_matrix(), x_.size());
    for (const std::vector<double>& direction : known.unidentified)
      console_.line(unidentified(problem_.scene.unknowns, direction));
  }

private:
  /// Admissible relative difference between the two gradients, from rounding and solvers. Solvers control the
  /// energy norm of motions. Forces are residuals and less accurate, by the root of the condition number,
  /// about ten.
  [[nodiscard]] double sweeps_leave() const {
    constexpr double forces = 10;
    return forces *
           std::max(std::sqrt(static_cast<double>(problem_.scene.time.steps)) * rounding_, relative_noise_);
  }

  /// Measures the rounding of residuals by changes of the unknowns that are too small for an effect of their
  /// own: each motion has its own factor, and stiff materials lose more digits.
  void measure_noise(const optimize::LeastSquares& here) {
    constexpr double tiny = 1e-13; // of the unit of an unknown
    const std::size_t m = here.residuals.size();
    for (std::size_t j = 0; j < x_.size(); ++j)
      for (const double change : {tiny * unit(j), -tiny * unit(j)})
        if (const std::optional<Trial> trial = at(j, change)) {
          double off = 0;
          for (std::size_t k = 0; k < m; ++k)
            off =
                std::hypot(off, trial->residuals[k] - here.residuals[k] - change * here.jacobian[j * m + k]);
          noise_ = std::max(noise_, off);
        }
    double data = 0;
    for (const control::Data& one : problem_.misfit.data())
      for (std::size_t k = 0; k < one.values.size(); ++k)
        data = std::hypot(data, one.values[k] / one.deviations[k]);
    const double size = std::sqrt(2 * here_) + data;
    relative_noise_ = size > 0 ? noise_ / size : 0;
  }

  /// Change of unknown j that changes the simulated values by about as much as they differ from the data.
  [[nodiscard]] double unit(std::size_t j) const {
    const double moves = lengths_[j] > 0 ? std::max(std::sqrt(2 * here_), 1.0) / lengths_[j] : 1;
    return problem_.scene.unknowns[j].logarithmic() ? std::min(moves, 1.0) : moves;
  }

  struct Trial {
    double value;
    std::vector<double> residuals;
    bool kept; ///< whether the active sets are unchanged
  };
  /// Evaluates J with unknown j changed by `change`; absent beyond the bounds, where the scene is invalid (as
  /// with a node inside an obstacle), and where a step has no solution.
  [[nodiscard]] std::optional<Trial> at(std::size_t j, double change) const {
    std::vector<double> x = x_;
    x[j] += change;
    if (x[j] < problem_.misfit.box().lower[j] || x[j] > problem_.misfit.box().upper[j])
      return std::nullopt;
    try {
      const double value = reduced_.value(control::Variables(x));
      return Trial{value, reduced_.trial_residuals(),
                   switches(reduced_.trajectory().contact(), reduced_.trial_contact()).steps == 0};
    } catch (const SolverFailure&) {
      return std::nullopt;
    }
  }

  /// Two changes of an unknown for a difference of second order: opposite ones or, at a bound, two to one
  /// side.
  struct Changes {
    double p, q;

    /// Returns the slope at 0 of the parabola through the values at 0, p and q.
    [[nodiscard]] double slope(double at_0, double at_p, double at_q) const {
      return q / (p * (q - p)) * (at_p - at_0) - p / (q * (q - p)) * (at_q - at_0);
    }
  };
  [[nodiscard]] Changes changes(std::size_t j, double size) const {
    const auto& box = problem_.misfit.box();
    return {x_[j] + size > box.upper[j] ? -2 * size : size, x_[j] - size < box.lower[j] ? 2 * size : -size};
  }

  /// Compares a column of the Jacobian with differences of second order, central ones or, at a bound, to one
  /// side: the best agreement among differences of several sizes that keep the active sets. `here`: residuals
  /// at x_.
  void jacobian(std::size_t j, std::span<const double> here, std::span<const double> column,
                std::vector<CheckRow>& rows) const {
    const std::string name =
        fmt::format("d(values)/d({}) against differences", problem_.scene.unknowns[j].name);
    constexpr double differences = 1e-6, useful = 1e-4; // of second order; limits
    double least = std::numeric_limits<double>::infinity(), admitted = differences;
    for (int i = 0; i < 8; ++i) {
      const double epsilon = unit(j) * std::pow(10, -3.5 - 0.5 * i);
      const Changes changed = changes(j, epsilon);
      const std::optional<Trial> first = at(j, changed.p), second = at(j, changed.q);
      if (!first || !second || !first->kept || !second->kept)
        continue;
      double off = 0;
      for (std::size_t k = 0; k < column.size(); ++k)
        off = std::hypot(off, changed.slope(here[k], first->residuals[k], second->residuals[k]) - column[k]);
      const double relative = lengths_[j] > 0 ? off / lengths_[j] : off;
      if (relative < least) {
        constexpr double clear = 3;
        const double rounding = lengths_[j] > 0 ? clear * noise_ / (epsilon * lengths_[j]) : 0;
        least = relative, admitted = std::clamp(rounding, differences, useful);
      }
      if (constexpr double clear = 1e-7; least < clear)
        break;
    }
    rows.push_back(std::isfinite(least) ? below(name, least, admitted)
                                        : CheckRow{name, "active sets change for every difference tried",
                                                   "one with unchanged sets", false});
  }

  void taylor(std::size_t j, std::vector<CheckRow>& rows) const {
    constexpr double clear = 200; // J's rounding is more than an evaluation's: each has a factor of its own
    constexpr double noisy = 20;  // as much, of the noise that was measured
    const std::string& name = problem_.scene.unknowns[j].name;
    const double of_noise = std::sqrt(2 * here_) * noise_,
                 floor = std::max(clear * rounding_ * std::max(here_, 1e-6), noisy * of_noise);
    std::vector<std::pair<double, double>> usable;
    double widest = 0;
    for (int i = 0; i < 14; ++i) {
      const double epsilon = unit(j) * std::pow(10, -1 - 0.5 * i);
      const std::optional<Trial> trial = at(j, epsilon);
      if (!trial || !trial->kept)
        continue;
      widest = std::max(widest, epsilon);
      const double remainder = std::abs(trial->value - here_ - epsilon * by_x_[j]);
      if (!(remainder > floor)) // remainders of smaller sizes are rounding too
        break;
      usable.emplace_back(epsilon, remainder);
    }
    if (usable.size() >= 3) {
      // The smallest sizes, at which higher orders no longer show.
      usable.erase(usable.begin(), usable.end() - 3);
      const double p = log_log_slope(usable);
      rows.push_back({fmt::format("Taylor order by {}", name), fmt::format("{:.3f}", p), "2.00 +- 0.05",
                      std::abs(p - 2) <= 0.05});
      return;
    }
    const std::string against = fmt::format("dJ/d({}) against differences of J", name);
    if (widest == 0) {
      rows.push_back(
          {against, "active sets change for every difference tried", "one with unchanged sets", false});
      return;
    }
    Changes changed = changes(j, widest);
    std::optional<Trial> first = at(j, changed.p), second = at(j, changed.q);
    for (int i = 0; i < 6 && !(first && first->kept && second && second->kept); ++i) {
      widest /= std::sqrt(10);
      changed = changes(j, widest);
      first = at(j, changed.p), second = at(j, changed.q);
    }
    if (!first || !second || !first->kept || !second->kept) {
      rows.push_back({against, "active sets change for the other difference",
                      "unchanged sets in both differences", false});
      return;
    }
    const double slope = changed.slope(here_, first->value, second->value),
                 lost = std::max(rounding_ * here_, of_noise / 10) / widest,
                 size = std::max(std::abs(slope), std::abs(by_x_[j]));
    rows.push_back(
        size > 0 ? below(against, std::abs(slope - by_x_[j]) / size, std::max(1e-6, clear * lost / size))
                 : below(against, 0, 0));
  }

  problem::ParameterProblem& problem_;
  control::ReducedProblem& reduced_;
  const Console& console_;
  std::vector<double> x_;
  double here_;                 ///< J at the start values
  std::vector<double> by_x_;    ///< dJ/dx
  double rounding_;             ///< relative rounding error of J
  std::vector<double> lengths_; ///< norms of the Jacobian's columns
  double noise_ = 0;            ///< rounding of the residuals, as measured (norm)
  double relative_noise_ = 0;   ///< the same, relative to the norm of the simulated values
};

} // namespace

void check_joint(control::ReducedProblem& problem, double solver_tolerance, std::vector<CheckRow>& rows) {
  const control::Variables v = problem.variables();
  const double here = problem.value(v);
  control::Variables d = problem.trial_gradient();
  problem.accept();
  const ContactHistory contact = problem.contact();
  const double squared = problem.inner(d, d), curvature = problem.inner(d, problem.hessian_product(d)),
               floor = 200 * (1000 * std::numeric_limits<double>::epsilon() + 10 * solver_tolerance) * here;
  d.scale(-squared / std::max(std::abs(curvature), std::numeric_limits<double>::min())); // Cauchy's step
  const double slope = -squared * squared / std::abs(curvature);
  std::vector<std::pair<double, double>> usable;
  for (int i = 0; i < 14; ++i) {
    const double epsilon = std::pow(10, -1 - 0.5 * i);
    control::Variables beside = v;
    beside.add(epsilon, d);
    const double remainder = std::abs(problem.value(beside) - here - epsilon * slope);
    if (switches(contact, problem.trial_contact()).steps == 0 && remainder > floor)
      usable.emplace_back(epsilon, remainder);
  }
  constexpr std::size_t enough = 3;
  if (usable.size() < enough) {
    rows.push_back(
        {"Taylor order by control and unknowns", "too few differences keep the active sets", "three", false});
    return;
  }
  usable.erase(usable.begin(), usable.end() - enough);
  const double p = log_log_slope(usable);
  rows.push_back({"Taylor order by control and unknowns", fmt::format("{:.3f}", p), "2.00 +- 0.05",
                  std::abs(p - 2) <= 0.05});
}

void check_fit(problem::ParameterProblem& problem, double solver_tolerance, const Console& console,
               std::vector<CheckRow>& rows) {
  const std::size_t first = rows.size();
  FitCheck(problem, solver_tolerance, console).run(rows);
  if (!std::ranges::all_of(rows.begin() + static_cast<std::ptrdiff_t>(first), rows.end(), &CheckRow::holds))
    console.line("The first guess does not confirm the derivatives. Where contact is weak or chatters, J is "
                 "smooth for tiny changes only: " +
                 diagnostics::calmer_contact(problem.reduced.stepper()) +
                 ", or another first guess (unknown.start).");
}

} // namespace signorini::drivers
