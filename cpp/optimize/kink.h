#pragma once
#include "base/best_combination.h"
#include "base/error.h"
#include "optimize/curvature.h"
#include "optimize/wolfe_search.h"
#include <optional>
#include <utility>

namespace signorini::optimize {

/// Controls that a KinkModel may keep.
constexpr std::size_t most_kept_vectors = 120;

/// J near a kink as the largest of quadratic pieces, J(u + d) ≈ J(u) + max_i (g_i·d − e_i) + ½ d·Hd, by the
/// gradients that were met and one Hessian: the pieces of a piecewise quadratic J have the same curvature
/// along the edge where they meet. Where J is higher than at the minimiser of the model, the piece met there
/// is one more (a bundle method, Lemaréchal 1978, with the curvature of J); at the end its steps are Newton's
/// along the edge.
template <TwiceDifferentiable P>
class KinkModel {
public:
  using Vector = typename P::Vector;

  /// The model of one piece. `step` is the length of a long one.
  KinkModel(const P& problem, const Iterate<P>& at, double step) : KinkModel(step) {
    held_at_ = share(at.u);
    Vector down = at.g;
    down.scale(-1);
    held_by_.push_back(share(std::move(down)));
    const Coordinates g = gradient(problem, at.g);
    pieces_.push_back({g, g, {}, 0});
  }

  /// One to be read from an archive.
  explicit KinkModel(double step) : ball_(1e-4 * step) {}

  template <class Archive>
  void exchange(Archive& archive) {
    archive("kink/ball", ball_);
    archive("kink/held_at", held_at_);
    exchange_list(archive, "kink/held_by", held_by_,
                  [&](Shared<Vector>& d, const std::string& name) { archive(name, d); });
    span_.exchange(archive, "kink/span");
    curvature_.exchange(archive, "kink/curvature");
    exchange_list(archive, "kink/pieces", pieces_, [&](Piece& piece, const std::string& name) {
      archive(name + "/gathered", piece.gathered);
      archive(name + "/here", piece.here);
      archive(name + "/offset", piece.offset);
      archive(name + "/price", piece.price);
    });
    archive("kink/last_minimiser", last_minimiser_);
  }

  /// Where the model leads: to another point, to a certificate that there is none to go to, or nowhere.
  struct Step {
    std::optional<Iterate<P>> found{}; ///< where it moved; then it is the problem's trial
    bool at_other_bounds = false;      ///< than the model holds
    std::optional<Certificate<Vector>> certificate{};
  };

  /// One step down from `at`, where the model was made or the last step led to. A certificate is one by `tolerance`.
  Step step(P& problem, const Iterate<P>& at, double tolerance) {
    constexpr int most_rounds = 100, most_claims = 10;
    int claims = 0;
    double size = 0;
    std::optional<Certificate<Vector>> smooth; // true, but there may still be a way down to a small gradient
    for (int round = 0; round < most_rounds && !full(); ++round) {
      if (!smooth)
        if (const Combination shortest = shortest_near(); shortest.length <= tolerance) {
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
        // So near that the curvature does not show in the combination; farther where that finds no way on.
        constexpr double least = 1e-6; // of the ball: J's differences have digits there
        size = size > 0 ? 10 * size : std::clamp(tolerance / (4 * curvature_.largest()), least * ball_, ball_);
        if (size > ball_)
          break;
        gather_around(problem, at, direction.weights, size);
      }
    }
    return {.certificate = std::move(smooth)};
  }

  /// Whether it has grown so large that another should take its place.
  [[nodiscard]] bool full() const { return span_.dimension() > most_kept_vectors; }

private:
  struct Piece {
    Coordinates gathered; ///< its gradient where it was met
    Coordinates here;     ///< the same at the current point, by Hessian products
    Coordinates offset;   ///< from the current point to where it was met
    double price = 0;     ///< e_i: how far it lies below J at the current point
  };

  struct Direction {
    Coordinates d, Hd;
    std::vector<double> weights; ///< of the pieces
    double rest = 0;             ///< length of the combination of their gradients
    double predicted = 0;        ///< decrease of J
  };

