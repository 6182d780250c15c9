// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "contact/delassus_operator.h"

namespace signorini::contact {

/// Failure to solve the laws of a step, described at the candidate with the largest residual.
struct LawFailure : SolverFailure {
  LawFailure(const std::string& message, int group, double friction, double critical)
      : SolverFailure(message), group(group), friction(friction), critical(critical) {}
  int group;       ///< number of the candidate
  double friction; ///< as ContactState::friction
  double critical; ///< coefficient from which on a contact of this candidate alone has several solutions
};

/// Solves the laws of a step with gaps U = U⁰ + S ρ, where some law is not symmetric, such as friction
/// (docs/method.md section 5). Newton steps on the laws' active sets start from the multipliers of the step
/// before and settle in a few iterations. If they cycle, the problem is solved with soft contacts first, U =
/// U⁰ + (S + softness diag(S)) ρ, and these are hardened step by step. In the plane Lemke's method follows,
/// and at last a block Gauss–Seidel iteration.
class LawSolver {
public:
  /// `compliances`: of the groups, for Law::newton_equation() (Complementarity::compliances()). The laws are
  /// those of `rows`. The references must outlive this object.
  LawSolver(const ConstraintRows& rows, const DelassusOperator& delassus, std::vector<Compliance> compliances)
      : rows_(rows), delassus_(delassus), compliances_(std::move(compliances)) {
    for (int i = 0; i < rows.groups(); ++i)
      laws_.push_back(&rows.law(i));
  }
  /// `laws`: of the groups. They and the references must outlive this object.
  LawSolver(const ConstraintRows& rows, const DelassusOperator& delassus, std::vector<Compliance> compliances,
            std::vector<const Law*> laws)
      : rows_(rows), delassus_(delassus), compliances_(std::move(compliances)), laws_(std::move(laws)) {}

  /// Methods in the order in which they are tried, each from zero but the first.
  enum class Method { newton, hardening, pivots, sweeps };

  /// Computes the multipliers and gaps of `state`, whose `friction` is given, for the predicted gaps
  /// `work.gap0` (m), to a residual of at most `negligible` (m). `guess`: multipliers to start from, or
  /// empty. Returns the method that succeeded. Collective. Throws LawFailure.
  Method solve(std::span<const double> guess, double negligible, ContactState& state, Workspace& work,
               Method first = Method::newton) const;
  /// Takes one Newton step from the multipliers and gaps of `state`. Collective.
  void newton_step(ContactState& state, Workspace& work) const { newton_step(state, work, {}); }
  /// Returns the largest residual of a law, m.
  [[nodiscard]] double residual(const ContactState& state) const { return residual(state, 0); }

private:
  /// Multipliers, gaps and compliance of a group, with softened contacts.
  struct Values {
    std::size_t size;
    std::array<double, 3> multipliers, gaps;
    Compliance compliance;
    std::array<double, 3> softening; ///< part of the gaps per unit of the multipliers
    double friction;
    [[nodiscard]] std::span<const double> rho() const { return {multipliers.data(), size}; }
    [[nodiscard]] std::span<const double> U() const { return {gaps.data(), size}; }
  };
  /// Contacts of Newton steps.
  struct Contacts {
    double softness = 0; ///< compliance of the contacts relative to the diagonal of S
    double share = 1;    ///< compliances in Law::newton_equation() are (node alone)^(1 − share) (S_ii)^share
  };
  [[nodiscard]] Values values(int group, const ContactState& state, const Contacts& contacts) const;
  /// Diagonal entries of S of a group; the mean of those of its tangents.
  [[nodiscard]] Compliance diagonal(int group) const;
  /// Residual of one group's law, m; infinite if it is not finite.
  [[nodiscard]] double residual(int group, const ContactState& state, double softness = 0) const;
  [[nodiscard]] double residual(const ContactState& state, double softness) const;
  /// Computes all columns of S. Collective.
  void prepare_all() const;
  /// Tries one method. Returns whether the residual is negligible. Collective.
  bool solve_by(Method method, double negligible, ContactState& state, Workspace& work) const;
  /// Sets multipliers, and the gaps that they cause.
  void start(std::span<const double> lambda, ContactState& state, Workspace& work) const;
  /// Sets the equation of a group's law for the next Newton step. Returns false if the group opens.
  [[nodiscard]] bool next(int group, const ContactState& state, const Contacts& contacts,
                          LawEquation& equation) const;
  /// Adds the effect of a change of a row's multiplier to all gaps.
  void add_to_gaps(int row, double change, ContactState& state) const;
  /// Sets the gaps that the multipliers cause.
  void set_gaps(ContactState& state, const Workspace& work) const;
  void newton_step(ContactState& state, Workspace& work, const Contacts& contacts) const;
  /// Takes Newton steps until the residual is negligible; gives up after twenty, or when they cycle. Returns
  /// whether the residual is negligible. Collective.
  bool settle(double negligible, ContactState& state, Workspace& work, const Contacts& contacts) const;
  /// Solves with softness 1, or the least larger one that is solved, then with ever less down to zero, each
  /// time from the solution before and with several values of Contacts::share. The ratio of two values is at
  /// most ten, and smaller where Newton steps do not settle. Returns whether the residual is negligible.
  /// Collective.
  bool harden(double negligible, ContactState& state, Workspace& work) const;
  /// Makes up to `most` sweeps of a block Gauss–Seidel iteration over the groups. Collective.
  void sweep(int most, double negligible, ContactState& state, Workspace& work) const;
  /// Solves the law of one group with the multipliers of all other groups fixed.
  void relax(int group, ContactState& state) const;
  /// Sets the multipliers and gaps by Lemke's method for a problem in the plane with Coulomb's law (Stewart,
  /// Trinkle 1996). Returns false if there are too many candidates or the method fails. Collective.
  bool pivot(ContactState& state, Workspace& work) const;
  [[noreturn]] void fail(const ContactState& state) const;

  const ConstraintRows& rows_;
  const DelassusOperator& delassus_;
  std::vector<Compliance> compliances_;
  std::vector<const Law*> laws_;
};

} // namespace signorini::contact
