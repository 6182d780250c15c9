// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/rigid_motions.h"
#include "fem/coherence.h"
#include "linalg/dense.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace signorini::fem {
using petsc::check;

namespace {

constexpr int most_parts = 16;
/// Share of the sum of all resistances of clamps below which a resistance counts as rounding error.
constexpr double rounding = 1e-10;

/// Rigid motions of one part of the mesh: translations along the axes, and rotations about the centre of the
/// part's nodes. Rotations are scaled to the same magnitude as the translations. A body of revolution has
/// only the translation along its axis.
std::vector<petsc::Vector> motions_of(const Space& space, const std::vector<int>& part_of_node, int part) {
  const auto dim = static_cast<std::size_t>(space.dim());
  std::array<double, 5> sums{}; // coordinates, their squares, number
  const auto for_each_node = [&](auto&& visit) {
    for (std::size_t node = 0; node < part_of_node.size(); ++node)
      if (part_of_node[node] == part)
        visit(node, &space.points()[3 * node]);
  };
  for_each_node([&](std::size_t, const double* x) {
    for (std::size_t c = 0; c < 3; ++c)
      sums[c] += x[c], sums[3] += x[c] * x[c];
    sums[4] += 1;
  });
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, space.comm());
  std::array<double, 3> centre{};
  double square = sums[3] / sums[4];
  for (std::size_t c = 0; c < 3; ++c)
    centre[c] = sums[c] / sums[4], square -= centre[c] * centre[c];
  const double radius = std::sqrt(std::max(square, 0.0));
  std::vector<petsc::Vector> motions;
  const auto add = [&](auto&& value) { // of component c at offset r
    petsc::Vector motion = space.vector();
    {
      const petsc::WriteArray values(motion);
      for_each_node([&](std::size_t node, const double* x) {
        const std::array r{x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]};
        for (std::size_t c = 0; c < dim; ++c)
          values[dim * node + c] = value(c, r);
      });
    }
    motions.push_back(std::move(motion));
  };
  for (std::size_t axis = 0; axis < dim; ++axis)
    if (space.translates(axis))
      add([axis](std::size_t c, const auto&) { return c == axis ? 1.0 : 0.0; });
  if (space.mesh().axisymmetric())
    return motions;
  for (std::size_t axis = dim == 2 ? 2 : 0; axis < 3; ++axis) {
    const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
    add([=](std::size_t c, const auto& r) { return c == a ? -r[b] / radius : c == b ? r[a] / radius : 0.0; });
  }
  return motions;
}

/// Basis of the linear combinations of `motions` that vanish on the clamped dofs. Collective.
std::vector<petsc::Vector> unclamped(std::vector<petsc::Vector> motions, const DirichletDofs& clamped,
                                     MPI_Comm comm) {
  const std::size_t n = motions.size();
  std::vector<double> gram(n * n);
  double size = 0; // sum of squares of the motions at the clamped dofs
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const petsc::ReadArray x(motions[a]), y(motions[b]);
      for (const int dof : clamped.dofs())
        gram[a * n + b] += x[static_cast<std::size_t>(dof)] * y[static_cast<std::size_t>(dof)];
    }
  MPI_Allreduce(MPI_IN_PLACE, gram.data(), static_cast<int>(gram.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t a = 0; a < n; ++a) {
    size += gram[a * n + a];
    for (std::size_t b = 0; b < a; ++b)
      gram[b * n + a] = gram[a * n + b];
  }
  if (size == 0)
    return motions;
  const std::vector<double> resistance = symmetric_eigenvalues(gram, n);
  std::vector<petsc::Vector> free;
  for (std::size_t j = 0; j < n && resistance[j] <= rounding * size; ++j) {
    petsc::Vector& motion = free.emplace_back(petsc::zero_like(motions.front()));
    for (std::size_t a = 0; a < n; ++a)
      check(VecAXPY(motion, gram[j * n + a], motions[a]));
    clamped.clear(motion);
  }
  return free;
}

} // namespace

RigidMotions::RigidMotions(const Space& space, const DirichletDofs& clamped, Mat M) {
  const ConnectedParts parts = connected_parts(space);
  for (int part = 0; parts.count <= most_parts && part < parts.count; ++part)
    for (petsc::Vector& motion : unclamped(motions_of(space, parts.of_node, part), clamped, space.comm())) {
      petsc::Vector weighed = petsc::zero_like(motion);
      for (int time = 0; time < 2; ++time) // Gram and Schmidt
        subtract(coefficients(motion), motion);
      check(MatMult(M, motion, weighed));
      const double length = std::sqrt(petsc::dot(motion, weighed));
      check(VecScale(motion, 1 / length));
      check(VecScale(weighed, 1 / length));
      basis_.push_back(std::move(motion));
      weighed_.push_back(std::move(weighed));
    }
}

std::vector<double> RigidMotions::products(const std::vector<petsc::Vector>& with, Vec x) {
  const std::vector<Vec> all(with.begin(), with.end());
  std::vector<double> values(all.size());
  if (!all.empty())
    check(VecMDot(x, static_cast<PetscInt>(all.size()), all.data(), values.data()));
  return values;
}

namespace {

void subtract_sum(const std::vector<double>& coefficients, const std::vector<petsc::Vector>& of, Vec x) {
  std::vector<double> factors(coefficients.size());
  std::ranges::transform(coefficients, factors.begin(), std::negate());
  std::vector<Vec> all(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(factors.size()));
  check(VecMAXPY(x, static_cast<PetscInt>(factors.size()), factors.data(), all.data()));
}

} // namespace

void RigidMotions::subtract(const std::vector<double>& coefficients, Vec x) const {
  subtract_sum(coefficients, basis_, x);
}

void RigidMotions::subtract_forces(const std::vector<double>& coefficients, Vec f) const {
  subtract_sum(coefficients, weighed_, f);
}

} // namespace signorini::fem
