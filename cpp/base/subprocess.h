// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace signorini {

/// Runs a program in a separate process: for libraries that may crash or corrupt their memory. `command`: the
/// program, which is found on PATH if it is a name without a folder, and its arguments. The program reads
/// `request` from its standard input and writes its answer to the descriptor answer_file. Returns the answer,
/// "" if the program exited with an error, and nothing if it crashed. Does not copy this process (fork),
/// which MPI forbids after its start. Not collective; call it from one thread at a time. Throws
/// std::runtime_error if no process can be started. Throws Interrupted if a stop is requested meanwhile,
/// after killing the program and all processes that it started.
std::optional<std::string> in_subprocess(const std::vector<std::string>& command, const std::string& request);

/// Writes a whole text to a file descriptor. Returns false and sets errno if that fails.
bool write_all(int file, const std::string& text);

constexpr int answer_file = 3; ///< descriptor to which a program run by in_subprocess() writes its answer

/// Folder of the file that contains the running code, a program or a shared library. Throws
/// std::runtime_error.
std::filesystem::path own_folder();

/// Finds the program `name`: beside the running code, in the build folder of that code or in
/// libexec/signorini of its installation prefix. If it is in none of these, searches libexec/signorini of the
/// prefixes whose bin folder is on PATH. Throws std::runtime_error if the program is not found.
std::filesystem::path find_program(const std::string& name);

/// Command that runs a script of postprocess/ by Python: of the build folder or of the installation. Throws
/// std::runtime_error if the script is not found.
std::vector<std::string> python_command(const std::string& script);

} // namespace signorini
