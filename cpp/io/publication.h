#pragma once
#include <filesystem>
#include <span>

namespace signorini::io {

/// Makes the files of `staging`, a folder inside `folder`, take the place of those of `names` in it: all of them, or none
/// if it throws. A process that is killed on the way leaves what complete_publication() needs. `names` ends with the file that
/// stands for the others: while they change it is not there. Not collective. Throws UserError.
void publish(const std::filesystem::path& folder, const std::filesystem::path& staging,
             std::span<const char* const> names);

/// Finishes what a process that was killed while it published began. Throws UserError.
void complete_publication(const std::filesystem::path& folder, std::span<const char* const> names);

} // namespace signorini::io
