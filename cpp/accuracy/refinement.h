// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini::accuracy {

/// A pair of numbers: one for the size of elements, one for the length of steps.
struct SizeAndStep {
  double size = 0, step = 0;
};

/// The order with which a part of the error has fallen from `coarse` to `fine` as its width changed by
/// `factor` < 1, between `least` and above that of the schemes; `otherwise` where these determine none.
double observed_order(double coarse, double fine, double factor, double otherwise, double least);

/// Factors of size and step for which the parts of an error, proportional to powers of them with `orders`,
/// add up to `target` at the least cost, which grows as size^(−dim·step_power(dim)) / step; each between
/// `least` and `most`. Where nothing may become coarser, a part that is small already leaves its share to the
/// other.
SizeAndStep cheapest_factors(const SizeAndStep& error, const SizeAndStep& orders, double target, int dim,
                             double least, double most);

} // namespace signorini::accuracy
