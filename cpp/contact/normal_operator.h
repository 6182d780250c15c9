// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"

namespace signorini::contact {

/// The operator N of the contact pairs, which takes normal forces λ (m) to nodal forces Nλ, and what belongs
/// to it: gaps, and the inverses of N and Nᵀ at the nodes of a set (docs/method.md section 2).
class NormalOperator {
public:
  /// `pairs` must outlive this object.
  explicit NormalOperator(const ContactPairs& pairs);

  /// ν_i·x of a vector at the candidates (m), including components that clamps hold. Collective.
  void normal_components(Vec x, std::span<double> out) const;

  /// g(y) (m), in metres, for the given ψ (m). Collective.
  void gap(std::span<const double> psi, Vec y, std::span<double> out) const;

  /// x += scale · Nλ, for λ (m).
  void add(double scale, std::span<const double> lambda, Vec x) const;

  /// x += scale · Σ_i λ_i ν_i, for λ (m), including components that clamps hold.
  void add_whole(double scale, std::span<const double> lambda, Vec x) const;

  /// x += scale · Σ_i λ_i n_i for directions n (m × dim), and n_i·x (m). The latter is collective.
  void add_along(double scale, std::span<const double> lambda, const std::vector<double>& directions,
                 Vec x) const;
  void components_along(const std::vector<double>& directions, Vec x, std::span<double> out) const;

  /// λ (m) with Nλ = x at the nodes of `set` and zero elsewhere, for an x in the range of the set's columns
  /// of N; of candidates of a node that are linearly dependent, the first ones carry the force. Collective.
  void forces(const ActiveSet& set, Vec x, std::span<double> lambda) const;

  /// Makes x·ν = value (m) at the candidates of `set` by the smallest change of the components that no clamp
  /// holds; of candidates of a node that are linearly dependent, for the first ones.
  void set_normal(std::span<const int> set, std::span<const double> value, Vec x) const;

  /// Sets the components of y that clamps hold, where they contribute to ν·y, to their values in the step's
  /// system, in which they are decoupled: r divided by the matrix's diagonal.
  void hold(Vec diagonal, Vec r, Vec y) const;

  /// What the held components contribute to ν_i·y, for a candidate whose node this rank owns and the owned
  /// entries of y.
  [[nodiscard]] double held_normal(int i, std::span<const double> y) const;

private:
  const ContactPairs& pairs_;
  int dim_;
  const std::vector<int>& local_;
  const std::vector<double>&normals_, &directions_;
};

} // namespace signorini::contact
