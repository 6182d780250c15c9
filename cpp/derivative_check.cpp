#include "derivative_check.h"
#include "base/error.h"
#include "base/fit.h"
#include "evaluation_point.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <tuple>

namespace signorini {
using petsc::check;

CheckRow below(const std::string& name, double value, double limit) {
  return {name, fmt::format("{:.2e}", value), "<= " + fmt::format("{:.0e}", limit), value <= limit};
}

namespace {

/// Candidates that are in one of two ascending sets alone.
int apart(const contact::ActiveSet& a, const contact::ActiveSet& b) {
  contact::ActiveSet difference;
  std::ranges::set_symmetric_difference(a, b, std::back_inserter(difference));
  return static_cast<int>(difference.size());
}

/// Changes of candidates between closed and open from one motion to another, those of projected predictors
/// included.
struct Switches {
  int steps = 0, candidates = 0;
};

Switches switches(const forward::Trajectory& a, const forward::Trajectory& b) {
  Switches sum;
  for (int k = 1; k <= a.steps(); ++k) {
    const contact::ContactState &one = a.contact()[static_cast<std::size_t>(k)],
                                &other = b.contact()[static_cast<std::size_t>(k)];
    const int here = apart(one.active, other.active) + apart(one.predictor, other.predictor);
    sum.steps += here > 0;
    sum.candidates += here;
  }
  return sum;
}

/// How near a motion is to one with other active sets.
struct Margins {
  double force = 0; ///< the least on closed candidates, relative to the largest
  double gap = 0;   ///< the least of open ones, m
};

Margins margins(const forward::Trajectory& trajectory) {
  double least = std::numeric_limits<double>::infinity(), largest = 0, gap = least;
  for (int k = 1; k <= trajectory.steps(); ++k) {
    const contact::ContactState& state = trajectory.contact()[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < state.lambda.size(); ++i)
      if (state.status[i] == contact::Status::open) {
        gap = std::min(gap, state.gap[i]);
      } else {
        least = std::min(least, state.lambda[i]);
        largest = std::max(largest, state.lambda[i]);
      }
  }
  return {largest > 0 ? least / largest : 0, gap};
}

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
  }

