#include "forward/step_solver.h"
#include "base/collective.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

/// Local nodes of the candidates of a run on one rank, each once.
std::vector<int> candidate_nodes(const contact::Constraints* constraints) {
  std::vector<int> nodes;
  if (constraints)
    for (PetscInt dof : constraints->first_dofs())
      nodes.push_back(static_cast<int>(dof / constraints->dim()));
  nodes.erase(std::ranges::unique(nodes).begin(),
              nodes.end()); // several candidates of a node follow each other
  return nodes;
}

/// Memory of S and the factor of its active block, bytes.
double dense_bytes(const contact::Constraints* constraints) {
  const double m = constraints ? constraints->count() : 0;
  return 2 * m * m * sizeof(double);
}

} // namespace

StepSolver::StepSolver(petsc::Matrix D, const contact::Constraints* constraints, const scene::Solver& scene,
                       bool sliding)
    : D_(std::move(D)) {
  if (constraints)
    complementarity_.emplace(*constraints, D_);
  if (constraints && scene.vi == scene::ViMethod::full)
    full_vi_.emplace(*constraints, D_, *complementarity_);
  if (scene.linear == scene::LinearMethod::iterative)
    iterate();
  else
    factorise(constraints, scene);
  if (constraints)
    add_contact(*constraints, scene, sliding);
  if (!iterative_)
    D_ = {};
}

void StepSolver::factorise(const contact::Constraints* constraints, const scene::Solver& scene) {
  constexpr double gigabyte = 1e9;
  const auto settle = [&](auto solver) {
    const double needed = solver->estimate() + dense_bytes(constraints);
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
    auto cholesky = std::make_unique<SparseCholesky>(D_, candidate_nodes(constraints));
    const SparseCholesky* kept = cholesky.get();
    settle(std::move(cholesky));
    cholesky_ = iterative_ ? nullptr : kept;
  } else {
    settle(std::make_unique<MumpsSolver>(D_));
  }
}

void StepSolver::iterate() {
  auto solver = std::make_unique<ConjugateGradients>(D_);
  iterative_ = solver.get();
  choice_ = solver->name();
  linear_ = std::move(solver);
}

void StepSolver::add_contact(const contact::Constraints& constraints, const scene::Solver& scene,
                             bool sliding) {
  if (full_vi_)
    vi_ = &*full_vi_;
  if (full_vi_ && !sliding)
    return;
  if (iterative_) {
    projected_.emplace(constraints, *iterative_, D_, *complementarity_);
    sliding_ = &*projected_;
    if (!vi_)
      vi_ = &*projected_;
    return;
  }
  if (cholesky_)
    elimination_ = std::make_unique<contact::TrailingBlockElimination>(constraints, *cholesky_);
  else
    elimination_ = std::make_unique<contact::StoredColumnsElimination>(
        constraints, *linear_, petsc::vector_of(D_),
        scene.memory - linear_->bytes() - dense_bytes(&constraints));
  condensation_.emplace(constraints, *elimination_);
  sliding_ = &*condensation_;
  if (!vi_)
    vi_ = &condensed_vi_.emplace(constraints, *condensation_, *complementarity_);
}

StepSolver::Memory StepSolver::memory() const {
  return {.factor = linear_->bytes() + (D_ ? petsc::bytes(D_) : 0),
          .condensation = condensation_ ? condensation_->bytes() : 0};
}

} // namespace signorini::forward
