// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/bundle_method.h"
#include "optimize/minimize.h"
#include "optimize/options.h"
#include "optimize/unknowns.h"

namespace signorini::optimize {

/// Convex combination of the gradients at the last iterates, and its length.
struct PathCombination {
  std::vector<double> weights; ///< weights from the latest iterate backwards; their sum is 1
  double length = 0;
};

template <Differentiable P>
struct Search {
  std::optional<Iterate<P>> found; ///< accepted trial; it is also the problem's trial
  double length = 0;               ///< step length t
  double predicted_decrease = 0;   ///< −slope/2: decrease of a quadratic with its minimum at t = 1
  bool solver_failed = false;      ///< whether a solver failed in the last trial
};

/// Searches for a step length along the arc t ↦ P(u + t d) by the weak Wolfe conditions with bisection and
/// doubling (Lewis, Overton 2013); the first trial is t = 1. Requires sufficient decrease, and a slope above
/// a fraction of the initial, negative slope. A small slope is not required, so that the search can end
/// beyond a kink. `d` must be tangential to the bounds. A trial at which a solver fails counts as too long.
template <Differentiable P>
[[nodiscard]] Search<P> weak_wolfe_search(P& problem, const Iterate<P>& from, const typename P::Vector& d,
                                          const Options& options) {
  const auto& [sufficient, curvature_condition] = options.wolfe;
  const double slope = problem.inner(from.g, d), least = options.negligible(from.objective);
  Search<P> search;
  search.predicted_decrease = -slope / 2;
  double low = 0, high = std::numeric_limits<double>::infinity();
  bool collapsed = false;
  for (double t = 1; -slope * t > least;) {
    typename P::Vector trial = from.u;
    trial.add(t, d);
    problem.project(trial);
    const std::optional<double> value = attempt(problem, trial);
    search.solver_failed = !value;
    const double decrease = from.objective - value.value_or(nan);
    const auto tangent = [&] { // decrease of J's tangent
      return problem.bounded() ? -problem.inner(from.g, difference(trial, from.u)) : -slope * t;
    };
    if (decrease > 0 && decrease >= sufficient * tangent()) {
      typename P::Vector g = problem.trial_gradient();
      const bool steep =
          problem.inner(g, tangential(problem, trial, d)) < curvature_condition * slope; // false for NaN
      if (!steep || collapsed) {
        search.found.emplace(std::move(trial), *value, std::move(g));
        search.length = t;
        return search;
      }
      low = t;
    } else if (collapsed) {
      return search;
    } else {
      high = t;
    }
    collapsed = low > 0 && -slope * (high - low) <= least;
    t = collapsed ? low : std::isfinite(high) ? (low + high) / 2 : 2 * low;
  }
  return search;
}

/// Descent by line searches along the directions of `Method`, until the gradients of the last iterates have a
/// short convex combination. If a line search fails, the method restarts with steepest descent. If that fails
/// too, or steps have become short, as they do among kinks, a bundle method takes over and ends with a
/// certificate (docs/method.md section 6).
///
/// `Method` provides: direction(problem, at), a vector d that is tangential to the bounds and as long as the
/// first trial step; learn(problem, from, to, t), called after the step from u to u + t d (t = 1: that
/// trial); restart(), which returns false if the last direction was steepest descent; store_at_most(vectors);
/// serialize(archive). A method that remembers the last iterates also provides path_combination(problem, at,
/// radius) and before(at, steps).
template <TwiceDifferentiable P, class Method>
class Descent {
public:
  using Vector = typename P::Vector;

  explicit Descent(const Options& options) : options_(options), method_(options) {}

