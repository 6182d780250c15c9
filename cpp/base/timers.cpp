#include "base/timers.h"
#include <sys/resource.h>

namespace signorini {

Timers::Scope::~Scope() {
  entry_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  ++entry_.calls;
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss); // Linux counts in KiB
}

} // namespace signorini
