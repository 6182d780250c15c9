#pragma once
#include "fem/operators.h"
#include "forward/load.h"
#include "scene/expression.h"
#include <functional>
#include <optional>

namespace signorini::control {

/// A control u: one vector per time step, constant on (t_{k−1}, t_k), or one for all of them.
class Control {
public:
  /// `values` holds one vector, for all steps, or one for each.
  Control(petsc::Series values, int steps) : values_(std::move(values)), steps_(steps) {}
  Control(const Control& other);
  Control& operator=(const Control& other);
  Control(Control&&) = default;
  Control& operator=(Control&&) = default;

  /// u_k, k = 1…N.
  [[nodiscard]] Vec at(int k) const {
    return values_[values_.size() == 1 ? 0 : static_cast<std::size_t>(k) - 1];
  }
  [[nodiscard]] int steps() const { return steps_; }
  /// Different vectors: 1 or N.
  [[nodiscard]] int count() const { return static_cast<int>(values_.size()); }

  /// this += a x.
  void add(double a, const Control& x);
  void scale(double a);

private:
  petsc::Series values_;
  int steps_;
};

/// The space of controls: what they act on, their products, their bounds, and how they enter the equation of
/// motion. Nodal values of the displacement's degree ("P1"), or one value for each cell ("P0"); on the whole
/// body, a part of it or a surface (there a cell's value acts on those of its facets that lie on it). All
/// members collective.
///
/// A vector u_k holds values only where and in what components the control acts, (places × components), place
/// by place; extend() makes a field of it. A control of a surface is small.
///
/// Two products: product() is that of L2(0,T; L2), τ Σ (u_k, w_k), over what the control acts on. metric() is
/// what the optimizer measures with: the same where the mass matrix is diagonal or there are no bounds; else
/// with a diagonal one (lumped, HRZ), because clipping the values to the bounds is the projection onto the
/// bounds exactly where the mass matrix is diagonal.
class ControlSpace {
public:
  /// The references must outlive this object. Throws UserError.
  ControlSpace(const fem::Space& space, const fem::Operators& operators, forward::Scheme scheme, int steps,
               const scene::Control& scene);

  [[nodiscard]] Control zero() const;
  /// One whose values are still to be written.
  [[nodiscard]] Control unset() const;
  /// The same number wherever the control acts.
  [[nodiscard]] Control constant(double value) const;
  /// Values at the nodes or midpoints, in the middle of each step; of a control constant in time, at t = 0.
  /// Throws UserError naming `key`.
  [[nodiscard]] Control interpolate(const scene::Components& components, const std::string& key) const;

  /// Values for one step, zero.
  [[nodiscard]] petsc::Vector value() const { return petsc::zero_like(work_); }
  /// A zero field: a vector of V, or one for each cell (owned cells × dim).
  [[nodiscard]] petsc::Vector field() const;
  /// The field with these values, zero where and in what components the control does not act.
  void extend(Vec values, Vec field) const;
  /// The values of a field where the control acts.
  void restrict(Vec field, Vec values) const;

  [[nodiscard]] double product(const Control& u, const Control& w) const;
  /// (u_k, w_k)
  [[nodiscard]] double product_at(int k, const Control& u, const Control& w) const;
  [[nodiscard]] double norm(const Control& u) const;
  [[nodiscard]] double metric(const Control& u, const Control& w) const;
  /// w ↦ metric(u, w) by the values that pairing() multiplies w's with: many products with one control are cheaper
  /// through it.
  [[nodiscard]] Control dual(const Control& u) const;
  [[nodiscard]] double pairing(const Control& dual, const Control& w) const;
  /// From the Riesz representative of a functional by product() to that by metric(), in place.
  void to_metric(Control& gradient) const;

  [[nodiscard]] bool bounded() const { return lower_ || upper_; }
  /// Clips to the bounds: the projection in metric().
  void project(Control& u) const;
  /// Sets w to zero where u is at a bound and d points out of it.
  void hold(Control& w, const Control& u, const Control& d) const;

  /// Memory of one control, bytes. Collective.
  [[nodiscard]] double control_bytes() const;
  /// Memory of the matrix that only the control needs, bytes; 0 if W does. Collective.
  [[nodiscard]] double matrix_bytes() const { return own_ ? petsc::bytes(own_) : 0; }

  [[nodiscard]] int steps() const { return steps_; }
  [[nodiscard]] const fem::Space& space() const { return space_; }
  /// Whether a control has one value for each cell.
  [[nodiscard]] bool cellwise() const { return cellwise_; }
  /// Where the owned values are: nodes or midpoints of cells (places × 3), m.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// Their numbers among the owned nodes or cells (places).
  [[nodiscard]] const std::vector<int>& places() const { return places_; }
  /// In which components, ascending numbers.
  [[nodiscard]] const std::vector<int>& components() const { return components_; }

  /// s u_k; valid as long as `u` and this object live.
  [[nodiscard]] forward::Load load(const Control& u) const;
  /// The same for a control whose u_k is evaluated in each step.
  [[nodiscard]] forward::Load load(std::function<Vec(int k)> u) const;

  /// Adds to g what step k contributes to the Riesz representative, by product(), of the functional
  /// u ↦ Σ_k impulse() p_k · (force of u_k): the transpose of load(). For one vector per step (τ s/2) p_k.
  void add_riesz(int k, Vec p, Control& g) const;

private:
  [[nodiscard]] std::size_t vectors() const {
    return constant_in_time_ ? 1 : static_cast<std::size_t>(steps_);
  }
  /// τ, or T where one vector is that of all steps.
  [[nodiscard]] double duration() const { return scheme_.tau * steps_ / static_cast<double>(vectors()); }
  /// field += a · values.
  void add(double a, Vec values, Vec field) const;
  /// out = mass matrix · x.
  void mass(Vec x, Vec out) const;
  template <class Mass>
  double product(const Control& u, const Control& w, Mass&& mass) const;

  /// Entry of a field that an owned value is.
  [[nodiscard]] std::size_t entry(std::size_t value) const {
    const std::size_t n = components_.size();
    return static_cast<std::size_t>(places_[value / n] * space_.dim() + components_[value % n]);
  }
  void take_cells(const std::optional<std::string>& on);
  void take_nodes(const fem::Operators& operators, const std::optional<std::string>& on);
  /// Keeps the places of which a field, its weights, is not zero.
  void keep_places(Vec weights, const std::vector<double>& points);

  const fem::Space& space_;
  forward::Scheme scheme_;
  int steps_;
  double scale_;
  bool constant_in_time_, cellwise_, whole_;
  std::vector<int> components_;
  std::vector<int> places_; ///< owned nodes or cells where the control acts, ascending local numbers
  bool everywhere_ = false; ///< on every rank, in all components: values are a field
  std::vector<double> points_;
  petsc::Matrix own_;     ///< nodal: mass matrix, if it is not W; cellwise: ∫ u·φ (dofs × values)
  Mat mass_ = nullptr;    ///< nodal: the mass matrix (values × values), own_ or W
  petsc::Vector volumes_; ///< cellwise: the diagonal mass matrix
  std::optional<std::vector<double>> lower_, upper_; ///< one entry per component of components_
  petsc::Vector work_, field_;                       ///< of values; a field
  petsc::Vector lumped_; ///< diagonal of the lumped mass matrix; null where metric() is product()
};

} // namespace signorini::control
