// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <algorithm>

namespace signorini::fem {

/// A field over the time of a run, seen at all of its points: exact means over steps, and by how much it
/// changes within them (docs/method.md section 11). A time series is integrated between its own times. Of
/// expressions the time is cut, once, into panels on which a Gauss–Kronrod rule integrates and, by an
/// enclosure of their values, no change passes between its points. All members collective.
class TimeProfile {
public:
  /// `points`: (n × 3) of this rank, m, which must outlive this object; `end`: of the run, s. Throws
  /// UserError where a value is not finite.
  TimeProfile(MPI_Comm comm, scene::Field field, const std::vector<double>& points, double end);

  [[nodiscard]] const scene::Field& field() const { return field_; }

  /// Means over the time from `from` to `to` (s) of some components at the points, into `out`
  /// (n × components). Throws UserError as Field::value().
  void mean(double from, double to, const std::vector<int>& components, std::span<double> out) const;
  /// Of all components.
  void mean(double from, double to, std::span<double> out) const;

  /// ∫ |f − f̄| dt over that time, f̄ the mean there, relative to ∫ |f| dt over the run: the largest of all
  /// points and components.
  [[nodiscard]] double variation(double from, double to) const;
  /// The largest distance of f from the parabola through its values at the two times and in their middle.
  [[nodiscard]] double deviation(double from, double to) const;
  /// The range of f over the run: the largest of all points and components.
  [[nodiscard]] double range() const { return range_; }

  /// Times between the two at which changes show (s), ascending.
  [[nodiscard]] std::vector<double> times(double from, double to) const;

  /// By how much the integral may be off, relative, where the panels do not integrate to their tolerance.
  [[nodiscard]] double unresolved() const { return std::min(unresolved_, 1.0); }
  static constexpr double noticeable = 1e-9; ///< of that
  /// Throws UserError where it is noticeable.
  void require_resolved() const;

private:
  /// A time, and its weight in a mean.
  struct Node {
    double t, weight;
  };
  struct Panel {
    double begin, end;
    double integral = 0;     ///< of |f|, the largest of all components and samples
    double width = 0;        ///< of the values that it may have
    bool open = true;        ///< not known to be resolved
    bool all_suspect = true; ///< changes may pass between samples at any point, else at these:
    std::vector<int> suspects{};
  };
  /// Cuts the time into panels.
  void cut();
  /// Integrates the open panels at the samples, closes those that are resolved, and halves the others.
  void refine();
  /// Halves the open panels with a cut other than 0 and closes the others; of one that is too short to be
  /// halved the part of the `whole` integral that may be off is noted.
  void halve(const std::vector<double>& cuts, double whole);
  /// Appends the figures of an open panel at this rank's samples.
  void sample(const Panel& panel, std::vector<double>& most, std::vector<double>& least) const;
  /// Whether a component is an expression of t.
  [[nodiscard]] bool quadrated(std::size_t component) const {
    return field_.depends_on_time(component) && !field_.series(component);
  }
  /// Whether the enclosure of a component over a panel says no more than the range of its samples does, or
  /// than `enough`; leaves the points of which it does not say so.
  bool explains(scene::Interval sampled, Panel& panel, std::size_t component, double enough);
  /// Of a component over a time, which a step or the run takes.
  void set_nodes(std::size_t component, double from, double to) const;
  /// The largest of all ranks, time-dependent components and points of measure(values), the values at
  /// nodes_, preceded by those at `from`, `to` and between if `ends`.
  template <class Measure>
  [[nodiscard]] double largest(double from, double to, bool ends, Measure&& measure) const;
  /// The points at which a component may differ.
  [[nodiscard]] std::size_t places(std::size_t component) const;
  [[nodiscard]] const double* place(std::size_t component, std::size_t i) const;

  MPI_Comm comm_;
  scene::Field field_;
  const std::vector<double>& points_;
  double end_;
  scene::Box box_{}; ///< of all points
  std::vector<double> knots_;
  std::vector<Panel> panels_;
  std::vector<std::size_t> samples_; ///< points at which panels are made
  double integral_ = 0, range_ = 0, unresolved_ = 0;
  // Scratch, so that means over steps do not allocate.
  mutable std::vector<Node> nodes_;
  mutable std::vector<double> values_;
};

} // namespace signorini::fem
