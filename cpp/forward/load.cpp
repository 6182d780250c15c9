#include "forward/load.h"
#include "base/counters.h"

namespace signorini::forward {
using petsc::check;

namespace {
long& evaluations = count("load evaluations");
}

BodyLoad::BodyLoad(const fem::Space& space, const scene::Load& load, Scheme scheme)
    : space_(space), scheme_(scheme), field_(load.body, "load.body", true), nodal_(space.vector()) {
  evaluate(scheme.load_time(1));
}

void BodyLoad::evaluate(double t) const {
  space_.interpolate(field_, t, nodal_);
  ++evaluations;
}

void BodyLoad::add(int k, Vec density) const {
  if (field_.depends_on_time())
    evaluate(scheme_.load_time(k));
  check(VecAXPY(density, 1, nodal_));
}

} // namespace signorini::forward
