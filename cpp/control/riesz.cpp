// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/riesz.h"
#include "base/collective.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <functional>

namespace signorini::control {
namespace {

double pairing(const ControlSpace& controls, const Control& d, const Control& u) {
  double sum = dot(d.values(), u.values());
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, controls.space().comm());
  return sum;
}

Control divided(const Control& d, const Control& weights) {
  Control quotient = d;
  std::ranges::transform(d.values(), weights.values(), quotient.values().begin(), std::divides());
  return quotient;
}

} // namespace

Control riesz_representative(const ControlSpace& controls, const Control& d) {
  const Control weights = controls.diagonal_weights();
  if (controls.diagonal())
    return divided(d, weights);
  // Conjugate gradients: mass matrices, scaled by their lumped ones, are as well conditioned on every mesh.
  constexpr double rounding = 1e-15;
  constexpr int most = 500; // about 40 are needed
  Control x = controls.zero(), r = d, z = divided(r, weights), p = z;
  double now = pairing(controls, r, z);
  const double enough = rounding * rounding * now;
  for (int i = 0; i < most; ++i) {
    if (now <= enough)
      return x;
    const Control image = controls.dual(p);
    const double length = now / pairing(controls, image, p);
    x.add(length, p);
    r.add(-length, image);
    z = divided(r, weights);
    const double next = pairing(controls, r, z);
    p.scale(next / now);
    p.add(1, z);
    now = next;
  }
  throw SolverFailure("conjugate gradients with the mass matrix of the controls did not converge");
}

} // namespace signorini::control
