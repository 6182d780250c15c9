// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/primal_dual.h"
#include "base/error.h"
#include "contact/node_basis.h"
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>

namespace signorini::contact {

namespace {

/// Makes the candidates of one node, those of `set` from `begin` on, independent by the ratio test of
/// next_set().
void exchange(const ContactPairs& pairs, std::span<const double> lambda, ActiveSet& set, std::size_t begin) {
  NodeBasis basis(pairs.dim());
  std::array<int, 3> members{};
  for (const bool pushes : {true, false}) // closed candidates with forces are independent
    for (std::size_t at = begin; at < set.size(); ++at) {
      const int i = set[at];
      if ((lambda[i] > 0) != pushes)
        continue;
      if (basis.add(pairs.direction(i))) {
        members[basis.size() - 1] = i;
        continue;
      }
      std::array<double, 3> part{}; // coefficients of the members in the direction of i
      for (std::size_t k = 0; k < basis.size(); ++k)
        part[k] = basis.along(k, pairs.direction(i));
      basis.combine(part);
      std::size_t leaves = basis.size();
      for (std::size_t k = 0; k < basis.size(); ++k)
        if (part[k] > NodeBasis::parallel &&
            (leaves == basis.size() || lambda[members[k]] * part[leaves] < lambda[members[leaves]] * part[k]))
          leaves = k;
      if (leaves == basis.size() || lambda[members[leaves]] == 0) // it was just added, with no force
        continue;
      members[leaves] = i;
      const std::size_t size = basis.size();
      basis.clear();
      for (std::size_t k = 0; k < size; ++k)
        if (basis.add(pairs.direction(members[k])))
          members[basis.size() - 1] = members[k];
    }
  set.resize(begin);
  set.insert(set.end(), members.begin(), members.begin() + static_cast<std::ptrdiff_t>(basis.size()));
  std::sort(set.begin() + static_cast<std::ptrdiff_t>(begin), set.end());
}

/// Replaces the candidates of candidate i's node in `set` by those in `other`.
void take_node(const ContactPairs& pairs, const ActiveSet& other, int i, ActiveSet& set) {
  const ContactPairs::Node& here = pairs.node(i);
  const auto part = [&](auto& all) {
    return std::pair{std::ranges::lower_bound(all, here.first), std::ranges::lower_bound(all, here.last)};
  };
  const auto [first, last] = part(set);
  const auto [from, to] = part(other);
  set.insert(set.erase(first, last), from, to);
}

} // namespace

bool depends(const ContactPairs& pairs, const ActiveSet& set, int i) {
  const ContactPairs::Node& here = pairs.node(i);
  if (!here.crowded)
    return false;
  NodeBasis basis(pairs.dim());
  for (const int other : set)
    if (here.first <= other && other < here.last)
      basis.add(pairs.direction(other));
  return !basis.add(pairs.direction(i));
}

void drop_dependent(const ContactPairs& pairs, ActiveSet& set) {
  if (!pairs.dependent())
    return;
  NodeBasis basis(pairs.dim());
  int last = 0;
  std::erase_if(set, [&](int i) {
    if (i >= last) {
      basis.clear();
      last = pairs.node(i).last;
    }
    return !basis.add(pairs.direction(i));
  });
}

void next_set(const ContactPairs& pairs, const ActiveSet& set, std::span<const double> lambda,
              std::span<const double> gap, ActiveSet& next) {
  next.clear();
  auto at = set.begin();
  for (const ContactPairs::Node& here : pairs.nodes()) {
    const std::size_t begin = next.size();
    for (int i = here.first; i < here.last; ++i) {
      const bool closed = at != set.end() && *at == i;
      at += closed;
      if (closed ? lambda[i] > 0 : gap[i] < 0)
        next.push_back(i);
    }
    if (here.crowded)
      exchange(pairs, lambda, next, begin);
  }
}

void BlockPivoting::advance(ActiveSet& set, ActiveSet& next, ActiveSet& wrong) {
  constexpr int most = 1000;
  if (++steps_ > most)
    throw SolverFailure(fmt::format("the active set did not settle in {} steps: {} of {} candidates closed",
                                    most, set.size(), pairs_.count()));
  wrong.clear();
  std::ranges::set_symmetric_difference(set, next, std::back_inserter(wrong));
  left_ = wrong.size() < fewest_ ? patience : std::max(left_ - 1, 0);
  fewest_ = std::min(fewest_, wrong.size());
  if (whole())
    std::swap(set, next);
  else
    take_node(pairs_, next, wrong.back(), set);
}

} // namespace signorini::contact
