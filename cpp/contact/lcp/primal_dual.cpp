// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/primal_dual.h"
#include "base/error.h"
#include "contact/row_basis.h"
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>

namespace signorini::contact {

namespace {

/// Makes the candidates of one cluster linearly independent by the ratio test of next_set(). These candidates
/// are the members of `set` from position `begin` on.
void exchange(const ConstraintRows& rows, std::span<const double> lambda, ActiveSet& set, std::size_t begin) {
  RowBasis basis(rows);
  RowBasis::Coordinates part = basis.coordinates(); // coefficients of the members in the direction of i
  for (const bool pushes : {true, false})           // closed candidates with forces are independent
    for (std::size_t at = begin; at < set.size(); ++at) {
      const int i = set[at];
      if ((lambda[i] > 0) != pushes || basis.add(i))
        continue;
      basis.coefficients(i, part);
      const auto force = [&](std::size_t k) { return lambda[basis.member(k)]; };
      std::size_t leaves = basis.size();
      for (std::size_t k = 0; k < basis.size(); ++k)
        if (part[k] > RowBasis::dependence_limit &&
            (leaves == basis.size() || force(k) * part[leaves] < force(leaves) * part[k]))
          leaves = k;
      if (leaves == basis.size() || force(leaves) == 0) // it was just added, with no force
        continue;
      basis.replace(leaves, i);
    }
  set.resize(begin);
  for (std::size_t k = 0; k < basis.size(); ++k)
    set.push_back(basis.member(k));
  std::sort(set.begin() + static_cast<std::ptrdiff_t>(begin), set.end());
}

/// Replaces the members of `set` that are in candidate i's cluster by the members of `other` in this cluster.
void take_cluster(const ConstraintRows& rows, const ActiveSet& other, int i, ActiveSet& set) {
  const ConstraintRows::Cluster& here = rows.cluster(i);
  const auto part = [&](auto& all) {
    return std::pair{std::ranges::lower_bound(all, here.first), std::ranges::lower_bound(all, here.last)};
  };
  const auto [first, last] = part(set);
  const auto [from, to] = part(other);
  set.insert(set.erase(first, last), from, to);
}

} // namespace

bool depends(const ConstraintRows& rows, const ActiveSet& set, int i) {
  const ConstraintRows::Cluster& here = rows.cluster(i);
  if (!here.dependent)
    return false;
  RowBasis basis(rows);
  for (const int other : set)
    if (here.first <= other && other < here.last)
      basis.add(other);
  return !basis.add(i);
}

void drop_dependent(const ConstraintRows& rows, ActiveSet& set) {
  if (!rows.dependent())
    return;
  RowBasis basis(rows);
  int last = 0;
  std::erase_if(set, [&](int i) {
    if (i >= last) {
      basis.clear();
      last = rows.cluster(i).last;
    }
    return !basis.add(i);
  });
}

void next_set(const ConstraintRows& rows, const ActiveSet& set, std::span<const double> lambda,
              std::span<const double> gap, ActiveSet& next) {
  next.clear();
  auto at = set.begin();
  for (const ConstraintRows::Cluster& here : rows.clusters()) {
    const std::size_t begin = next.size();
    for (int i = here.first; i < here.last; ++i) {
      const bool closed = at != set.end() && *at == i;
      at += closed;
      if (rows.law(i).closes(closed, lambda[i], gap[i]))
        next.push_back(i);
    }
    if (here.dependent)
      exchange(rows, lambda, next, begin);
  }
}

void BlockPivoting::advance(ActiveSet& set, ActiveSet& next, ActiveSet& wrong) {
  constexpr int most = 1000;
  if (++steps_ > most)
    throw SolverFailure(fmt::format("the active set did not settle in {} iterations: {} of {} candidates "
                                    "closed",
                                    most, set.size(), rows_.count()));
  wrong.clear();
  std::ranges::set_symmetric_difference(set, next, std::back_inserter(wrong));
  left_ = wrong.size() < fewest_ ? patience : std::max(left_ - 1, 0);
  fewest_ = std::min(fewest_, wrong.size());
  if (whole())
    std::swap(set, next);
  else
    take_cluster(rows_, next, wrong.back(), set);
}

} // namespace signorini::contact
