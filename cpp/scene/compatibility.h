#pragma once
#include <initializer_list>
#include <string>
#include <string_view>

namespace signorini::scene {

/// Sets of keys, given by prefixes.
using Keys = std::initializer_list<std::string_view>;

/// Returns the part of a resolved scene (echo()) that defines the problem: a line "key = value" for each such
/// key, sorted by key. Left out are the optimizer, the storage of states, the solver's memory, checks,
/// watched identities, output, the exact solution and the paths of files that are read, except for the keys
/// `besides`, which matter to the caller.
std::string problem(const std::string& scene, Keys besides = {});

/// A key in which two problems differ, as "key = value" of the first and of the second.
struct Difference {
  std::string first, second;
};
/// Returns the first difference between the problems of two resolved scenes; empty texts if they are the
/// same.
Difference difference(const std::string& first, const std::string& second, Keys besides = {});

} // namespace signorini::scene
