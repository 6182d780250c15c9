// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace signorini {

/// Has a worker, a program whose main function is worker::serve(), answer `request`, for libraries that may
/// crash or corrupt their memory: each request in a process of its own, which a worker that has been started
/// before has loaded already. Returns the answer; "" if that process exited without one, nothing if it
/// crashed or took more than `seconds` of processor time. This process is not copied (fork), which MPI does
/// not allow once it has started. Not collective; on one thread at a time. Throws std::runtime_error if no
/// process can be started, Interrupted if this process was asked to stop meanwhile; then the worker is gone,
/// with all that it started.
std::optional<std::string> in_subprocess(const std::filesystem::path& program, const std::string& request,
                                         std::optional<unsigned> seconds = {});

/// The folder of the running code, a program or a shared library. Throws std::runtime_error.
std::filesystem::path own_folder();

/// The worker of this name, found from the place of the running code: beside it, in the folder of the build
/// that it is in, or in libexec/signorini of the prefix that it is installed in; else in a prefix whose
/// programs are on PATH. Throws std::runtime_error.
std::filesystem::path find_worker(const std::string& name);

} // namespace signorini
