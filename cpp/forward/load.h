#pragma once
#include "fem/operators.h"
#include "forward/scheme.h"
#include "scene/expression.h"
#include <functional>
#include <optional>

namespace signorini::forward {

/// Adds the force density of step k = 1…N to nodal values (N/m³): f_k + s u_k, whose force on the nodes is
/// its product with W.
using AddLoad = std::function<void(int k, Vec density)>;

/// The body force of the scene at the nodes; evaluated again only if it depends on time.
class BodyLoad {
public:
  /// Collective.
  BodyLoad(const fem::Space& space, const scene::Load& load, Scheme scheme);

  /// density += f(t_{k−1/2}). Collective.
  void add(int k, Vec density) const;

private:
  void evaluate(double t) const;

  const fem::Space& space_;
  Scheme scheme_;
  scene::Field field_;
  petsc::Vector nodal_;
};

} // namespace signorini::forward
