// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/time_integrator.h"
#include <array>
#include <span>
#include <string>
#include <vector>

namespace signorini::diagnostics {

class Balance;

/// Motion of a body as a whole at one time. Units as in StepBalance.
struct BodyMotion {
  std::array<double, 3> displacement{}; ///< displacement of the centre of mass, m
  std::array<double, 3> momentum{};     ///< kg m/s
  double kinetic_energy = 0, elastic_energy = 0;
};

/// The connected parts of a mesh as bodies that move independently but for contact.
class Bodies {
public:
  struct Body {
    std::string name; ///< group of cells that the body is, if there is one, else "body 1", "body 2" …
    double mass = 0;  ///< kg; in plane strain and plane stress kg/m
    std::array<bool, 3> clamped{}; ///< whether a clamp holds a node in a component
  };

  /// Finds the bodies: first those of the scene's contacts in their order, then the others by their centres.
  /// Collective. `stepper` must outlive this object.
  Bodies(const step::Stepper& stepper, const std::vector<scene::Contact>& contacts);

  [[nodiscard]] const std::vector<Body>& all() const { return bodies_; }
  /// Number of the body on which a boundary group is; −1 if it is on several. Collective.
  [[nodiscard]] int of_group(const std::string& group, const std::string& key) const;

  /// Sets the motions to those of the next frame. `balance`: of this frame. Collective.
  void observe(const trajectory::Frame& frame, const Balance& balance);
  /// Motion of each body in the last frame.
  [[nodiscard]] std::span<const BodyMotion> motions() const { return motions_; }
  /// Velocity of a body's centre of mass in the last frame, m/s.
  [[nodiscard]] std::array<double, 3> velocity(int body) const;

private:
  const step::Stepper& stepper_;
  std::vector<int> body_of_node_; ///< of each owned node of the mesh
  std::vector<double> masses_;    ///< of each owned node of the mesh, kg
  std::vector<Body> bodies_;
  std::vector<BodyMotion> motions_;
  std::vector<double> sums_; ///< of all motions
};

} // namespace signorini::diagnostics
