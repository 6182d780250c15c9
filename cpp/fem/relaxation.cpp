// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/relaxation.h"
#include "fem/forms.h"
#include "fem/operators.h"
#include "linalg/threaded_product.h"
#include <algorithm>

namespace signorini::fem {
using petsc::check;

Relaxation::Relaxation(const Space& space, const std::vector<scene::Material>& materials) {
  const std::vector<Part> body = parts(space.mesh(), materials);
  const auto assembled = [&](std::size_t material, scene::ElasticModuli moduli) {
    return symmetric_half(assemble_elasticity(space, body, material, moduli));
  };
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const std::vector<scene::Branch>& series = materials[i].prony;
    if (series.empty())
      continue;
    Stiffness& made = stiffnesses_.emplace_back(Stiffness{branches_.size(), series.size(), {}, {}});
    for (const scene::Branch& branch : series)
      branches_.push_back({i, branch.g, branch.k, branch.time});
    const auto [bulk, shear] = materials[i].instantaneous();
    if (std::ranges::all_of(series, [](const scene::Branch& one) { return one.g == one.k; })) {
      made.shear = assembled(i, {bulk, shear});
      continue;
    }
    if (std::ranges::any_of(series, [](const scene::Branch& one) { return one.g > 0; }))
      made.shear = assembled(i, {.shear = shear});
    if (std::ranges::any_of(series, [](const scene::Branch& one) { return one.k > 0; }))
      made.bulk = assembled(i, {.bulk = bulk});
  }
}

void Relaxation::add(const Combinations& x, Vec sum, Vec work) const {
  for (const Stiffness& of : stiffnesses_) {
    const auto add_product = [&](Mat stiffness, double Branch::* fraction) {
      if (!stiffness)
        return;
      check(VecZeroEntries(work));
      double common = 0;
      for (std::size_t j = of.first; j < of.first + of.count; ++j) {
        const double part = branches_[j].*fraction;
        if (part == 0)
          continue;
        check(VecAXPY(work, part * x.weights[j], x.vectors[j]));
        if (x.common)
          common += part * x.common_weights[j];
      }
      if (common != 0)
        check(VecAXPY(work, common, x.common));
      check(MatMultAdd(stiffness, work, sum, sum));
    };
    add_product(of.shear, &Branch::g);
    add_product(of.bulk, &Branch::k);
  }
}

double Relaxation::bytes() const {
  double sum = 0;
  for (const Stiffness& of : stiffnesses_)
    for (const Mat matrix : {Mat(of.shear), Mat(of.bulk)})
      sum += matrix ? petsc::bytes(matrix) : 0;
  return sum;
}

} // namespace signorini::fem
