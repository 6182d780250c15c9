// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/bundle_model.h"
#include "optimize/report.h"
#include "optimize/span.h"

namespace signorini::optimize {

/// Descent among kinks by a bundle method (Lemaréchal 1978): where J at the minimiser of its model is too
/// high, the gradient there becomes another cut (null step), until the model leads down (serious step);
/// finally the steps are Newton's along the edge of the pieces of J, and a certificate ends them. A step is
/// made round by round, between which it can be stored and vectors given up.
template <TwiceDifferentiable P>
class BundleMethod {
public:
  using Vector = typename P::Vector;

  /// Starts from the cut of `at` alone. `length` is that of a long step, of which the balls are parts.
  BundleMethod(const Options& options, const P& problem, const Iterate<P>& at, double length)
      : options_(options), length_(length), bounds_at_(share(at.u)), held_{share(negative(at.g))},
        span_(options.bundle.dependent), model_(options.bundle, {cut(problem, at.g)}) {}

  /// For serialize() from an archive.
  explicit BundleMethod(const Options& options)
      : options_(options), span_(options.bundle.dependent), model_(options.bundle, {}) {}

  template <class Archive>
  void serialize(Archive& archive) {
    archive("bundle/length", length_);
    archive("bundle/bounds_at", bounds_at_);
    serialize_list(archive, "bundle/active_bounds", held_,
                   [&](Shared<Vector>& d, const std::string& name) { archive(name, d); });
    span_.serialize(archive, "bundle/span");
    model_.serialize(archive);
    archive("bundle/rounds", rounds_);
    archive("bundle/unconfirmed", unconfirmed_);
    archive("bundle/distance", distance_);
    bool smooth = smooth_.has_value();
    archive("bundle/is_smooth", smooth);
    if (smooth && !smooth_)
      smooth_.emplace();
    if (smooth_)
      smooth_->serialize(archive, "bundle/smooth");
  }

  /// Result of a round: a new iterate by a serious step, a certificate of stationarity, or neither.
  struct Step {
    std::optional<Iterate<P>> found{}; ///< the new iterate, the problem's trial
    bool at_other_bounds = false;      ///< the new iterate is at further bounds than the blocked ones
    std::optional<Certificate<Vector>> certificate{};
    bool over = false; ///< without any of these, and further rounds would not find one
    double promised = std::numeric_limits<double>::infinity(); ///< decrease by the model, of a serious step
  };

  /// One round of a step from `at`, where the method started or the last serious step ended. A certificate is
  /// at most as long as the tolerance of the options, a part of `first_norm`.
  Step round(P& problem, const Iterate<P>& at, double first_norm) {
    const BundleOptions& options = options_.bundle;
    const double wanted = options_.tolerance * first_norm,
                 tolerance = std::min(options_.tolerance, options.finest) * first_norm,
                 ball = Options::ball(std::min(options_.tolerance, options.finest)) * length_;
    if (rounds_++ == options.rounds)
      return over();
    if (!smooth_)
      if (const Combination shortest = minimum_norm_subgradient(model_.cuts(), certificate_ball());
          shortest.length <= wanted) {
        auto certificate = confirmed(problem, at, shortest.weights, wanted);
        if (!certificate)
          return ++unconfirmed_ == options.unconfirmed ? over() : Step();
        if (!stationary_between(problem, *certificate, wanted))
          return {.certificate = std::move(certificate)};
        smooth_ = std::move(certificate);
      }
    const auto [direction, d] = downhill(problem, at);
    if (direction.subgradient.length > options.model_part * tolerance &&
        direction.predicted > options_.negligible(at.objective)) {
      Step step = follow(problem, at, direction, *d);
      if (step.found) {
        step.promised = direction.predicted;
        rounds_ = unconfirmed_ = 0;
        distance_ = 0;
        smooth_.reset();
      }
      return step;
    }
    const double least = std::max(options.least_distance * ball,
                                  options.gathered_part * tolerance / model_.curvature().largest());
    if (distance_ > 0 && distance_ <= least)
      return over();
    distance_ = std::max(least, distance_ > 0 ? options.nearer * distance_ : options.farthest * ball);
    gather_around(problem, at, direction.subgradient.weights, distance_);
    return {};
  }

  /// Restricts the subspace where it has almost as many vectors as may be stored.
  void make_room() {
    const BundleOptions& options = options_.bundle;
    const std::size_t most = std::min(options.dimension, options_.vectors);
    const auto part = [&](double of) { return static_cast<std::size_t>(of * static_cast<double>(most)); };
    if (span_.dimension() > part(options.restrict_above))
      span_.restrict(model_.restrict(part(options.restricted), part(options.carried), certificate_ball()));
  }

  [[nodiscard]] std::size_t dimension() const { return span_.dimension(); }

private:
  /// Radius of a certificate.
  double certificate_ball() const { return Options::ball(options_.tolerance) * length_; }

