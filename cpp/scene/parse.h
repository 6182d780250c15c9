// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <string>
#include <toml++/toml.hpp>

namespace signorini::scene {

/// Applies one `key.path=value` of --set to a scene's table. The value is TOML, or else taken as a plain
/// text; `file`: path of the scene, for messages. Throws UserError.
void override_key(toml::table& root, const std::string& assignment, const std::filesystem::path& file);

} // namespace signorini::scene
