#pragma once
#include <functional>
#include <optional>
#include <string>

namespace signorini {

/// What `make` returns, from a process of its own, for libraries that may crash or spoil their memory: a copy
/// of this one, which says nothing and vanishes. Nothing if it did not come to an end within `seconds` of
/// processor time, if that is given. `make` must not throw, nor use MPI. Not collective.
std::optional<std::string> in_own_process(const std::function<std::string()>& make,
                                          std::optional<unsigned> seconds = {});

} // namespace signorini
