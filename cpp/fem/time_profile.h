// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <algorithm>

namespace signorini::fem {

/// Field over the time of a run at all of its points: exact means over steps, and its changes within them
/// (docs/method.md section 11). A time series is integrated between its own times. For expressions the time
/// is cut, once, into panels that a Gauss–Kronrod rule integrates and in which, by an enclosure of their
/// values, no change passes between its points. All members collective.
class TimeProfile {
public:
  /// Cuts the time into panels. `points`: (n × 3) of this rank, m, which must outlive this object; `end`: end
  /// of the run, s. Throws UserError where a value is not finite.
  TimeProfile(MPI_Comm comm, scene::Field field, const std::vector<double>& points, double end);

  [[nodiscard]] const scene::Field& field() const { return field_; }

  /// Means over the time from `from` to `to` (s) of some components at the points, into `out`
  /// (n × components). Throws UserError as Field::value().
  void mean(double from, double to, const std::vector<int>& components, std::span<double> out) const;
  /// Means over the time from `from` to `to` (s) of all components.
  void mean(double from, double to, std::span<double> out) const;

  /// ∫ |f − f̄| dt from `from` to `to`, f̄ the mean there, relative to ∫ |f| dt over the run: the largest of
  /// all points and components.
  [[nodiscard]] double variation(double from, double to) const;
  /// Largest distance of f from the parabola through its values at `from`, `to` and in their middle.
  [[nodiscard]] double deviation(double from, double to) const;
  /// The range of f over the run: the largest of all points and components.
  [[nodiscard]] double range() const { return range_; }

  /// Times between `from` and `to` that resolve the changes of f (s), ascending.
  [[nodiscard]] std::vector<double> times(double from, double to) const;

  /// Possible relative error of the integral, from panels that do not integrate to their tolerance.
  [[nodiscard]] double unresolved() const { return std::min(unresolved_, 1.0); }
  static constexpr double noticeable = 1e-9; ///< largest unresolved() that require_resolved() accepts
  /// Throws UserError if unresolved() is above `noticeable`.
  void require_resolved() const;

private:
  /// A time, and its weight in a mean.
  struct Node {
    double t, weight;
  };
  struct Panel {
    double begin, end;
    double integral = 0;     ///< integral of |f|, the largest of all components and samples
    double width = 0;        ///< width of the range that the values may have
    bool open = true;        ///< not yet resolved
    bool all_suspect = true; ///< changes may pass between samples at any point, else at `suspects`
    std::vector<int> suspects{};
  };
  /// Cuts the time into panels.
  void cut();
  /// Integrates the open panels at the samples, closes those that are resolved, and halves the others.
  void refine();
  /// Halves the open panels with a cut other than 0 and closes the others. If a panel is too short to be
  /// halved, the part of the `whole` integral that may be off is added to unresolved_.
  void halve(const std::vector<double>& cuts, double whole);
  /// Appends the figures of an open panel at this rank's samples.
  void sample(const Panel& panel, std::vector<double>& most, std::vector<double>& least) const;
  /// Whether a component is an expression of t.
  [[nodiscard]] bool quadrated(std::size_t component) const {
    return field_.depends_on_time(component) && !field_.series(component);
  }
  /// Whether the enclosure of a component over a panel is not much wider than the range of its samples, or at
  /// most `enough` wide. Notes in the panel the points where it is not.
  bool explains(scene::Interval sampled, Panel& panel, std::size_t component, double enough);
  /// Sets nodes_ for means of a component from `from` to `to`, a step or the run.
  void set_nodes(std::size_t component, double from, double to) const;
  /// Largest measure(values) of all ranks, time-dependent components and points. The values are those at
  /// nodes_, with `ends` preceded by those at `from`, `to` and in the middle.
  template <class Measure>
  [[nodiscard]] double largest(double from, double to, bool ends, Measure&& measure) const;
  /// Number of points at which a component may differ.
  [[nodiscard]] std::size_t places(std::size_t component) const;
  [[nodiscard]] const double* place(std::size_t component, std::size_t i) const;

  MPI_Comm comm_;
  scene::Field field_;
  const std::vector<double>& points_;
  double end_;
  scene::Box box_{}; ///< box around all points
  std::vector<double> knots_;
  std::vector<Panel> panels_;
  std::vector<std::size_t> samples_; ///< points that are sampled to make panels
  double integral_ = 0, range_ = 0, unresolved_ = 0;
  // Scratch, so that means over steps do not allocate.
  mutable std::vector<Node> nodes_;
  mutable std::vector<double> values_;
};

} // namespace signorini::fem
