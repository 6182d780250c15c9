// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/refinement.h"
#include "accuracy/rungs.h"
#include <algorithm>
#include <cmath>

namespace signorini::accuracy {

double observed_order(double coarse, double fine, double factor, double otherwise, double least) {
  constexpr double most = 2.5, enough = 0.9;
  if (!(factor < enough) || !(coarse > 0) || !(fine > 0))
    return otherwise;
  return std::clamp(std::log(fine / coarse) / std::log(factor), least, most);
}

SizeAndStep cheapest_factors(const SizeAndStep& error, const SizeAndStep& orders, double target, int dim,
                             double least, double most) {
  // The parts of a minimum are in proportion to the exponents of the cost over their orders.
  const double of_size = dim * step_power(dim) / orders.size, of_step = 1 / orders.step;
  double size = target * of_size / (of_size + of_step), step = target - size;
  if (most <= 1) {
    if (error.step < step && error.size > size)
      size = target - error.step;
    else if (error.size < size && error.step > step)
      step = target - error.size;
  }
  const auto factor = [&](double part, double wanted, double order) {
    return part > 0 ? std::clamp(std::pow(wanted / part, 1 / order), least, most) : most;
  };
  return {factor(error.size, size, orders.size), factor(error.step, step, orders.step)};
}

} // namespace signorini::accuracy
