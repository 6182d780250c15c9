// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/solver_choice.h"
#include "base/collective.h"
#include "base/text.h"
#include "contact/condensation.h"
#include "contact/solver/full.h"
#include "contact/solver/projected.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::step {
using petsc::check;

namespace {

constexpr double small_setup = 2e9; ///< flops

/// Rates of one rank: operations per second of a set-up, bytes per second of a solve (`./dev bench choice`).
/// Only ratios matter. A dense product is four times as fast as CHOLMOD's factorisation, and an array is read
/// somewhat faster than a factor. MUMPS is slower, since its fronts wait for each other.
struct Rates {
  double flops, bytes;
};
constexpr Rates cholmod{.flops = 16e9, .bytes = 15e9}, mumps{.flops = 8e9, .bytes = 6e9};
/// Bytes per second of an iteration by conjugate gradients; two machines read 12 and 20 GB/s.
constexpr double iteration_rate = 18e9;

/// Seconds per unknown for the analysis by MUMPS, which one rank makes, and for the distribution of D.
constexpr double mumps_analysis = 25e-6;
/// Entries of a factor per entry of D's upper half: 5 for a slender block, 16 for a disc of 13,000 unknowns.
constexpr double typical_fill = 10;

/// Cost of a step by conjugate gradients in units of the trial solve, which starts from zero. A step's guess
/// saves iterations; changes of the active set and evaluations of contact cost others.
constexpr double solves_per_step = 0.9;
/// Factor by which conjugate gradients must be faster to be chosen: estimates are rough, and solves by a
/// factor are exact.
constexpr double margin = 1.15;

} // namespace

DirectWork::DirectWork(const FactorWork& factor, double candidates, double trailing_block)
    : setup_flops(factor.flops + candidates * candidates * candidates +
                  (trailing_block > 0 ? candidates * trailing_block * (trailing_block + candidates)
                                      : 4 * factor.entries * candidates)),
      solve_bytes(2 * sizeof(double) * factor.entries) {}

bool DirectWork::small() const { return setup_flops < small_setup; }

Price price(const DirectWork& work, int ranks) {
  const Rates& rates = ranks == 1 ? cholmod : mumps;
  return {.setup = work.setup_flops / (rates.flops * ranks),
          .solve = work.solve_bytes / (rates.bytes * ranks)};
}

Price expected_mumps_price(Mat D, int ranks) {
  PetscInt n = 0;
  MatInfo info{};
  check(MatGetSize(D, &n, nullptr));
  check(MatGetInfo(D, MAT_GLOBAL_SUM, &info));
  const auto unknowns = static_cast<double>(n);
  const double entries = typical_fill * (info.nz_used + unknowns) / 2;
  return {.setup = mumps_analysis * unknowns, .solve = 2 * sizeof(double) * entries / (mumps.bytes * ranks)};
}

Price iterative_price(double trial_work, double iteration_bytes, int ranks) {
  return {.solve = solves_per_step * trial_work * iteration_bytes / (iteration_rate * ranks)};
}

double affordable(const Price& direct, double solves, double iteration_bytes, int ranks) {
  return direct.total(solves) / (margin * iterative_price(1, iteration_bytes, ranks).total(solves));
}

namespace {

/// Returns the number of layers of a graph around the node `start`: sets of nodes at equal distance from it.
/// Sets `start` to a node of the last layer.
int layers(PetscInt nodes, const PetscInt* begin, const PetscInt* neighbours, PetscInt& start) {
  std::vector<bool> found(static_cast<std::size_t>(nodes));
  std::vector<PetscInt> layer{start}, next;
  found[static_cast<std::size_t>(start)] = true;
  int count = 0;
  while (!layer.empty()) {
    ++count;
    start = layer.back();
    next.clear();
    for (const PetscInt node : layer)
      for (PetscInt k = begin[node]; k < begin[node + 1]; ++k)
        if (auto there = found[static_cast<std::size_t>(neighbours[k])]; !there) {
          there = true;
          next.push_back(neighbours[k]);
        }
    layer.swap(next);
  }
  return count;
}

} // namespace

