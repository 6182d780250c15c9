#pragma once
#include "base/error.h"
#include "base/simplex_qp.h"
#include "optimize/curvature.h"
#include "optimize/wolfe_search.h"
#include <optional>
#include <utility>

namespace signorini::optimize {

/// Largest dimension of the subspace of a BundleModel, each a control in memory.
constexpr std::size_t most_kept_vectors = 120;

/// The model of a bundle method (Lemaréchal 1978) with the curvature of J (docs/method.md section 6): near a
/// kink
///     J(u + d) ≈ J(u) + max_i (g_i·d − e_i) + ½ d·Hd
/// with cuts of gradients g_i and linearisation errors e_i ≥ 0, and a single Hessian H, since the pieces of a
/// piecewise quadratic J have the same curvature along the edge where they meet. Where J at the model's
/// minimiser is too high, the gradient there becomes another cut; finally the steps are Newton's along the
/// edge.
template <TwiceDifferentiable P>
class BundleModel {
public:
  using Vector = typename P::Vector;

  /// The model of one cut, that of `at`. `step` is the length of a long step, which sets the radius of the
  /// ball.
  BundleModel(const P& problem, const Iterate<P>& at, double step) : BundleModel(step) {
    bounds_at_ = share(at.u);
    Vector down = at.g;
    down.scale(-1);
    active_bounds_.push_back(share(std::move(down)));
    const Coordinates g = gradient(problem, at.g);
    cuts_.push_back({g, g, {}, 0});
  }

  /// For serialize() from an archive.
  explicit BundleModel(double step) : ball_(1e-4 * step) {}

  template <class Archive>
  void serialize(Archive& archive) {
    archive("bundle/ball", ball_);
    archive("bundle/bounds_at", bounds_at_);
    serialize_list(archive, "bundle/active_bounds", active_bounds_,
                   [&](Shared<Vector>& d, const std::string& name) { archive(name, d); });
    span_.serialize(archive, "bundle/span");
    curvature_.serialize(archive, "bundle/curvature");
    serialize_list(archive, "bundle/cuts", cuts_, [&](Cut& cut, const std::string& name) {
      archive(name + "/gathered", cut.gathered);
      archive(name + "/here", cut.here);
      archive(name + "/offset", cut.offset);
      archive(name + "/linearisation_error", cut.linearisation_error);
    });
    archive("bundle/last_minimiser", last_minimiser_);
  }

  /// Result of a step: a new iterate, a certificate of stationarity, or neither.
  struct Step {
    std::optional<Iterate<P>> found{}; ///< the new iterate, the problem's trial
    bool at_other_bounds = false;      ///< the new iterate is at further bounds than the blocked ones
    std::optional<Certificate<Vector>> certificate{};
  };

  /// One descent step from `at`, where the model was made or the last step ended. A certificate is at most as
  /// long as `tolerance`.
  Step step(P& problem, const Iterate<P>& at, double tolerance) {
    constexpr int most_rounds = 100, most_claims = 10;
    int claims = 0;
    double size = 0;
    std::optional<Certificate<Vector>> smooth; // valid, but J may still descend on one smooth piece
    for (int round = 0; round < most_rounds && !full(); ++round) {
      if (!smooth)
        if (const Combination shortest = minimum_norm_subgradient(); shortest.length <= tolerance) {
          auto certificate = confirmed(problem, at, shortest.weights, tolerance);
          if (!certificate) {
            if (++claims == most_claims)
              break;
            continue;
          }
          if (!stationary_between(problem, *certificate, tolerance))
            return {.certificate = std::move(certificate)};
          smooth = std::move(certificate);
        }
      const Direction direction = downhill(problem, at);
      if (direction.rest > tolerance / 2 && direction.predicted > rounding(at.objective)) {
        Step step = follow(problem, at, direction);
        if (step.found)
          return step;
      } else {
        // At a distance over which gradients change by less than tolerance/4; ten times farther where that
        // fails.
        constexpr double least = 1e-6; // of the ball: beyond the rounding of J's differences
        size =
            size > 0 ? 10 * size : std::clamp(tolerance / (4 * curvature_.largest()), least * ball_, ball_);
        if (size > ball_)
          break;
        gather_around(problem, at, direction.weights, size);
      }
    }
    return {.certificate = std::move(smooth)};
  }

