// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/body.h"

namespace signorini::scene {

namespace {

/// Parts of the instantaneous moduli that remain after relaxation, 1 − Σk and 1 − Σg.
ElasticModuli remaining(const std::vector<Branch>& prony) {
  ElasticModuli part{1, 1};
  for (const Branch& branch : prony) {
    part.bulk -= branch.k;
    part.shear -= branch.g;
  }
  return part;
}

/// Quotients of the long-term and the given moduli of a material.
ElasticModuli relaxed_part(const Material& material) {
  return material.moduli == Moduli::instantaneous ? remaining(material.prony) : ElasticModuli{1, 1};
}

} // namespace

double ElasticModuli::young() const { return 9 * bulk * (shear / (3 * bulk + shear)); }

double ElasticModuli::poisson() const { return (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear)); }

ElasticModuli Material::given() const {
  return {young / (3 * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
}

ElasticModuli Material::instantaneous() const {
  if (moduli == Moduli::instantaneous)
    return given();
  const ElasticModuli relaxed = given(), part = remaining(prony);
  return {relaxed.bulk / part.bulk, relaxed.shear / part.shear};
}

ElasticConstants Material::instantaneous_constants() const {
  if (moduli == Moduli::instantaneous)
    return {young, poisson};
  const ElasticModuli at_once = instantaneous();
  return {at_once.young(), at_once.poisson()};
}

ElasticModuli Material::long_term() const {
  const ElasticModuli whole = given(), part = relaxed_part(*this);
  return {whole.bulk * part.bulk, whole.shear * part.shear};
}

ElasticModuli Material::during_step(double tau) const {
  ElasticModuli sum = long_term();
  const ElasticModuli at_once = instantaneous();
  for (const Branch& branch : prony) {
    const double gain = branch_step(tau, branch.time).gain;
    sum.bulk += gain * branch.k * at_once.bulk;
    sum.shear += gain * branch.g * at_once.shear;
  }
  return sum;
}

Viscosity Material::total_viscosity() const {
  Viscosity total = viscosity.value_or(Viscosity{});
  if (rayleigh) {
    const ElasticModuli part = relaxed_part(*this);
    total.bulk += rayleigh->beta * young / (3 * (1 - 2 * poisson)) * part.bulk;
    total.shear += rayleigh->beta * young / (2 * (1 + poisson)) * part.shear;
  }
  return total;
}

} // namespace signorini::scene
