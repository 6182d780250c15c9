// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <string>

namespace signorini::mesh {

/// Reads a mesh by meshio in a process of Python. Returns it as the text of a .msh (MSH 2.2) with its sets as
/// physical groups. Throws UserError if the file cannot be read or Python lacks a module, and Interrupted if
/// a stop of this process is requested meanwhile. Not collective: call it on one rank.
std::string read_by_meshio(const std::filesystem::path& file);

} // namespace signorini::mesh