  /// Whether the subspace is so large that a new model should replace this one.
  [[nodiscard]] bool full() const { return span_.dimension() > most_kept_vectors; }

private:
  struct Cut {
    Coordinates gathered;           ///< its gradient where it was evaluated
    Coordinates here;               ///< the same moved to the current point by Hessian products
    Coordinates offset;             ///< from the current point to where it was evaluated
    double linearisation_error = 0; ///< e_i: how far the cut lies below J at the current point
  };

  struct Direction {
    Coordinates d, Hd;
    std::vector<double> weights; ///< of the cuts, Σ = 1
    double rest = 0;             ///< length of the combination of their gradients
    double predicted = 0;        ///< decrease of J
  };

  /// Coordinates of a gradient without the blocked values.
  Coordinates gradient(const P& problem, const Vector& g) {
    Vector free = g;
    zero_blocked(problem, free);
    return span_.coordinates(problem, std::move(free));
  }

  void zero_blocked(const P& problem, Vector& w) const {
    for (const Shared<Vector>& d : active_bounds_)
      problem.zero_blocked(w, *bounds_at_, *d);
  }

  /// Blocks in addition the values that d pushes out of the bounds, and restarts the subspace without them.
  void activate_bounds(const P& problem, Vector d) {
    active_bounds_.push_back(share(std::move(d)));
    const Span<P> before = std::exchange(span_, {});
    last_minimiser_.clear();
    curvature_ = {};
    for (Cut& cut : cuts_) {
      cut.gathered = gradient(problem, before.vector(cut.gathered, *bounds_at_));
      cut.here = gradient(problem, before.vector(cut.here, *bounds_at_));
      cut.offset = span_.coordinates(problem, before.vector(cut.offset, *bounds_at_));
    }
  }

  /// The certificate of these weights of the cuts, if it is confirmed: the gradients are evaluated anew where
  /// they were gathered, and the stationarity measure of their combination, blocked values included, is at
  /// most `tolerance`. It does not depend on the model. If not confirmed, the model is rebuilt from these
  /// gradients, with only those values blocked that their combination pushes to the bounds.
  std::optional<Certificate<Vector>> confirmed(P& problem, const Iterate<P>& at,
                                               const std::vector<double>& weights, double tolerance) {
    Certificate<Vector> certificate;
    std::vector<std::pair<Vector, Vector>> gathered; // offset and gradient
    Vector sum = at.g;
    sum.scale(weights.front());
    bool whole = true;
    if (weights.front() > 0) {
      certificate.points.push_back(at.u);
      certificate.weights.push_back(weights.front());
    }
    for (std::size_t i = 1; i < cuts_.size(); ++i) {
      if (!(weights[i] > 0))
        continue;
      Vector u = point(problem, cuts_[i], at), offset = u;
      offset.add(-1, at.u);
      if (!std::isfinite(value(problem, u))) {
        whole = false;
        continue;
      }
      certificate.radius = std::max(certificate.radius, norm(problem, offset));
      gathered.emplace_back(std::move(offset), problem.trial_gradient());
      sum.add(weights[i], gathered.back().second);
      certificate.points.push_back(std::move(u));
      certificate.weights.push_back(weights[i]);
    }
    certificate.length = stationarity(problem, at.u, sum);
    constexpr double rounding = 1e-9; // relative, of differences of controls 1e4 times as long
    if (whole && certificate.length <= tolerance && certificate.radius <= (1 + rounding) * ball_)
      return certificate;
    sum.scale(-1);
    active_bounds_ = {share(std::move(sum))};
    span_ = {};
    curvature_ = {};
    last_minimiser_.clear();
    cuts_.clear();
    const Coordinates here = gradient(problem, at.g);
    cuts_.push_back({here, here, {}, 0});
    for (const auto& [offset, g] : gathered) {
      const Coordinates free = gradient(problem, g);
      cuts_.push_back({free, free, span_.coordinates(problem, offset), 0});
    }
    return std::nullopt;
  }

