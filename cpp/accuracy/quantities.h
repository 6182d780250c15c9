// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "adjoint/weighted_residual.h"
#include "base/error.h"
#include <optional>
#include <span>

namespace signorini::accuracy {

struct Quantity {
  std::string name, title, unit;
  bool field = false;
  bool absolute = false; ///< already relative: errors are plain differences
  bool limited = true;   ///< whether it converges with steps and mesh in every motion

  /// Whether a warning of a motion concerns its value: those of peaks alone do not, but for these.
  [[nodiscard]] bool doubted_by(const Warning& warning) const;
};

/// What is measured of a run. A field is compared in its norm, a number by its modulus.
struct Measured {
  long unknowns = 0;
  int steps = 0;
  double seconds = 0;                    ///< of set-up and sweeps
  double memory = 0;                     ///< peak beyond what the program held before, bytes
  std::map<std::string, double> numbers; ///< by quantity
  std::map<std::string, std::vector<double>>
      fields; ///< by quantity: samples, scaled so that their sum of squares is the norm's
  std::optional<adjoint::ErrorParts> estimate; ///< of the error of J, J(exact) − J
  std::vector<Warning> warnings;               ///< of what its steps may have missed

  /// The warnings that concern a quantity, in words; empty without any.
  [[nodiscard]] std::string warning(const Quantity& quantity) const;

  /// The number of a quantity, or the samples of a field.
  [[nodiscard]] std::span<const double> values(const Quantity& quantity) const {
    if (quantity.field)
      return fields.at(quantity.name);
    return {&numbers.at(quantity.name), 1};
  }
};

/// A rung and its measurements; empty if it has not run.
struct Result {
  Rung rung;
  std::optional<Measured> measured;
};

/// The values against which errors are taken, by quantity; an absent quantity is compared with the finest
/// rung.
struct Exact {
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> fields;
  [[nodiscard]] bool knows(const Quantity& quantity) const {
    return quantity.field ? fields.contains(quantity.name) : numbers.contains(quantity.name);
  }
  [[nodiscard]] std::span<const double> values(const Quantity& quantity) const {
    if (quantity.field)
      return fields.at(quantity.name);
    return {&numbers.at(quantity.name), 1};
  }
};

constexpr const char* of_stress = "largest_von_mises"; ///< the name of that quantity

/// The quantities that can be compared in a scene: displacement, the largest von Mises stress, energy_loss
/// where it has contact with obstacles at rest, impulse, forces and times of contact, pressure where the
/// exact one is given, J and gradient with an objective. `dim` tells the units.
std::vector<Quantity> quantities(const scene::Scene& scene, int dim);

/// Those of these names or, if there are none, all but the gradient and, where the scene stores none, the
/// stress. Throws UserError.
std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names, int dim);

} // namespace signorini::accuracy