double least_factor_bytes(Mat D) {
  // A layer is about as wide as the first separator of nested dissection, whose front has half the square of
  // its unknowns; all fronts of a body in space have 27 times as much as that, and those of a plate or a bar
  // more.
  constexpr double fronts = 8;
  PetscInt nodes = 0, block = 1;
  const PetscInt *begin = nullptr, *neighbours = nullptr;
  PetscBool done = PETSC_FALSE;
  check(MatGetBlockSize(D, &block));
  check(MatGetRowIJ(D, 0, PETSC_FALSE, PETSC_TRUE, &nodes, &begin, &neighbours, &done));
  if (!done || nodes == 0)
    return 0;
  PetscInt start = 0;
  (void)layers(nodes, begin, neighbours, start);
  const double width = static_cast<double>(nodes) / layers(nodes, begin, neighbours, start);
  check(MatRestoreRowIJ(D, 0, PETSC_FALSE, PETSC_TRUE, &nodes, &begin, &neighbours, &done));
  return fronts * std::pow(width * static_cast<double>(block), 2) * sizeof(double);
}

namespace {

/// Returns the local nodes whose dofs contact constrains, each once, for a run on one rank.
std::vector<int> constrained_nodes(const contact::ContactPairs* pairs) {
  std::vector<int> nodes;
  if (pairs)
    for (PetscInt dof : pairs->rows().dofs())
      nodes.push_back(static_cast<int>(dof / pairs->dim()));
  nodes.erase(std::ranges::unique(nodes).begin(), nodes.end()); // the dofs of a node follow each other
  return nodes;
}

/// Returns whether columns on demand take fewer iterations than projection onto the active set and all
/// columns fit into `memory` (bytes).
bool condense_on_demand(const contact::ConstraintRows& rows, double solves, Mat D, double memory) {
  // A column, from zero, takes as many iterations as two or three steps, from their guesses. A step saves the
  // solves in which the set changes, 0.07 to 0.15 of one, and the projections (half-disc, block, disc-drop).
  constexpr double of_column = 2, saved = 0.1;
  PetscInt n = 0;
  check(MatGetSize(D, &n, nullptr));
  return of_column * rows.count() <= saved * solves &&
         sizeof(double) * static_cast<double>(n) * rows.count() <= memory;
}

/// Returns the memory of the condensed matrix S and of the factor of its active block, bytes.
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
  std::unique_ptr<contact::ContactStepSolver> condensed;
  if (pairs && (!full_ || derivatives)) {
    if (!iterative_)
      diagonal_ = std::make_shared<const petsc::Vector>(fem::diagonal(D_));
    condensed = by_linear(*pairs, scene, solves, std::move(residual));
  }
  if (full_) {
    full->linearise_by(std::move(condensed));
    contact_ = std::move(full);
  } else {
    contact_ = std::move(condensed);
  }
  if (!iterative_)
    D_ = {};
}

SolverChoice::SolverChoice(const SolverChoice& like, const contact::ContactPairs* pairs, bool same_rows,
                           const scene::Solver& scene, contact::Residual residual)
    : linear_(like.linear_), cholesky_(like.cholesky_), mumps_(like.mumps_), diagonal_(like.diagonal_),
      choice_(like.choice_) {
  if (same_rows)
    contact_ = like.contact_;
  else if (pairs)
    contact_ = by_linear(*pairs, scene, 0, std::move(residual));
}

