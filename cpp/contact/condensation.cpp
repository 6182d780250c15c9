#include "contact/condensation.h"
#include "base/error.h"
#include <fmt/format.h>
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

void Condensation::solve_sliding(Vec r, const ActiveSet& set, Vec p) const {
  D_.solve(r, p);
  if (set.empty())
    return;
  std::vector<double> normal(static_cast<std::size_t>(constraints_.count()));
  constraints_.normal_components(p, normal);
  std::vector<double> slip;
  for (int i : set)
    slip.push_back(normal[static_cast<std::size_t>(i)]);
  const std::vector<double> mu = solve_active(set, slip);
  std::ranges::fill(normal, 0);
  for (std::size_t i = 0; i < set.size(); ++i)
    normal[static_cast<std::size_t>(set[i])] = mu[i];
  check(VecCopy(r, work_));
  constraints_.add_normal(-1, normal, work_);
  D_.solve(work_, p);
}

} // namespace signorini::contact
