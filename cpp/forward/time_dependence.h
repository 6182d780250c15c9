// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include "scene/expression.h"
#include <functional>
#include <string>
#include <vector>

namespace signorini::forward {

/// What a scene prescribes as a function of time: loads, the motion of clamps and of obstacles. A step sees a
/// load at its middle and motions at its end; whatever happens in between passes it by. Fields of place too
/// are looked at in a few nodes. All of it is looked at `looks` times over the motion, and in steps shorter
/// than that at a few times of their own.
class TimeDependence {
public:
  static constexpr int looks = 1 << 12;

  /// Collective. Throws UserError.
  TimeDependence(const fem::Space& space, const scene::Scene& scene);

  /// Whether it goes smoothly between two times (s), like the polynomial through five values there: a load up
  /// to the part `tolerance` of its whole impulse, a motion up to that part of its range. What smooth ones
  /// leave as an error, the motion of the body shows.
  [[nodiscard]] bool resolves(double from, double to, double tolerance) const;

private:
  /// A component at one place.
  struct Signal {
    std::function<double(double t)> value;
    std::vector<double> samples; ///< at equal distances
    bool load = false;
    double size = 0; ///< ∫ |·| dt of a load, else the range
  };
  void add(const std::shared_ptr<const scene::Field>& field, bool load);
  /// The largest distance from that polynomial.
  [[nodiscard]] double deviation(const Signal& signal, double from, double to) const;

  double end_;
  std::vector<double> nodes_; ///< coordinates (nodes × 3), m, the same on every rank
  std::vector<Signal> signals_;
};

} // namespace signorini::forward
