// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/contact_forces.h"
#include "fem/sampler.h"
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Computes the quantities that a scene records over time ([[output.probe]]). At a point, or as the mean over
/// a group: displacement and velocity; for a clamped group also the reaction of its clamps. For an obstacle:
/// force and impulse. For the body: centre of mass, momentum and mean rotation, which is the rotation of the
/// rigid motion nearest to y in the norm of the mass matrix.
class Probes {
public:
  /// Prepares all probes of the scene. Collective. The references must outlive this object. Throws UserError
  /// if a point is outside the body or a named group does not exist.
  Probes(const step::Stepper& stepper, const scene::Scene& scene);

  /// Returns the names of the values, `<name of the probe>.<quantity>`; values are in SI units.
  [[nodiscard]] const std::vector<std::string>& columns() const { return names_; }

  /// Returns whether a probe needs the reactions of the clamps.
  [[nodiscard]] bool need_reactions() const { return reactions_; }

  /// Appends the values of a frame to `values`. `reactions`: forces of the clamps (Balance::reactions());
  /// null if not needed. Collective.
  void add_values(const trajectory::Frame& frame, const ObstacleForces& forces, Vec reactions,
                  std::vector<double>& values) const;

private:
  /// Data of a frame from which the probes' values are computed.
  struct Sample {
    Vec y, v, reactions;             ///< displacement, velocity, forces of the clamps (null if not needed)
    Vec v_before = nullptr;          ///< velocity before the step; null in frame 0
    double tau = 0;                  ///< length of the step, s
    std::vector<double> y_at, v_at;  ///< y and v at the points (points × dim)
    std::vector<double> v_at_before; ///< v_before at the points, if a probe at a point needs it
    const std::vector<ObstacleForce>& obstacles;
    const std::vector<petsc::Vector>& weights;
  };
  using ProbeFunction = std::function<double(const Sample& now)>;

  /// Returns a function for the value factor · (w · field) + offset, w being the entry `weights` of weights_.
  [[nodiscard]] static ProbeFunction linear(std::size_t weights, Vec Sample::* field, double factor = 1,
                                            double offset = 0);
  /// Returns a function for the acceleration in the step: the change of w · v over its length, w being the
  /// entry `weights` of weights_. Zero in frame 0.
  [[nodiscard]] static ProbeFunction acceleration(std::size_t weights);
  void add_column(const std::string& probe, const std::string& quantity, const ProbeFunction& value);
  /// Adds a value for each component c; `make(c)` returns the function that computes it.
  template <class Make>
  void add_vector(const std::string& probe, const std::string& quantity, Make&& make);
  /// Creates the sampler of all probes' points.
  void find_points(const std::vector<scene::Probe>& probes);
  /// Adds the values of a probe at a point. `number`: index of that point among all points.
  void add_point(const scene::Probe& probe, std::size_t number);
  void add_obstacle(const scene::Probe& probe, std::size_t obstacle);
  void add_group(const scene::Probe& probe, const std::string& key);
  void add_reaction(const std::string& probe, const std::string& group, const std::string& key);
  void add_body(const scene::Probe& probe);
  void add_rotation(const std::string& probe, const std::vector<double>& centre);

  const step::Stepper& stepper_;
  std::size_t dim_;
  std::vector<std::string> names_;
  std::vector<ProbeFunction> values_;
  std::vector<petsc::Vector> weights_;
  std::optional<fem::Sampler> sampler_;
  bool reactions_ = false, points_accelerate_ = false;
};

} // namespace signorini::diagnostics
