// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace signorini {

/// Has a program answer `request`, its standard input, in a process of its own: for libraries that may crash
/// or corrupt their memory. Its first argument is `seconds`, or 0, to which it limits its processor time.
/// Returns the answer; "" if the process exited without one, nothing if it crashed or took more than
/// `seconds` of processor time. This process is not copied (fork), which MPI does not allow once it has
/// started. Not collective; on one thread at a time. Throws std::runtime_error if no process can be started,
/// Interrupted if this process was asked to stop meanwhile; then the other one is killed, with all that it
/// started.
std::optional<std::string> in_subprocess(const std::filesystem::path& program, const std::string& request,
                                         std::optional<unsigned> seconds = {});

/// Writes all of a text to a descriptor. False, with errno, if that fails.
bool write_all(int file, const std::string& text);

constexpr int answer_file = 3; ///< the descriptor to which such a program writes its answer

/// The folder of the running code, a program or a shared library. Throws std::runtime_error.
std::filesystem::path own_folder();

/// The program of this name, found from the place of the running code: beside it, in the folder of the build
/// that it is in, or in libexec/signorini of the prefix that it is installed in; else in a prefix whose
/// programs are on PATH. Throws std::runtime_error.
std::filesystem::path find_program(const std::string& name);

} // namespace signorini
