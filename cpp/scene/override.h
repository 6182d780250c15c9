#pragma once
#include <filesystem>
#include <string>
#include <toml++/toml.hpp>

namespace signorini::scene {

/// Sets one `key.path=value` of --set in a scene's table; the value is TOML, or a plain text. `file` is the scene's, for messages.
/// Throws UserError.
void override_key(toml::table& root, const std::string& assignment, const std::filesystem::path& file);

} // namespace signorini::scene
