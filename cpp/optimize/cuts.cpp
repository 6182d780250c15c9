// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/cuts.h"
#include "base/error.h"
#include "linalg/dense.h"
#include "linalg/simplex_qp.h"
#include <limits>

namespace signorini::optimize {

namespace {

/// Gram matrix of vectors (m × m).
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

} // namespace signorini::optimize
