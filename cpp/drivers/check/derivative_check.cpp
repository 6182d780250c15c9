// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/check/derivative_check.h"
#include "base/error.h"
#include "base/log_slope.h"
#include "diagnostics/warnings.h"
#include "drivers/check/evaluation_point.h"
#include "drivers/check/switches.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::drivers {
using petsc::check;

CheckRow below(const std::string& name, double value, double limit) {
  return {name, fmt::format("{:.2e}", value), fmt::format("<= {:.2g}", limit), value <= limit};
}

namespace {

/// Smooth test duals for the states, which are not proportional to a derivative of J.
class Waves final : public step::StateDuals {
public:
  explicit Waves(const control::ControlSpace& controls)
      : space_(controls.space()), steps_(controls.steps()), shape_(space_.vector()) {}
  [[nodiscard]] bool has_density() const override { return false; }
  [[nodiscard]] bool has_vector() const override { return true; }
  void add(const step::TimeStep& step, step::StateDual sum) const override {
    check(VecAXPY(sum.vector, 1, at(step.k)));
  }

  /// Dual of the state after step k; valid until the next call.
  [[nodiscard]] Vec at(int k) const {
    wave(space_, space_.points(), fem::component_numbers({}, space_.dim()), static_cast<double>(k) / steps_,
         1, petsc::WriteArray(shape_));
    return shape_;
  }

private:
  const fem::Space& space_;
  int steps_;
  petsc::Vector shape_;
};

class DerivativeCheck {
public:
  DerivativeCheck(control::ReducedProblem& problem, const control::Control& u, double solver_tolerance,
                  const Console& console)
      : problem_(problem), controls_(problem.controls()), u_(u), d_(wave(controls_, 0)),
        solver_tolerance_(solver_tolerance), console_(console) {
    // A direction as long as the control itself makes ε a relative size.
    const double size = controls_.norm(u);
    d_.scale((size > 0 ? size : 1) / controls_.norm(d_));
    settle(u_);
    cancellation_ = cancellation();
  }

  void run(std::vector<CheckRow>& rows) {
    rows.push_back(below("transpose identity <S'd, w> = <d, S'*w>", transpose_defect(), sweeps_leave()));
    if (const int weak = kinks(problem_.trajectory().contact()); weak > 0) {
      console_.line(
          fmt::format("Contact is weak, closed without force or about to slip, {} times (candidates × "
                      "steps). J may have a kink here, with one-sided slopes only.",
                      weak));
      const double plus = slope(Side::plus, rows);
      kink(plus, slope(Side::minus, rows));
      return;
    }
    const double derivative = slope(Side::both, rows);
    hessian(rows);
    settle(u_);
    if (contact_occurs())
      judge(derivative);
  }

  /// Advice on changing the scene; empty if no change is needed.
  [[nodiscard]] const std::string& advice() const { return advice_; }

private:
  void settle(const control::Control& u) {
    objective_ = problem_.value(u);
    problem_.accept();
  }

  [[nodiscard]] control::Control moved(double epsilon) const {
    control::Control u = u_;
    u.add(epsilon, d_);
    return u;
  }

  double transpose_defect() {
    const Waves waves(controls_);
    petsc::Pairing forward;
    problem_.linearised(d_, [&](int k, Vec dy) { forward.add(dy, waves.at(k)); });
    return forward.defect(controls_.product(problem_.adjoint({controls_.space(), waves}), d_));
  }

  /// Sides of u on which differences of J are compared with the slope of J at u.
  enum class Side { both, plus, minus };

  /// Admissible relative difference between a sweep and its transpose: rounding, and a multiple of the
  /// solver's tolerance for each step.
  [[nodiscard]] double sweeps_leave() const { return 1e-12 + 10 * controls_.steps() * solver_tolerance_; }
  /// Admissible relative rounding error of J or of a gradient. The rounding of N steps grows like √N. One
  /// step contributes up to 80 machine epsilons (flat bar in contact, without viscosity); about ten times as
  /// many are admitted. y − y_d has the rounding of y, hence the factor for cancellation.
  [[nodiscard]] double rounding() const {
    return cancellation_ * std::sqrt(static_cast<double>(controls_.steps())) *
           (1000 * std::numeric_limits<double>::epsilon() + 10 * solver_tolerance_);
  }

  /// ‖y‖ / ‖y − y_d‖ in L2(0,T; L2) of the set that is observed, at least 1: the amplification of rounding in
  /// y − y_d.
  double cancellation() {
    double motion = 0, error = 0;
    for (int k = 1; k <= controls_.steps(); ++k) {
      const double norm = problem_.objective().norm(problem_.trajectory().at(k).y());
      motion += norm * norm;
      error += problem_.squared_distances()[static_cast<std::size_t>(k)];
    }
    return error > 0 ? std::max(1.0, std::sqrt(motion / error)) : 1;
  }

