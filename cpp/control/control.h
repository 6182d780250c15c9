#pragma once
#include "fem/operators.h"
#include "forward/load.h"
#include "scene/expression.h"
#include <optional>

namespace signorini::control {

/// A control u: one vector of V per time step, constant on (t_{k−1}, t_k).
class Control {
public:
  explicit Control(petsc::Series steps) : steps_(std::move(steps)) {}
  Control(const Control& other);
  Control& operator=(const Control& other);
  Control(Control&&) = default;
  Control& operator=(Control&&) = default;

  /// u_k, k = 1…N.
  [[nodiscard]] Vec at(int k) const { return steps_[static_cast<std::size_t>(k) - 1]; }
  [[nodiscard]] int steps() const { return static_cast<int>(steps_.size()); }

  /// this += a x.
  void add(double a, const Control& x);
  void scale(double a);

private:
  petsc::Series steps_;
};

/// The space of controls: its products, its bounds, and how it enters the equation of motion. All members
/// collective.
///
/// Two products: product() is that of L2(0,T; L2), τ Σ (u_k, w_k). metric() is what the optimizer measures
/// with: the same without bounds; with bounds its mass matrix is replaced by a diagonal one (lumped, HRZ),
/// because clipping the nodal values to the bounds is the projection onto the bounds exactly where the mass
/// matrix is diagonal.
class ControlSpace {
public:
  /// The references must outlive this object.
  ControlSpace(const fem::Space& space, const fem::Operators& operators, forward::Scheme scheme, int steps,
               const scene::Control& scene);

  [[nodiscard]] Control zero() const;
  /// One whose values are still to be written.
  [[nodiscard]] Control unset() const;
  /// Nodal values at the middle of each step.
  [[nodiscard]] Control interpolate(const scene::Components& components, const std::string& key) const;

  /// (x, y) in L2 of two fields in V.
  [[nodiscard]] double dot(Vec x, Vec y) const;
  [[nodiscard]] double product(const Control& u, const Control& w) const;
  [[nodiscard]] double norm(const Control& u) const;
  [[nodiscard]] double metric(const Control& u, const Control& w) const;
  /// From the Riesz representative of a functional by product() to that by metric(), in place.
  void to_metric(Control& gradient) const;

  [[nodiscard]] bool bounded() const { return lower_ || upper_; }
  /// Clips to the bounds: the projection in metric().
  void project(Control& u) const;

  /// s, N/m³ per unit of control.
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] int steps() const { return steps_; }
  [[nodiscard]] const fem::Space& space() const { return space_; }

  /// density += s u_k.
  void add_load(const Control& u, int k, Vec density) const;
  /// `load` and the control's on top of it; u must outlive the result.
  [[nodiscard]] forward::AddLoad with(forward::AddLoad load, const Control& u) const;

private:
  const fem::Space& space_;
  Mat W_;
  forward::Scheme scheme_;
  int steps_;
  double scale_;
  std::optional<std::vector<double>> lower_, upper_; ///< one entry per component
  petsc::Vector work_;
  petsc::Vector lumped_; ///< diagonal of the lumped mass matrix; null without bounds
};

} // namespace signorini::control
