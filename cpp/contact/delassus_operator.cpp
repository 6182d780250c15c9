// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/delassus_operator.h"
#include "base/collective.h"
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include "linalg/dense.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::contact {

namespace {
constexpr double to_rounding = 10; ///< tolerance of refinement, in units of the machine epsilon
}

DelassusOperator::DelassusOperator(const ConstraintRows& rows,
                                   std::unique_ptr<const Condensation> condensation)
    : rows_(rows), condensation_(std::move(condensation)),
      zero_(static_cast<std::size_t>(rows.count()), 0.0) {}

Workspace DelassusOperator::workspace() const {
  Workspace work(rows_.count());
  work.half_solve = condensation_->half_solve();
  if (complete())
    work.factor.reserve(zero_.size() * zero_.size());
  return work;
}

void DelassusOperator::solve_active(const ActiveSet& set, std::span<double> b, Workspace& work) const {
  if (set.empty())
    return;
  condensation_->prepare(set);
  // LAPACK's last digits may differ between the ranks' processors: rank 0's result is used on all of them.
  on_root<SolverFailure>(rows_.comm(), [&] { solve_here(set, b, work); });
  MPI_Bcast(b.data(), static_cast<int>(b.size()), MPI_DOUBLE, 0, rows_.comm());
}

void DelassusOperator::solve_here(const ActiveSet& set, std::span<double> b, Workspace& work) const {
  if (set != work.factorised) {
    work.factorised.clear();
    work.factor.resize(set.size() * set.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
      const std::span<const double> column = this->column(set[i]);
      for (std::size_t j = 0; j < set.size(); ++j)
        work.factor[i * set.size() + j] = column[set[j]];
    }
    if (const int pivot = factorise_dense(work.factor, set.size()); pivot != 0)
      throw SolverFailure(fmt::format("the condensed matrix of {} active candidates is singular (pivot {})",
                                      set.size(), pivot));
    work.factorised = set;
  }
  solve_factorised(work.factor, set.size(), b.first(set.size()));
}

std::vector<double> DelassusOperator::inverse() const {
  const auto m = static_cast<std::size_t>(rows_.count());
  std::vector<double> K;
  for (int i = 0; i < rows_.count(); ++i)
    K.insert(K.end(), column(i).begin(), column(i).end());
  int pivot = factorise_dense(K, m);
  if (pivot == 0)
    pivot = invert_factorised(K, m);
  if (pivot != 0)
    throw SolverFailure(
        fmt::format("the condensed matrix of {} candidates is singular (pivot {})", m, pivot));
  return K;
}

void DelassusOperator::refine_on_set(const ActiveSet& set, std::span<const double> psi,
                                     std::span<double> lambda, std::span<double> motion, Vec y,
                                     Workspace& work, double digits, double scale) const {
  // Iterative refinement. Where rigid motions dominate S (a stiff body without a clamp), it is
  // ill-conditioned and one pass leaves gaps on the set; each pass gains as many digits as the factor of S_AA
  // is accurate to. For a well-conditioned S one pass suffices.
  constexpr int most = 4;
  for (int pass = 0;; ++pass) {
    condensation_->finish(work.half_solve, lambda, y); // y = D⁻¹ (r − N λ)
    rows_.apply_transpose(y, motion);
    double size = scale, defect = 0;
    for (std::size_t i = 0; i < motion.size(); ++i)
      size = std::max({size, std::abs(motion[i]), std::abs(psi[i])});
    work.b.clear();
    for (int i : set) {
      work.b.push_back(motion[i] - psi[i]);
      defect = std::max(defect, std::abs(work.b.back()));
    }
    if (defect <= digits * std::numeric_limits<double>::epsilon() * size || pass + 1 == most)
      return;
    solve_active(set, work.b, work); // S_AA δλ = (Nᵀy − ψ)_A
    for (std::size_t i = 0; i < set.size(); ++i)
      lambda[set[i]] += work.b[i];
  }
}

