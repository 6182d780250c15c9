// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/bundle_model.h"
#include "base/error.h"
#include "linalg/dense.h"
#include "linalg/simplex_qp.h"
#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <ranges>

namespace signorini::optimize {

void Curvature::learn(const Coordinates& d, const Coordinates& y) {
  const double curvature = dot(d, y) / dot(d, d);
  least_ = known_.empty() ? curvature : std::min(least_, curvature);
  largest_ = std::max(largest_, norm(y) / norm(d));
  known_.emplace_back(d, y);
}

std::optional<std::vector<double>> Curvature::matrix(std::size_t n) const {
  std::vector<double> B(n * n);
  for (std::size_t i = 0; i < n; ++i)
    B[i * n + i] = least_;
  const std::size_t k = known_.size();
  std::vector<double> DD(k * k), DY(k * k), D(n * k), Y(n * k);
  for (std::size_t i = 0; i < k; ++i) {
    const auto& [d, y] = known_[i];
    for (std::size_t j = 0; j < k; ++j) {
      DD[i * k + j] = dot(d, known_[j].first);
      DY[i * k + j] = (dot(d, known_[j].second) + dot(known_[j].first, y)) / 2;
    }
    for (std::size_t c = 0; c < d.size(); ++c)
      D[c * k + i] = d[c];
    for (std::size_t c = 0; c < y.size(); ++c)
      Y[c * k + i] = y[c];
  }
  std::vector<double> by_DD = D, by_DY = Y;
  if (!solve_dense(DD, by_DD) || !solve_dense(DY, by_DY))
    return std::nullopt;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t l = 0; l < k; ++l)
        B[i * n + j] += Y[i * k + l] * by_DY[j * k + l] - least_ * D[i * k + l] * by_DD[j * k + l];
  return B;
}

namespace {

/// Returns the Gram matrix of the vectors (m × m).
std::vector<double> products(const std::vector<Coordinates>& vectors) {
  std::vector<double> all;
  for (const Coordinates& a : vectors)
    for (const Coordinates& b : vectors)
      all.push_back(dot(a, b));
  return all;
}

} // namespace

Combination minimum_norm_subgradient(std::span<const Cut> cuts, double radius) {
  std::vector<std::size_t> near;
  std::vector<Coordinates> gradients;
  for (std::size_t i = 0; i < cuts.size(); ++i)
    if (i == 0 || norm(cuts[i].offset) <= radius) {
      near.push_back(i);
      gradients.push_back(cuts[i].gathered);
    }
  const auto weights = simplex_qp(products(gradients), std::vector<double>(near.size()));
  if (!weights)
    throw SolverFailure("the gradients gathered at a kink have no shortest convex combination");
  Combination shortest{0, std::vector<double>(cuts.size())};
  Coordinates sum;
  for (std::size_t i = 0; i < near.size(); ++i) {
    add(sum, (*weights)[i], gradients[i]);
    shortest.weights[near[i]] = (*weights)[i];
  }
  shortest.length = norm(sum);
  return shortest;
}

double highest(std::span<const Cut> cuts, const Coordinates& d) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Cut& cut : cuts)
    most = std::max(most, dot(cut.here, d) - cut.linearisation_error);
  return most;
}

std::optional<Direction> model_minimiser(std::span<const Cut> cuts, std::vector<double> B, std::size_t n) {
  const std::size_t m = cuts.size();
  std::vector<double> columns; // B⁻¹ g_i
  for (const Cut& cut : cuts) {
    columns.insert(columns.end(), cut.here.begin(), cut.here.end());
    columns.resize(columns.size() + n - cut.here.size());
  }
  if (!solve_dense(std::move(B), columns))
    return std::nullopt;
  const auto column = [&](std::size_t i) {
    return Coordinates(columns.begin() + static_cast<std::ptrdiff_t>(i * n),
                       columns.begin() + static_cast<std::ptrdiff_t>((i + 1) * n));
  };
  std::vector<double> G(m * m), linearisation_errors;
  for (std::size_t i = 0; i < m; ++i) {
    const Coordinates of_i = column(i);
    for (std::size_t j = 0; j <= i; ++j)
      G[i * m + j] = G[j * m + i] = dot(of_i, cuts[j].here);
    linearisation_errors.push_back(cuts[i].linearisation_error);
  }
  auto weights = simplex_qp(G, linearisation_errors);
  if (!weights)
    return std::nullopt;
  Direction direction;
  Coordinates sum;
  for (std::size_t i = 0; i < m; ++i) {
    add(direction.d, -(*weights)[i], column(i));
    add(sum, (*weights)[i], cuts[i].here);
  }
  direction.subgradient = {norm(sum), std::move(*weights)};
  direction.predicted = -highest(cuts, direction.d) + dot(direction.d, sum) / 2; // B d = −sum
  return direction;
}