  /// Compares J's slope along d, or to one side, by the linearised motion with that by the gradient, which
  /// has rounding errors of its own, and with differences of J; returns it.
  double slope(Side side, std::vector<CheckRow>& rows) {
    control::Control direction = d_;
    direction.scale(side == Side::minus ? -1 : 1);
    const control::ReducedProblem::OneSided found = problem_.one_sided_slope(direction);
    const std::string along = side == Side::both ? "" : side == Side::plus ? " along +d" : " along -d";
    if (side != Side::both)
      console_.line(fmt::format("Slope of J{}: {:.6e}.", along, found.by_motion.value));
    rows.push_back(below(fmt::format("slope{}: gradient against linearised motion", along),
                         found.by_motion.defect(found.by_gradient), std::max(sweeps_leave(), rounding())));
    taylor(side, along, found, rows);
    return found.by_motion.value;
  }

  void taylor(Side side, const std::string& along, const control::ReducedProblem::OneSided& found,
              std::vector<CheckRow>& rows) {
    constexpr double clear =
        20; // then the smallest remainder is right to 5 %, an order over one decade to 0.02
    const double sign = side == Side::minus ? -1 : 1, floor = clear * rounding() * std::abs(objective_);
    console_.line(fmt::format("Taylor remainders |J(u + eps d) - J(u) - eps <g, d>|{}, |d| = {}:\n"
                              "       eps    remainder   order  active sets",
                              along, controls_.norm(u_) > 0 ? "|u|" : "1, since u = 0"));
    std::vector<std::pair<double, double>> usable;
    double last = 0, within = 0;
    constexpr int sizes = 8;
    for (int j = 0; j < sizes; ++j) {
      const double epsilon = epsilon_of(j);
      const double remainder =
          std::abs(problem_.value(moved(sign * epsilon)) - objective_ - epsilon * found.by_motion.value);
      const Switches changed = switches(found.contact, problem_.trial_contact());
      const bool kept = changed.steps == 0;
      console_.line(fmt::format(
          "  {:8.1e}   {:10.3e}  {:>6}  {}{}", epsilon, remainder,
          j > 0 ? fmt::format("{:.2f}", std::log(last / remainder) / std::log(std::sqrt(10))) : "",
          kept ? "kept" : fmt::format("{} changes in {} steps", changed.candidates, changed.steps),
          remainder > floor ? "" : ", rounding"));
      last = remainder;
      if (kept && remainder > floor)
        usable.emplace_back(epsilon, remainder);
      if (kept && within == 0 && (side != Side::both || same_sets_at(-epsilon, found.contact)))
        within = epsilon;
    }
    if (within == 0)
      within = invariance_radius(side, found.contact, epsilon_of(sizes));
    kept_size_ = within;
    const std::string difference = fmt::format("slope{} against differences of J", along);
    if (usable.size() >= 3) {
      const double p = log_log_slope(usable);
      rows.push_back(
          {"Taylor order" + along, fmt::format("{:.3f}", p), "2.00 +- 0.05", std::abs(p - 2) <= 0.05});
    } else if (within == 0) {
      rows.push_back(
          {difference, "active sets change for every difference tried", "one with unchanged sets", false});
    } else {
      const Fit fit = fitted(side, within);
      rows.push_back(beyond_rounding(difference, std::abs(fit.slope / found.by_motion.value - 1),
                                     fit.rounding / std::abs(found.by_motion.value)));
    }
  }

  struct Fit {
    double slope, rounding;
  };

