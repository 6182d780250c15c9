// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/parameter_problem.h"

namespace signorini::drivers {

/// What a search varies, and of which problem: a control, the parameters of a scene, or both. Null parts are
/// absent.
struct SearchSubject {
  const scene::Scene& scene; ///< as it is written into the results
  const problem::Discretisation& discretisation;
  control::ReducedProblem& reduced;
  Timers& timers;
  const problem::Problem* problem = nullptr; ///< whose steps a control has
  const problem::ControlProblem* control = nullptr;
  const problem::ParameterProblem* parameters = nullptr;

  [[nodiscard]] MPI_Comm comm() const { return discretisation.space.comm(); }
  [[nodiscard]] std::size_t parameter_count() const {
    return parameters ? parameters->scene.unknowns.size() : 0;
  }
};

} // namespace signorini::drivers
