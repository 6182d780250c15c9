#include "contact/condensation.h"
#include "base/error.h"
#include "base/signals.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <petscblaslapack.h>

namespace signorini::contact {
using petsc::check;

Condensation::Condensation(const Constraints& constraints, const Factorisation& D, Vec layout)
    : constraints_(constraints), D_(D), work_(petsc::zero_like(layout)) {
  const std::size_t m = static_cast<std::size_t>(constraints.count());
  S_.resize(m * m);
  petsc::Vector column = petsc::zero_like(layout);
  std::vector<double> unit(m, 0.0);
  for (std::size_t j = 0; j < m; ++j) {
    if (stop_requested(petsc::comm(layout)))
      throw Interrupted();
    check(VecZeroEntries(work_));
    unit[j] = 1;
    constraints.add_normal(1, unit, work_);
    unit[j] = 0;
    D.solve(work_, column);
    constraints.normal_components(column, std::span(&S_[j * m], m));
  }
  for (std::size_t i = 0; i < m; ++i) // rounding of the solves is the only asymmetry
    for (std::size_t j = 0; j < i; ++j)
      S_[i * m + j] = S_[j * m + i] = (S_[i * m + j] + S_[j * m + i]) / 2;
}

std::vector<double> Condensation::solve_active(const ActiveSet& set, std::vector<double> b) const {
  if (set.empty())
    return b;
  const std::size_t m = static_cast<std::size_t>(constraints_.count());
  const PetscBLASInt n = static_cast<PetscBLASInt>(set.size()), one = 1;
  std::vector<double> factor(set.size() * set.size());
  for (std::size_t i = 0; i < set.size(); ++i)
    for (std::size_t j = 0; j < set.size(); ++j)
      factor[i * set.size() + j] = S_[static_cast<std::size_t>(set[i]) * m + static_cast<std::size_t>(set[j])];
  PetscBLASInt info = 0;
  LAPACKpotrf_("L", &n, factor.data(), &n, &info);
  if (info != 0)
    throw SolverFailure(fmt::format("the condensed matrix of {} active candidates is singular (pivot {})",
                                    set.size(), static_cast<int>(info)));
  LAPACKpotrs_("L", &n, &one, factor.data(), &n, b.data(), &n, &info);
  return b;
}

std::vector<double> Condensation::inverse() const {
  const auto m = static_cast<std::size_t>(constraints_.count());
  const auto n = static_cast<PetscBLASInt>(m);
  std::vector<double> K = S_;
  PetscBLASInt info = 0;
  LAPACKpotrf_("L", &n, K.data(), &n, &info);
  if (info == 0)
    LAPACKpotri_("L", &n, K.data(), &n, &info);
  if (info != 0)
    throw SolverFailure(fmt::format("the condensed matrix of {} candidates is singular (pivot {})", m,
                                    static_cast<int>(info)));
  for (std::size_t j = 0; j < m; ++j) // LAPACK fills the lower triangle, column by column
    for (std::size_t i = j + 1; i < m; ++i)
      K[i * m + j] = K[j * m + i];
  return K;
}

void Condensation::refine(Vec r, const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                          Vec y) const {
  // Where rigid motions dominate S (a stiff body without a clamp) its condition leaves digits of the constraints open; each
  // pass gains what the factorisation has. A well-conditioned S ends after the first.
  constexpr int most = 4;
  std::vector<double> normal(lambda.size());
  for (int pass = 0; pass < most; ++pass) {
    check(VecCopy(r, work_));
    constraints_.add_normal(-1, lambda, work_);
    D_.solve(work_, y);
    constraints_.normal_components(y, normal);
    double size = 0, defect = 0;
    for (std::size_t i = 0; i < normal.size(); ++i)
      size = std::max({size, std::abs(normal[i]), std::abs(psi[i])});
    std::vector<double> slip;
    for (int i : set) {
      slip.push_back(normal[static_cast<std::size_t>(i)] - psi[static_cast<std::size_t>(i)]);
      defect = std::max(defect, std::abs(slip.back()));
    }
    if (defect <= 10 * std::numeric_limits<double>::epsilon() * size)
      return;
    const std::vector<double> correction = solve_active(set, slip);
    for (std::size_t i = 0; i < set.size(); ++i)
      lambda[static_cast<std::size_t>(set[i])] += correction[i];
  }
}

void Condensation::solve_closed(Vec r, const ActiveSet& set, std::span<double> lambda, Vec y) const {
  refine(r, set, constraints_.psi(), lambda, y);
}

void Condensation::solve_sliding(Vec r, const ActiveSet& set, Vec p) const {
  D_.solve(r, p);
  if (set.empty())
    return;
  const std::vector<double> zero(static_cast<std::size_t>(constraints_.count()), 0.0);
  std::vector<double> normal(zero.size()), mu = zero, slip;
  constraints_.normal_components(p, normal);
  for (int i : set)
    slip.push_back(normal[static_cast<std::size_t>(i)]);
  slip = solve_active(set, slip);
  for (std::size_t i = 0; i < set.size(); ++i)
    mu[static_cast<std::size_t>(set[i])] = slip[i];
  refine(r, set, zero, mu, p);
}

} // namespace signorini::contact