  /// Whether J is stationary at the same combination of the points. Where they lie on one smooth piece, its
  /// gradient there is the combination of theirs: there is no kink between them.
  static bool stationary_between(P& problem, const Certificate<Vector>& certificate, double tolerance) {
    Vector u = certificate.points.front();
    u.scale(certificate.weights.front());
    for (std::size_t i = 1; i < certificate.points.size(); ++i)
      u.add(certificate.weights[i], certificate.points[i]);
    problem.project(u); // for rounding
    return std::isfinite(value(problem, u)) &&
           stationarity(problem, u, problem.trial_gradient()) <= tolerance;
  }

  /// Where the gradient of a cut was evaluated.
  Vector point(const P& problem, const Cut& cut, const Iterate<P>& at) const {
    Vector u = at.u;
    u.add(1, span_.vector(cut.offset, at.u));
    problem.project(u); // for rounding
    return u;
  }

  struct Combination {
    double length = 0;
    std::vector<double> weights; ///< of all cuts
  };

  /// The shortest convex combination of the gradients within the ball around the current point, whose own
  /// gradient is always among them (Goldstein 1977).
  [[nodiscard]] Combination minimum_norm_subgradient() const {
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < cuts_.size(); ++i)
      if (i == 0 || norm(cuts_[i].offset) <= ball_)
        near.push_back(i);
    std::vector<double> products;
    for (std::size_t i : near)
      for (std::size_t j : near)
        products.push_back(dot(cuts_[i].gathered, cuts_[j].gathered));
    const std::vector<double> weights = simplex_qp(products, std::vector<double>(near.size()));
    Combination shortest{0, std::vector<double>(cuts_.size())};
    Coordinates sum;
    for (std::size_t i = 0; i < near.size(); ++i) {
      add(sum, weights[i], cuts_[near[i]].gathered);
      shortest.weights[near[i]] = weights[i];
    }
    shortest.length = norm(sum);
    return shortest;
  }

