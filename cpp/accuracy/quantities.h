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
  bool absolute = false; ///< whether it is relative already: errors are plain differences
  bool limited = true;   ///< whether it converges with steps and mesh in every motion

  /// Whether a warning of a motion concerns this quantity; warnings of peaks concern peaks alone.
  [[nodiscard]] bool doubted_by(const Warning& warning) const;
};

/// Measurements of a run. A field is compared in its norm, a number by its modulus.
struct Measured {
  long unknowns = 0;
  int steps = 0;
  double seconds = 0;                    ///< time of set-up and sweeps
  double memory = 0;                     ///< peak beyond the program's memory before, bytes
  std::map<std::string, double> numbers; ///< values by quantity
  std::map<std::string, std::vector<double>>
      fields; ///< samples by quantity, scaled so that their sum of squares is the squared norm
  std::optional<adjoint::ErrorParts> estimate; ///< estimated error of J, J(exact) − J
  std::vector<Warning> warnings;               ///< warnings about its steps and its mesh

  /// The warnings that concern a quantity, in words; empty without any.
  [[nodiscard]] std::string warning(const Quantity& quantity) const;

  /// The number of a quantity, or the samples of a field.
  [[nodiscard]] std::span<const double> values(const Quantity& quantity) const {
    if (quantity.field)
      return fields.at(quantity.name);
    return {&numbers.at(quantity.name), 1};
  }
};

/// A rung and its measurements, which are absent if it has not run.
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

constexpr const char* of_stress = "largest_von_mises"; ///< name of the largest von Mises stress

/// The quantities that can be compared in a scene: displacement and largest von Mises stress; impulse, forces
/// and times of contact; energy_loss if all obstacles are at rest; pressure if the exact one is given. With
/// an objective these are also J and the gradient. `dim` determines the units.
std::vector<Quantity> quantities(const scene::Scene& scene, int dim);

/// Selects the quantities of these names or, without names, all but the gradient and, where the scene stores
/// none, the stress. Throws UserError.
std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names, int dim);

} // namespace signorini::accuracy
