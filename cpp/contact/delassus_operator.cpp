// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/delassus_operator.h"
#include "base/collective.h"
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include "contact/solver/contact_step_solver.h"
#include "linalg/dense.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::contact {

namespace {
constexpr double to_rounding = 10; ///< in units of the last place
}

DelassusOperator::DelassusOperator(const ConstraintRows& rows, std::unique_ptr<const Elimination> elimination)
    : rows_(rows), elimination_(std::move(elimination)), S_(elimination_->condensed()),
      zero_(static_cast<std::size_t>(rows.count()), 0.0) {}

Workspace DelassusOperator::workspace() const {
  Workspace work(rows_.count());
  work.prediction = elimination_->prediction();
  work.factor.reserve(S_.size());
  return work;
}

void DelassusOperator::solve_active(const ActiveSet& set, std::span<double> b, Workspace& work) const {
  if (set.empty())
    return;
  // LAPACK's last digits may differ between the ranks' processors: rank 0's result is used on all of them.
  on_root<SolverFailure>(rows_.comm(), [&] { solve_here(set, b, work); });
  MPI_Bcast(b.data(), static_cast<int>(b.size()), MPI_DOUBLE, 0, rows_.comm());
}

void DelassusOperator::solve_here(const ActiveSet& set, std::span<double> b, Workspace& work) const {
  const std::size_t m = zero_.size();
  if (set != work.factorised) {
    work.factorised.clear();
    work.factor.resize(set.size() * set.size());
    for (std::size_t i = 0; i < set.size(); ++i)
      for (std::size_t j = 0; j < set.size(); ++j)
        work.factor[i * set.size() + j] =
            S_[static_cast<std::size_t>(set[i]) * m + static_cast<std::size_t>(set[j])];
    if (const int pivot = factorise_dense(work.factor, set.size()); pivot != 0)
      throw SolverFailure(fmt::format("the condensed matrix of {} active candidates is singular (pivot {})",
                                      set.size(), pivot));
    work.factorised = set;
  }
  solve_factorised(work.factor, set.size(), b.first(set.size()));
}

std::vector<double> DelassusOperator::inverse() const {
  const auto m = static_cast<std::size_t>(rows_.count());
  std::vector<double> K = S_;
  int pivot = factorise_dense(K, m);
  if (pivot == 0)
    pivot = invert_factorised(K, m);
  if (pivot != 0)
    throw SolverFailure(
        fmt::format("the condensed matrix of {} candidates is singular (pivot {})", m, pivot));
  return K;
}

void DelassusOperator::finish(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                              std::span<double> motion, Vec y, Workspace& work, double digits) const {
  // Iterative refinement. Where rigid motions dominate S (a stiff body without a clamp), it is
  // ill-conditioned and one pass leaves gaps on the set; each pass gains as many digits as the factor of S_AA
  // is accurate to. For a well-conditioned S one pass suffices.
  constexpr int most = 4;
  for (int pass = 0;; ++pass) {
    elimination_->finish(work.prediction, lambda, y);
    rows_.apply_transpose(y, motion);
    double size = 0, defect = 0;
    for (std::size_t i = 0; i < motion.size(); ++i)
      size = std::max({size, std::abs(motion[i]), std::abs(psi[i])});
    work.b.clear();
    for (int i : set) {
      work.b.push_back(motion[static_cast<std::size_t>(i)] - psi[static_cast<std::size_t>(i)]);
      defect = std::max(defect, std::abs(work.b.back()));
    }
    if (defect <= digits * std::numeric_limits<double>::epsilon() * size || pass + 1 == most)
      return;
    solve_active(set, work.b, work);
    for (std::size_t i = 0; i < set.size(); ++i)
      lambda[static_cast<std::size_t>(set[i])] += work.b[i];
  }
}

void DelassusOperator::predict_gap(Vec r, std::span<const double> psi, std::span<double> gap,
                                   Prediction& prediction) const {
  elimination_->predict(r, prediction, gap);
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = psi[i] - gap[i];
}

void DelassusOperator::finish_closed(const ActiveSet& set, std::span<const double> psi,
                                     std::span<double> lambda, std::span<double> gap, Vec y,
                                     Workspace& work) const {
  finish(set, psi, lambda, gap, y, work, to_rounding);
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = psi[i] - gap[i];
}

void DelassusOperator::solve_linearised(const LinearisedContact& step, Workspace& work) const {
  const std::span<double> mu = step.multipliers.empty() ? work.mu : step.multipliers;
  elimination_->predict(step.r, work.prediction, work.motion);
  std::ranges::fill(mu, 0);
  if (step.set.empty()) {
    elimination_->finish(work.prediction, zero_, step.x);
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
  for (int i : set)
    work.b.push_back(work.motion[static_cast<std::size_t>(i)] - value[static_cast<std::size_t>(i)]);
  solve_active(set, work.b, work);
  for (std::size_t i = 0; i < set.size(); ++i)
    mu[static_cast<std::size_t>(set[i])] = work.b[i];
  // Prescribed motions are data of derivatives, which no law of energy watches: a pass for their last digits
  // would cost half a solve.
  finish(set, value, mu, work.motion, step.x, work, prescribed ? 1e4 : to_rounding);
}

double DelassusOperator::bytes() const {
  return elimination_->bytes() + ranks(rows_.comm()) * 2 * sizeof(double) * static_cast<double>(S_.size());
}

} // namespace signorini::contact
