#include "forward/load.h"

namespace signorini::forward {
using petsc::check;

BodyLoad::BodyLoad(const fem::Space& space, const fem::Operators& operators, const scene::Load& load, Scheme scheme)
    : space_(space), W_(operators.W), scheme_(scheme), field_(load.body, "load.body", true), nodal_(space.vector()),
      load_(space.vector()) {
  evaluate(scheme.load_time(1));
}

void BodyLoad::evaluate(double t) const {
  space_.interpolate(field_, t, nodal_);
  check(MatMult(W_, nodal_, load_));
}

void BodyLoad::add(int k, Vec out) const {
  if (field_.depends_on_time())
    evaluate(scheme_.load_time(k));
  check(VecAXPY(out, 1, load_));
}

} // namespace signorini::forward
