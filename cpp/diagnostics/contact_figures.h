// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/contact_times.h"
#include "diagnostics/obstacle_forces.h"
#include "trajectory/impulse_record.h"
#include <array>
#include <map>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// The end of the names that belong to one of several obstacles of a scene, by its index.
std::string obstacle_suffix(int obstacle);

/// Measures impulse, forces and times of contact frame by frame: of all obstacles together and, where there
/// are several, of each, whose names end with its number. In the plane forces are per metre.
class ContactFigures {
public:
  /// `stepper` must outlive this object.
  explicit ContactFigures(const step::Stepper& stepper);

  /// Takes the frames of a motion in turn.
  void operator()(const trajectory::Frame& frame);

  /// Their values by name, at the end of a motion that took `end` s: without contact it starts there.
  [[nodiscard]] std::map<std::string, double> numbers(double end) const;

private:
  /// What is known of one obstacle, or of all.
  struct Part {
    std::string suffix; ///< of the quantities' names
    ContactTimes times;
    trajectory::ImpulseRecord record{};        ///< of the sum of the forces' moduli
    std::array<double, 3> before{}, impulse{}; ///< N (in the plane N/m) and N s (N s/m)
    double peak = 0;
    /// Takes the force of a step that ends at `t` (s).
    void add(double t, const ObstacleForce& now);
  };

  const step::Stepper& stepper_;
  ObstacleForces forces_;
  std::vector<Part> parts_; ///< that of all obstacles first
};

} // namespace signorini::diagnostics
