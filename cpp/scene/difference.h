#pragma once
#include <initializer_list>
#include <string>
#include <string_view>

namespace signorini::scene {

/// Keys by the texts that they begin with.
using Keys = std::initializer_list<std::string_view>;

/// What of a resolved scene (echo()) poses the problem: "key = value" of each such key, one a line, in the order of the
/// keys. How J is minimised, how a run keeps its states, what it looks at and writes, what is known of the solution and
/// where files lie that are read is not part of it, but for the keys `besides`, which matter to the caller.
std::string problem(const std::string& scene, Keys besides = {});

/// The first key in which two resolved scenes pose different problems, as "key = value" of the first and of the second;
/// empty texts if they pose the same.
struct Difference {
  std::string first, second;
};
Difference difference(const std::string& first, const std::string& second, Keys besides = {});

} // namespace signorini::scene
