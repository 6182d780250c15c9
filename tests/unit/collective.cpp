// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include <array>
#include <catch2/catch_test_macros.hpp>

using namespace signorini;

namespace {

/// What a rank gathers: as many entries as its number says, none of rank 1.
std::vector<std::array<float, 3>> entries_of(int rank) {
  std::vector<std::array<float, 3>> entries;
  for (int i = 0; rank != 1 && i < 4 + 3 * rank; ++i)
    entries.push_back({static_cast<float>(rank), static_cast<float>(i), 0.5F});
  return entries;
}

} // namespace

TEST_CASE("what is too long for one message is sent in pieces", "[collective]") {
  const int size = ranks(MPI_COMM_WORLD), here = rank(MPI_COMM_WORLD);
  std::vector<std::array<float, 3>> expected;
  for (int r = 0; r < size; ++r)
    for (const auto& entry : entries_of(r))
      expected.push_back(entry);
  const std::size_t bytes = expected.size() * sizeof(expected.front());
  // Within entries, at their ends, one byte less than all, and all at once.
  for (const std::size_t largest : {std::size_t{1}, std::size_t{5}, std::size_t{12}, std::size_t{24},
                                    bytes - 1, bytes, largest_message}) {
    INFO("messages of " << largest << " bytes");
    CHECK(gather(MPI_COMM_WORLD, entries_of(here), largest) == expected);
    CHECK(gather(MPI_COMM_WORLD, std::vector<double>(), largest).empty());
    for (int root = 0; root < size; ++root) {
      CHECK(broadcast(MPI_COMM_WORLD, entries_of(here), root, largest) == entries_of(root));
      const std::string text = "from rank " + std::to_string(root);
      CHECK(broadcast(MPI_COMM_WORLD, here == root ? text : std::string(), root, largest) == text);
    }
  }
}
