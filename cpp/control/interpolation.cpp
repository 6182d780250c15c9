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
    first_ += places[static_cast<std::size_t>(r)];
}

Control Interpolation::operator()(const Control& u) const {
  const double end = to_.grid().time(to_.steps()), from_step = from_.grid().time(from_.steps()) / u.count(),
               to_step = end / to_.count();
  Control result = to_.zero();
  const petsc::Vector field = from_.field();
  const std::vector<int>& components = to_.components();
  const auto dim = static_cast<std::size_t>(to_.space().dim());
  std::vector<double> here(to_.size());
  for (int j = 1; j <= u.count(); ++j) { // each is evaluated once
    from_.extend(u.at(j), field);
    const std::vector<double> all = sampler_(field);
    for (std::size_t i = 0; i < here.size(); ++i)
      here[i] = all[(first_ + i / components.size()) * dim +
                    static_cast<std::size_t>(components[i % components.size()])];
    constexpr double rounding = 1e-9; // of a step: below that two steps do not overlap
    const double start = (j - 1) * from_step,
                 stop = j == u.count() ? std::max(end, j * from_step) : j * from_step;
    const int first = std::max(1, static_cast<int>(start / to_step)),
              last = std::min(to_.count(), static_cast<int>(stop / to_step) + 2);
    for (int k = first; k <= last; ++k) {
      const double part = (std::min(stop, k * to_step) - std::max(start, (k - 1) * to_step)) / to_step;
      if (part > 1 - rounding)
        std::ranges::copy(here, result.at(k).begin());
      else if (part > rounding)
        axpy(part, here, result.at(k));
    }
  }
  return result;
}

} // namespace signorini::control
