#pragma once
#include "fem/space.h"
#include <functional>
#include <string>
#include <vector>

namespace signorini::io {

/// For each of this rank's points `here` (places × 3) the number of the same point among `there` (points ×
/// dim), which may differ in the last digits and in order. Throws UserError, by way of `fail(problem)`, where
/// there is none or two of `there` are the same. Collective.
std::vector<std::size_t> match_points(const fem::Space& space, const std::vector<double>& there,
                                      const std::vector<double>& here,
                                      const std::function<void(const std::string& problem)>& fail);

} // namespace signorini::io
