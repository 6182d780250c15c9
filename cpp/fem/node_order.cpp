// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/node_order.h"
#include <algorithm>
#include <tuple>

namespace signorini::fem {

namespace {

using Links = dolfinx::graph::AdjacencyList<std::int32_t>;

/// Nodes in the order of breadth-first searches, which visit the neighbours of a node by ascending number of
/// links.
class Search {
public:
  explicit Search(const Links& links) : links_(links), reached_(static_cast<std::size_t>(links.num_nodes())) {
    nodes_.reserve(reached_.size());
  }

  [[nodiscard]] const std::vector<std::int32_t>& nodes() const { return nodes_; }
  [[nodiscard]] bool reached(std::int32_t node) const { return reached_[static_cast<std::size_t>(node)]; }

  /// Appends the nodes of the component of `start` that no search has reached.
  void append_from(std::int32_t start) {
    std::size_t next = nodes_.size();
    append(start);
    for (; next < nodes_.size(); ++next) {
      const auto first = static_cast<std::ptrdiff_t>(nodes_.size());
      for (const std::int32_t node : links_.links(nodes_[next]))
        if (!reached(node))
          append(node);
      std::ranges::sort(nodes_.begin() + first, nodes_.end(), {},
                        [this](std::int32_t node) { return std::tuple(links_.num_links(node), node); });
    }
  }

  /// Undoes the searches of all but the first `count` nodes.
  void take_back(std::size_t count) {
    for (std::size_t i = count; i < nodes_.size(); ++i)
      reached_[static_cast<std::size_t>(nodes_[i])] = false;
    nodes_.resize(count);
  }

private:
  void append(std::int32_t node) {
    reached_[static_cast<std::size_t>(node)] = true;
    nodes_.push_back(node);
  }

  const Links& links_;
  std::vector<std::int32_t> nodes_;
  std::vector<bool> reached_;
};

} // namespace

std::vector<int> breadth_first_order(const Links& links) {
  constexpr int trials = 3; // the last node of a search is far from its first; more searches gain little
  Search search(links);
  for (std::int32_t node = 0; node < links.num_nodes(); ++node) {
    if (search.reached(node))
      continue;
    const std::size_t before = search.nodes().size();
    std::int32_t start = node;
    for (int i = 0; i < trials; ++i) {
      search.append_from(start);
      start = search.nodes().back();
      search.take_back(before);
    }
    search.append_from(start);
  }
  std::vector<int> number(search.nodes().size());
  for (int i = 0; const std::int32_t node : search.nodes())
    number[static_cast<std::size_t>(node)] = i++;
  return number;
}

} // namespace signorini::fem