  /// The end of the rounds.
  Step over() { return {.certificate = std::move(smooth_), .over = true}; }

  /// A vector without its blocked values.
  Vector unblocked(const P& problem, Vector x) const {
    for (const Shared<Vector>& d : held_)
      problem.zero_blocked(x, *bounds_at_, *d);
    return x;
  }

  /// Coordinates of the values of a gradient that are not blocked.
  Coordinates coordinates(const P& problem, Vector g) {
    return span_.coordinates(problem, unblocked(problem, std::move(g)));
  }

  /// The cut of a gradient, as of the current point.
  Cut cut(const P& problem, const Vector& g) {
    const Coordinates here = coordinates(problem, g);
    return {here, here, {}, 0};
  }

  struct BoundedPoint {
    Vector u;                        ///< within the bounds
    std::optional<Vector> outside{}; ///< what was beyond them
  };

  /// The point at t times an offset.
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

  /// Length of the part of d that pushes values out of the bounds at u.
  static double outward(const P& problem, const Vector& u, const Vector& d) {
    if (!problem.bounded())
      return 0;
    return norm(problem, difference(tangential(problem, u, d), d));
  }

  /// The certificate of these weights of the cuts, if gradients evaluated anew confirm it. If they do not,
  /// they become the cuts of a new model, with only those values blocked that they push out of the bounds.
  std::optional<Certificate<Vector>> confirmed(P& problem, const Iterate<P>& at,
                                               const std::vector<double>& weights, double tolerance) {
    std::vector<Cut> gathered_anew; // in full, whatever is blocked
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
    held_ = {share(negative(std::move(gathered.sum)))};
    const Span<P> before = std::exchange(span_, Span<P>(options_.bundle.dependent));
    std::vector<Cut> cuts{cut(problem, at.g)};
    for (const Cut& anew : gathered_anew) {
      cuts.push_back(cut(problem, before.vector(anew.gathered, at.g)));
      cuts.back().offset = span_.coordinates(problem, before.vector(anew.offset, at.g));
    }
    model_ = BundleModel(options_.bundle, std::move(cuts));
    return std::nullopt;
  }

  /// Blocks in addition the values that d pushes out of the bounds.
  void block(const P& problem, const Vector& d) {
    held_.push_back(share(d));
    const Span<P> before = std::exchange(span_, Span<P>(options_.bundle.dependent));
    std::vector<Cut> cuts = model_.cuts();
    for (Cut& cut : cuts) {
      cut.gathered = coordinates(problem, before.vector(cut.gathered, d));
      cut.here = coordinates(problem, before.vector(cut.here, d));
      cut.offset = span_.coordinates(problem, before.vector(cut.offset, d));
    }
    model_ = BundleModel(options_.bundle, std::move(cuts));
  }

  /// The minimiser of the model, also as a vector unless it is zero; adds Hessian products until its
  /// curvature along the direction is accurate.
  std::pair<Direction, std::optional<Vector>> downhill(P& problem, const Iterate<P>& at) {
    for (int products = 0;;) {
      Direction direction = model_.minimise(span_.dimension());
      if (direction.subgradient.length == 0)
        return {std::move(direction), std::nullopt};
      // A short sum of long vectors has rounding where they have nothing, which would be blocked for ever.
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

  /// Tries the direction, whose vector is d, at decreasing lengths: the first that leads down makes a serious
  /// step, others make null steps.
  Step follow(P& problem, const Iterate<P>& at, const Direction& direction, const Vector& d) {
    const BundleOptions& options = options_.bundle;
    int null_steps = 0;
    for (double t = 1; t * direction.predicted > options_.negligible(at.objective); t *= options.shorter) {
      const Coordinates s = scaled(direction.d, t), Hs = scaled(direction.Hd, t);
      auto [u, outside] = point(problem, at, t, d);
      // Also where a bound is met exactly: block() could not hold there what is free at bounds_at_.
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
      if (!std::isfinite(norm(g))) // so far away leads a model that has lost its curvature to rounding
        return {.over = true};
      // A cut above J at the current point is invalid there: a shorter step meets the piece in between.
      if (model_.null_step(g, s, Hs, decrease) <= 0 || ++null_steps == options.null_steps)
        break;
    }
    return {};
  }

  /// Replaces the cuts that carry the model's minimum with these weights and were gathered farther than
  /// `distance` from the current point by cuts of gradients at that distance, where each is the highest.
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
  double length_ = 0; ///< of a long step
  Shared<Vector> bounds_at_;
  std::vector<Shared<Vector>> held_; ///< directions that push the blocked values out of the bounds there
  Span<P> span_;
  BundleModel model_;
  int rounds_ = 0, unconfirmed_ = 0;            ///< of the step so far
  double distance_ = 0;                         ///< at which gradients were last gathered, if they were
  std::optional<Certificate<Vector>> smooth_{}; ///< valid, but J may still descend on one smooth piece
};

} // namespace signorini::optimize
