// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include "fem/operators.h"
#include "fem/time_profile.h"
#include "step/load.h"
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace signorini::control {

/// Space of controls: the set on which they act, their products, their bounds, and their force in the
/// equation of motion. Controls have nodal values of the displacement's degree ("nodal") or one value for
/// each cell ("cellwise"). They act on the whole body, a part of it or a surface; on a surface, a cell's
/// value acts on the facets of the cell that are part of the surface. All members are collective.
///
/// A control is constant on each time step or on separate intervals (control.step, or the whole time); a step
/// then takes the mean over its duration. The values u_j of an interval belong to the places (nodes or cells)
/// and components where the control acts (places × components), place by place. A control on a surface
/// therefore stores few values; extend() inserts these into a field on the body.
///
/// product() is the product of L2(0,T; L2), Σ_j T_j (u_j, w_j), T_j being the length of interval j, over the
/// set on which the control acts. inner() is the optimizer's product. It equals product() unless there are
/// bounds and the mass matrix is not diagonal; then the lumped mass matrix (HRZ) replaces the mass matrix.
/// This is because clipping values to the bounds is the projection in inner() only if its matrix is diagonal
/// (docs/method.md section 6).
class ControlSpace {
public:
  using Vector = Control;
  using Compact = CompactControl;

  /// `grid`: time grid of the motions; its steps must be known already if controls are constant on each step.
  /// The references must outlive this object. Throws UserError.
  ControlSpace(const fem::Space& space, const fem::Operators& operators, step::TimeGrid grid,
               const scene::Control& scene);

  /// Returns the zero control.
  [[nodiscard]] Control zero() const;
  /// Returns a control that has `value` wherever it acts.
  [[nodiscard]] Control constant(double value) const;
  /// Returns the control that the expressions `components` give. Its values are the exact means of the
  /// expressions over each interval, at the nodes or the midpoints of cells. Throws UserError naming `key`.
  [[nodiscard]] Control interpolate(const scene::Components& components, const std::string& key) const;

  /// Number of values of an interval on this rank.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Returns a zero field: a vector of V or, for a cellwise control, one vector for each cell (owned cells ×
  /// dim).
  [[nodiscard]] petsc::Vector field() const;
  /// Sets `field` to the values of an interval, and to zero at places and in components where the control
  /// does not act.
  void extend(std::span<const double> values, Vec field) const;
  /// Sets `values` to those of `field` at the places and in the components where the control acts.
  void restrict(Vec field, std::span<double> values) const;

  /// Returns the product of u and w in L2(0,T; L2), Σ_j T_j (u_j, w_j).
  [[nodiscard]] double product(const Control& u, const Control& w) const;
  /// Returns the product (u_j, w_j) in L2 of the values of u and w in interval j.
  [[nodiscard]] double product_at(int j, const Control& u, const Control& w) const;
  /// Returns the norm of u in L2(0,T; L2).
  [[nodiscard]] double norm(const Control& u) const;
  /// Returns the optimizer's product of u and w.
  [[nodiscard]] double inner(const Control& u, const Control& w) const;
  /// Returns the functional inner(u, ·) as coefficients: inner(u, w) is the Euclidean product of these with
  /// the values of w, summed over the ranks.
  [[nodiscard]] Control dual(const Control& u) const;
  /// Returns whether the matrix of dual() is diagonal.
  [[nodiscard]] bool diagonal() const { return cellwise_ || lumped_; }
  /// Returns the diagonal of the matrix of dual(), T_j included. If that matrix is not diagonal, returns the
  /// diagonal of the lumped mass matrix (HRZ), also times T_j: a preconditioner that is equally good on every
  /// mesh.
  [[nodiscard]] Control diagonal_weights() const;
  /// Returns the products inner(u_i, w_j) from the duals of the u_i (duals × w), in one pass over the w_j and
  /// one reduction.
  [[nodiscard]] std::vector<double> pairings(std::span<const Control> duals,
                                             std::span<const Compact> w) const;
  /// Replaces the Riesz representative `gradient` of a functional in product() by its representative in
  /// inner().
  void to_inner(Control& gradient) const;

  /// Returns whether controls have bounds.
  [[nodiscard]] bool bounded() const { return lower_ || upper_; }
  /// Clips u to the bounds, which is the projection onto them in inner().
  void project(Control& u) const;
  /// Sets those values of w to zero where u is at a bound and d points out of the bounds.
  void zero_blocked(Control& w, const Control& u, const Control& d) const;

  /// Returns the memory of one control on all ranks, bytes. Collective.
  [[nodiscard]] double control_bytes() const;
  /// Returns the memory of one control in single precision on all ranks, bytes. Collective.
  [[nodiscard]] double compact_bytes() const { return control_bytes() * sizeof(float) / sizeof(double); }
  /// Returns the memory of the matrix that was assembled for the control alone, on all ranks, bytes; 0 if the
  /// control uses the matrix W of the body. Collective.
  [[nodiscard]] double matrix_bytes() const { return matrix_ ? petsc::bytes(matrix_) : 0; }

  /// Number of time steps of the motions.
  [[nodiscard]] int steps() const { return grid_.steps(); }
  [[nodiscard]] const fem::Space& space() const { return space_; }
  /// Returns the group on which the control acts, or no value if it acts on the whole body.
  [[nodiscard]] const std::optional<std::string>& on() const { return on_; }
  /// Returns whether a control has one value for each cell, rather than nodal values.
  [[nodiscard]] bool cellwise() const { return cellwise_; }
  /// Returns the points of the owned places, nodes or midpoints of cells (places × 3), m.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// Returns the local numbers of the owned places among the owned nodes or cells (places).
  [[nodiscard]] const std::vector<int>& places() const { return places_; }
  /// Returns the numbers of the components in which the control acts, ascending.
  [[nodiscard]] const std::vector<int>& components() const { return components_; }

  /// Returns whether the control acts by a force density, rather than by forces on the nodes
  /// (step::NodalForce).
  [[nodiscard]] bool acts_by_density() const { return !on_ && !cellwise_; }
  /// Adds `weight` times the force s u to `sum`, for the values u of an interval.
  void add_force(std::span<const double> u, step::NodalForce sum, double weight) const;

  /// Adds to g the contribution of step k to the Riesz representative, in product(), of the functional u ↦
  /// Σ_k impulse() p_k · (force of u in step k). This is the transpose of add_force(). If the control has
  /// nodal values for each step, the contribution is (τ_k s/2) p_k (docs/method.md section 4).
  void add_riesz(int k, Vec p, Control& g) const;

  /// Number of intervals on which controls are constant.
  [[nodiscard]] int count() const { return intervals_.steps(); }
  /// Returns whether a control has the same values at all times.
  [[nodiscard]] bool constant_in_time() const { return constant_in_time_; }
  /// Returns whether a control has values for each time step, rather than for separate intervals.
  [[nodiscard]] bool stepwise() const { return stepwise_; }
  /// Calls visit(j, part) for each interval j that overlaps the time from `from` to `to` (s). `part`:
  /// fraction of this time that lies in interval j; the fractions add up to one.
  template <class Visit>
  void for_each_interval(double from, double to, Visit&& visit) const {
    const auto [first, last] = intervals(from, to);
    if (first == last)
      return visit(first, 1.0);
    const double start = begin(first + 1), stop = begin(last);
    visit(first, (start - from) / (to - from));
    for (int j = first + 1; j < last; ++j)
      visit(j, length(j) / (to - from));
    visit(last, (to - stop) / (to - from));
  }
  /// Calls visit(j, part) for the intervals whose values act in `step`. `part`: fraction of the step that
  /// lies in interval j.
  template <class Visit>
  void for_each_interval(const step::TimeStep& step, Visit&& visit) const {
    if (stepwise())
      return visit(step.k, 1.0);
    for_each_interval(step.begin, step.end, visit);
  }
  /// Returns how much u varies between two times (s): ∫ |u − ū| dt between these times, where ū is the mean
  /// of u there, divided by ∫ |u| dt over the whole time. The numerator is the largest among the values of u,
  /// the denominator the largest among the values that vary; 0 if none varies.
  [[nodiscard]] double variation(const Control& u, double from, double to) const;

  /// Returns the beginning of interval j, s; for j = count() + 1, the end of the last interval.
  [[nodiscard]] double begin(int j) const { return intervals_.time(j - 1); }
  /// Returns the middle of interval j, s; 0 for a control that is constant in time.
  [[nodiscard]] double middle(int j) const { return constant_in_time_ ? 0 : begin(j) + length(j) / 2; }
  /// Returns the length T_j of interval j, s.
  [[nodiscard]] double length(int j) const { return intervals_.length(j); }
  /// Returns the time grid of the motions.
  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }

private:
  /// Returns the numbers of the first and the last interval between two times (s); overlaps by rounding do
  /// not count.
  [[nodiscard]] std::pair<int, int> intervals(double from, double to) const;
  /// Adds a times the values of an interval to `field`.
  void add(double a, std::span<const double> values, Vec field) const;
  /// Returns u with the values of each interval multiplied by the mass matrix of product().
  [[nodiscard]] Control mass(const Control& u) const;
  /// Sets `out` to the values u of one interval, multiplied by the mass matrix of product().
  void mass(std::span<const double> u, std::span<double> out) const;
  /// Returns the sum of `mine` over all ranks.
  [[nodiscard]] double sum(double mine) const;

  /// Returns the local index, in a field, of the value number `value` of an interval.
  [[nodiscard]] std::size_t field_index(std::size_t value) const {
    const std::size_t n = components_.size();
    return static_cast<std::size_t>(places_[value / n] * space_.dim() + components_[value % n]);
  }
  /// Creates the work vectors in the layout of `values`.
  void make_work(Vec values);
  void take_cells(const std::optional<std::string>& on);
  void take_nodes(const fem::Operators& operators, const std::optional<std::string>& on);
  /// Selects as places the nodes or cells at which the field `weights` is not zero.
  void keep_places(Vec weights, const std::vector<double>& points);

  const fem::Space& space_;
  step::TimeGrid grid_;
  step::TimeGrid intervals_; ///< intervals on which controls are constant
  bool stepwise_;
  double scale_;
  bool constant_in_time_, cellwise_;
  std::optional<std::string> on_;
  std::vector<int> components_;
  std::vector<int> places_; ///< owned nodes or cells where the control acts, ascending local numbers
  bool everywhere_ = false; ///< whether the control acts at all places and in all components, on all ranks
  std::vector<double> points_;
  petsc::Matrix matrix_;  ///< nodal: mass matrix, null if it is W; cellwise: ∫ u·φ (dofs × values)
  Mat mass_ = nullptr;    ///< nodal: the mass matrix (values × values), matrix_ or W
  petsc::Vector volumes_; ///< cellwise: the diagonal mass matrix
  std::optional<std::vector<double>> lower_, upper_; ///< one entry per component of components_
  std::size_t size_ = 0;
  /// Scratch: work_ has the values of an interval, in_ and out_ use arrays of controls (petsc::Placed),
  /// field_ is a field.
  petsc::Vector work_, in_, out_, field_;
  petsc::Vector lumped_; ///< diagonal of the lumped mass matrix; null if inner() equals product()
};

