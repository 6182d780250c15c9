#include "base/timers.h"

namespace signorini {

Timers::Scope::~Scope() {
  entry_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  ++entry_.calls;
}

} // namespace signorini
