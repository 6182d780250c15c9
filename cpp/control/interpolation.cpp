// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/interpolation.h"
#include "base/collective.h"
#include <algorithm>
#include <cmath>

namespace signorini::control {

Interpolation::Interpolation(const ControlSpace& from, const ControlSpace& to)
    : from_(from), to_(to), sampler_(from.space(), gather(to.space().comm(), to.points()), from.on(),
                                     "control.on", from.cellwise()) {
  const MPI_Comm comm = to.space().comm();
  const std::vector<std::size_t> places = gather(comm, std::vector{to.places().size()});
  for (int r = 0; r < rank(comm); ++r)
    first_ += places[r];
}

double Interpolation::farthest() const {
  const std::vector<double>& distances = sampler_.distances();
  return distances.empty() ? 0 : *std::ranges::max_element(distances);
}

Control Interpolation::operator()(const Control& u) const {
  const double end = to_.grid().end();
  Control result = to_.zero();
  const petsc::Vector field = from_.field();
  const std::vector<int>& components = to_.components();
  const auto dim = static_cast<std::size_t>(to_.space().dim());
  std::vector<double> here(to_.size());
  int next = 1;                          // of the intervals of to_
  for (int j = 1; j <= u.count(); ++j) { // each is evaluated once
    from_.extend(u.at(j), field);
    const std::vector<double> all = sampler_(field);
    for (std::size_t i = 0; i < here.size(); ++i)
      here[i] = all[(first_ + i / components.size()) * dim +
                    static_cast<std::size_t>(components[i % components.size()])];
    constexpr double rounding = 1e-9; // of an interval: below that two do not overlap
    const double start = from_.begin(j),
                 stop = j == u.count() ? std::max(end, from_.begin(j + 1)) : from_.begin(j + 1);
    for (; next <= to_.count() && to_.begin(next) < stop; ++next) {
      const double length = to_.length(next),
                   part = (std::min(stop, to_.begin(next + 1)) - std::max(start, to_.begin(next))) / length;
      if (part > 1 - rounding)
        std::ranges::copy(here, result.at(next).begin());
      else if (part > rounding)
        axpy(part, here, result.at(next));
    }
    if (next > 1)
      --next; // it may continue in the next interval
  }
  return result;
}

} // namespace signorini::control
