// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/bundle_model.h"
#include "optimize/report.h"
#include "optimize/span.h"

namespace signorini::optimize {

/// Bundle method for descent among kinks of J (Lemaréchal 1978). If J at the minimiser of its model is too
/// high, the gradient there becomes another cut (null step). This repeats until the model's minimiser
/// decreases J (serious step). The last steps are Newton steps along the edge where smooth selections of J
/// meet; a certificate ends them. A step consists of rounds; between two rounds the method can be stored, and
/// vectors can be dropped.
template <TwiceDifferentiable P>
class BundleMethod {
public:
  using Vector = typename P::Vector;

  /// Starts the method at `at`, whose cut is the only one at first. `length`: length of the longest step so
  /// far, to which radii of balls are relative.
  BundleMethod(const Options& options, const P& problem, const Iterate<P>& at, double length)
      : options_(options), length_(length), blocked_at_(share(at.u)),
        blocking_directions_{share(negative(at.g))}, span_(options.bundle.dependent),
        model_(options.bundle, {cut(problem, at.g)}) {}

  /// Creates an empty method, to be read from an archive by serialize().
  explicit BundleMethod(const Options& options)
      : options_(options), span_(options.bundle.dependent), model_(options.bundle, {}) {}

  template <class Archive>
  void serialize(Archive& archive) {
    archive("bundle/length", length_);
    archive("bundle/bounds_at", blocked_at_);
    serialize_list(archive, "bundle/active_bounds", blocking_directions_,
                   [&](Shared<Vector>& d, const std::string& name) { archive(name, d); });
    span_.serialize(archive, "bundle/span");
    model_.serialize(archive);
    archive("bundle/rounds", rounds_);
    archive("bundle/unconfirmed", unconfirmed_);
    archive("bundle/distance", distance_);
    bool smooth = smooth_certificate_.has_value();
    archive("bundle/is_smooth", smooth);
    if (smooth && !smooth_certificate_)
      smooth_certificate_.emplace();
    if (smooth_certificate_)
      smooth_certificate_->serialize(archive, "bundle/smooth");
  }

  /// Result of a round: a new iterate by a serious step, a certificate of stationarity, or neither.
  struct Step {
    std::optional<Iterate<P>> found{}; ///< new iterate; it is also the problem's trial
    bool at_other_bounds = false;      ///< whether the step has brought unblocked values to a bound
    std::optional<Certificate<Vector>> certificate{};
    bool ended = false;                                        ///< whether further rounds would give nothing
    double promised = std::numeric_limits<double>::infinity(); ///< predicted decrease of a serious step
  };

  /// Makes one round of a step from `at`, which is the start of the method or the end of the last serious
  /// step. A certificate's length is at most the tolerance of the options times `first_norm`.
  Step round(P& problem, const Iterate<P>& at, double first_norm) {
    const BundleOptions& options = options_.bundle;
    const double wanted = options_.tolerance * first_norm,
                 tolerance = std::min(options_.tolerance, options.largest_tolerance) * first_norm,
                 ball = Options::ball(std::min(options_.tolerance, options.largest_tolerance)) * length_;
    if (rounds_++ == options.rounds)
      return over();
    if (!smooth_certificate_)
      if (const Combination shortest = minimum_norm_subgradient(model_.cuts(), certificate_ball());
          shortest.length <= wanted) {
        auto certificate = confirmed(problem, at, shortest.weights, wanted);
        if (!certificate)
          return ++unconfirmed_ == options.unconfirmed ? over() : Step();
        if (!stationary_between(problem, *certificate, wanted))
          return {.certificate = std::move(certificate)};
        smooth_certificate_ = std::move(certificate);
      }
    const auto [direction, d] = downhill(problem, at);
    if (direction.subgradient.length > options.model_part * tolerance &&
        direction.predicted > options_.negligible(at.objective)) {
      Step step = follow(problem, at, direction, *d);
      if (step.found) {
        step.promised = direction.predicted;
        rounds_ = unconfirmed_ = 0;
        distance_ = 0;
        smooth_certificate_.reset();
      }
      return step;
    }
    const double least = std::max(options.least_distance * ball,
                                  options.gathered_part * tolerance / model_.curvature().largest());
    if (distance_ > 0 && distance_ <= least)
      return over();
    distance_ =
        std::max(least, distance_ > 0 ? options.distance_factor * distance_ : options.first_distance * ball);
    gather_around(problem, at, direction.subgradient.weights, distance_);
    return {};
  }

