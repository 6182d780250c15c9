#pragma once
#include <string>

namespace signorini::scene {

/// The first key in which two resolved scenes (echo()) pose different problems, as "key = value" of the first and of the
/// second; empty texts if they pose the same. Where a run ends, how it keeps its states, what it writes and where the
/// mesh file lies is not part of the problem.
struct Difference {
  std::string first, second;
};
Difference difference(const std::string& first, const std::string& second);

} // namespace signorini::scene
