// SPDX-License-Identifier: GPL-3.0-or-later
// J of a scene at the control that it starts from, and the norm of its gradient there: own SCENE [key=value…]
#include "problem/problem.h"
#include <cmath>
#include <cstdio>
#include <spdlog/spdlog.h>

using namespace signorini;

int main(int argc, char** argv) {
  PetscInitializeNoArguments();
  spdlog::set_level(spdlog::level::warn); // dolfinx tells all that it does
  {
    const scene::Scene scene = scene::parse(scene::read(argv[1]), argv[1], {argv + 2, argv + argc});
    Timers timers;
    const problem::Problem problem(PETSC_COMM_WORLD, scene, problem::search_needs(scene), timers);
    problem::ControlProblem control(problem, Console(false, false));
    const double J = control.reduced.value(control.first_guess(scene));
    control.reduced.accept();
    const control::Control g = control.reduced.l2_gradient();
    std::printf("J = %.15g, |gradient| = %.15g\n", J, std::sqrt(control.reduced.inner(g, g)));
  }
  return PetscFinalize() == PETSC_SUCCESS ? 0 : 1;
}
