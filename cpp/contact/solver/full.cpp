// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/solver/full.h"
#include "base/error.h"
#include "base/text.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

namespace signorini::contact {
using petsc::check;

namespace {

/// Orthonormal frame (dim × dim, row by row) whose column `axis` is n / `length`, by the Householder
/// reflection that maps this axis to ±n. Components in which n is zero are not mixed with others.
std::array<double, 9> frame(const double* n, double length, int dim, int axis) {
  std::array<double, 3> w{};
  const double sign = n[axis] >= 0 ? 1 : -1; // avoids cancellation
  double ww = 0;
  for (int c = 0; c < dim; ++c)
    w[c] = n[c] / length + (c == axis ? sign : 0), ww += w[c] * w[c];
  std::array<double, 9> F{};
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j)
      F[i * dim + j] = ((i == j) - 2 * w[i] * w[j] / ww) * (j == axis ? -sign : 1);
  return F;
}

/// For each candidate, the index of the largest component of its force direction.
std::vector<int> largest_components(const ContactPairs& pairs) {
  std::vector<int> axes;
  for (int i = 0; i < pairs.count(); ++i) {
    const std::span<const double> n = pairs.rows().force(i);
    const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
    axes.push_back(static_cast<int>(std::ranges::max_element(n, smaller) - n.begin()));
  }
  return axes;
}

std::vector<double> lengths(const ContactPairs& pairs) {
  std::vector<double> lengths;
  for (int i = 0; i < pairs.count(); ++i) {
    const std::span<const double> n = pairs.rows().force(i);
    lengths.push_back(std::sqrt(std::inner_product(n.begin(), n.end(), n.begin(), 0.0)));
  }
  return lengths;
}

/// Throws UserError if a node has several candidates, so that its constraints are not simple bounds.
void require_bounds(const ContactPairs& pairs) {
  if (!pairs.rows().symmetric() || pairs.rows().count() > pairs.count())
    throw std::logic_error("the full VI needs symmetric contact laws with one row per candidate");
  const auto& clusters = pairs.rows().clusters();
  const auto several = std::ranges::find_if(
      clusters, [](const ConstraintRows::Cluster& one) { return one.last - one.first > 1; });
  if (several == clusters.end())
    return;
  throw UserError(fmt::format("solver.vi: found \"full\" with {} obstacles for the node at {}, but the full "
                              "VI takes one obstacle per node; set solver.vi to \"condensed\"",
                              several->last - several->first,
                              point_text(&pairs.points()[3 * static_cast<std::size_t>(several->first)])));
}

petsc::Matrix frames(const ContactPairs& pairs, Mat D, const std::vector<int>& axes,
                     const std::vector<double>& lengths) {
  require_bounds(pairs);
  const int dim = pairs.dim();
  petsc::Matrix Q;
  PetscInt rows = 0, begin = 0, end = 0;
  check(MatGetLocalSize(D, &rows, nullptr));
  check(MatGetOwnershipRange(D, &begin, &end));
  check(MatCreateAIJ(petsc::comm(D), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, dim, nullptr, 0, nullptr,
                     Q.put()));
  for (PetscInt i = begin; i < end; ++i)
    check(MatSetValue(Q, i, i, 1, INSERT_VALUES));
  for (int i = 0; i < pairs.count(); ++i) {
    const PetscInt first = pairs.first_dofs()[i];
    if (first < begin || first >= end)
      continue;
    std::array<PetscInt, 3> dofs{first, first + 1, first + 2};
    const std::array<double, 9> F = frame(pairs.rows().force(i).data(), lengths[i], dim, axes[i]);
    check(MatSetValues(Q, dim, dofs.data(), dim, dofs.data(), F.data(), INSERT_VALUES));
  }
  check(MatAssemblyBegin(Q, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(Q, MAT_FINAL_ASSEMBLY));
  return Q;
}

} // namespace

FullSolver::FullSolver(const ContactPairs& pairs, Mat D)
    : pairs_(pairs), complementarity_(pairs.rows(), pairs.diameter(), fem::diagonal(D)),
      length_unit_(pairs.gap_tolerance()), axis_(largest_components(pairs)), length_(lengths(pairs)),
      Q_(frames(pairs, D, axis_, length_)) {
  if (pairs.rows().clamped())
    diagonal_ = fem::diagonal(D);
  petsc::Matrix rows; // PETSc multiplies and extracts submatrices by rows, not by blocks
  check(MatConvert(D, MATAIJ, MAT_INITIAL_MATRIX, rows.put()));
  check(MatPtAP(rows, Q_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, D_.put()));
  check(MatCreateVecs(D_, z_.put(), r_.put()));
  PetscReal largest = 1;
  check(MatGetDiagonal(D_, r_));
  check(VecMax(r_, nullptr, &largest));
  check(MatScale(D_, 1 / largest));
  force_unit_ = length_unit_ * largest;
  petsc::Vector lower = petsc::zero_like(z_), upper = petsc::zero_like(z_);
  check(VecSet(lower, PETSC_NINFINITY));
  check(VecSet(upper, PETSC_INFINITY));
  vi_.emplace("full_vi", D_, std::move(lower), std::move(upper), MATSOLVERMUMPS);
}

PetscInt FullSolver::coordinate(std::size_t i) const {
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(z_, &begin, &end));
  const PetscInt dof = pairs_.first_dofs()[i];
  return dof >= begin && dof < end ? dof - begin + axis_[i] : -1;
}

Workspace FullSolver::workspace() const {
  return linearised_ ? linearised_->workspace() : Workspace(pairs_.count());
}

void FullSolver::solve(const ContactProblem& step, Workspace&) const {
  const auto& [r, psi, previous, state, y, guess] = step;
  const std::size_t m = psi.size();
  check(MatMultTranspose(Q_, r, r_));
  check(VecScale(r_, -1 / force_unit_));
  pairs_.rows().set_clamped(diagonal_, r, y);
  check(MatMultTranspose(Q_, y, z_));
  check(VecScale(z_, 1 / length_unit_));
  {
    const petsc::ReadArray known(y);
    const petsc::WriteArray upper(vi_->upper()), z(z_);
    for (std::size_t i = 0; i < m; ++i)
      if (const PetscInt at = coordinate(i); at >= 0) {
        upper[at] =
            (psi[i] - pairs_.rows().clamped_part(static_cast<int>(i), known)) / length_[i] / length_unit_;
        // Rounding may put a guess on the bound slightly below it, where the solver would leave it: within
        // one unit, the gap tolerance, it counts as on the bound.
        if (z[at] >= upper[at] - 1)
          z[at] = upper[at];
      }
  }
  state.vi_iterations = vi_->solve(r_, z_);
  count_solved();

  std::ranges::fill(state.lambda, 0);
  {
    const petsc::ReadArray residual(vi_->residual()), z(z_), upper(vi_->upper());
    for (std::size_t i = 0; i < m; ++i)
      if (const PetscInt at = coordinate(i); at >= 0 && z[at] >= upper[at] - 1)
        state.lambda[i] = std::max(0.0, -force_unit_ * residual[at]) / length_[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, state.lambda.data(), static_cast<int>(m), MPI_DOUBLE, MPI_SUM, petsc::comm(r_));
  check(VecScale(z_, length_unit_));
  check(MatMult(Q_, z_, y));
  pairs_.rows().gap(psi, y, state.gap);
  complementarity_.classify(state, y);
}

} // namespace signorini::contact