  /// Its coordinates, without the held values.
  Coordinates gradient(const P& problem, const Vector& g) {
    Vector free = g;
    hold(problem, free);
    return span_.coordinates(problem, std::move(free));
  }

  void hold(const P& problem, Vector& w) const {
    for (const Shared<Vector>& d : held_by_)
      problem.hold(w, *held_at_, *d);
  }

  /// Holds what d pushes out of the bounds too.
  void hold_more(const P& problem, Vector d) {
    held_by_.push_back(share(std::move(d)));
    const Span<P> before = std::exchange(span_, {});
    last_minimiser_.clear();
    curvature_ = {};
    for (Piece& piece : pieces_) {
      piece.gathered = gradient(problem, before.vector(piece.gathered, *held_at_));
      piece.here = gradient(problem, before.vector(piece.here, *held_at_));
      piece.offset = span_.coordinates(problem, before.vector(piece.offset, *held_at_));
    }
  }

  /// The certificate that these weights of the pieces make, if the gradients themselves, evaluated anew where they were
  /// gathered, have a combination as short, what is held included: it owes nothing to the model. If not, the model goes
  /// on by these gradients, and without holding what their combination does not push to its bounds.
  std::optional<Certificate<Vector>> confirmed(P& problem, const Iterate<P>& at, const std::vector<double>& weights,
                                               double tolerance) {
    Certificate<Vector> certificate;
    std::vector<std::pair<Vector, Vector>> gathered; // offset and gradient
    Vector sum = at.g;
    sum.scale(weights.front());
    bool whole = true;
    if (weights.front() > 0) {
      certificate.points.push_back(at.u);
      certificate.weights.push_back(weights.front());
    }
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      if (!(weights[i] > 0))
        continue;
      Vector u = point(problem, pieces_[i], at), offset = u;
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
    constexpr double rounding = 1e-9; // of offsets, beside controls 1e4 times as long
    if (whole && certificate.length <= tolerance && certificate.radius <= (1 + rounding) * ball_)
      return certificate;
    sum.scale(-1);
    held_by_ = {share(std::move(sum))};
    span_ = {};
    curvature_ = {};
    last_minimiser_.clear();
    pieces_.clear();
    const Coordinates here = gradient(problem, at.g);
    pieces_.push_back({here, here, {}, 0});
    for (const auto& [offset, g] : gathered) {
      const Coordinates free = gradient(problem, g);
      pieces_.push_back({free, free, span_.coordinates(problem, offset), 0});
    }
    return std::nullopt;
  }

  /// Whether J is stationary at the same combination of the points. Where they lie on one smooth piece its gradient there is
  /// the combination of theirs, and there is no kink between them.
  static bool stationary_between(P& problem, const Certificate<Vector>& certificate, double tolerance) {
    Vector u = certificate.points.front();
    u.scale(certificate.weights.front());
    for (std::size_t i = 1; i < certificate.points.size(); ++i)
      u.add(certificate.weights[i], certificate.points[i]);
    problem.project(u); // for rounding
    return std::isfinite(value(problem, u)) && stationarity(problem, u, problem.trial_gradient()) <= tolerance;
  }

  /// Where a piece was met.
  Vector point(const P& problem, const Piece& piece, const Iterate<P>& at) const {
    Vector u = at.u;
    u.add(1, span_.vector(piece.offset, at.u));
    problem.project(u); // for rounding
    return u;
  }

  struct Combination {
    double length = 0;
    std::vector<double> weights; ///< of all pieces
  };

