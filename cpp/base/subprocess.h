// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <functional>
#include <optional>
#include <string>

namespace signorini {

/// Runs `make` in a silenced child process, for libraries that may crash or corrupt their memory, and returns
/// its result; empty if it crashed or took more than `seconds` of processor time. `make` must not throw nor
/// use MPI. Not collective. Throws std::runtime_error if no process can be started, Interrupted if this
/// process was asked to stop meanwhile; then the child is gone, with all that it started.
std::optional<std::string> in_subprocess(const std::function<std::string()>& make,
                                         std::optional<unsigned> seconds = {});

} // namespace signorini