void DelassusOperator::predict_gap(Vec r, const Guess& guess, std::span<const double> psi,
                                   std::span<double> gap, HalfSolve& half_solve) const {
  condensation_->predict(r, guess, half_solve, gap); // Nᵀ y⁰, y⁰ = D⁻¹ r
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = psi[i] - gap[i];
}

void DelassusOperator::finish_closed(const ActiveSet& set, std::span<const double> psi,
                                     std::span<double> lambda, std::span<double> gap, Vec y,
                                     Workspace& work) const {
  refine_on_set(set, psi, lambda, gap, y, work, to_rounding);
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = psi[i] - gap[i];
}

void DelassusOperator::finish(std::span<const double> psi, std::span<const double> lambda,
                              std::span<double> gap, Vec y, Workspace& work) const {
  condensation_->finish(work.half_solve, lambda, y);
  rows_.gap(psi, y, gap);
}

void DelassusOperator::solve_linearised(const LinearisedContact& step, Workspace& work) const {
  if (!step.equations.empty()) {
    solve_by_equations(step, false, work);
    return;
  }
  const std::span<double> mu = step.multipliers.empty() ? work.mu : step.multipliers;
  condensation_->predict(step.r, {step.x, step.set}, work.half_solve, work.motion);
  std::ranges::fill(mu, 0);
  if (step.set.empty()) {
    condensation_->finish(work.half_solve, zero_, step.x);
    return;
  }
  const bool prescribed = !step.value.empty();
  const std::span<const double> value = prescribed ? step.value : zero_;
  if (rows_.dependent()) {
    work.independent = step.set;
    drop_dependent(rows_, work.independent);
  }
  const ActiveSet& set = rows_.dependent() ? work.independent : step.set;
  work.b.clear();
  // S_AA μ = (Nᵀ D⁻¹ r − value)_A
  for (int i : set)
    work.b.push_back(work.motion[i] - value[i]);
  solve_active(set, work.b, work);
  double predicted = 0; // where all candidates are closed, the motion itself is no scale of its rounding
  for (const double motion : work.motion)
    predicted = std::max(predicted, std::abs(motion));
  for (std::size_t i = 0; i < set.size(); ++i)
    mu[set[i]] = work.b[i];
  // Prescribed motions are data of derivatives, which no energy balance checks: a pass for their last digits
  // would cost half a solve.
  refine_on_set(set, value, mu, work.motion, step.x, work, prescribed ? 1e4 : to_rounding, predicted);
}

void DelassusOperator::solve_transposed(const LinearisedContact& step, Workspace& work) const {
  std::ranges::fill(step.law_duals, 0);
  if (step.equations.empty())
    solve_linearised(step, work);
  else
    solve_by_equations(step, true, work);
}

namespace {

/// Calls visit(position, group, equation, c) for each row c of the groups of a set. `position` counts the
/// calls, `equation` is that of the group.
template <class Visit>
void for_each_row(const ConstraintRows& rows, const ActiveSet& set, std::span<const LawEquation> equations,
                  Visit&& visit) {
  std::size_t at = 0;
  for (std::size_t j = 0; j < set.size(); ++j)
    for (std::size_t c = 0; c < rows.size(set[j]); ++c)
      visit(at++, set[j], equations[j], c);
}

} // namespace

