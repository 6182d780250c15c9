// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/load.h"
#include "base/counters.h"
#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace signorini::forward {
using petsc::check;

namespace {

long& evaluations = count("load evaluations");

/// `out` set to zero; null if no term has such a part.
Vec zeroed(const petsc::Vector& out) {
  if (out)
    check(VecZeroEntries(out));
  return out;
}

} // namespace

template <class Part>
SumAtStep<Part>::SumAtStep(const fem::Space& space, std::initializer_list<const StepByStep<Part>*> terms) {
  std::ranges::copy_if(terms, std::back_inserter(terms_), [](const auto* term) { return term != nullptr; });
  if (std::ranges::any_of(terms_, &StepByStep<Part>::has_density))
    density_ = space.vector();
  if (std::ranges::any_of(terms_, &StepByStep<Part>::has_vector))
    vector_ = space.vector();
}

template <class Part>
Part SumAtStep<Part>::at(int k) const {
  const Part sum{{zeroed(density_), zeroed(vector_)}};
  for (const StepByStep<Part>* term : terms_)
    term->add(k, sum);
  return sum;
}

template class SumAtStep<NodalForce>;
template class SumAtStep<StateDual>;

void assemble(Functional functional, const fem::Operators& operators, Vec out) {
  check(VecZeroEntries(out));
  if (functional.density)
    check(MatMult(*operators.W, functional.density, out));
  if (functional.vector)
    check(VecAXPY(out, 1, functional.vector));
}

SceneLoad::SceneLoad(const fem::Space& space, Mat M, const scene::Load& scene, TimeGrid grid)
    : space_(space), grid_(grid) {
  if (scene.body) {
    body_.emplace(Term{scene::Field(*scene.body, "load.body", true), space.vector()});
    evaluate(*body_, 0);
  }
  if (scene.gravity) {
    forces_.push_back(
        {scene::Field(*scene.gravity, "load.gravity", true), space.vector(), {}, M, space.vector()});
    evaluate(forces_.back(), 0);
  }
  for (std::size_t i = 0; i < scene.tractions.size(); ++i) {
    const auto key = [&](const char* name) { return fmt::format("load.traction[{}].{}", i, name); };
    const scene::Traction& traction = scene.tractions[i];
    (void)space.mesh().facets(traction.on, key("on")); // throws if the group is not a surface
    petsc::Matrix surface = fem::assemble_L2(space, traction.on, key("on"));
    const Mat product = surface;
    forces_.push_back({scene::Field(traction.value, key("value"), true), space.vector(), std::move(surface),
                       product, space.vector()});
    evaluate(forces_.back(), 0);
  }
}

void SceneLoad::evaluate(const Term& term, int k) const {
  ++evaluations;
  space_.interpolate(term.field, k > 0 ? grid_.load_time(k) : grid_.first_length() / 2, term.nodal);
  if (term.product)
    check(MatMult(term.product, term.nodal, term.force));
}

void SceneLoad::add_term(const Term& term, int k, Vec out) const {
  if (term.field.depends_on_time())
    evaluate(term, k);
  check(VecAXPY(out, 1, term.product ? term.force : term.nodal));
}

bool SceneLoad::depends_on_time() const {
  return (body_ && body_->field.depends_on_time()) ||
         std::ranges::any_of(forces_, [](const Term& term) { return term.field.depends_on_time(); });
}

double SceneLoad::surface_bytes() const {
  double sum = 0;
  for (const Term& term : forces_)
    sum += term.surface ? petsc::bytes(term.surface) : 0;
  return sum;
}

void SceneLoad::add(int k, NodalForce sum) const {
  if (body_)
    add_term(*body_, k, sum.density);
  for (const Term& term : forces_)
    add_term(term, k, sum.vector);
}

} // namespace signorini::forward