  /// max_i (g_i·d − e_i).
  [[nodiscard]] double highest(const Coordinates& d) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const Cut& cut : cuts_)
      most = std::max(most, dot(cut.here, d) - cut.linearisation_error);
    return most;
  }

  /// The minimiser of the model with the approximation B for H. Where the known curvature is inconsistent, so
  /// that B is not positive definite, the oldest pair is dropped. Throws SolverFailure.
  Direction model_minimiser() {
    for (;; curvature_.forget_oldest()) {
      try {
        return model_minimiser(curvature_.matrix(span_.dimension()));
      } catch (const SolverFailure&) {
        if (curvature_.empty())
          throw;
      }
    }
  }

  Direction model_minimiser(std::vector<double> B) const {
    const std::size_t n = span_.dimension(), m = cuts_.size();
    std::vector<double> columns; // B⁻¹ g_i
    for (const Cut& cut : cuts_) {
      columns.insert(columns.end(), cut.here.begin(), cut.here.end());
      columns.resize(columns.size() + n - cut.here.size());
    }
    solve_dense(std::move(B), columns);
    const auto column = [&](std::size_t i) {
      return Coordinates(columns.begin() + static_cast<std::ptrdiff_t>(i * n),
                         columns.begin() + static_cast<std::ptrdiff_t>((i + 1) * n));
    };
    std::vector<double> products(m * m), linearisation_errors;
    for (std::size_t i = 0; i < m; ++i) {
      const Coordinates of_i = column(i);
      for (std::size_t j = 0; j <= i; ++j)
        products[i * m + j] = products[j * m + i] = dot(of_i, cuts_[j].here);
      linearisation_errors.push_back(cuts_[i].linearisation_error);
    }
    Direction direction;
    direction.weights = simplex_qp(products, linearisation_errors);
    Coordinates rest;
    for (std::size_t i = 0; i < m; ++i) {
      add(direction.d, -direction.weights[i], column(i));
      add(rest, direction.weights[i], cuts_[i].here);
    }
    direction.rest = norm(rest);
    direction.predicted = -highest(direction.d) + dot(direction.d, rest) / 2; // B d = −rest
    return direction;
  }

  /// The minimiser of the model; adds Hessian products until its curvature along the direction is accurate.
  Direction downhill(P& problem, const Iterate<P>& at) {
    constexpr int most_products = 10;
    for (int products = 1;; ++products) {
      Direction direction = model_minimiser();
      if (direction.rest == 0)
        return direction;
      const double modelled = -2 * (direction.predicted + highest(direction.d));
      last_minimiser_ = direction.d;
      const Vector d = span_.vector(direction.d, at.u);
      Vector out = tangential(problem, at.u, d);
      out.add(-1, d);
      if (constexpr double rounding = 1e-9; norm(problem, out) > rounding * norm(direction.d)) {
        activate_bounds(problem, d);
        continue;
      }
      Vector product = problem.hessian_product(d);
      zero_blocked(problem, product);
      direction.Hd = span_.coordinates(problem, std::move(product));
      const double curvature = dot(direction.d, direction.Hd);
      direction.predicted = -highest(direction.d) - curvature / 2;
      if (curvature > 0)
        curvature_.learn(direction.d, direction.Hd);
      if (std::abs(curvature - modelled) <= std::abs(direction.predicted) || products == most_products)
        return direction;
    }
  }

  /// J at a trial; NaN where a solver fails, which counts as too long a step.
  static double value(P& problem, const Vector& trial) {
    try {
      return problem.value(trial);
    } catch (const SolverFailure&) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  }

  /// Tries the direction at decreasing lengths; where J is too high the gradient there becomes a cut.
  Step follow(P& problem, const Iterate<P>& at, const Direction& direction) {
    constexpr double sufficient = 0.1, shorter = 0.25;
    constexpr int most_pieces_met = 3;
    int met = 0;
    for (double t = 1; t * direction.predicted > rounding(at.objective); t *= shorter) {
      const Coordinates s = scaled(direction.d, t), Hs = scaled(direction.Hd, t);
      Vector trial = at.u;
      trial.add(1, span_.vector(s, at.u));
      Vector outside = trial;
      problem.project(trial);
      outside.add(-1, trial);
      const bool at_other_bounds = norm(problem, outside) > 0;
      const double here = value(problem, trial), decrease = at.objective - here;
      if (decrease >= sufficient * t * direction.predicted) { // false for NaN
        Vector g = problem.trial_gradient();
        const Coordinates gathered = gradient(problem, g);
        move(s, Hs, decrease, gathered);
        return {Iterate<P>{std::move(trial), here, std::move(g)}, at_other_bounds};
      }
      if (at_other_bounds || !std::isfinite(here))
        continue;
      const double above = learn(gradient(problem, problem.trial_gradient()), s, Hs, decrease);
      // A cut above J at the current point is invalid there: a shorter step meets the piece in between.
      if (above <= 0 || ++met == most_pieces_met)
        break;
    }
    return {};
  }

  /// Adds the cut of the gradient g of J at s, where J is lower by `decrease`. Returns how far the cut lies
  /// above J at the current point. Its linearisation error is the modulus of that (Kiwiel 1985).
  double learn(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease) {
    const double below = decrease + dot(g, s) - dot(s, Hs) / 2;
    Coordinates here = g;
    add(here, -1, Hs);
    keep({g, std::move(here), s, std::abs(below)});
    return -below;
  }

  void keep(Cut cut) {
    make_room();
    cuts_.push_back(std::move(cut));
  }

  /// Drops the cut that is lowest at the model's minimiser, if there are most_cuts. That of the current point
  /// is kept: without it the model would not interpolate J there.
  void make_room() {
    if (cuts_.size() == most_cuts)
      cuts_.erase(std::ranges::min_element(cuts_.begin() + 1, cuts_.end(), {}, [this](const Cut& p) {
        return dot(p.here, last_minimiser_) - p.linearisation_error;
      }));
  }

  /// Moves the current point by s, where J is lower by `decrease` and has the gradient g.
  void move(const Coordinates& s, const Coordinates& Hs, double decrease, const Coordinates& g) {
    for (Cut& cut : cuts_) {
      cut.linearisation_error =
          std::max(0.0, cut.linearisation_error - decrease - dot(cut.here, s) - dot(s, Hs) / 2);
      add(cut.here, 1, Hs);
      add(cut.offset, -1, s);
    }
    add(last_minimiser_, -1, s);
    make_room();
    cuts_.insert(cuts_.begin(), {g, g, {}, 0});
  }

  /// Replaces the cuts of positive weight that were gathered farther than `size` from the current point by
  /// gradients at that distance, evaluated where each of these cuts is the highest.
  void gather_around(P& problem, const Iterate<P>& at, const std::vector<double>& weights, double size) {
    constexpr double unused = 1e-8;
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < weights.size(); ++i)
      if (weights[i] > unused)
        used.push_back(i);
    std::vector<Coordinates> offsets;
    for (std::size_t i : used)
      if (norm(cuts_[i].offset) > size)
        if (const auto offset = highest_at(i, used, size))
          offsets.push_back(*offset);
    // A cut of a distant gradient need not be valid here.
    for (std::size_t i = weights.size(); i-- > 0;)
      if (norm(cuts_[i].offset) > size && weights[i] > unused)
        cuts_.erase(cuts_.begin() + static_cast<std::ptrdiff_t>(i));
    for (Coordinates& offset : offsets) {
      Vector trial = at.u;
      trial.add(1, span_.vector(offset, at.u));
      Vector outside = trial;
      problem.project(trial);
      outside.add(-1, trial);
      if (norm(problem, outside) > 0)
        add(offset, -1, span_.coordinates(problem, std::move(outside)));
      if (const double there = value(problem, trial); std::isfinite(there))
        learn(gradient(problem, problem.trial_gradient()), offset, {}, at.objective - there);
    }
  }

  /// An offset of length `size` along which cut i rises above the other used ones; none if they are
  /// dependent.
  [[nodiscard]] std::optional<Coordinates> highest_at(std::size_t i, const std::vector<std::size_t>& used,
                                                      double size) const {
    std::vector<Coordinates> edges;
    for (std::size_t j : used)
      if (j != i) {
        edges.push_back(cuts_[i].here);
        add(edges.back(), -1, cuts_[j].here);
      }
    if (edges.empty())
      return std::nullopt;
    std::vector<double> products, weights(edges.size(), 1.0);
    for (const Coordinates& a : edges)
      for (const Coordinates& b : edges)
        products.push_back(dot(a, b));
    try {
      solve_dense(std::move(products), weights);
    } catch (const SolverFailure&) { // linearly dependent
      return std::nullopt;
    }
    Coordinates offset;
    for (std::size_t j = 0; j < edges.size(); ++j)
      add(offset, weights[j], edges[j]);
    return scaled(offset, size / norm(offset));
  }

  static constexpr std::size_t most_cuts = 40;

  Shared<Vector> bounds_at_;
  std::vector<Shared<Vector>> active_bounds_; ///< directions that push the blocked values out of the bounds
  double ball_;
  Span<P> span_;
  Curvature curvature_;
  std::vector<Cut> cuts_;      ///< never empty: the first is that of the current point
  Coordinates last_minimiser_; ///< the model's last one, from the current point
};

} // namespace signorini::optimize