int DelassusOperator::solve_equations(const ActiveSet& set, std::span<const LawEquation> equations,
                                      bool transposed, std::span<double> b, Workspace& work) const {
  int sign = 1;
  if (set.empty())
    return sign;
  std::vector<int> all;
  for_each_row(rows_, set, equations, [&](std::size_t, int group, const LawEquation&, std::size_t c) {
    all.push_back(static_cast<int>(rows_.row(group, c)));
  });
  condensation_->prepare(all);
  work.factorised.clear();
  on_root<SolverFailure>(rows_.comm(), [&] {
    // E S + F on the rows of the set
    const std::size_t n = all.size();
    work.factor.resize(n * n);
    for (std::size_t j = 0; j < n; ++j) { // column by column
      const std::span<const double> S = column(all[j]);
      for_each_row(rows_, set, equations,
                   [&](std::size_t i, int group, const LawEquation& law, std::size_t c) {
                     const std::size_t k = rows_.size(group);
                     work.factor[j * n + i] = times(law.E, k, c, rows_.of_group(group, S));
                     for (std::size_t other = 0; other < k; ++other)
                       if (static_cast<std::size_t>(all[j]) == rows_.row(group, other))
                         work.factor[j * n + i] += law.F[c * k + other];
                   });
    }
    if (const int pivot = solve_general(work.factor, n, transposed, b, &sign); pivot != 0)
      throw SolverFailure(
          fmt::format("the condensed matrix of {} rows in contact is singular (pivot {})", n, pivot));
  });
  MPI_Bcast(b.data(), static_cast<int>(b.size()), MPI_DOUBLE, 0, rows_.comm());
  return sign;
}

void DelassusOperator::solve_by_equations(const LinearisedContact& step, bool transposed,
                                          Workspace& work) const {
  const std::span<double> mu = step.multipliers.empty() ? work.mu : step.multipliers;
  const std::span<const double> value = step.value.empty() ? zero_ : step.value;
  condensation_->predict(step.r, {step.x, step.set}, work.half_solve, work.motion);
  // With D x + Hρ = r: E (Hᵀx − value) = F ρ. Transposed, with ρ = Eᵀn: Hᵀx − value = Fᵀ n.
  std::vector<double> n(zero_.size()); // ρ of the step itself, n of its transpose
  constexpr int passes = 2;            // the second one corrects the rounding of S
  for (int pass = 0; pass < passes; ++pass) {
    work.b.clear();
    for_each_row(rows_, step.set, step.equations,
                 [&](std::size_t, int group, const LawEquation& law, std::size_t c) {
                   const std::size_t k = rows_.size(group);
                   std::array<double, 3> defect = rows_.of_group(group, work.motion);
                   const std::array<double, 3> asked = rows_.of_group(group, value);
                   for (std::size_t j = 0; j < k; ++j)
                     defect[j] -= asked[j];
                   work.b.push_back((transposed ? defect[c] : times(law.E, k, c, defect)) -
                                    times(law.F, k, c, rows_.of_group(group, n), transposed) +
                                    (step.law.empty() ? 0 : step.law[rows_.row(group, c)]));
                 });
    if (pass > 0) { // E, F and c have rows in m; transposed in that of n
      double defect = 0, size = 0;
      for (std::size_t row = 0; row < work.motion.size(); ++row)
        size = std::max({size, std::abs(work.motion[row]), std::abs(value[row])});
      for (const double one : work.b)
        defect = std::max(defect, std::abs(one));
      if (defect <= to_rounding * std::numeric_limits<double>::epsilon() * size)
        break;
    }
    solve_equations(step.set, step.equations, transposed, work.b, work);
    for_each_row(rows_, step.set, step.equations,
                 [&](std::size_t i, int group, const LawEquation&, std::size_t c) {
                   n[rows_.row(group, c)] += work.b[i];
                 });
    std::ranges::fill(mu, 0);
    for_each_row(rows_, step.set, step.equations,
                 [&](std::size_t, int group, const LawEquation& law, std::size_t c) {
                   mu[rows_.row(group, c)] =
                       transposed ? times(law.E, rows_.size(group), c, rows_.of_group(group, n), true)
                                  : n[rows_.row(group, c)];
                 });
    condensation_->finish(work.half_solve, mu, step.x);
    rows_.apply_transpose(step.x, work.motion);
  }
  if (!step.law_duals.empty())
    std::ranges::copy(n, step.law_duals.begin());
}

double DelassusOperator::bytes() const {
  const auto m = static_cast<double>(zero_.size());
  return condensation_->bytes() + (complete() ? ranks(rows_.comm()) * 2 * sizeof(double) * m * m : 0);
}

} // namespace signorini::contact
