// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "adjoint/weighted_residual.h"
#include "base/error.h"
#include <optional>
#include <span>

namespace signorini::accuracy {

/// A quantity that is compared between runs.
struct Quantity {
  std::string name, title, unit;
  bool field = false; ///< whether the quantity is a field rather than a number
  /// Whether errors are not divided by a norm, since the quantity is relative already.
  bool already_relative = false;
  bool converges = true; ///< whether the quantity converges with steps and mesh in every motion

  /// Whether a warning about a motion concerns this quantity. A warning about peak forces concerns only peak
  /// forces, a warning about the stress only the stress. Every other warning concerns all quantities.
  [[nodiscard]] bool affected_by(const Warning& warning) const;
};

/// Measurements of one run: cost, and values of quantities.
struct Measured {
  long unknowns = 0;
  int steps = 0;
  double seconds = 0;                    ///< time of set-up and sweeps
  double memory = 0;                     ///< peak minus the memory before the run, on all ranks, bytes
  std::map<std::string, double> numbers; ///< values of numbers, by name of the quantity
  std::map<std::string, std::vector<double>>
      fields; ///< samples of fields by name, scaled so that their sum of squares is the squared norm
  std::optional<adjoint::ErrorParts> estimate; ///< estimated error of J, J(exact) − J
  std::vector<Warning> warnings;               ///< warnings about the run's time steps and mesh

  /// Text of the warnings that concern a quantity; empty if there are none.
  [[nodiscard]] std::string warning(const Quantity& quantity) const;

  /// Values of a quantity: one number, or the scaled samples of a field.
  [[nodiscard]] std::span<const double> values(const Quantity& quantity) const {
    if (quantity.field)
      return fields.at(quantity.name);
    return {&numbers.at(quantity.name), 1};
  }
};

/// A rung and its measurements.
struct RungResult {
  Rung rung;
  std::optional<Measured> measured; ///< absent if the rung has not run
};

/// Exact values of quantities. The errors of other quantities are those against the finest rung.
struct Exact {
  std::map<std::string, double> numbers;             ///< values of numbers, by name of the quantity
  std::map<std::string, std::vector<double>> fields; ///< scaled samples of fields, by name of the quantity
  /// Whether the exact value of a quantity is known.
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
constexpr const char* of_restitution = "restitution";  ///< name of the coefficient of restitution

/// Whether quantities include the one with this name.
bool has(const std::vector<Quantity>& quantities, const std::string& name);

/// All quantities that can be compared for a scene. Every scene has the displacement and the largest von
/// Mises stress. A scene with an objective also has J and, if control values are nodal, the gradient. A scene
/// with contact also has the impulse, forces and times of contact, energy_loss if all obstacles are at rest,
/// and the pressure if its exact value is given. `dim` determines the units.
std::vector<Quantity> quantities(const scene::Scene& scene, int dim);

/// Selects those of the quantities `all` that have these names, each once. `what`: what they are, for
/// messages. Throws UserError if a name is unknown.
std::vector<Quantity> named(const std::vector<Quantity>& all, const std::vector<std::string>& names,
                            const char* what);

/// Selects quantities by their names. If `names` is empty, selects all quantities except the gradient, and
/// except the stress if the scene does not store it. Throws UserError if a name is unknown.
std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names, int dim);

} // namespace signorini::accuracy
