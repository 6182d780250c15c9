// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/solver_choice.h"
#include "base/collective.h"
#include "contact/condensation.h"
#include "contact/solver/full.h"
#include "contact/solver/projected.h"
#include "linalg/dense.h"
#include <algorithm>
#include <array>
#include <chrono>
#include <fmt/format.h>
#include <limits>

namespace signorini::step {
using petsc::check;

namespace {

/// Seconds of the quickest of some repetitions: what other work on the machine adds is left out.
template <class Work>
double least_seconds(int repetitions, Work&& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

double measure_flops() {
  constexpr std::size_t n =
      192; // about the width of the fronts in which a factor of a body in space has its work
  const std::vector<double> a(n * n, 1.0), b(n * n, 1.0);
  std::vector<double> c(n * n);
  constexpr double flops = 2.0 * n * n * n;
  return flops / least_seconds(8, [&] { multiply(a, b, c, n); });
}

double measure_bytes(double wanted) {
  constexpr double least = 1 << 20, most = 1 << 26;
  const std::vector<double> values(static_cast<std::size_t>(std::clamp(wanted, least, most)) / sizeof(double),
                                   1.0);
  volatile double kept = 0; // so that the sum is made
  const double seconds = least_seconds(3, [&] {
    double sum = 0;
#pragma omp parallel for simd reduction(+ : sum) schedule(static)
    for (std::size_t i = 0; i < values.size(); ++i)
      sum += values[i];
    kept = sum;
  });
  return static_cast<double>(values.size()) * sizeof(double) / seconds;
}

} // namespace

MachineRates measure_rates(MPI_Comm comm, double bytes) {
  const double size = ranks(comm);
  MPI_Barrier(comm); // so that ranks share memory's bandwidth as in a solve
  std::array<double, 2> rates{measure_flops(), measure_bytes(bytes / size)};
  MPI_Bcast(rates.data(), 2, MPI_DOUBLE, 0, comm);
  return {.flops = size * rates[0], .bytes = size * rates[1]};
}

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

namespace {

/// Local nodes whose dofs contact constrains, of a run on one rank, each once.
std::vector<int> constrained_nodes(const contact::ContactPairs* pairs) {
  std::vector<int> nodes;
  if (pairs)
    for (PetscInt dof : pairs->rows().dofs())
      nodes.push_back(static_cast<int>(dof / pairs->dim()));
  nodes.erase(std::ranges::unique(nodes).begin(), nodes.end()); // the dofs of a node follow each other
  return nodes;
}

/// Whether conjugate gradients take fewer iterations by columns on demand than by projection onto the
/// active set, if all of these fit into the memory.
bool condense_on_demand(const contact::ConstraintRows& rows, double solves, Mat D, double memory) {
  // A column, from zero, takes as many iterations as two or three steps, from their guesses. A step saves the
  // solves in which the set changes, 0.07 to 0.15 of one, and the projections (half-disc, block, disc-drop).
  constexpr double of_column = 2, saved = 0.1;
  PetscInt n = 0;
  check(MatGetSize(D, &n, nullptr));
  return of_column * rows.count() <= saved * solves &&
         sizeof(double) * static_cast<double>(n) * rows.count() <= memory;
}

/// Memory of S and the factor of its active block, bytes.
double dense_bytes(const contact::ContactPairs* pairs) {
  const double m = pairs ? pairs->count() : 0;
  return 2 * m * m * sizeof(double);
}

} // namespace

SolverChoice::SolverChoice(petsc::Matrix D, const contact::ContactPairs* pairs, const scene::Solver& scene,
                           bool derivatives, double solves, const EliminationOrder& order,
                           contact::Residual residual)
    : D_(std::move(D)), full_(pairs && scene.vi == scene::ViMethod::full) {
  std::unique_ptr<contact::FullSolver> full;
  if (full_)
    full = std::make_unique<contact::FullSolver>(*pairs, D_);
  if (scene.linear == scene::LinearMethod::iterative) {
    auto solver = std::make_unique<ConjugateGradients>(D_, solves);
    const std::string name = solver->name();
    iterate(std::move(solver), name);
  } else {
    factorise(pairs, scene, solves, order);
  }
  if (pairs && (!full_ || derivatives))
    contact_ = by_linear(*pairs, scene, solves, std::move(residual));
  if (full_) {
    full->linearise_by(std::move(contact_));
    contact_ = std::move(full);
  }
  if (!iterative_)
    D_ = {};
}

void SolverChoice::factorise(const contact::ContactPairs* pairs, const scene::Solver& scene, double solves,
                             const EliminationOrder& order) {
  constexpr double gigabyte = 1e9;
  const bool automatic = scene.linear == scene::LinearMethod::automatic;
  const auto settle = [&](auto solver, double trailing_block) -> decltype(solver.get()) {
    const double needed = solver->estimate() + dense_bytes(pairs);
    const bool possible = solver->possible();
    std::string compared =
        possible
            ? fmt::format("a factor needs {:.2g} GB, {:.2g} GB are allowed", needed / gigabyte,
                          scene.memory / gigabyte)
            : fmt::format("a factor of {:.2g} GB has more entries than can be numbered", needed / gigabyte);
    if (automatic && (needed > scene.memory || !possible)) {
      auto other = std::make_unique<ConjugateGradients>(D_, solves);
      const std::string why = fmt::format("{} ({} by {})", other->name(), compared, solver->name());
      iterate(std::move(other), why);
      return nullptr;
    }
    if (automatic && solves > 0 && !full_) {
      const DirectWork work(solver->work(), pairs ? pairs->count() : 0, trailing_block);
      std::string times;
      if (!work.small() && iterate_if_quicker(work, solver->name(), solves, times))
        return nullptr;
      compared += times;
    }
    solver->factorise();
    choice_ = fmt::format("{} ({})", solver->name(), compared);
    const auto kept = solver.get();
    linear_ = std::move(solver);
    return kept;
  };
  if (ranks(petsc::comm(D_)) == 1) {
    auto solver = std::make_unique<SparseCholesky>(D_, constrained_nodes(pairs),
                                                   std::numeric_limits<int>::max(), order);
    const double trailing_block = solver->trailing_size();
    cholesky_ = settle(std::move(solver), trailing_block);
  } else {
    mumps_ = settle(std::make_unique<MumpsSolver>(D_), 0);
  }
}

bool SolverChoice::iterate_if_quicker(const DirectWork& work, const std::string& direct, double solves,
                                      std::string& times) {
  const MPI_Comm comm = petsc::comm(D_);
  const Price factor = price(comm, work);
  const double most = affordable(factor, solves);
  std::unique_ptr<ConjugateGradients> solver;
  try {
    solver = std::make_unique<ConjugateGradients>(D_, solves, most);
  } catch (const SolverFailure&) { // no preconditioner
    return false;
  }
  const double seconds = solver->trial_seconds();
  int quicker = seconds <= most;
  MPI_Bcast(&quicker, 1, MPI_INT, 0, comm);
  const std::string compared = fmt::format(
      "for {:.0f} solves {:.2g} s by {}, {} by {}", solves, factor.total(solves), direct,
      quicker ? fmt::format("{:.2g} s", iterative_price(seconds).total(solves)) : "more", solver->name());
  if (quicker) {
    const std::string why = fmt::format("{} (estimated {})", solver->name(), compared);
    iterate(std::move(solver), why);
  } else {
    times = "; estimated " + compared;
  }
  return quicker != 0;
}

void SolverChoice::iterate(std::unique_ptr<ConjugateGradients> solver, const std::string& why) {
  iterative_ = solver.get();
  choice_ = why;
  linear_ = std::move(solver);
}

std::unique_ptr<contact::ContactStepSolver> SolverChoice::by_linear(const contact::ContactPairs& pairs,
                                                                    const scene::Solver& scene, double solves,
                                                                    contact::Residual residual) {
  if (iterative_) {
    const double room = scene.memory - linear_->bytes();
    if (!pairs.rows().symmetric() || condense_on_demand(pairs.rows(), solves, D_, room)) {
      choice_ += "; contact by columns on demand";
      auto columns = std::make_unique<contact::ColumnsOnDemand>(pairs.rows(), *iterative_, D_, room);
      return std::make_unique<contact::CondensedSolver>(pairs.rows(), pairs.diameter(), D_,
                                                        std::move(columns), contact::Residual(),
                                                        iterative_->tolerance());
    }
    return std::make_unique<contact::ProjectedSolver>(pairs.rows(), pairs.diameter(), *iterative_, D_);
  }
  std::unique_ptr<contact::Condensation> condensation;
  if (cholesky_)
    condensation = std::make_unique<contact::TrailingBlockCondensation>(pairs.rows(), *cholesky_);
  else
    condensation = std::make_unique<contact::StoredColumnsCondensation>(
        pairs.rows(), *mumps_, petsc::vector_of(D_), scene.memory - linear_->bytes() - dense_bytes(&pairs));
  return std::make_unique<contact::CondensedSolver>(pairs.rows(), pairs.diameter(), D_,
                                                    std::move(condensation), std::move(residual));
}

SolverChoice::Memory SolverChoice::memory() const {
  return {.factor = linear_->bytes() + (D_ ? petsc::bytes(D_) : 0),
          .condensation = contact_ ? contact_->bytes() : 0};
}

} // namespace signorini::step
