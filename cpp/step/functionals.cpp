// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/functionals.h"
#include "base/error.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::step {
using petsc::check;

petsc::Vector translation(const fem::Space& space, std::size_t axis) {
  petsc::Vector e = space.vector();
  const petsc::WriteArray values(e);
  const auto dim = static_cast<std::size_t>(space.dim());
  for (std::size_t node = 0; node < static_cast<std::size_t>(space.owned_nodes()); ++node)
    values[dim * node + axis] = 1;
  return e;
}

Mean mean(const fem::Space& space, Mat matrix, std::size_t component) {
  const petsc::Vector e = translation(space, component);
  Mean mean{.weights = petsc::zero_like(e), .measure = 0};
  check(MatMult(matrix, e, mean.weights));
  mean.measure = petsc::dot(e, mean.weights);
  check(VecScale(mean.weights, 1 / mean.measure));
  return mean;
}

void require_inside(const fem::Space& space, const fem::Sampler& sampler, std::size_t number,
                    const std::vector<double>& point, const std::string& key) {
  const double outside = 0.01 * space.mesh().diameter(), distance = sampler.distances()[number];
  if (distance > outside)
    throw UserError(fmt::format("{}.point: found ({:.6g}), which is {:.4g} m outside of the body; choose a "
                                "point of the undeformed body",
                                key, fmt::join(point, ", "), distance));
}

SparseFunctional::SparseFunctional(Vec functional) {
  const petsc::ReadArray values(functional);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] != 0)
      row_.emplace_back(static_cast<int>(i), values[i]);
}

double SparseFunctional::operator()(std::span<const double> values) const {
  double sum = 0;
  for (const auto& [dof, weight] : row_)
    sum += weight * values[dof];
  return sum;
}

void SparseFunctional::add_to(std::span<double> sum, double factor) const {
  for (const auto& [dof, weight] : row_)
    sum[dof] += factor * weight;
}

namespace {

bool counts(const contact::ContactPairs& pairs, int pair, ObstacleComponent of) {
  return of.obstacle < 0 || pairs.obstacles()[pair] == of.obstacle;
}

/// Component of the direction along which a row measures the motion of its pair.
double at_node(const contact::ConstraintRows& rows, std::size_t row, int component) {
  return rows.lift(static_cast<int>(row))[component];
}

} // namespace

double force_on_body(const contact::ContactPairs& pairs, const contact::ConstraintRows& rows,
                     ObstacleComponent of, std::span<const double> lambda) {
  double sum = 0;
  for (int i = 0; i < pairs.count(); ++i) {
    if (!counts(pairs, i, of))
      continue;
    double on_obstacle = 0;
    for (std::size_t c = 0; c < rows.size(i); ++c)
      on_obstacle += lambda[rows.row(i, c)] * at_node(rows, rows.row(i, c), of.component);
    sum -= pairs.side(pairs.obstacles()[i]) * on_obstacle;
  }
  return sum;
}

void add_force_dual(const contact::ContactPairs& pairs, ObstacleComponent of, double factor,
                    std::span<double> dual) {
  const contact::ConstraintRows& rows = pairs.rows();
  for (int i = 0; i < pairs.count(); ++i)
    if (counts(pairs, i, of))
      for (std::size_t c = 0; c < rows.size(i); ++c)
        dual[rows.row(i, c)] -=
            factor * pairs.side(pairs.obstacles()[i]) * at_node(rows, rows.row(i, c), of.component);
}

} // namespace signorini::step
