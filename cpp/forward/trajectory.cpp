#include "forward/trajectory.h"
#include "base/counters.h"

namespace signorini::forward {

namespace {
long& vectors = count("trajectory vectors");
}

Trajectory::Trajectory(const Stepper& stepper, int count) {
  const std::size_t entries = static_cast<std::size_t>(count) + 1;
  const petsc::Vector layout = stepper.space().vector();
  y = petsc::zero_series(layout, entries);
  v = petsc::zero_series(layout, entries);
  vectors += static_cast<long>(y.size() + v.size());
  const int candidates = stepper.constraints() ? stepper.constraints()->count() : 0;
  contact.reserve(entries);
  for (std::size_t k = 0; k < entries; ++k)
    contact.emplace_back(candidates); // not copies of one: a copy has no room for other active sets
}

} // namespace signorini::forward
