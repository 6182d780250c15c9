#pragma once
#include "contact/condensed_vi.h"
#include "contact/full_vi.h"
#include "contact/projected_cg.h"
#include <memory>
#include <optional>
#include <string>

namespace signorini::forward {

/// The solvers of a run's steps, as the scene's [solver] asks: a factorisation (CHOLMOD on one rank, MUMPS on
/// several) with contact condensed to the candidates, or conjugate gradients where the factor would not fit
/// the memory allowed.
class StepSolver {
public:
  /// Estimates the factor's memory, chooses a solver and factorises. `constraints` is null without contact;
  /// `sliding`: linearised or transposed steps are wanted. Collective. The references must outlive this
  /// object. Throws SolverFailure.
  StepSolver(petsc::Matrix D, const contact::Constraints* constraints, const scene::Solver& scene,
             bool sliding);
  StepSolver(const StepSolver&) = delete; // its parts refer to each other
  StepSolver& operator=(const StepSolver&) = delete;

  /// Solves with D, for steps without contact.
  [[nodiscard]] const LinearSolver& linear() const { return *linear_; }
  /// Null without contact.
  [[nodiscard]] const contact::ViSolver* vi() const { return vi_; }
  /// Null without contact, or if `sliding` was not wanted and contact is solved by the full VI.
  [[nodiscard]] const contact::ActiveSetKkt* sliding() const { return sliding_; }
  /// Whether solves start from a guess.
  [[nodiscard]] bool takes_guess() const { return iterative_ || full_vi_; }

  /// Relative error that a solve may leave; 0 for rounding alone.
  [[nodiscard]] double tolerance() const { return iterative_ ? iterative_->tolerance() : 0; }

  /// What was chosen and why, in a few words.
  [[nodiscard]] const std::string& choice() const { return choice_; }

  /// Memory on all ranks, bytes.
  struct Memory {
    double factor = 0; ///< or preconditioner, with the matrix D where it is kept
    double condensation = 0;
  };
  /// Collective.
  [[nodiscard]] Memory memory() const;

private:
  void factorise(const contact::Constraints* constraints, const scene::Solver& scene);
  void iterate();
  void add_contact(const contact::Constraints& constraints, const scene::Solver& scene, bool sliding);

  petsc::Matrix D_; ///< null once it is factorised
  std::unique_ptr<LinearSolver> linear_;
  const SparseCholesky* cholesky_ = nullptr; ///< linear_, if it is one of these
  const ConjugateGradients* iterative_ = nullptr;
  std::unique_ptr<contact::Elimination> elimination_;
  std::optional<contact::Complementarity> complementarity_;
  std::optional<contact::DelassusOperator> condensation_;
  std::optional<contact::CondensedVi> condensed_vi_;
  std::optional<contact::FullVi> full_vi_;
  std::optional<contact::ProjectedCg> projected_;
  const contact::ViSolver* vi_ = nullptr;
  const contact::ActiveSetKkt* sliding_ = nullptr;
  std::string choice_;
};

} // namespace signorini::forward
