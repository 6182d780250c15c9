#include "base/counters.h"

namespace signorini {
namespace {

std::map<std::string, long>& registry() {
  static std::map<std::string, long> all; // made at its first use, which may be before main
  return all;
}

} // namespace

long& count(const std::string& name) { return registry()[name]; }

const std::map<std::string, long>& counts() { return registry(); }

} // namespace signorini
