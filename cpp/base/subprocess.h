// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace signorini {

/// Runs a program in a process of its own, with `request` as its standard input: for libraries that may crash
/// or corrupt their memory. The program's first argument is `seconds`, or 0, to which it limits its processor
/// time. Returns the answer; "" if the process exited without one, nothing if it crashed or took more than
/// `seconds` of processor time. This process is not copied (fork), which MPI does not allow once it has
/// started. Not collective; on one thread at a time. Throws std::runtime_error if no process can be started,
/// Interrupted if a stop was requested meanwhile; the process is then killed with all that it started.
std::optional<std::string> in_subprocess(const std::filesystem::path& program, const std::string& request,
                                         std::optional<unsigned> seconds = {});

/// Writes all of a text to a descriptor. Returns false, with errno, if that fails.
bool write_all(int file, const std::string& text);

constexpr int answer_file = 3; ///< the descriptor to which such a program writes its answer

/// The folder of the running code, a program or a shared library. Throws std::runtime_error.
std::filesystem::path own_folder();

/// Finds the program of this name: beside the running code, in the folder of its build, or in
/// libexec/signorini of its installation prefix. Else it is sought in prefixes whose programs are on PATH.
/// Throws std::runtime_error.
std::filesystem::path find_program(const std::string& name);

} // namespace signorini
