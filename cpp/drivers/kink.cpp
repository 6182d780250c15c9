// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/kink.h"
#include <map>

namespace signorini::drivers {

io::Kink describe(control::ReducedProblem& reduced,
                  const optimize::Certificate<control::Variables>& certificate) {
  const auto sweeps = reduced.sweeps();
  std::map<std::pair<int, int>, std::size_t> closed; // number of points where it is active
  for (const auto& point : certificate.points) {
    reduced.simulate(*point);
    const auto& contact = reduced.trial_trajectory().contact();
    for (std::size_t k = 1; k < contact.size(); ++k)
      for (int i : contact[k].active)
        ++closed[{static_cast<int>(k), i}];
  }
  reduced.count_from(sweeps);
  io::Kink kink{certificate.length, certificate.radius, static_cast<int>(certificate.points.size()), {}};
  for (const auto& [where, times] : closed)
    if (times < certificate.points.size()) {
      const auto& [k, i] = where;
      const double* x = &reduced.stepper().pairs()->points()[3 * static_cast<std::size_t>(i)];
      kink.weak.push_back(
          {k, reduced.controls().grid().time(k), i, {x, x + reduced.stepper().space().dim()}});
    }
  return kink;
}

std::vector<double> numbers(const io::Kink& kink) {
  std::vector<double> all{kink.length, kink.radius, static_cast<double>(kink.gradients)};
  for (const io::WeakContact& weak : kink.weak) {
    all.insert(all.end(), {static_cast<double>(weak.step), weak.time, static_cast<double>(weak.candidate)});
    all.insert(all.end(), weak.x.begin(), weak.x.end());
  }
  return all;
}

std::optional<io::Kink> kink_of(const std::vector<double>& numbers, int dim) {
  constexpr std::size_t head = 3; // of the kink, and of each candidate before its place
  const std::size_t each = head + static_cast<std::size_t>(dim);
  if (numbers.size() < head || (numbers.size() - head) % each != 0)
    return std::nullopt;
  io::Kink kink{numbers[0], numbers[1], static_cast<int>(numbers[2]), {}};
  for (auto n = numbers.begin() + head; n != numbers.end(); n += static_cast<std::ptrdiff_t>(each))
    kink.weak.push_back({static_cast<int>(n[0]),
                         n[1],
                         static_cast<int>(n[2]),
                         {n + head, n + static_cast<std::ptrdiff_t>(each)}});
  return kink;
}

} // namespace signorini::drivers