  /// Fits a parabola to nine evenly spaced values of J along d, at relative distances of at most `within`
  /// from u. The active sets are unchanged there, so that J is a parabola up to rounding. Returns the slope
  /// at u, and the slope's rounding error, estimated from the residuals.
  Fit fitted(Side side, double within) {
    constexpr int half = 4;
    constexpr double squares = 60, mean_square = 20.0 / 3,
                     spread = 308;                    // Σ t², its mean, Σ (t² − mean)² over t = −4…4
    const int start = side == Side::both ? 0 : -half; // where u is
    const double spacing = (side == Side::minus ? -within : within) / (half - start);
    std::array<double, 2 * half + 1> J{};
    double mean = 0, linear = 0, quadratic = 0;
    for (int t = -half; t <= half; ++t) {
      double& value = J[static_cast<std::size_t>(t + half)];
      value = t == start ? 0 : problem_.value(moved((t - start) * spacing)) - objective_;
      mean += value / static_cast<double>(J.size());
      linear += t * value / squares;
      quadratic += (t * t - mean_square) * value / spread;
    }
    double off = std::numeric_limits<double>::epsilon() * std::abs(objective_), weights = 0;
    for (int t = -half; t <= half; ++t) {
      off = std::max(off, std::abs(J[static_cast<std::size_t>(t + half)] - mean - t * linear -
                                   (t * t - mean_square) * quadratic));
      weights += std::abs(t / squares + 2 * start * (t * t - mean_square) / spread);
    }
    // The fit absorbs a third of the values' rounding (three of nine degrees of freedom): hence the factor 2.
    // Residuals above rounding() have other causes and must not widen the tolerance.
    // Where J is no parabola, the residuals of its cubic term count too: 33/12 of its effect on the slope.
    constexpr double cubic = 3;
    // Errors of conjugate gradients are a smooth function of the control as long as the numbers of iterations
    // stay: a parabola absorbs them, and residuals do not show them.
    const double largest = rounding() * std::abs(objective_),
                 shown = solver_tolerance_ > 0 ? largest : std::min(2 * off, largest);
    const double each = curved() ? cubic * off : shown;
    return {(linear + 2 * start * quadratic) / std::abs(spacing), weights * each / std::abs(spacing)};
  }

  /// Whether J is not a parabola while the active sets are unchanged, since slip in space changes direction.
  [[nodiscard]] bool curved() const {
    return problem_.stepper().frictional() && problem_.stepper().space().dim() == 3;
  }

  void kink(double plus, double minus) {
    const double kink = std::abs(plus + minus) / std::max(std::abs(plus), std::abs(minus));
    constexpr double smooth = 1e-9;
    console_.line(
        kink > smooth
            ? fmt::format("Verdict: J has a kink along d. Its one-sided slopes differ by {:.3g} %; no "
                          "gradient gives both.",
                          100 * kink)
            : std::string("Verdict: J has no kink along d."));
  }

  bool same_sets_at(double epsilon, const ContactHistory& contact) {
    problem_.simulate(moved(epsilon));
    return switches(contact, problem_.trial_contact()).steps == 0;
  }

  [[nodiscard]] bool contact_occurs() const {
    return std::ranges::any_of(
        problem_.trajectory().contact(),
        [](const contact::ContactLinearisation& state) { return !state.closed_set().empty(); });
  }

  static double epsilon_of(int j) { return std::pow(10, -2 - 0.5 * j); }

  /// Largest ε of `from` · 10^(−j/2), j = 0, 1, …, for which the motions at u ± ε d (on the sides compared)
  /// have the active sets of `contact`; 0 if no ε above rounding qualifies.
  double invariance_radius(Side side, const ContactHistory& contact, double from) {
    constexpr double rounding = 1e-12;
    for (double epsilon = from; epsilon > rounding; epsilon /= std::sqrt(10))
      if ((side == Side::minus || same_sets_at(epsilon, contact)) &&
          (side == Side::plus || same_sets_at(-epsilon, contact)))
        return epsilon;
    return 0;
  }

  /// Makes a row for the deviation `value` of a difference quotient; the row passes if `value` is at most the
  /// quotient's rounding error, and fails if that error is too large to be useful.
  static CheckRow beyond_rounding(const std::string& name, double value, double rounding) {
    constexpr double useless = 1e-3;
    if (rounding > useless)
      return {name, "lost in rounding", "unchanged sets in a wider range", false};
    return below(name, value, rounding);
  }

  /// Prints the range in which the derivative along d is valid: exact as long as no active set changes, but
  /// useful only if J has the same slope over relevant changes of the control.
  void judge(double slope) {
    constexpr double macroscopic = 0.1, alike = 0.05, narrow = 1e-6;
    const double above = problem_.value(moved(macroscopic));
    int changed = switches(problem_.contact(), problem_.trial_contact()).candidates;
    const double below = problem_.value(moved(-macroscopic));
    changed += switches(problem_.contact(), problem_.trial_contact()).candidates;
    const double secant = (above - below) / (2 * macroscopic),
                 bend = (above - 2 * objective_ + below) / macroscopic, // growth of the slope over this range
        off = std::abs(secant - slope) / std::max({std::abs(secant), std::abs(slope), std::abs(bend)});
    const double radius = kept_size_;
    const trajectory::Margins margin = problem_.trajectory().margins();
    console_.line(fmt::format(
        "Active sets stay the same for relative changes of the control up to {:.1e}. The least force on a "
        "closed candidate is {:.1e} times the largest; the least gap of an open candidate is {:.1e} m.\nThe "
        "derivative along d is {:.6e}; over +- {} d, with {} changes of active sets on both sides, J has the "
        "mean slope {:.6e}.",
        radius, margin.force(), margin.gap, slope, macroscopic, changed, secant));
    if (off <= alike) {
      console_.line(radius > narrow
                        ? "Verdict: the derivative is exact, and holds for larger changes of the control too."
                        : fmt::format("Verdict: the derivative is exact, but only for relative changes of "
                                      "the control below {:.1e}: the contact chatters. Larger changes of the "
                                      "control nevertheless give the same slope.",
                                      radius));
      return;
    }
    advice_ = diagnostics::calmer_contact(problem_.stepper());
    console_.line(fmt::format("Verdict: the derivative is exact, but only for relative changes of the "
                              "control below {:.1e}: {}. Larger changes of the control give a mean slope "
                              "that differs by {:.0f} % of the largest slope among them; {}.",
                              radius,
                              radius > narrow ? "beyond that limit contact changes" : "the contact chatters",
                              100 * off, advice_));
  }

