#pragma once
#include "fem/operators.h"
#include "forward/scheme.h"
#include "scene/expression.h"

namespace signorini::forward {

/// Clamps that move as the scene prescribes: y_k = g(t_k) on their dofs, which acts on the free ones as the
/// load −D g.
class PrescribedMotion {
public:
  /// `D` is the step operator before its clamped dofs are decoupled. Collective. Throws UserError.
  PrescribedMotion(const fem::Space& space, const std::vector<scene::Clamp>& clamps, Mat D, Scheme scheme);

  /// Whether any of the clamps moves.
  [[nodiscard]] static bool in(const std::vector<scene::Clamp>& clamps);

  /// Memory of the D that it keeps, bytes. Collective.
  [[nodiscard]] double bytes() const { return petsc::bytes(D_); }

  /// Writes g(t) to the moving dofs. Collective. Throws UserError if it is not finite.
  void position(double t, Vec y) const;

  /// Writes ġ(0) to the moving dofs, by differences. Collective.
  void initial_velocity(Vec v) const;

  /// Puts the motion of step k into the right-hand side of D's decoupled system: the force −D g on the free
  /// dofs, and D's `diagonal` there times g on the `clamped` ones. Collective.
  void apply(int k, const fem::Clamped& clamped, double diagonal, Vec r) const;

private:
  struct Clamp {
    scene::Field field;
    std::vector<int> nodes, components;
  };
  template <class Set>
  void evaluate(double t, Set&& set) const;

  const fem::Space& space_;
  Scheme scheme_;
  std::vector<Clamp> clamps_;
  petsc::Matrix D_;
  petsc::Vector position_, force_;
  mutable bool evaluated_ = false;
};

} // namespace signorini::forward
