// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/step_operators.h"
#include <algorithm>
#include <chrono>

namespace signorini::step {

StepOperators::StepOperators(const fem::Space& space, Mat A, const fem::DirichletDofs& clamped,
                             const contact::ContactPairs* pairs, const scene::Solver& solver,
                             bool derivatives, double solves, bool whole, Assemble assemble,
                             const StepOperators* like, bool same_rows)
    : space_(space), A_(A), clamped_(clamped), pairs_(pairs), scene_(solver), derivatives_(derivatives),
      solves_(solves), whole_(whole), assemble_(std::move(assemble)), like_(like), same_rows_(same_rows) {}

const StepOperators::PerStepLength& StepOperators::at(double tau) const {
  const auto known = std::ranges::find(lengths_, tau, &PerStepLength::tau);
  if (known != lengths_.end()) {
    lengths_.splice(lengths_.begin(), lengths_, known);
    return lengths_.front();
  }
  double held = 0;
  for (const PerStepLength& one : lengths_)
    held += one.bytes;
  // Another length takes as much as the last one did.
  while (!lengths_.empty() && held + lengths_.front().bytes > scene_.memory) {
    held -= lengths_.back().bytes;
    lengths_.pop_back();
  }
  const auto start = std::chrono::steady_clock::now();
  lengths_.push_front(make(tau));
  factorisation_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  factorisations_ += !like_;
  return lengths_.front();
}

contact::Residual StepOperators::residual(double tau, Mat R) const {
  return [this, R, a = 2 * Scheme{tau}.stiffness()](Vec y, Vec r, Vec out) {
    const petsc::Vector free = petsc::copy(y);
    clamped_.clear(free);
    petsc::check(MatMult(A_, free, out)); // D y = R y + 2 stiffness() A y
    petsc::check(VecScale(out, a));
    petsc::check(MatMultAdd(R, free, out, out));
    petsc::check(VecAYPX(out, -1, r));
    clamped_.clear(out);
  };
}

StepOperators::PerStepLength StepOperators::make(double tau) const {
  PerStepLength made{.tau = tau};
  if (like_) {
    const PerStepLength& known = like_->at(tau);
    made.shared_R = known.shared_R;
    made.shared_whole_D = known.shared_whole_D;
    made.clamped_diagonal = known.clamped_diagonal;
    made.bytes = known.bytes; // which it keeps alive
    made.solver =
        std::make_unique<SolverChoice>(*known.solver, pairs_, same_rows_, scene_, residual(tau, made.R()));
    return made;
  }
  petsc::Matrix D = assemble_(tau);
  made.shared_R = std::make_shared<const petsc::Matrix>(fem::shifted(A_, D, 2 * Scheme{tau}.stiffness()));
  if (whole_)
    made.shared_whole_D = std::make_shared<const petsc::Matrix>(symmetric_half(D));
  made.clamped_diagonal = clamped_.decouple(D);
  fem::attach_rigid_motions(D, space_);
  made.solver = std::make_unique<SolverChoice>(std::move(D), pairs_, scene_, derivatives_, solves_, order_,
                                               residual(tau, made.R()));
  if (factorisations_ == 0) {
    scene_.linear = made.solver->iterates() ? scene::LinearMethod::iterative : scene::LinearMethod::direct;
    order_ = made.solver->order();
  }
  const SolverChoice::Memory memory = made.solver->memory();
  made.bytes = memory.factor + memory.condensation + petsc::bytes(made.R());
  return made;
}

} // namespace signorini::step
