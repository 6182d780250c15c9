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

/// The space of controls: where they act, their products, their bounds, and how they enter the equation of
/// motion. Controls have nodal values of the displacement's degree ("nodal") or one value for each cell
/// ("cellwise"). They act on the whole body, a part of it or a surface; there a cell's value acts on those of
/// its facets that lie on it. All members collective.
///
/// A control is constant on each time step, or on intervals of its own (control.step, or the whole time); a
/// step then takes the mean over its duration. u_j stores values only at the places (nodes or cells) and in
/// the components where the control acts, (places × components), place by place. extend() gives the field. A
/// control on a surface is thus small.
///
/// product() is that of L2(0,T; L2), Σ_j T_j (u_j, w_j), T_j the length of interval j, over the set on which
/// the control acts. inner() is the product of the optimizer. It is the same unless there are bounds and the
/// mass matrix is not diagonal; then the lumped mass matrix (HRZ) takes its place. Clipping the values to the
/// bounds is the projection onto them exactly where that matrix is diagonal (docs/method.md section 6).
class ControlSpace {
public:
  using Vector = Control;
  using Compact = CompactControl;

  /// `grid`: the steps of motions, which may still be unknown unless controls are constant on each. The
  /// references must outlive this object. Throws UserError.
  ControlSpace(const fem::Space& space, const fem::Operators& operators, step::TimeGrid grid,
               const scene::Control& scene);

  [[nodiscard]] Control zero() const;
  /// A control with the same value wherever it acts.
  [[nodiscard]] Control constant(double value) const;
  /// Interpolates at the nodes or midpoints the exact mean over each interval. Throws UserError naming `key`.
  [[nodiscard]] Control interpolate(const scene::Components& components, const std::string& key) const;

  /// Number of values of an interval on this rank.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// A zero field: a vector of V, or one for each cell (owned cells × dim).
  [[nodiscard]] petsc::Vector field() const;
  /// Sets the field of these values, zero in places and components where the control does not act.
  void extend(std::span<const double> values, Vec field) const;
  /// Reads the values of a field where the control acts.
  void restrict(Vec field, std::span<double> values) const;

  [[nodiscard]] double product(const Control& u, const Control& w) const;
  /// The product (u_j, w_j) of interval j.
  [[nodiscard]] double product_at(int j, const Control& u, const Control& w) const;
  [[nodiscard]] double norm(const Control& u) const;
  [[nodiscard]] double inner(const Control& u, const Control& w) const;
  /// The functional inner(u, ·), as the values that pairings() multiplies with those of w.
  [[nodiscard]] Control dual(const Control& u) const;
  /// Whether the matrix of dual() is diagonal.
  [[nodiscard]] bool diagonal() const { return cellwise_ || lumped_; }
  /// Diagonal of the matrix of dual(), T_j included. If that is not diagonal, the diagonal of the lumped mass
  /// matrix (HRZ), which approximates it on every mesh.
  [[nodiscard]] Control weights() const;
  /// Computes inner(u_i, w_j) from the duals of u_i (duals × w), in one pass over the w_j and one reduction.
  [[nodiscard]] std::vector<double> pairings(std::span<const Control> duals,
                                             std::span<const Compact> w) const;
  /// Converts the Riesz representative of a functional in product() to that in inner(), in place.
  void to_inner(Control& gradient) const;

  [[nodiscard]] bool bounded() const { return lower_ || upper_; }
  /// Clips to the bounds: the projection in inner().
  void project(Control& u) const;
  /// Sets w to zero where u is at a bound and d points out of it.
  void zero_blocked(Control& w, const Control& u, const Control& d) const;

  /// Memory of one control, bytes. Collective.
  [[nodiscard]] double control_bytes() const;
  /// Memory of one control in single precision, bytes. Collective.
  [[nodiscard]] double compact_bytes() const { return control_bytes() * sizeof(float) / sizeof(double); }
  /// Memory of the matrix assembled for the control alone, bytes; 0 where W serves. Collective.
  [[nodiscard]] double matrix_bytes() const { return matrix_ ? petsc::bytes(matrix_) : 0; }

  [[nodiscard]] int steps() const { return grid_.steps(); }
  [[nodiscard]] const fem::Space& space() const { return space_; }
  /// The group where the control acts, absent: the body.
  [[nodiscard]] const std::optional<std::string>& on() const { return on_; }
  /// Whether a control has one value for each cell.
  [[nodiscard]] bool cellwise() const { return cellwise_; }
  /// Points of the owned places: nodes or midpoints of cells (places × 3), m.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// Numbers of the owned places among the owned nodes or cells (places).
  [[nodiscard]] const std::vector<int>& places() const { return places_; }
  /// The components in which the control acts, ascending numbers.
  [[nodiscard]] const std::vector<int>& components() const { return components_; }

