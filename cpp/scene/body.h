// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/choices.h"
#include "scene/time_series.h"
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

/// Tables of a scene that describe the body with its supports.
namespace signorini::scene {

/// An expression in x, y, z (m) and t (s), or a time series.
struct Expression {
  std::string text;                         ///< the expression, or the TOML table that names the time series
  std::shared_ptr<const TimeSeries> series; ///< the time series; null for an expression
  double factor = 1, shift = 0; ///< value: factor · (expression or series) + shift; set by fits, not in files

  Expression(std::string expression) : text(std::move(expression)) {}
  Expression(const char* expression) : text(expression) {}
  template <class Number>
    requires std::is_arithmetic_v<Number>
  Expression(Number value) : text(written(static_cast<double>(value))) {}
  Expression(std::string table, TimeSeries given)
      : text(std::move(table)), series(std::make_shared<const TimeSeries>(std::move(given))) {}

  friend bool operator==(const Expression& a, const Expression& b) {
    return a.text == b.text && a.factor == b.factor && a.shift == b.shift;
  }

private:
  static std::string written(double value);
};
inline std::string_view format_as(const Expression& expression) { return expression.text; } // for fmt

/// Components of a vector field, one expression each.
using Components = std::vector<Expression>;

/// Table [mesh].
struct Mesh {
  std::filesystem::path file; ///< path of a .geo or .msh file, absolute
  std::optional<double>
      size{};       ///< element size for a .geo, m; 0: "auto"; absent: the sizes that the .geo itself sets
  double scale = 1; ///< factor on the sizes that the .geo itself sets
  LengthUnit unit = LengthUnit::m; ///< unit of the file's coordinates
  int degree = 1;                  ///< Lagrange degree of the displacement
  /// .geo of the same body with element sizes graded by the estimated error; set by the program, not a key.
  std::filesystem::path graded{};

  /// Whether the element size is "auto", chosen by the estimated error (--accuracy).
  [[nodiscard]] bool automatic() const { return size == 0.0; }
  /// Whether the file is a mesh already, a .msh.
  [[nodiscard]] bool meshed() const { return file.extension() == ".msh"; }
};

/// Viscosity of a material; docs/method.md section 1.
struct Viscosity {
  double bulk = 0;  ///< κ, Pa s
  double shear = 0; ///< η, Pa s
};

/// Rayleigh damping α M + β A of a material.
struct Rayleigh {
  double alpha = 0; ///< α, 1/s
  double beta = 0;  ///< β, s
};

/// Table [material], or one of [[material]].
struct Material {
  std::optional<std::string> on;      ///< physical group of its cells; absent: the whole body
  double density = 0;                 ///< ρ, kg/m³
  double young = 0;                   ///< E, Pa
  double poisson = 0;                 ///< ν
  std::optional<Viscosity> viscosity; ///< absent: elastic
  std::optional<Rayleigh> rayleigh;   ///< absent: none

  /// Whether the stress depends on the strain rate.
  [[nodiscard]] bool viscous() const { return viscosity || (rayleigh && rayleigh->beta > 0); }
  /// α of the Rayleigh damping, 1/s; 0 without it.
  [[nodiscard]] double mass_damping() const { return rayleigh ? rayleigh->alpha : 0; }
  /// Whether mass-proportional damping acts.
  [[nodiscard]] bool dragged() const { return mass_damping() > 0; }
  /// Sum of `viscosity` and the viscosity to which β A is equivalent: κ = β K, η = β μ.
  [[nodiscard]] Viscosity total_viscosity() const;
};

/// Springs of a foundation per area.
struct FoundationStiffness {
  double normal = 0, tangential = 0; ///< along and across the surface's normal, N/m³
};

/// Dashpots of a foundation per area.
struct FoundationDamping {
  double normal = 0, tangential = 0; ///< along and across the surface's normal, N s/m³
};

/// One table [[foundation]].
struct Foundation {
  std::string on;                               ///< physical group of the surface
  std::optional<FoundationStiffness> stiffness; ///< absent: none
  std::optional<FoundationDamping> damping;     ///< absent: none
  bool absorbing = false;                       ///< whether plane waves leave the body at the surface
};

/// One table [[clamp]].
struct Clamp {
  std::string on;                                   ///< physical group
  std::optional<std::vector<Component>> components; ///< clamped components; absent: all
  std::optional<Components> value; ///< displacement of each clamped component, m, in x, y, z, t; absent: 0
};

} // namespace signorini::scene
