#pragma once
#include "problem.h"

namespace signorini {

/// Components of a smooth field at points (× 3) and time t / T, the same on any number of ranks; `which` picks one of
/// several.
void wave(const fem::Space& space, const std::vector<double>& points, const std::vector<int>& components, double t,
          int which, std::span<double> out);

/// A smooth control, likewise. Collective.
control::Control wave(const control::ControlSpace& controls, int which);

/// Where derivatives and errors are looked at: the scene's [check] control, else near the reference control (at the
/// reference itself the tracking error and with it the adjoint vanish), else the first guess; the same function of place and
/// time on every mesh. `description` says which. Collective. Throws UserError.
control::Control evaluation_point(const Problem& problem, const ControlProblem& control_problem, std::string& description);

} // namespace signorini