  /// Whether the control acts by a force density, else by forces on the nodes (step::NodalForce).
  [[nodiscard]] bool acts_by_density() const { return !on_ && !cellwise_; }
  /// Adds the force s u, for the values u of an interval, times `weight`.
  void add_force(std::span<const double> u, step::NodalForce sum, double weight) const;

  /// Adds to g the contribution of step k to the Riesz representative, in product(), of the functional
  /// u ↦ Σ_k impulse() p_k · (force of u in step k): the transpose of add_force(). For nodal values of each
  /// step it is (τ_k s/2) p_k (docs/method.md section 4).
  void add_riesz(int k, Vec p, Control& g) const;

  /// Number of intervals on which controls are constant.
  [[nodiscard]] int count() const { return intervals_.steps(); }
  [[nodiscard]] bool constant_in_time() const { return constant_in_time_; }
  /// Whether the intervals are the time steps.
  [[nodiscard]] bool stepwise() const { return stepwise_; }
  /// Calls visit(j, part) for the intervals between two times (s), `part` being the share of an interval in
  /// that time: the parts add up to one.
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
  /// Calls visit(j, part) for the intervals whose values act in a step.
  template <class Visit>
  void for_each_interval(const step::TimeStep& step, Visit&& visit) const {
    if (stepwise())
      return visit(step.k, 1.0);
    for_each_interval(step.begin, step.end, visit);
  }
  /// Variation of u between two times: ∫ |u − ū| dt there, ū the mean there, over ∫ |u| dt of all times, each
  /// the largest over the values of u.
  [[nodiscard]] double variation(const Control& u, double from, double to) const;

  /// Begin of interval j, s; for the one after the last it is the end of the motion.
  [[nodiscard]] double begin(int j) const { return intervals_.time(j - 1); }
  /// Middle of interval j, s; 0 for a control that is constant in time.
  [[nodiscard]] double middle(int j) const { return constant_in_time_ ? 0 : begin(j) + length(j) / 2; }
  /// Length T_j of interval j, s.
  [[nodiscard]] double length(int j) const { return intervals_.length(j); }
  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }

private:
  /// The first and the last interval between two times; overlaps by rounding do not count.
  [[nodiscard]] std::pair<int, int> intervals(double from, double to) const;
  /// field += a · values.
  void add(double a, std::span<const double> values, Vec field) const;
  /// Multiplies each interval with the mass matrix of product().
  [[nodiscard]] Control mass(const Control& u) const;
  /// Multiplies one interval with the mass matrix of product().
  void mass(std::span<const double> u, std::span<double> out) const;
  /// The sum over all ranks.
  [[nodiscard]] double sum(double mine) const;

  /// Local entry of a field for an owned value.
  [[nodiscard]] std::size_t entry(std::size_t value) const {
    const std::size_t n = components_.size();
    return static_cast<std::size_t>(places_[value / n] * space_.dim() + components_[value % n]);
  }
  /// Creates the work vectors in the layout of `values`.
  void make_work(Vec values);
  void take_cells(const std::optional<std::string>& on);
  void take_nodes(const fem::Operators& operators, const std::optional<std::string>& on);
  /// Selects the places where a field, its weights, is not zero.
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
  bool everywhere_ = false; ///< whether it acts at all places and components of all ranks: values are a field
  std::vector<double> points_;
  petsc::Matrix matrix_;  ///< nodal: mass matrix, if it is not W; cellwise: ∫ u·φ (dofs × values)
  Mat mass_ = nullptr;    ///< nodal: the mass matrix (values × values), matrix_ or W
  petsc::Vector volumes_; ///< cellwise: the diagonal mass matrix
  std::optional<std::vector<double>> lower_, upper_; ///< one entry per component of components_
  std::size_t size_ = 0;
  petsc::Vector work_, in_, out_, field_; ///< work_: values; in_, out_: arrays of controls; field_: a field
  petsc::Vector lumped_; ///< diagonal of the lumped mass matrix; null where inner() is product()
};

/// The force of a control given by expressions: its mean over each interval, evaluated when a step needs it,
/// so that not more than one interval is stored.
class SampledForce final : public step::Load {
public:
  /// `key`: its name in messages; `within`: whether it is clipped to the bounds. `controls` must outlive this
  /// object. Throws UserError.
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

/// Steps in which a force acts: those of its control, or others.
enum class ForceSteps { of_control, others };

/// The force s u_k of a control on the body, as a load.
class ControlForce final : public step::Load {
public:
  /// The references must outlive this object.
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