  /// Makes one iteration or, among kinks, one round of an iteration, as minimize() defines. Returns the
  /// result if the search ends.
  std::optional<Result<Vector>> advance(P& problem, State<P, Descent>& state) {
    Iterate<P>& current = state.current;
    std::optional<Iterate<P>> next;
    double t = 1, predicted_decrease = std::numeric_limits<double>::infinity();
    if (!options_.through_kinks && short_steps_ >= options_.bundle.short_steps)
      return Result<Vector>{Stop::short_steps};
    if constexpr (requires { method_.path_combination(problem, current, t); })
      if (options_.through_kinks && !bundle_)
        if (auto certificate = path_certificate(problem, current, options_.tolerance * state.first_norm))
          return Result<Vector>{Stop::kink, std::move(certificate)};
    if (!bundle_) {
      Search<P> search;
      do
        search = weak_wolfe_search(problem, current, method_.direction(problem, current), options_);
      while (!search.found && method_.restart());
      if (search.found)
        method_.learn(problem, current, *search.found, search.length);
      else if (search.solver_failed)
        return Result<Vector>{Stop::solver_failed};
      else if (options_.through_kinks)
        take_over(problem, current);
      else
        return Result<Vector>{Stop::short_steps};
      t = search.length;
      predicted_decrease = search.predicted_decrease;
      next = std::move(search.found);
    }
    if (!next) {
      Step step = bundle_->round(problem, current, state.first_norm);
      if (step.certificate)
        return Result<Vector>{Stop::kink, std::move(step.certificate)};
      if (step.ended) {
        if (fresh_)
          return Result<Vector>{Stop::no_decrease};
        take_over(problem, current);
      }
      if (!step.found)
        return std::nullopt;
      fresh_ = false;
      if (step.at_other_bounds)
        bundle_.reset();
      predicted_decrease = step.promised;
      next = std::move(step.found);
    }
    problem.accept();
    const double length = norm(problem, difference(next->u, current.u));
    longest_ = std::max(longest_, length);
    short_steps_ = length < options_.bundle.short_step * longest_ ? short_steps_ + 1 : 0;
    current = std::move(*next);
    state.iteration = {state.iteration.number + 1, current.objective,
                       stationarity(problem, current.u, current.g), t, predicted_decrease};
    if (!bundle_ && options_.through_kinks && short_steps_ >= options_.bundle.short_steps)
      take_over(problem, current);
    return std::nullopt;
  }

  /// Takes over the state of the same method on another problem in the same units. `interpolate`: transfers
  /// vectors of that problem to this one.
  template <class Interpolate>
  void inherit(const Descent& other, const P& problem, const Interpolate& interpolate) {
    longest_ = other.longest_;
    method_.inherit(other.method_, problem, interpolate);
  }

  /// Drops vectors of the bundle method and of `Method`, so that both together store at most
  /// Options::vectors. Has no effect before the bundle method takes over.
  void make_room() {
    if (!bundle_)
      return;
    bundle_->make_room();
    method_.store_at_most(options_.vectors - std::min(options_.vectors, bundle_->dimension()));
  }

  template <class Archive>
  void serialize(Archive& archive) {
    method_.serialize(archive);
    archive("longest_step", longest_);
    archive("short_steps", short_steps_);
    archive("unconfirmed", unconfirmed_);
    archive("bundle/fresh", fresh_);
    bool takes_over = bundle_.has_value();
    archive("bundle/takes_over", takes_over);
    if (takes_over && !bundle_)
      bundle_.emplace(options_);
    if (bundle_)
      bundle_->serialize(archive);
  }

private:
  using Step = typename BundleMethod<P>::Step;

  /// Returns a certificate from newly evaluated gradients at the last iterates, if these confirm one.
  std::optional<Certificate<Vector>> path_certificate(P& problem, const Iterate<P>& at, double tolerance) {
    const double radius = Options::ball(options_.tolerance) * longest_;
    const auto combination = method_.path_combination(problem, at, radius);
    if (!combination ||
        combination->length > tolerance * std::pow(options_.bundle.length_reduction, unconfirmed_))
      return std::nullopt;
    GatheredGradients<P> gathered = gather(
        problem, at, combination->weights,
        [&](std::size_t steps) { return projected(problem, method_.before(at, steps)); },
        [](std::size_t, const Vector&) {});
    if (gathered.confirms(tolerance, (1 + options_.bundle.rounding) * radius) &&
        gathered.certificate.points.size() > 1 &&
        !stationary_between(problem, gathered.certificate, tolerance))
      return std::move(gathered.certificate);
    ++unconfirmed_;
    return std::nullopt;
  }

  /// Starts the bundle method at `at`.
  void take_over(const P& problem, const Iterate<P>& at) {
    bundle_.emplace(options_, problem, at, longest_);
    fresh_ = true;
    if (!problem.bounded()) // the bundle method then takes all further steps
      method_.restart();
  }

  Options options_;
  Method method_;
  double longest_ = 1;                    ///< longest step so far; initially Cauchy's step, 1
  int short_steps_ = 0;                   ///< number of consecutive short steps up to now
  int unconfirmed_ = 0;                   ///< number of rejected certificates from the last iterates
  std::optional<BundleMethod<P>> bundle_; ///< takes the steps instead of the method, if set
  bool fresh_ = false;                    ///< whether the bundle method has not made a step yet
};

} // namespace signorini::optimize
