// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/solver_cost.h"
#include "base/collective.h"
#include "linalg/machine_rates.h"

namespace signorini::step {

namespace {

constexpr double small_setup = 1;   ///< s
constexpr double any_machine = 2e9; ///< flops a second that any machine reaches

/// What direct solvers reach of the machine's rates (`./dev bench choice`).
struct Efficiency {
  double flops, bytes;
};
/// Of CHOLMOD, on one rank, and of MUMPS, whose ranks wait for each other.
constexpr Efficiency alone{.flops = 0.3, .bytes = 0.7}, together{.flops = 0.15, .bytes = 0.25};
/// Times of a trial from zero that a step takes by conjugate gradients: its guess saves iterations, changes
/// of the active set and evaluations of contact cost others.
constexpr double solves_per_step = 0.9;
/// By how much conjugate gradients must be quicker: estimates are rough, and a factor's solves are exact.
constexpr double margin = 1.15;

} // namespace

DirectWork::DirectWork(const FactorWork& factor, double candidates, double trailing_block)
    : setup_flops(factor.flops + candidates * candidates * candidates +
                  (trailing_block > 0 ? candidates * trailing_block * (trailing_block + candidates)
                                      : 4 * factor.entries * candidates)),
      solve_bytes(2 * sizeof(double) * factor.entries) {}

bool DirectWork::small() const { return setup_flops < small_setup * any_machine; }

Price price(MPI_Comm comm, const DirectWork& work) {
  const MachineRates rates = measure_rates(comm, work.solve_bytes / 2); // read forward and backward
  const Efficiency& reached = ranks(comm) == 1 ? alone : together;
  return {.setup = work.setup_flops / (reached.flops * rates.flops),
          .solve = work.solve_bytes / (reached.bytes * rates.bytes)};
}

Price iterative_price(double trial) { return {.solve = solves_per_step * trial}; }

double affordable(const Price& direct, double solves) {
  return direct.total(solves) / (margin * iterative_price(1).total(solves));
}

} // namespace signorini::step
