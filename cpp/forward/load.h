#pragma once
#include "fem/operators.h"
#include "forward/scheme.h"
#include "scene/expression.h"
#include <functional>
#include <optional>

namespace signorini::forward {

/// What acts on the body in step k = 1…N (f_k + s u_k), or what a backward sweep starts from at step k. Each
/// part adds to a vector of V; an empty part is none and costs nothing.
struct Load {
  using Add = std::function<void(int k, Vec out)>;
  Add density{}; ///< force density at the nodes, N/m³: its force on the nodes is its product with W
  Add force{};   ///< force on the nodes, N
};

Load operator+(Load a, Load b);

/// The load of one step; null parts are none.
struct StepLoad {
  Vec density = nullptr, force = nullptr;
};

/// The force on the nodes of both parts. Collective.
void force_of(StepLoad load, const fem::Operators& operators, Vec out);

/// A load step by step, with vectors for the parts that it has.
class LoadAtStep {
public:
  /// Collective. The references must outlive this object.
  LoadAtStep(const fem::Space& space, const Load& load);

  /// Valid until the next call. Collective.
  [[nodiscard]] StepLoad operator()(int k) const;

private:
  const Load& load_;
  petsc::Vector density_, force_;
};

/// The body force and the tractions of a scene; evaluated again only if they depend on time.
class SceneLoad {
public:
  /// Collective. The references must outlive this object. Throws UserError.
  SceneLoad(const fem::Space& space, const scene::Load& scene, Scheme scheme);

  /// f(t_{k−1/2}); valid as long as this object lives.
  [[nodiscard]] Load load() const;

  /// Whether any part of it is evaluated in every step.
  [[nodiscard]] bool depends_on_time() const;
  /// Memory of the surfaces' mass matrices, bytes. Collective.
  [[nodiscard]] double surface_bytes() const;

private:
  /// An expression at the nodes, and what it contributes: itself, or its product with the surface's mass.
  struct Term {
    scene::Field field;
    petsc::Vector nodal;
    petsc::Matrix surface; ///< null for a body force
    petsc::Vector force;   ///< surface · nodal
  };
  void evaluate(const Term& term, int k) const;
  void add(const Term& term, int k, Vec out) const;

  const fem::Space& space_;
  Scheme scheme_;
  std::optional<Term> body_;
  std::vector<Term> tractions_;
};

} // namespace signorini::forward
