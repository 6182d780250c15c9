#pragma once
#include <map>
#include <string>

namespace signorini {

/// How often this process made or did something, by name, for run.json: what a scene does not ask for must
/// count nothing. The reference stays valid: in a loop it is taken once before, and counting costs an
/// increment.
long& count(const std::string& name);

/// All of them.
const std::map<std::string, long>& counts();

} // namespace signorini
