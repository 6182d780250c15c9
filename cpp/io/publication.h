// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace signorini::io {

/// Replaces those files of `folder` that `names` lists by those in `staging`, a folder inside it, and removes
/// `outdated` ones of the folder, with folders that this leaves empty: all of it, or nothing if it throws. A
/// process that is killed meanwhile leaves a state that complete_publication()
/// can finish. `names` ends with the manifest of the others: it is absent while they change. Not collective.
/// Throws OutputFailure.
void publish(const std::filesystem::path& folder, const std::filesystem::path& staging,
             std::span<const char* const> names, const std::vector<std::string>& outdated);

/// Finishes the publication of a process that was killed during it. Not collective. Throws OutputFailure.
void complete_publication(const std::filesystem::path& folder, std::span<const char* const> names);

} // namespace signorini::io