  void run(std::vector<CheckRow>& rows) {
    // Rounding; and what an iterative solver leaves of each step of both sweeps, a few times its tolerance.
    const double solves = 10 * controls_.steps() * solver_tolerance_;
    rows.push_back(below("transpose identity <S'd, w> = <d, S'*w>", transpose_defect(), 1e-12 + solves));
    if (const int weak = weak_candidates(); weak > 0) {
      one_sided(weak, rows);
      return;
    }
    const double slope = taylor(rows);
    hessian(rows);
    settle(u_);
    if (contact_occurs())
      judge(slope);
  }

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
    const fem::Space& space = controls_.space();
    petsc::Vector shape = space.vector();
    const auto shape_of = [&](int k) {
      wave(space, space.points(), fem::component_numbers({}, space.dim()), static_cast<double>(k) / controls_.steps(), 1,
           shape);
      return Vec(shape);
    };
    double forward = 0;
    problem_.linearised(d_, [&](int k, Vec dy) { forward += petsc::dot(dy, shape_of(k)); });
    const forward::Load dual{.force = [&](int k, Vec out) { check(VecAXPY(out, 1, shape_of(k))); }};
    const control::Control back = problem_.adjoint(dual);
    const double backward = controls_.product(back, d_);
    return std::abs(forward - backward) / std::max(std::abs(forward), std::abs(backward));
  }

  double taylor(std::vector<CheckRow>& rows) {
    const control::Control g = problem_.l2_gradient();
    const double slope = controls_.product(g, d_);
    // Rounding of J, accumulated over the steps, hides remainders below this.
    const double floor = 100 * std::numeric_limits<double>::epsilon() * std::abs(objective_) *
                         std::sqrt(static_cast<double>(controls_.steps()));
    console_.line("Taylor remainders |J(u + eps d) - J(u) - eps <g, d>|, |d| = |u|:\n"
                  "       eps    remainder   order  active sets");
    std::vector<std::pair<double, double>> usable;
    double last = 0;
    constexpr int sizes = 8;
    for (int j = 0; j < sizes; ++j) {
      const double epsilon = epsilon_of(j);
      const double remainder = std::abs(problem_.value(moved(epsilon)) - objective_ - epsilon * slope);
      const Switches changed = switches(problem_.trajectory(), problem_.trial_trajectory());
      const bool kept = changed.steps == 0;
      console_.line(fmt::format(
          "  {:8.1e}   {:10.3e}  {:>6}  {}{}", epsilon, remainder,
          j > 0 ? fmt::format("{:.2f}", std::log(last / remainder) / std::log(std::sqrt(10))) : "",
          kept ? "kept" : fmt::format("{} changes in {} steps", changed.candidates, changed.steps),
          remainder > floor ? "" : ", rounding"));
      last = remainder;
      if (kept && remainder > floor)
        usable.emplace_back(epsilon, remainder);
      if (kept && kept_size_ == 0 && same_sets_at(-epsilon))
        kept_size_ = epsilon;
    }
    if (kept_size_ == 0)
      kept_size_ = invariance_radius(epsilon_of(sizes));
    const std::string difference = "derivative against the difference of J";
    if (usable.size() >= 3) {
      const double p = log_log_slope(usable);
      rows.push_back({"Taylor order", fmt::format("{:.3f}", p), "2.00 +- 0.05", std::abs(p - 2) <= 0.05});
    } else if (kept_size_ == 0) {
      rows.push_back({difference, "no size keeps the active sets", "a size that keeps them", false});
    } else {
      // While sets are kept J is quadratic and its central difference exact.
      const double quotient =
          (problem_.value(moved(kept_size_)) - problem_.value(moved(-kept_size_))) / (2 * kept_size_);
      rows.push_back(beyond_rounding(difference, std::abs(quotient / slope - 1), floor / (kept_size_ * std::abs(slope))));
    }
    return slope;
  }

  /// Candidates in weak contact, over all steps.
  [[nodiscard]] int weak_candidates() const {
    int weak = 0;
    for (const contact::ContactState& state : problem_.trajectory().contact())
      weak += state.count(contact::Status::weak);
    return weak;
  }

  /// At a kink J has slopes to one side alone.
  void one_sided(int weak, std::vector<CheckRow>& rows) {
    console_.line(fmt::format("Contact is weak (closed without force) {} times: J may have a kink here, and slopes to one side alone.",
                              weak));
    control::Control back = d_;
    back.scale(-1);
    double slopes[2]{};
    for (const auto& [name, direction, sign] : {std::tuple{"+d", &d_, 1.0}, std::tuple{"-d", &back, -1.0}}) {
      const control::ReducedProblem::OneSided slope = problem_.one_sided_slope(*direction);
      slopes[sign < 0] = slope.by_motion;
      // While sets are kept J is quadratic along d, and two quotients give the slope.
      const double ratio = epsilon_of(0) / epsilon_of(1);
      double best = std::numeric_limits<double>::infinity(), larger = best;
      for (int j = 0; j < 12; ++j) {
        const double epsilon = epsilon_of(j), quotient = (problem_.value(moved(sign * epsilon)) - objective_) / epsilon;
        const double extrapolated = (ratio * quotient - larger) / (ratio - 1);
        best = std::min(best, std::abs(extrapolated - slope.by_motion) / std::abs(slope.by_motion));
        larger = quotient;
      }
      console_.line(fmt::format("Slope of J along {}: {:.6e}; by the adjoint inequality, with weak contact free to open, {:.6e}.", name,
                                slope.by_motion, slope.by_adjoint));
      rows.push_back(below(fmt::format("one-sided slope along {} against differences of J", name), best, 1e-5));
    }
    const double kink = std::abs(slopes[0] + slopes[1]) / std::max(std::abs(slopes[0]), std::abs(slopes[1]));
    constexpr double smooth = 1e-9;
    console_.line(kink > smooth ? fmt::format("Verdict: a kink along d, whose slopes differ by {:.3g} %; no gradient tells both.", 100 * kink)
                                : std::string("Verdict: no kink along d."));
  }

  bool same_sets_at(double epsilon) {
    problem_.value(moved(epsilon));
    return switches(problem_.trajectory(), problem_.trial_trajectory()).steps == 0;
  }

  [[nodiscard]] bool contact_occurs() const {
    return std::ranges::any_of(problem_.trajectory().contact(),
                               [](const contact::ContactState& state) { return !state.active.empty(); });
  }

  static double epsilon_of(int j) { return std::pow(10, -2 - 0.5 * j); }

  /// The largest of 10^(−j/2) below `from` within which no active set changes, on both sides; 0 if there is none.
  double invariance_radius(double from) {
    constexpr double rounding = 1e-12;
    for (double epsilon = from; epsilon > rounding; epsilon /= std::sqrt(10))
      if (same_sets_at(epsilon) && same_sets_at(-epsilon))
        return epsilon;
    return 0;
  }

  /// A row for a quotient of differences that rounding disturbs.
  static CheckRow beyond_rounding(const std::string& name, double value, double rounding) {
    constexpr double most = 1e-6, useless = 0.1;
    CheckRow row = below(name, value, std::max(most, rounding));
    if (rounding > useless)
      row = {name, "lost in rounding", "sets kept within more", false};
    return row;
  }

  /// Says how far the derivative can be trusted: exact it is as long as no active set changes, useful only if
  /// changes of the control that matter see the same slope.
  void judge(double slope) {
    constexpr double macroscopic = 0.1, alike = 0.05, narrow = 1e-6;
    const double above = problem_.value(moved(macroscopic));
    const int changed = switches(problem_.trajectory(), problem_.trial_trajectory()).candidates;
    const double secant = (above - problem_.value(moved(-macroscopic))) / (2 * macroscopic);
    const double off = std::abs(secant - slope) / std::max(std::abs(secant), std::abs(slope));
    const double radius = kept_size_;
    const Margins margin = margins(problem_.trajectory());
    console_.line(fmt::format(
        "Active sets are kept within {:.1e} of the control; least force on a closed candidate {:.1e} of the "
        "largest, least gap of an open one {:.1e} m.\nThe derivative along d is {:.6e}; over +- {} d, with {} "
        "changes of the sets, J has the slope {:.6e}.",
        radius, margin.force, margin.gap, slope, macroscopic, changed, secant));
    const bool massless = problem_.stepper().massless();
    if (radius > narrow && off <= alike)
      console_.line("Verdict: exact, and what larger changes of the control see.");
    else if (radius > narrow)
      console_.line(fmt::format("Verdict: exact, but valid only within {:.1e}: beyond it contact changes, and "
                                "larger changes of the control see a slope that differs by {:.0f} %.",
                                radius, 100 * off));
    else
      console_.line(fmt::format("Verdict: exact, but valid only within {:.1e}: the contact chatters, and larger "
                                "changes of the control see a slope that differs by {:.0f} %; {}.",
                                radius, 100 * off,
                                massless ? "try more viscosity" : "try massless contact (contact.mass)"));
  }

  void hessian(std::vector<CheckRow>& rows) {
    const std::string name = "Hessian product against differences of gradients";
    if (kept_size_ == 0) {
      rows.push_back({name, "no size keeps the active sets", "<= 1e-06", false});
      return;
    }
    control::Control h = problem_.l2_hessian_product(d_);
    const double size = controls_.norm(h), gradient = controls_.norm(problem_.l2_gradient());
    settle(moved(kept_size_));
    h.add(-1 / (2 * kept_size_), problem_.l2_gradient());
    settle(moved(-kept_size_));
    h.add(1 / (2 * kept_size_), problem_.l2_gradient());
    const double rounding = 100 * std::numeric_limits<double>::epsilon() *
                            std::sqrt(static_cast<double>(controls_.steps())) * gradient / (kept_size_ * size);
    rows.push_back(beyond_rounding(name, controls_.norm(h) / size, rounding));
  }

  control::ReducedProblem& problem_;
  const control::ControlSpace& controls_;
  const control::Control& u_;
  control::Control d_;
  double solver_tolerance_;
  const Console& console_;
  double objective_ = 0;
  double kept_size_ = 0; ///< the invariance radius: the largest size that keeps the active sets on both sides
};

} // namespace

void check_derivatives(control::ReducedProblem& problem, const control::Control& u, double solver_tolerance,
                       const Console& console, std::vector<CheckRow>& rows) {
  DerivativeCheck(problem, u, solver_tolerance, console).run(rows);
}

} // namespace signorini
