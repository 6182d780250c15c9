#include "contact/delassus_operator.h"
#include "base/collective.h"
#include "base/dense.h"
#include "base/error.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::contact {

DelassusOperator::DelassusOperator(const Constraints& constraints, const Elimination& elimination)
    : constraints_(constraints), elimination_(elimination), S_(elimination.condensed()),
      zero_(static_cast<std::size_t>(constraints.count()), 0.0) {
  const std::size_t m = zero_.size();
  work_.factorised.reserve(m);
  work_.independent.reserve(m);
  work_.factor.reserve(m * m);
  work_.b.reserve(m);
  work_.normal.resize(m);
  work_.mu.resize(m);
}

void DelassusOperator::solve_active(const ActiveSet& set, std::span<double> b) const {
  if (set.empty())
    return;
  // LAPACK's last digits may differ between the ranks' processors: rank 0's result is used on all of them.
  on_root<SolverFailure>(constraints_.comm(), [&] { solve_here(set, b); });
  MPI_Bcast(b.data(), static_cast<int>(b.size()), MPI_DOUBLE, 0, constraints_.comm());
}

void DelassusOperator::solve_here(const ActiveSet& set, std::span<double> b) const {
  const std::size_t m = zero_.size();
  if (set != work_.factorised) {
    work_.factorised.clear();
    work_.factor.resize(set.size() * set.size());
    for (std::size_t i = 0; i < set.size(); ++i)
      for (std::size_t j = 0; j < set.size(); ++j)
        work_.factor[i * set.size() + j] =
            S_[static_cast<std::size_t>(set[i]) * m + static_cast<std::size_t>(set[j])];
    if (const int pivot = factorise_dense(work_.factor, set.size()); pivot != 0)
      throw SolverFailure(fmt::format("the condensed matrix of {} active candidates is singular (pivot {})",
                                      set.size(), pivot));
    work_.factorised = set;
  }
  solve_factorised(work_.factor, set.size(), b.first(set.size()));
}

std::vector<double> DelassusOperator::inverse() const {
  const auto m = static_cast<std::size_t>(constraints_.count());
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
                              std::span<double> normal, Vec y) const {
  // Iterative refinement. Where rigid motions dominate S (a stiff body without a clamp), it is
  // ill-conditioned and one pass leaves gaps on the set; each pass gains as many digits as the factor of S_AA
  // is accurate to. For a well-conditioned S one pass suffices.
  constexpr int most = 4;
  for (int pass = 0;; ++pass) {
    elimination_.finish(lambda, y);
    constraints_.normal_components(y, normal);
    double size = 0, defect = 0;
    for (std::size_t i = 0; i < normal.size(); ++i)
      size = std::max({size, std::abs(normal[i]), std::abs(psi[i])});
    work_.b.clear();
    for (int i : set) {
      work_.b.push_back(normal[static_cast<std::size_t>(i)] - psi[static_cast<std::size_t>(i)]);
      defect = std::max(defect, std::abs(work_.b.back()));
    }
    if (defect <= 10 * std::numeric_limits<double>::epsilon() * size || pass + 1 == most)
      return;
    solve_active(set, work_.b);
    for (std::size_t i = 0; i < set.size(); ++i)
      lambda[static_cast<std::size_t>(set[i])] += work_.b[i];
  }
}

void DelassusOperator::predict_gap(Vec r, std::span<const double> psi, std::span<double> gap) const {
  elimination_.predict(r, gap);
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = psi[i] - gap[i];
}

void DelassusOperator::finish_closed(const ActiveSet& set, std::span<const double> psi,
                                     std::span<double> lambda, std::span<double> gap, Vec y) const {
  finish(set, psi, lambda, gap, y);
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = psi[i] - gap[i];
}

void DelassusOperator::solve_sliding(Vec r, const ActiveSet& active, Vec p) const {
  elimination_.predict(r, work_.normal);
  if (active.empty()) {
    elimination_.finish(zero_, p);
    return;
  }
  if (constraints_.dependent()) {
    work_.independent = active;
    constraints_.drop_dependent(work_.independent);
  }
  const ActiveSet& set = constraints_.dependent() ? work_.independent : active;
  work_.b.clear();
  for (int i : set)
    work_.b.push_back(work_.normal[static_cast<std::size_t>(i)]);
  solve_active(set, work_.b);
  std::ranges::fill(work_.mu, 0);
  for (std::size_t i = 0; i < set.size(); ++i)
    work_.mu[static_cast<std::size_t>(set[i])] = work_.b[i];
  finish(set, zero_, work_.mu, work_.normal, p);
}

double DelassusOperator::bytes() const {
  return elimination_.bytes() + ranks(constraints_.comm()) * sizeof(double) *
                                    static_cast<double>(S_.size() + work_.factor.capacity());
}

} // namespace signorini::contact