/// Force of a control that is given by expressions. Its mean over an interval is evaluated when a step needs
/// it, so that at most one interval is stored.
class SampledForce final : public step::Load {
public:
  /// `key`: name of the control in messages; `within`: whether the control is clipped to the bounds.
  /// `controls` must outlive this object. Throws UserError.
  SampledForce(const ControlSpace& controls, const scene::Components& components, const std::string& key,
               bool within);
  [[nodiscard]] bool has_density() const override { return controls_.acts_by_density(); }
  [[nodiscard]] bool has_vector() const override { return !controls_.acts_by_density(); }
  void add(const step::TimeStep& step, step::NodalForce sum) const override;
  [[nodiscard]] double variation(double from, double to) const override {
    return profile_.variation(from, to);
  }

private:
  const ControlSpace& controls_;
  fem::TimeProfile profile_;
  bool within_;
  // Several steps may lie in an interval, and evaluating its expressions takes longer than a step's products.
  mutable Control values_;                     ///< values of the interval evaluated last
  mutable std::pair<double, double> of_{0, 0}; ///< begin and end of that interval, s
};

/// Time grid on which a control's force acts: that for which its ControlSpace was made, or another one.
enum class ForceSteps { of_control, others };

/// Force s u_k of a control on the body, as a load.
class ControlForce final : public step::Load {
public:
  /// `steps`: the time steps in which the force acts. The references must outlive this object.
  ControlForce(const ControlSpace& controls, const Control& u, ForceSteps steps = ForceSteps::of_control)
      : controls_(controls), u_(u), steps_(steps) {}
  [[nodiscard]] bool has_density() const override { return controls_.acts_by_density(); }
  [[nodiscard]] bool has_vector() const override { return !controls_.acts_by_density(); }
  void add(const step::TimeStep& step, step::NodalForce sum) const override {
    const auto act = [&](int j, double part) { controls_.add_force(u_.at(j), sum, part); };
    if (steps_ == ForceSteps::of_control)
      controls_.for_each_interval(step, act);
    else
      controls_.for_each_interval(step.begin, step.end, act);
  }
  [[nodiscard]] double variation(double from, double to) const override {
    return controls_.variation(u_, from, to);
  }

private:
  const ControlSpace& controls_;
  const Control& u_;
  ForceSteps steps_;
};

} // namespace signorini::control