  /// Restricts the subspace if it has nearly as many vectors as may be stored.
  void make_room() {
    const BundleOptions& options = options_.bundle;
    const std::size_t most = std::min(options.dimension, options_.vectors);
    const auto part = [&](double of) { return static_cast<std::size_t>(of * static_cast<double>(most)); };
    if (span_.dimension() > part(options.restrict_above))
      span_.restrict(model_.restrict(part(options.restricted), part(options.carried), certificate_ball()));
  }

  /// Number of dimensions of the subspace, which is the number of stored vectors.
  [[nodiscard]] std::size_t dimension() const { return span_.dimension(); }

private:
  /// Returns the radius of the ball in which a certificate gathers gradients.
  double certificate_ball() const { return Options::ball(options_.tolerance) * length_; }

  /// Returns the result that ends the rounds, with the certificate smooth_certificate_ if there is one.
  Step over() { return {.certificate = std::move(smooth_certificate_), .ended = true}; }

  /// Returns x with its blocked values set to zero.
  Vector unblocked(const P& problem, Vector x) const {
    for (const Shared<Vector>& d : blocking_directions_)
      problem.zero_blocked(x, *blocked_at_, *d);
    return x;
  }

  /// Returns the coordinates of the gradient g without its blocked values.
  Coordinates coordinates(const P& problem, Vector g) {
    return span_.coordinates(problem, unblocked(problem, std::move(g)));
  }

  /// Returns the cut of the gradient g at the current point.
  Cut cut(const P& problem, const Vector& g) {
    const Coordinates here = coordinates(problem, g);
    return {here, here, {}, 0};
  }

  /// A point projected onto the bounds.
  struct BoundedPoint {
    Vector u;                        ///< point within the bounds
    std::optional<Vector> outside{}; ///< part of the point beyond the bounds; absent if there is none
  };

  /// Returns the point `at` plus t times `offset`, projected onto the bounds.
  static BoundedPoint point(const P& problem, const Iterate<P>& at, double t, const Vector& offset) {
    Vector u = at.u;
    u.add(t, offset);
    if (!problem.bounded())
      return {std::move(u)};
    Vector within = projected(problem, u);
    u.add(-1, within);
    if (norm(problem, u) > 0)
      return {std::move(within), std::move(u)};
    return {std::move(within)};
  }
  BoundedPoint point(const P& problem, const Iterate<P>& at, const Coordinates& offset) const {
    return point(problem, at, 1, span_.vector(offset, at.u));
  }

  /// Returns the length of the part of d that points out of the bounds at u.
  static double outward(const P& problem, const Vector& u, const Vector& d) {
    if (!problem.bounded())
      return 0;
    return norm(problem, difference(tangential(problem, u, d), d));
  }

  /// Returns the certificate with these weights of the cuts if newly evaluated gradients confirm it.
  /// Otherwise these gradients become the cuts of a new model. If there are bounds, a value then remains
  /// blocked only if a step along −Σ wᵢ gᵢ, by these gradients and weights, would take it out of its bounds.
  std::optional<Certificate<Vector>> confirmed(P& problem, const Iterate<P>& at,
                                               const std::vector<double>& weights, double tolerance) {
    std::vector<Cut> gathered_anew; // in full, including blocked values
    GatheredGradients<P> gathered = gather(
        problem, at, weights,
        [&](std::size_t i) {
          return point(problem, at, model_.cuts()[i].offset).u;
        }, // projected for rounding
        [&](std::size_t i, Vector g) {
          gathered_anew.push_back({span_.coordinates(problem, std::move(g)), {}, model_.cuts()[i].offset, 0});
        });
    if (gathered.confirms(tolerance, (1 + options_.bundle.rounding) * certificate_ball()))
      return std::move(gathered.certificate);
    if (!problem.bounded()) { // nothing was blocked: the subspace stays
      std::vector<Cut> cuts{model_.cuts().front()};
      for (Cut& anew : gathered_anew) {
        anew.here = anew.gathered;
        cuts.push_back(std::move(anew));
      }
      model_ = BundleModel(options_.bundle, std::move(cuts));
      return std::nullopt;
    }
    blocking_directions_ = {share(negative(std::move(gathered.sum)))};
    const Span<P> before = std::exchange(span_, Span<P>(options_.bundle.dependent));
    std::vector<Cut> cuts{cut(problem, at.g)};
    for (const Cut& anew : gathered_anew) {
      cuts.push_back(cut(problem, before.vector(anew.gathered, at.g)));
      cuts.back().offset = span_.coordinates(problem, before.vector(anew.offset, at.g));
    }
    model_ = BundleModel(options_.bundle, std::move(cuts));
    return std::nullopt;
  }