  void hessian(std::vector<CheckRow>& rows) {
    const std::string name = "Hessian product against differences of gradients";
    if (curved()) {
      console_.line("Directions of slip change with the control: Hessian products are those of Gauss and "
                    "Newton, and are not compared with differences.");
      return;
    }
    if (kept_size_ == 0) {
      rows.push_back(
          {name, "active sets change for every difference tried", "one with unchanged sets", false});
      return;
    }
    const control::Control h = problem_.l2_hessian_product(d_);
    // At an optimum the terms of the gradient α u + S*W(y - y_d) cancel, their rounding does not.
    const control::ObjectiveDuals of_motion(problem_.objective(), problem_.trajectory(),
                                            control::ObjectiveDuals::Order::second);
    const double size = controls_.norm(h),
                 terms = problem_.objective().alpha() * controls_.norm(u_) +
                         controls_.norm(problem_.adjoint({controls_.space(), of_motion})),
                 gradient = std::max(controls_.norm(problem_.l2_gradient()), terms / cancellation_);
    const auto limit = [&](double epsilon) {
      return std::max(sweeps_leave(), rounding() * gradient / (epsilon * size));
    };
    // While the active sets are unchanged, gradients are affine along d.
    control::Control off = difference(kept_size_).value;
    off.add(-1, h);
    double worst = controls_.norm(off) / size, admitted = limit(kept_size_);
    if (worst > admitted) {
      // A power mean over scenarios has a third derivative, which Richardson's extrapolation removes. Where
      // contact chatters, sweeps amplify rounding: second differences show by how much.
      constexpr double small = 1e-3, weights = (4 * 2 + 1) / 3.0;
      const double epsilon = std::min(kept_size_, small);
      Quotient finer = difference(epsilon / 2);
      finer.value.scale(4.0 / 3);
      finer.value.add(-1.0 / 3, difference(epsilon).value);
      finer.value.add(-1, h);
      worst = controls_.norm(finer.value) / size;
      admitted = weights * limit(epsilon);
      if (worst > admitted)
        admitted = std::max(admitted, weights * finer.rounding / size);
    }
    rows.push_back(beyond_rounding(name, worst, admitted));
  }

  /// Central difference of the gradients at u ± ε d, and its rounding error by their second difference, which
  /// has √3 times this error and vanishes without it.
  struct Quotient {
    control::Control value;
    double rounding;
  };
  Quotient difference(double epsilon) {
    constexpr double safety = 2;
    settle(u_);
    control::Control bend = problem_.l2_gradient();
    bend.scale(-2);
    settle(moved(epsilon));
    control::Control quotient = problem_.l2_gradient();
    bend.add(1, quotient);
    settle(moved(-epsilon));
    const control::Control below = problem_.l2_gradient();
    bend.add(1, below);
    quotient.add(-1, below);
    quotient.scale(1 / (2 * epsilon));
    return {std::move(quotient), safety * controls_.norm(bend) / std::sqrt(3.0) / (2 * epsilon)};
  }

  control::ReducedProblem& problem_;
  const control::ControlSpace& controls_;
  const control::Control& u_;
  control::Control d_;
  double solver_tolerance_;
  const Console& console_;
  double objective_ = 0, cancellation_ = 1;
  double kept_size_ = 0; ///< invariance radius: largest relative change along d that keeps the active sets
  std::string advice_;
};

} // namespace

std::string check_derivatives(control::ReducedProblem& problem, const control::Control& u,
                              double solver_tolerance, const Console& console, std::vector<CheckRow>& rows) {
  DerivativeCheck derivatives(problem, u, solver_tolerance, console);
  derivatives.run(rows);
  return derivatives.advice();
}

} // namespace signorini::drivers
