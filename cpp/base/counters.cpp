// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/counters.h"

namespace signorini {
namespace {

std::map<std::string, long>& registry() {
  static std::map<std::string, long> all; // counters of other files are initialised before main, in any order
  return all;
}

} // namespace

long& count(const std::string& name) { return registry()[name]; }

const std::map<std::string, long>& counts() { return registry(); }

} // namespace signorini