  /// The shortest convex combination of the gradients gathered near the current point, that of the point itself among
  /// them.
  [[nodiscard]] Combination shortest_near() const {
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (i == 0 || norm(pieces_[i].offset) <= ball_)
        near.push_back(i);
    std::vector<double> products;
    for (std::size_t i : near)
      for (std::size_t j : near)
        products.push_back(dot(pieces_[i].gathered, pieces_[j].gathered));
    const std::vector<double> weights = best_combination(products, std::vector<double>(near.size()));
    Combination shortest{0, std::vector<double>(pieces_.size())};
    Coordinates sum;
    for (std::size_t i = 0; i < near.size(); ++i) {
      add(sum, weights[i], pieces_[near[i]].gathered);
      shortest.weights[near[i]] = weights[i];
    }
    shortest.length = norm(sum);
    return shortest;
  }

  /// max_i (g_i·d − e_i).
  [[nodiscard]] double highest(const Coordinates& d) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const Piece& piece : pieces_)
      most = std::max(most, dot(piece.here, d) - piece.price);
    return most;
  }

  /// The minimiser of the model with B for H. Where what is known of H contradicts itself the oldest is
  /// forgotten.
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
    const std::size_t n = span_.dimension(), m = pieces_.size();
    std::vector<double> columns; // B⁻¹ g_i
    for (const Piece& piece : pieces_) {
      columns.insert(columns.end(), piece.here.begin(), piece.here.end());
      columns.resize(columns.size() + n - piece.here.size());
    }
    solve_dense(std::move(B), columns);
    const auto column = [&](std::size_t i) {
      return Coordinates(columns.begin() + static_cast<std::ptrdiff_t>(i * n),
                         columns.begin() + static_cast<std::ptrdiff_t>((i + 1) * n));
    };
    std::vector<double> products(m * m), prices;
    for (std::size_t i = 0; i < m; ++i) {
      const Coordinates of_i = column(i);
      for (std::size_t j = 0; j <= i; ++j)
        products[i * m + j] = products[j * m + i] = dot(of_i, pieces_[j].here);
      prices.push_back(pieces_[i].price);
    }
    Direction direction;
    direction.weights = best_combination(products, prices);
    Coordinates rest;
    for (std::size_t i = 0; i < m; ++i) {
      add(direction.d, -direction.weights[i], column(i));
      add(rest, direction.weights[i], pieces_[i].here);
    }
    direction.rest = norm(rest);
    direction.predicted = -highest(direction.d) + dot(direction.d, rest) / 2; // B d = −rest
    return direction;
  }

  /// The minimiser of the model, with Hessian products until its curvature is right along it.
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
        hold_more(problem, d);
        continue;
      }
      Vector product = problem.hessian_product(d);
      hold(problem, product);
      direction.Hd = span_.coordinates(problem, std::move(product));
      const double curvature = dot(direction.d, direction.Hd);
      direction.predicted = -highest(direction.d) - curvature / 2;
      if (curvature > 0)
        curvature_.learn(direction.d, direction.Hd);
      if (std::abs(curvature - modelled) <= std::abs(direction.predicted) || products == most_products)
        return direction;
    }
  }

  /// J at a trial; NaN where a solver fails, which is too far.
  static double value(P& problem, const Vector& trial) {
    try {
      return problem.value(trial);
    } catch (const SolverFailure&) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  }

  /// Tries the direction, and where J is too high at its end learns the piece that was met there.
  Step follow(P& problem, const Iterate<P>& at, const Direction& direction) {
    constexpr double sufficient = 0.1, shorter = 0.25;
    constexpr int most_pieces_met = 3;
    int met = 0;
    for (double t = 1; t * direction.predicted > rounding(at.objective); t *= shorter) {
      const Coordinates s = scaled(direction.d, t), Hs = scaled(direction.Hd, t);
      Vector trial = at.u;
      trial.add(1, span_.vector(s, at.u));
      Vector cut = trial;
      problem.project(trial);
      cut.add(-1, trial);
      const bool at_other_bounds = norm(problem, cut) > 0;
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
      // A piece above J at the current point does not reach as far as there: the one in between is nearer.
      if (above <= 0 || ++met == most_pieces_met)
        break;
    }
    return {};
  }

  /// Keeps the piece of gradient g that J has at s, where it is lower by `decrease`. Returns how far it lies
  /// above J at the current point, for which it is no less to blame than for lying below (Kiwiel 1985).
  double learn(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease) {
    const double below = decrease + dot(g, s) - dot(s, Hs) / 2;
    Coordinates here = g;
    add(here, -1, Hs);
    keep({g, std::move(here), s, std::abs(below)});
    return -below;
  }

  void keep(Piece piece) {
    make_room();
    pieces_.push_back(std::move(piece));
  }

  /// Drops the piece that matters least where the model is least, if there are many. That of the current point stays:
  /// without it the model would say nothing of where it is.
  void make_room() {
    if (pieces_.size() == most_pieces)
      pieces_.erase(std::ranges::min_element(pieces_.begin() + 1, pieces_.end(), {}, [this](const Piece& p) {
        return dot(p.here, last_minimiser_) - p.price;
      }));
  }

  /// To s from the current point, where J is lower by `decrease` and has the gradient g.
  void move(const Coordinates& s, const Coordinates& Hs, double decrease, const Coordinates& g) {
    for (Piece& piece : pieces_) {
      piece.price = std::max(0.0, piece.price - decrease - dot(piece.here, s) - dot(s, Hs) / 2);
      add(piece.here, 1, Hs);
      add(piece.offset, -1, s);
    }
    add(last_minimiser_, -1, s);
    make_room();
    pieces_.insert(pieces_.begin(), {g, g, {}, 0});
  }

  /// Gathers the gradients of the pieces in use at points that far from the current one where each is the
  /// highest.
  void gather_around(P& problem, const Iterate<P>& at, const std::vector<double>& weights, double size) {
    constexpr double unused = 1e-8;
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < weights.size(); ++i)
      if (weights[i] > unused)
        used.push_back(i);
    std::vector<Coordinates> offsets;
    for (std::size_t i : used)
      if (norm(pieces_[i].offset) > size)
        if (const auto offset = highest_at(i, used, size))
          offsets.push_back(*offset);
    // What was met far away need not reach as far as here.
    for (std::size_t i = weights.size(); i-- > 0;)
      if (norm(pieces_[i].offset) > size && weights[i] > unused)
        pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(i));
    for (Coordinates& offset : offsets) {
      Vector trial = at.u;
      trial.add(1, span_.vector(offset, at.u));
      Vector cut = trial;
      problem.project(trial);
      cut.add(-1, trial);
      if (norm(problem, cut) > 0)
        add(offset, -1, span_.coordinates(problem, std::move(cut)));
      if (const double there = value(problem, trial); std::isfinite(there))
        learn(gradient(problem, problem.trial_gradient()), offset, {}, at.objective - there);
    }
  }

  /// An offset of length `size` along which piece i rises above the other used ones.
  [[nodiscard]] std::optional<Coordinates> highest_at(std::size_t i, const std::vector<std::size_t>& used,
                                                      double size) const {
    std::vector<Coordinates> edges;
    for (std::size_t j : used)
      if (j != i) {
        edges.push_back(pieces_[i].here);
        add(edges.back(), -1, pieces_[j].here);
      }
    if (edges.empty())
      return std::nullopt;
    std::vector<double> products, weights(edges.size(), 1.0);
    for (const Coordinates& a : edges)
      for (const Coordinates& b : edges)
        products.push_back(dot(a, b));
    try {
      solve_dense(std::move(products), weights);
    } catch (const SolverFailure&) { // pieces that depend on each other
      return std::nullopt;
    }
    Coordinates offset;
    for (std::size_t j = 0; j < edges.size(); ++j)
      add(offset, weights[j], edges[j]);
    return scaled(offset, size / norm(offset));
  }

  static constexpr std::size_t most_pieces = 40;

  Shared<Vector> held_at_;
  std::vector<Shared<Vector>> held_by_; ///< what pushes the held values to their bounds
  double ball_;
  Span<P> span_;
  Curvature curvature_;
  std::vector<Piece> pieces_;  ///< never empty: the first is that of the current point
  Coordinates last_minimiser_; ///< from the current point, the last one
};

} // namespace signorini::optimize
