#pragma once
#include "problem.h"

namespace signorini {

/// The verb info: sizes, effects on and off, and for each what it adds: matrices, other memory, work in a
/// step. Makes no step but for `timed_steps` forward, and as many adjoint ones of a scene with an objective,
/// from which it estimates the time of the whole. Collective. Throws UserError, SolverFailure.
void tell(const Problem& problem, int timed_steps, const Console& console);

} // namespace signorini
