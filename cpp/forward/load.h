#pragma once
#include "fem/operators.h"
#include "forward/scheme.h"
#include "scene/expression.h"
#include <functional>
#include <optional>

namespace signorini::forward {

/// Adds the load of step k = 1…N to a vector (N).
using AddLoad = std::function<void(int k, Vec out)>;

/// The body force of the scene: W f, f interpolated at the nodes; evaluated again only if it depends on time.
class BodyLoad {
public:
  /// Collective.
  BodyLoad(const fem::Space& space, const fem::Operators& operators, const scene::Load& load, Scheme scheme);

  /// out += W f(t_{k−1/2}). Collective.
  void add(int k, Vec out) const;

private:
  void evaluate(double t) const;

  const fem::Space& space_;
  Mat W_;
  Scheme scheme_;
  scene::Field field_;
  petsc::Vector nodal_, load_;
};

} // namespace signorini::forward