std::optional<Coordinates> offset_above(std::span<const Cut> cuts, std::size_t i,
                                        std::span<const std::size_t> carrying, double length) {
  std::vector<Coordinates> edges;
  for (std::size_t j : carrying)
    if (j != i) {
      edges.push_back(cuts[i].here);
      add(edges.back(), -1, cuts[j].here);
    }
  std::vector<double> weights(edges.size(), 1.0);
  if (edges.empty() || !solve_dense(products(edges), weights))
    return std::nullopt;
  Coordinates offset;
  for (std::size_t j = 0; j < edges.size(); ++j)
    add(offset, weights[j], edges[j]);
  return scaled(offset, length / norm(offset));
}

Direction BundleModel::minimise(std::size_t n) {
  for (;; curvature_.forget_oldest()) {
    auto B = curvature_.matrix(n);
    if (auto direction = B ? model_minimiser(cuts_, std::move(*B), n) : std::nullopt) {
      if (direction->subgradient.length != 0)
        last_minimiser_ = direction->d;
      return std::move(*direction);
    }
    if (curvature_.empty())
      throw SolverFailure("the model of J at a kink has no minimiser");
  }
}

bool BundleModel::learn(Direction& direction, Coordinates Hd) {
  const double most = highest(cuts_, direction.d), modelled = -2 * (direction.predicted + most);
  const double curvature = dot(direction.d, Hd);
  if (curvature > 0)
    curvature_.learn(direction.d, Hd);
  direction.Hd = std::move(Hd);
  direction.predicted = -most - curvature / 2;
  return std::abs(curvature - modelled) <= std::abs(direction.predicted);
}

double BundleModel::null_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs,
                              double decrease) {
  const double below = decrease + dot(g, s) - dot(s, Hs) / 2;
  Coordinates here = g;
  add(here, -1, Hs);
  make_room();
  cuts_.push_back({g, std::move(here), s, std::abs(below)});
  return -below;
}

void BundleModel::serious_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs,
                               double decrease) {
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

std::vector<Coordinates> BundleModel::drop_distant(const std::vector<double>& weights, double distance) {
  std::vector<std::size_t> carrying;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > options_.carrying)
      carrying.push_back(i);
  std::vector<Coordinates> offsets;
  for (std::size_t i : carrying)
    if (norm(cuts_[i].offset) > distance)
      if (auto offset = offset_above(cuts_, i, carrying, distance))
        offsets.push_back(std::move(*offset));
  for (std::size_t i : carrying | std::views::reverse)
    if (norm(cuts_[i].offset) > distance)
      cuts_.erase(cuts_.begin() + static_cast<std::ptrdiff_t>(i));
  return offsets;
}

std::vector<Coordinates> BundleModel::restrict(std::size_t dimension, std::size_t carried, double radius) {
  Orthonormal basis(options_.dependent);
  std::vector<Cut> kept, others;
  const auto take = [&](Cut& cut, std::size_t most) {
    if (!basis.take({&cut.gathered, &cut.here, &cut.offset}, most))
      return false;
    kept.push_back(std::move(cut));
    return true;
  };
  std::vector<double> weights = minimum_norm_subgradient(cuts_, radius).weights;
  weights.front() = 1; // the cut of the current point stays
  std::vector<std::size_t> order(cuts_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return weights[i]; });
  for (std::size_t i : order)
    if (!(weights[i] > options_.carrying && take(cuts_[i], carried)))
      others.push_back(std::move(cuts_[i]));
  std::ranges::stable_sort(others, std::greater(), [this](const Cut& cut) { return at_minimiser(cut); });
  std::vector<std::pair<Coordinates, Coordinates>> pairs;
  const auto& known = curvature_.directions_with_products();
  for (std::size_t i = 0; i < std::max(others.size(), known.size()); ++i) { // alternately
    if (i < known.size()) {
      const auto& [d, y] = known[known.size() - 1 - i];
      if (basis.take({&d, &y}, dimension))
        pairs.emplace(pairs.begin(), basis.of(d), basis.of(y));
    }
    if (i < others.size())
      take(others[i], dimension);
  }
  for (Cut& cut : kept)
    cut = {basis.of(cut.gathered), basis.of(cut.here), basis.of(cut.offset), cut.linearisation_error};
  for (auto& [d, y] : pairs) // the first pairs date from a shorter basis
    d.resize(basis.vectors().size()), y.resize(basis.vectors().size());
  cuts_ = std::move(kept);
  curvature_.set_pairs(std::move(pairs));
  last_minimiser_ = basis.of(last_minimiser_);
  return basis.vectors();
}

double BundleModel::at_minimiser(const Cut& cut) const {
  return dot(cut.here, last_minimiser_) - cut.linearisation_error;
}

void BundleModel::make_room() {
  if (cuts_.size() == options_.cuts)
    cuts_.erase(std::ranges::min_element(cuts_.begin() + 1, cuts_.end(), {},
                                         [this](const Cut& cut) { return at_minimiser(cut); }));
}

} // namespace signorini::optimize
