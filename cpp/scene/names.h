#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini::scene {

/// The valid name nearest to `found` in edits, or an empty text if none is near.
std::string nearest(std::string_view found, const std::vector<std::string>& valid);

/// "a, b, c".
std::string list(const std::vector<std::string>& names);

} // namespace signorini::scene
