// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/choices.h"
#include "scene/mesh_format.h"
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
  std::filesystem::path file; ///< path of a geometry or a mesh, absolute
  std::optional<double>
      size{};       ///< element size of a geometry, m; 0: "auto"; absent: the sizes that a .geo itself sets
  double scale = 1; ///< factor on the sizes that the .geo itself sets
  LengthUnit unit = LengthUnit::m; ///< unit of the file's coordinates
  bool split = false; ///< whether quadrilaterals, hexahedra, prisms and pyramids are divided into simplices
  int degree = 1;     ///< Lagrange degree of the displacement
  std::optional<PlaneModel> model{}; ///< absent in space; in the plane absent means plane strain
  /// .geo of the same body with element sizes graded by the estimated error; set by the program, not a key.
  std::filesystem::path graded{};

  /// scene::per_depth() for a mesh of `dim` dimensions.
  [[nodiscard]] const char* per_depth(int dim) const {
    return scene::per_depth(dim, model.value_or(PlaneModel::plane_strain));
  }
  /// Whether the mesh is the half section of a body of revolution.
  [[nodiscard]] bool axisymmetric() const { return model == PlaneModel::axisymmetric; }
  /// Whether the element size is "auto", chosen by the estimated error (--accuracy).
  [[nodiscard]] bool automatic() const { return size == 0.0; }
  /// Length of the unit of the file's coordinates, m. Files that name their unit are read in mm.
  [[nodiscard]] double metres() const { return scene::metres(names_its_unit(file) ? LengthUnit::mm : unit); }
  /// Format of the file; a .geo if its extension is unknown.
  [[nodiscard]] MeshFormat format() const { return mesh_format(file).value_or(MeshFormat::script); }
  /// Whether the file is a mesh already, not a geometry that the program meshes.
  [[nodiscard]] bool meshed() const {
    return format() != MeshFormat::script && format() != MeshFormat::shape;
  }
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

/// Young's modulus and Poisson's ratio of an isotropic material.
struct ElasticConstants {
  double young = 0, poisson = 0; ///< Pa; without unit
};

/// Bulk and shear modulus of an isotropic material.
struct ElasticModuli {
  double bulk = 0, shear = 0; ///< Pa

  /// Returns Young's modulus of these moduli, Pa.
  [[nodiscard]] double young() const;
  /// Returns Poisson's ratio of these moduli.
  [[nodiscard]] double poisson() const;
};

/// Branch of a Prony series: a spring and a dashpot in series, parallel to the long-term elasticity;
/// docs/method.md section 1.
struct Branch {
  double g = 0;    ///< fraction of the instantaneous shear modulus
  double k = 0;    ///< fraction of the instantaneous bulk modulus
  double time = 0; ///< relaxation time t, s
};

/// Coefficients of the midpoint rule for the internal displacement q of a branch, q̇ = v − q/t: at the end of
/// a step from y_{k−1} to y_k it is q_k = decay q_{k−1} + gain (y_k − y_{k−1}).
struct BranchStep {
  double gain, decay;
};
/// Computes the coefficients of a step of length `tau`, s, for a branch with the relaxation time `time`, s.
inline BranchStep branch_step(double tau, double time) {
  const double gain = 1 / (1 + tau / (2 * time));
  return {gain, 2 * gain - 1};
}

/// Table [material], or one of [[material]].
struct Material {
  std::optional<std::string> on;         ///< physical group of its cells; absent: the whole body
  double density = 0;                    ///< ρ, kg/m³
  double young = 0;                      ///< E of the moduli that `moduli` names, Pa
  double poisson = 0;                    ///< ν of the same moduli
  std::optional<Viscosity> viscosity;    ///< absent: elastic
  std::optional<Rayleigh> rayleigh;      ///< absent: none
  std::vector<Branch> prony;             ///< branches of the Prony series; empty: no relaxation
  Moduli moduli = Moduli::instantaneous; ///< meaning of `young` and `poisson`; instantaneous without `prony`

  /// Limit of the sums Σg and Σk. Beyond it ν is so near to 1/2 or −1 that moduli lose more than four digits.
  static constexpr double most_relaxed = 1 - 1e-4;

  /// Whether the stress depends on the strain rate.
  [[nodiscard]] bool viscous() const { return viscosity || (rayleigh && rayleigh->beta > 0); }
  /// α of the Rayleigh damping, 1/s; 0 without it.
  [[nodiscard]] double mass_damping() const { return rayleigh ? rayleigh->alpha : 0; }
  /// Whether mass-proportional damping acts.
  [[nodiscard]] bool dragged() const { return mass_damping() > 0; }
  /// Whether the stress relaxes, since the material has a Prony series.
  [[nodiscard]] bool relaxes() const { return !prony.empty(); }
  /// Returns the moduli of `young` and `poisson`.
  [[nodiscard]] ElasticModuli given() const;
  /// Returns the moduli at the instant of loading, K_0 and G_0.
  [[nodiscard]] ElasticModuli instantaneous() const;
  /// Returns the constants of instantaneous(): exactly `young` and `poisson` unless `moduli` is long_term.
  [[nodiscard]] ElasticConstants instantaneous_constants() const;
  /// Returns the moduli after relaxation, K_0 (1 − Σk) and G_0 (1 − Σg).
  [[nodiscard]] ElasticModuli long_term() const;
  /// Returns the moduli with which a step of length `tau`, s, resists a change of displacement: the long-term
  /// ones plus those of each branch times its gain.
  [[nodiscard]] ElasticModuli during_step(double tau) const;
  /// Sum of `viscosity` and the viscosity to which β A is equivalent: κ = β K, η = β μ, with the long-term
  /// moduli.
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
