// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include "scene/scene.h"

namespace signorini::drivers {

/// Calls `use.template operator()<Method>()` with the class of an optimisation method, and returns the result
/// of the call. gauss_newton, a method for parameters alone, is replaced by ProjectedGradient.
template <class Use>
decltype(auto) with_method(scene::OptimizerMethod method, Use&& use) {
  switch (method) {
  case scene::OptimizerMethod::lbfgs:
    return use.template operator()<optimize::Lbfgs>();
  case scene::OptimizerMethod::newton_cg:
    return use.template operator()<optimize::NewtonCg>();
  case scene::OptimizerMethod::projected_gradient:
  case scene::OptimizerMethod::gauss_newton:
    break;
  }
  return use.template operator()<optimize::ProjectedGradient>();
}

} // namespace signorini::drivers
