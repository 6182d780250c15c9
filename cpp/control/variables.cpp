// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/variables.h"

namespace signorini::control {

Variables::Variables(const CompactVariables& compact) : u(compact.u), x(compact.x) {}

void Variables::add(std::span<const double> a, std::span<const CompactVariables> v) {
  u.add(a, controls_of(v));
  for (std::size_t i = 0; i < v.size(); ++i)
    axpy(a[i], v[i].x, x);
}

void CompactVariables::combine(std::vector<CompactVariables>& v,
                               const std::vector<std::vector<double>>& factors) {
  std::vector<CompactControl> controls; // moved, so that none is copied when it is overwritten
  for (CompactVariables& one : v)
    controls.push_back(std::move(one.u));
  CompactControl::combine(controls, factors);
  std::vector<CompactVariables> combined(factors.size());
  for (std::size_t j = 0; j < factors.size(); ++j) {
    combined[j].u = std::move(controls[j]);
    combined[j].x.assign(v.empty() ? 0 : v.front().x.size(), 0.0);
    for (std::size_t i = 0; i < v.size(); ++i)
      axpy(factors[j][i], v[i].x, combined[j].x);
  }
  v = std::move(combined);
}

std::vector<CompactControl> controls_of(std::span<const CompactVariables> v) {
  std::vector<CompactControl> controls;
  for (const CompactVariables& one : v)
    controls.push_back(one.u);
  return controls;
}

} // namespace signorini::control