void SolverChoice::factorise(const contact::ContactPairs* pairs, const scene::Solver& scene, double solves,
                             const EliminationOrder& order) {
  const int size = ranks(petsc::comm(D_));
  const bool automatic = scene.linear == scene::LinearMethod::automatic;
  const auto settle = [&](auto solver, double trailing_block) -> decltype(solver.get()) {
    const double needed = solver->estimate() + dense_bytes(pairs);
    const bool indexable = solver->indexable();
    std::string compared =
        indexable
            ? fmt::format("a factor needs {}, the limit is {}", bytes_text(needed), bytes_text(scene.memory))
            : fmt::format("a factor of {} has more entries than can be numbered", bytes_text(needed));
    if (automatic && (needed > scene.memory || !indexable)) {
      auto other = std::make_unique<ConjugateGradients>(D_, solves);
      const std::string why = fmt::format("{} ({}: {})", other->name(), solver->name(), compared);
      iterate(std::move(other), why);
      return nullptr;
    }
    if (automatic && solves > 0 && !full_) {
      const DirectWork work(solver->work(), pairs ? pairs->count() : 0, trailing_block);
      std::string times;
      if (!work.small() && iterate_if_quicker(price(work, size), solver->name(), solves, times))
        return nullptr;
      compared += times;
    }
    solver->factorise();
    choice_ = fmt::format("{} ({})", solver->name(), compared);
    const auto kept = solver.get();
    linear_ = std::move(solver);
    return kept;
  };
  if (size == 1) {
    if (const double least = least_factor_bytes(D_); automatic && least > scene.memory) {
      auto other = std::make_unique<ConjugateGradients>(D_, solves);
      const std::string why = fmt::format("{} (a factor needs at least {}, the limit is {})", other->name(),
                                          bytes_text(least), bytes_text(scene.memory));
      return iterate(std::move(other), why);
    }
    auto solver = std::make_unique<SparseCholesky>(D_, constrained_nodes(pairs),
                                                   std::numeric_limits<int>::max(), order);
    const double trailing_block = solver->trailing_size();
    cholesky_ = settle(std::move(solver), trailing_block);
  } else {
    // The analysis takes longer than short runs by conjugate gradients. In long runs a trial of these before
    // the analysis and another after it would cost more than it saves.
    if (const Price expected = expected_mumps_price(D_, size); automatic && solves > 0 && !full_ &&
                                                               expected.setup > small_setup / mumps.flops &&
                                                               expected.setup > solves * expected.solve) {
      std::string ignored;
      if (iterate_if_quicker(expected, "MUMPS (before its analysis of D)", solves, ignored))
        return;
    }
    mumps_ = settle(std::make_unique<MumpsSolver>(D_), 0);
  }
}

bool SolverChoice::iterate_if_quicker(const Price& factor, const std::string& direct, double solves,
                                      std::string& compared) {
  const int size = ranks(petsc::comm(D_));
  const double bytes = ConjugateGradients::iteration_bytes(D_);
  std::unique_ptr<ConjugateGradients> solver;
  try {
    solver = std::make_unique<ConjugateGradients>(D_, solves, affordable(factor, solves, bytes, size));
  } catch (const SolverFailure&) { // no preconditioner
    return false;
  }
  const Price iterative = iterative_price(solver->trial_work(), bytes, size);
  const bool quicker =
      std::isfinite(iterative.solve) && margin * iterative.total(solves) <= factor.total(solves);
  const std::string both =
      fmt::format("time of {:.0f} solves: {:.2g} s by {}, {} by {}", solves, factor.total(solves), direct,
                  quicker ? fmt::format("{:.2g} s", iterative.total(solves)) : "more", solver->name());
  if (quicker) {
    const std::string why = fmt::format("{} (estimated {})", solver->name(), both);
    iterate(std::move(solver), why);
  } else {
    compared = "; estimated " + both;
  }
  return quicker;
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
    if (!pairs.rows().symmetric() || pairs.rows().share() ||
        condense_on_demand(pairs.rows(), solves, D_, room)) {
      choice_ += "; contact condensed by columns computed on demand";
      auto columns =
          std::make_unique<contact::ColumnsOnDemand>(pairs.rows(), *iterative_, iterative_->product(), room);
      return std::make_unique<contact::CondensedSolver>(pairs.rows(), pairs.diameter(), fem::diagonal(D_),
                                                        std::move(columns), contact::Residual(),
                                                        iterative_->tolerance());
    }
    return std::make_unique<contact::ProjectedSolver>(pairs.rows(), pairs.diameter(), *iterative_,
                                                      iterative_->product());
  }
  std::unique_ptr<contact::Condensation> condensation;
  if (cholesky_)
    condensation = std::make_unique<contact::TrailingBlockCondensation>(pairs.rows(), *cholesky_);
  else
    condensation = std::make_unique<contact::StoredColumnsCondensation>(
        pairs.rows(), *mumps_, *diagonal_, scene.memory - linear_->bytes() - dense_bytes(&pairs));
  return std::make_unique<contact::CondensedSolver>(pairs.rows(), pairs.diameter(), *diagonal_,
                                                    std::move(condensation), std::move(residual));
}

SolverChoice::Memory SolverChoice::memory() const {
  return {.factor = linear_->bytes() + (D_ ? petsc::bytes(D_) : 0),
          .condensation = contact_ ? contact_->bytes() : 0};
}

} // namespace signorini::step
