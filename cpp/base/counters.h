// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <map>
#include <string>

namespace signorini {

/// Returns the counter `name` of this process, zero at first; run.json lists them, to show that a scene costs
/// nothing that it does not ask for. The reference stays valid: take it once before a loop, so that counting
/// costs an increment. Not collective.
long& count(const std::string& name);

/// All counters of this process, by name. Not collective.
const std::map<std::string, long>& counts();

} // namespace signorini
