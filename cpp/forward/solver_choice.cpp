#include "forward/solver_choice.h"
#include "base/collective.h"
#include "contact/solver/condensed.h"
#include "contact/solver/full.h"
#include "contact/solver/projected.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

/// Local nodes of the candidates of a run on one rank, each once.
std::vector<int> candidate_nodes(const contact::ContactPairs* pairs) {
  std::vector<int> nodes;
  if (pairs)
    for (PetscInt dof : pairs->first_dofs())
      nodes.push_back(static_cast<int>(dof / pairs->dim()));
  nodes.erase(std::ranges::unique(nodes).begin(),
              nodes.end()); // several candidates of a node follow each other
  return nodes;
}

/// Memory of S and the factor of its active block, bytes.
double dense_bytes(const contact::ContactPairs* pairs) {
  const double m = pairs ? pairs->count() : 0;
  return 2 * m * m * sizeof(double);
}

} // namespace

SolverChoice::SolverChoice(petsc::Matrix D, const contact::ContactPairs* pairs, const scene::Solver& scene,
                           bool sliding)
    : D_(std::move(D)), full_(pairs && scene.vi == scene::ViMethod::full) {
  std::unique_ptr<contact::FullSolver> full;
  if (full_)
    full = std::make_unique<contact::FullSolver>(*pairs, D_);
  if (scene.linear == scene::LinearMethod::iterative)
    iterate();
  else
    factorise(pairs, scene);
  if (pairs && (!full_ || sliding))
    contact_ = by_linear(*pairs, scene);
  if (full_) {
    full->slide_by(std::move(contact_));
    contact_ = std::move(full);
  }
  if (!iterative_)
    D_ = {};
}

void SolverChoice::factorise(const contact::ContactPairs* pairs, const scene::Solver& scene) {
  constexpr double gigabyte = 1e9;
  const auto settle = [&](auto solver) {
    const double needed = solver->estimate() + dense_bytes(pairs);
    const bool possible = solver->possible();
    const std::string compared =
        possible
            ? fmt::format("a factor needs {:.2g} GB, {:.2g} GB are allowed", needed / gigabyte,
                          scene.memory / gigabyte)
            : fmt::format("a factor of {:.2g} GB has more entries than can be numbered", needed / gigabyte);
    if (scene.linear == scene::LinearMethod::automatic && (needed > scene.memory || !possible)) {
      iterate();
      choice_ = fmt::format("{} ({} by {})", linear_->name(), compared, solver->name());
      return;
    }
    solver->factorise();
    choice_ = fmt::format("{} ({})", solver->name(), compared);
    linear_ = std::move(solver);
  };
  if (ranks(petsc::comm(D_)) == 1) {
    auto cholesky = std::make_unique<SparseCholesky>(D_, candidate_nodes(pairs));
    const SparseCholesky* kept = cholesky.get();
    settle(std::move(cholesky));
    cholesky_ = iterative_ ? nullptr : kept;
  } else {
    auto mumps = std::make_unique<MumpsSolver>(D_);
    const MumpsSolver* kept = mumps.get();
    settle(std::move(mumps));
    mumps_ = iterative_ ? nullptr : kept;
  }
}

void SolverChoice::iterate() {
  auto solver = std::make_unique<ConjugateGradients>(D_);
  iterative_ = solver.get();
  choice_ = solver->name();
  linear_ = std::move(solver);
}

std::unique_ptr<contact::ContactStepSolver> SolverChoice::by_linear(const contact::ContactPairs& pairs,
                                                                    const scene::Solver& scene) const {
  if (iterative_)
    return std::make_unique<contact::ProjectedSolver>(pairs, *iterative_, D_);
  std::unique_ptr<contact::Elimination> elimination;
  if (cholesky_)
    elimination = std::make_unique<contact::TrailingBlockElimination>(pairs, *cholesky_);
  else
    elimination = std::make_unique<contact::StoredColumnsElimination>(
        pairs, *mumps_, petsc::vector_of(D_), scene.memory - linear_->bytes() - dense_bytes(&pairs));
  return std::make_unique<contact::CondensedSolver>(pairs, D_, std::move(elimination));
}

SolverChoice::Memory SolverChoice::memory() const {
  return {.factor = linear_->bytes() + (D_ ? petsc::bytes(D_) : 0),
          .condensation = contact_ ? contact_->bytes() : 0};
}

} // namespace signorini::forward
