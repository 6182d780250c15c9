// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/study/measured.h"
#include "forward/contact_times.h"
#include "forward/impulse_record.h"
#include "forward/obstacle_forces.h"
#include <array>

namespace signorini::study {

/// Impulse, forces and times of contact: the quantities of a scene that has contact, of all obstacles
/// together and, where there are several, of each under the same names with its number. `dim` tells the
/// units: in the plane forces are per metre.
std::vector<Quantity> contact_quantities(const scene::Scene& scene, int dim);

/// The end of the names that belong to one of several obstacles of a scene, by its index.
std::string suffix(int obstacle);

/// Measures them frame by frame.
class ContactWatch {
public:
  /// `stepper` must outlive this object.
  explicit ContactWatch(const forward::Stepper& stepper);

  /// Takes the frames of a motion in turn.
  void operator()(const forward::Frame& frame);

  /// Their values by name, at the end of a motion that took `end` s: without contact it starts there.
  [[nodiscard]] std::map<std::string, double> numbers(double end) const;

private:
  /// What is known of one obstacle, or of all.
  struct Part {
    std::string suffix; ///< of the quantities' names
    forward::ContactTimes times;
    forward::ImpulseRecord record{};           ///< of the sum of the forces' moduli
    std::array<double, 3> before{}, impulse{}; ///< N (in the plane N/m) and N s (N s/m)
    double peak = 0;
    /// Takes the force of a step that ends at `t` (s).
    void add(double t, const forward::ObstacleForce& now);
  };

  const forward::Stepper& stepper_;
  forward::ObstacleForces forces_;
  std::vector<Part> parts_; ///< that of all obstacles first
};

} // namespace signorini::study
