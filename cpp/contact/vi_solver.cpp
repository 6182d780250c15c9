#include "contact/vi_solver.h"
#include "base/counters.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::contact {
using petsc::check;

namespace {
long &solvers = count("VI solvers"), &solved = count("VIs solved");
}

ViSolver::ViSolver() { ++solvers; }

void ViSolver::count_solved() { ++solved; }

Complementarity::Complementarity(const Constraints& constraints, Mat D)
    : gap_tolerance_(constraints.gap_tolerance()) {
  const petsc::Vector diagonal = fem::diagonal(D);
  // Σ_c n_c² D_cc is the stiffness against moving the node alone along n, the direction of its force, but for
  // D's entries between its components.
  const std::size_t m = static_cast<std::size_t>(constraints.count());
  stiffness_.assign(m, 0.0);
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(diagonal, &begin, &end));
  {
    const petsc::ReadArray d(diagonal);
    const auto dim = static_cast<std::size_t>(constraints.dim());
    for (std::size_t i = 0; i < m; ++i)
      if (const PetscInt first = constraints.first_dofs()[i]; first >= begin && first < end)
        for (std::size_t c = 0; c < dim; ++c) {
          const double n = constraints.directions()[i * dim + c];
          stiffness_[i] += n * n * d[static_cast<std::size_t>(first - begin) + c];
        }
  }
  MPI_Allreduce(MPI_IN_PLACE, stiffness_.data(), static_cast<int>(m), MPI_DOUBLE, MPI_SUM, petsc::comm(D));
}

void Complementarity::classify(ContactState& state) const {
  double penetration = 0, adhesion = 0, distance = 0;
  std::ranges::fill(state.status, Status::open);
  state.active.clear();
  for (std::size_t i = 0; i < state.lambda.size(); ++i) {
    const double zero_force = gap_tolerance_ * stiffness_[i];
    penetration = std::max(penetration, -state.gap[i]);
    adhesion = std::max(adhesion, -state.lambda[i] / zero_force);
    if (state.lambda[i] > zero_force) {
      state.status[i] = Status::strong;
      distance = std::max(distance, state.gap[i]);
    } else if (state.gap[i] <= gap_tolerance_) {
      state.status[i] = Status::weak;
    }
    if (state.status[i] != Status::open)
      state.active.push_back(static_cast<int>(i));
  }
  const auto finite = [](double x) { return std::isfinite(x); };
  if (!std::ranges::all_of(state.gap, finite) || !std::ranges::all_of(state.lambda, finite))
    throw SolverFailure("the solution is not finite");
  if (!holds(state.lambda, state.gap))
    throw SolverFailure(
        fmt::format("the contact solution is not complementary: penetration {:.3e} m and forces at a gap of "
                    "{:.3e} m (allowed {:.3e} m), adhesion {:.3e} times the negligible force, {} strong "
                    "and {} weak of {} candidates",
                    penetration, distance, gap_tolerance_, adhesion, state.count(Status::strong),
                    state.count(Status::weak), state.lambda.size()));
}

bool Complementarity::holds_within(double negligible, std::span<const double> lambda,
                                   std::span<const double> gap) const {
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const double zero_force = negligible * stiffness_[i];
    if (!(gap[i] >= -negligible && lambda[i] >= -zero_force &&
          (lambda[i] <= zero_force || gap[i] <= negligible)))
      return false;
  }
  return true;
}

} // namespace signorini::contact
