// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "fem/space.h"
#include <optional>

namespace signorini::adjoint {

/// The body in functions of degree 2 on the mesh of a run of degree 1. These are sums of functions of degree
/// 1 and bubbles: functions that vanish at the vertices, one for each edge and component.
class EnrichedBody {
public:
  /// `linear` is the run's space and `pairs` its contact, null without. Collective. The references must
  /// outlive this object. Throws UserError.
  EnrichedBody(const fem::Space& linear, const contact::ContactPairs* pairs, const scene::Scene& scene);
  EnrichedBody(const EnrichedBody&) = delete;
  EnrichedBody& operator=(const EnrichedBody&) = delete;

  [[nodiscard]] const fem::Space& space() const { return space_; }
  [[nodiscard]] const fem::Operators& operators() const { return operators_; }

  /// y of degree 1 as a function of degree 2. Collective.
  void embed(Vec y, Vec out) const;

  /// The interpolation of a field at time t (s) in degree 2 less that in the run's space, a combination of
  /// bubbles. Collective. Throws UserError as fem::Space::interpolate does.
  void interpolation_error(const scene::Field& field, double t, Vec out) const;

  /// interpolation_error() of the scene's initial displacement and velocity; null where it has none.
  struct InitialError {
    petsc::Vector y, v;
  };
  [[nodiscard]] const InitialError& initial_error() const { return initial_error_; }

  /// The modulus of what the bubbles of each edge have in x, a sum over components, shared by the cells at
  /// the edge: one number for each cell owned. Collective.
  [[nodiscard]] std::vector<double> by_cells(Vec x) const;

  /// Projects x, in the Euclidean product of the coefficients, onto the bubbles that are free to move: zero
  /// at vertices and clamped dofs and, along ν, in the middle of edges whose ends are both active against the
  /// same obstacle. Collective.
  void keep_bubbles(const contact::ActiveSet& active, Vec x) const;

private:
  void find_vertices();
  void match(const contact::ContactPairs& pairs);

  const fem::Space& linear_;
  fem::Space space_;
  fem::Operators operators_;
  fem::DirichletDofs clamped_;
  petsc::Matrix embed_;
  std::vector<int> vertices_; ///< owned nodes, local numbers
  std::optional<contact::ContactPairs> pairs_;
  std::vector<std::array<int, 2>>
      ends_; ///< for each candidate here the run's candidates at the ends of its edge, or −1
  std::vector<double> zero_;
  InitialError initial_error_;
};

} // namespace signorini::adjoint