  /// Also blocks the values that d pushes out of the bounds.
  void block(const P& problem, const Vector& d) {
    blocking_directions_.push_back(share(d));
    const Span<P> before = std::exchange(span_, Span<P>(options_.bundle.dependent));
    std::vector<Cut> cuts = model_.cuts();
    for (Cut& cut : cuts) {
      cut.gathered = coordinates(problem, before.vector(cut.gathered, d));
      cut.here = coordinates(problem, before.vector(cut.here, d));
      cut.offset = span_.coordinates(problem, before.vector(cut.offset, d));
    }
    model_ = BundleModel(options_.bundle, std::move(cuts));
  }

  /// Returns the minimiser of the model in coordinates and as a vector, which is absent if the minimiser is
  /// zero. Adds Hessian products until the model's curvature along the direction is accurate or their number
  /// reaches its limit.
  std::pair<Direction, std::optional<Vector>> downhill(P& problem, const Iterate<P>& at) {
    for (int products = 0;;) {
      Direction direction = model_.minimise(span_.dimension());
      if (direction.subgradient.length == 0)
        return {std::move(direction), std::nullopt};
      // In a sum of long vectors that is short, rounding in blocked values would be blocked again and again.
      Vector d = unblocked(problem, span_.vector(direction.d, at.u));
      if (outward(problem, at.u, d) > options_.bundle.rounding * norm(direction.d)) {
        block(problem, d); // without a product, so that none is counted
        continue;
      }
      Coordinates product = coordinates(problem, problem.hessian_product(d));
      ++products;
      if (model_.learn(direction, std::move(product)) || products == options_.bundle.products)
        return {std::move(direction), std::move(d)};
    }
  }

  /// Tries the direction, whose vector is d, at decreasing lengths. The first length that decreases J makes a
  /// serious step; others make null steps.
  Step follow(P& problem, const Iterate<P>& at, const Direction& direction, const Vector& d) {
    const BundleOptions& options = options_.bundle;
    int null_steps = 0;
    for (double t = 1; t * direction.predicted > options_.negligible(at.objective);
         t *= options.length_factor) {
      const Coordinates s = scaled(direction.d, t), Hs = scaled(direction.Hd, t);
      auto [u, outside] = point(problem, at, t, d);
      // Also where a bound is met exactly: block() cannot block values that are free at blocked_at_.
      const bool at_other_bounds =
          outside || (problem.bounded() && outward(problem, u, tangential(problem, at.u, d)) > 0);
      const double J = attempt(problem, u).value_or(nan), decrease = at.objective - J;
      if (decrease >= options.sufficient * t * direction.predicted) { // false for NaN
        Vector g = problem.trial_gradient();
        model_.serious_step(coordinates(problem, g), s, Hs, decrease);
        return {Iterate<P>{std::move(u), J, std::move(g)}, at_other_bounds};
      }
      if (at_other_bounds || !std::isfinite(J))
        continue;
      const Coordinates g = coordinates(problem, problem.trial_gradient());
      if (!std::isfinite(norm(g))) // the model has lost its curvature to rounding and leads far away
        return {.ended = true};
      // A cut above J at the current point is invalid there: a shorter step meets the selection in between.
      if (model_.null_step(g, s, Hs, decrease) <= 0 || ++null_steps == options.null_steps)
        break;
    }
    return {};
  }

  /// Replaces cuts that were gathered farther than `distance` from the current point and carry the model's
  /// minimum with these weights. For each, a new gradient is gathered at that distance, in a direction in
  /// which the old cut rises above the others.
  void gather_around(P& problem, const Iterate<P>& at, const std::vector<double>& weights, double distance) {
    for (Coordinates& offset : model_.drop_distant(weights, distance)) {
      auto [u, outside] = point(problem, at, offset);
      if (outside)
        add(offset, -1, span_.coordinates(problem, std::move(*outside)));
      if (const auto there = evaluated(problem, std::move(u)))
        model_.null_step(coordinates(problem, there->g), offset, {}, at.objective - there->objective);
    }
  }

  Options options_;
  double length_ = 0; ///< length of the longest step when the method started
  Shared<Vector> blocked_at_;
  /// Directions. A value is blocked if one of them points out of the value's bounds at the point blocked_at_.
  std::vector<Shared<Vector>> blocking_directions_;
  Span<P> span_;
  BundleModel model_;
  int rounds_ = 0, unconfirmed_ = 0; ///< numbers of rounds and unconfirmed certificates in the present step
  double distance_ = 0;              ///< distance at which gradients were gathered last; 0: none yet
  /// Confirmed certificate whose points may be on one smooth selection, along which J may still descend.
  std::optional<Certificate<Vector>> smooth_certificate_{};
};

} // namespace signorini::optimize
