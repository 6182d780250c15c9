#include "forward/load.h"
#include "base/counters.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

long& evaluations = count("load evaluations");

Load::Add both(Load::Add a, Load::Add b) {
  if (!a || !b)
    return a ? std::move(a) : std::move(b);
  return [a = std::move(a), b = std::move(b)](int k, Vec out) {
    a(k, out);
    b(k, out);
  };
}

Vec at_step(const Load::Add& add, int k, Vec out) {
  if (!add)
    return nullptr;
  check(VecZeroEntries(out));
  add(k, out);
  return out;
}

} // namespace

Load operator+(Load a, Load b) {
  return {both(std::move(a.density), std::move(b.density)), both(std::move(a.force), std::move(b.force))};
}

void force_of(StepLoad load, const fem::Operators& operators, Vec out) {
  check(VecZeroEntries(out));
  if (load.density)
    check(MatMult(*operators.W, load.density, out));
  if (load.force)
    check(VecAXPY(out, 1, load.force));
}

LoadAtStep::LoadAtStep(const fem::Space& space, const Load& load) : load_(load) {
  if (load.density)
    density_ = space.vector();
  if (load.force)
    force_ = space.vector();
}

StepLoad LoadAtStep::operator()(int k) const {
  return {at_step(load_.density, k, density_), at_step(load_.force, k, force_)};
}

SceneLoad::SceneLoad(const fem::Space& space, const scene::Load& scene, Scheme scheme)
    : space_(space), scheme_(scheme) {
  if (scene.body) {
    body_.emplace(Term{scene::Field(*scene.body, "load.body", true), space.vector(), {}, {}});
    evaluate(*body_, 1);
  }
  for (std::size_t i = 0; i < scene.tractions.size(); ++i) {
    const auto key = [&](const char* name) { return fmt::format("load.traction[{}].{}", i, name); };
    const scene::Traction& traction = scene.tractions[i];
    (void)space.mesh().facets(traction.on, key("on")); // a surface
    tractions_.push_back(Term{scene::Field(traction.value, key("value"), true), space.vector(),
                              fem::assemble_L2(space, traction.on, key("on")), space.vector()});
    evaluate(tractions_.back(), 1);
  }
}

void SceneLoad::evaluate(const Term& term, int k) const {
  ++evaluations;
  space_.interpolate(term.field, scheme_.load_time(k), term.nodal);
  if (term.surface)
    check(MatMult(term.surface, term.nodal, term.force));
}

void SceneLoad::add(const Term& term, int k, Vec out) const {
  if (term.field.depends_on_time())
    evaluate(term, k);
  check(VecAXPY(out, 1, term.surface ? term.force : term.nodal));
}

bool SceneLoad::depends_on_time() const {
  return (body_ && body_->field.depends_on_time()) ||
         std::ranges::any_of(tractions_, [](const Term& term) { return term.field.depends_on_time(); });
}

double SceneLoad::surface_bytes() const {
  double sum = 0;
  for (const Term& term : tractions_)
    sum += petsc::bytes(term.surface);
  return sum;
}

Load SceneLoad::load() const {
  Load load;
  if (body_)
    load.density = [this](int k, Vec out) { add(*body_, k, out); };
  if (!tractions_.empty())
    load.force = [this](int k, Vec out) {
      for (const Term& term : tractions_)
        add(term, k, out);
    };
  return load;
}

} // namespace signorini::forward
