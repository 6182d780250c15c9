// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <algorithm>

namespace signorini::fem {

/// Time dependence of a field at given points over the duration of a run: exact means over steps, and
/// measures of its changes within steps (docs/method.md section 11). Time series, which are linear between
/// their times, are integrated exactly. For expressions the constructor divides the duration into panels. A
/// Gauss–Kronrod rule integrates each panel, and an enclosure of the values by interval arithmetic shows that
/// the points of the rule miss no change. All members are collective.
class TimeProfile {
public:
  /// Divides the duration of the run into panels. `points`: (n × 3) of this rank, m, which must outlive this
  /// object; `end`: end of the run, s. Throws UserError if a value of the field is not finite.
  TimeProfile(MPI_Comm comm, scene::Field field, const std::vector<double>& points, double end);

  [[nodiscard]] const scene::Field& field() const { return field_; }

  /// Computes the means over the time from `from` to `to` (s) of some components at the points. `out`: (n ×
  /// components). Throws UserError as Field::value() does.
  void mean(double from, double to, const std::vector<int>& components, std::span<double> out) const;
  /// Computes the means over the time from `from` to `to` (s) of all components at the points, (n ×
  /// components).
  void mean(double from, double to, std::span<double> out) const;

  /// Largest ∫ |f − f̄| dt from `from` to `to` (s), f̄ being the mean over this time, divided by the largest
  /// ∫ |f| dt over the run. Both are the largest over all points and components.
  [[nodiscard]] double variation(double from, double to) const;
  /// Largest distance between f and the parabola through its values at the times `from`, `to` and
  /// (from + to)/2 (s). The largest is over all points and components, in the unit of the field.
  [[nodiscard]] double deviation(double from, double to) const;
  /// Largest difference between two values of a component of f at one point during the run, in the unit of
  /// the field. The largest is over all points and components.
  [[nodiscard]] double range() const { return range_; }

  /// Times between `from` and `to` (s), ascending, that are dense enough to sample the changes of f. Empty if
  /// f does not depend on time.
  [[nodiscard]] std::vector<double> times(double from, double to) const;

  /// Upper estimate of the relative error of the field's integral over the run, from panels in which the
  /// quadrature does not reach its tolerance; at most 1.
  [[nodiscard]] double unresolved() const { return std::min(unresolved_, 1.0); }
  static constexpr double noticeable = 1e-9; ///< largest unresolved() that require_resolved() accepts
  /// Throws UserError if unresolved() exceeds `noticeable`.
  void require_resolved() const;

private:
  /// Time (s) with its weight in a mean.
  struct Node {
    double t, weight;
  };
  struct Panel {
    double begin, end;
    double integral = 0;     ///< integral of |f|: the largest over all components and samples
    double width = 0;        ///< width of the enclosure of the values, the largest over components
    bool open = true;        ///< whether the panel still has to be resolved
    bool all_suspect = true; ///< true: values at any point may change unseen; false: only at `suspects`
    std::vector<int> suspects{};
  };
  /// Divides the duration of the run into panels until all are resolved.
  void make_panels();
  /// Integrates all open panels at the sampled points, closes the resolved panels and halves the others.
  void refine();
  /// Halves each open panel whose entry of `cuts` is not 0, and closes the other panels. For a panel that is
  /// too short to be halved, its possible error relative to `whole`, the integral over the run, is added to
  /// unresolved_.
  void halve(const std::vector<double>& cuts, double whole);
  /// Appends the results of an open panel at the sampled points of this rank: to `most` the difference of the
  /// two rules, the integral of |f| and the greatest value of each component; to `least` the least values.
  void sample(const Panel& panel, std::vector<double>& most, std::vector<double>& least) const;
  /// Whether a component is integrated by quadrature, being an expression of t.
  [[nodiscard]] bool needs_quadrature(std::size_t component) const {
    return field_.depends_on_time(component) && !field_.series(component);
  }
  /// Whether the samples of a component over a panel miss no change: the enclosure of its values is at most
  /// four times as wide as the range `sampled`, or at most `enough` wide. For a field with one
  /// component, stores in the panel the points at which the enclosure is wider.
  bool samples_cover_enclosure(scene::Interval sampled, Panel& panel, std::size_t component, double enough);
  /// Sets nodes_ to the quadrature nodes for means of a component from `from` to `to` (s), over a step or the
  /// run.
  void set_nodes(std::size_t component, double from, double to) const;
  /// Largest measure(values) over all time-dependent components and the points of all ranks. `values` are a
  /// component's values at one point, at the times of nodes_. If `ends`, the values at `from`, `to` and
  /// (from + to)/2 come first.
  template <class Measure>
  [[nodiscard]] double largest(double from, double to, bool ends, Measure&& measure) const;
  /// Number of points at which a component is evaluated: all points, or one if the component does not depend
  /// on place.
  [[nodiscard]] std::size_t places(std::size_t component) const;
  [[nodiscard]] const double* place(std::size_t component, std::size_t i) const;

  MPI_Comm comm_;
  scene::Field field_;
  const std::vector<double>& points_;
  double end_;
  scene::Box box_{}; ///< bounding box of the points of all ranks
  std::vector<double> knots_;
  std::vector<Panel> panels_;
  std::vector<std::size_t> samples_; ///< numbers of the points that are sampled to determine the panels
  double integral_ = 0, range_ = 0, unresolved_ = 0;
  // Scratch, so that means over steps do not allocate.
  mutable std::vector<Node> nodes_;
  mutable std::vector<double> values_;
};

} // namespace signorini::fem
