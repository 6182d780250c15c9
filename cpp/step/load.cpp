// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/load.h"
#include "base/timers.h"
#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace signorini::step {
using petsc::check;

namespace {

long& evaluations = count("load evaluations");

/// Sets `out` to zero and returns it; null if `out` is null, since no term has that part.
Vec zeroed(const petsc::Vector& out) {
  if (out)
    check(VecZeroEntries(out));
  return out;
}

} // namespace

template <std::derived_from<Functional> F>
SumAtStep<F>::SumAtStep(const fem::Space& space, std::initializer_list<const StepByStep<F>*> terms) {
  std::ranges::copy_if(terms, std::back_inserter(terms_), [](const auto* term) { return term != nullptr; });
  if (std::ranges::any_of(terms_, &StepByStep<F>::has_density))
    density_ = space.vector();
  if (std::ranges::any_of(terms_, &StepByStep<F>::has_vector))
    vector_ = space.vector();
}

template <std::derived_from<Functional> F>
F SumAtStep<F>::at(const TimeStep& step) const {
  const F sum{{zeroed(density_), zeroed(vector_)}};
  for (const StepByStep<F>* term : terms_)
    term->add(step, sum);
  return sum;
}

template <std::derived_from<Functional> F>
double SumAtStep<F>::variation(double from, double to) const {
  double most = 0;
  for (const StepByStep<F>* term : terms_)
    most = std::max(most, term->variation(from, to));
  return most;
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

bool SceneLoad::acts(const scene::Scene& scene) {
  const auto pushed = [](const scene::Contact& contact) { return contact.rigid && contact.rigid->force; };
  return scene.load || std::ranges::any_of(scene.contacts, pushed);
}

SceneLoad::SceneLoad(const fem::Space& space, Mat M, const scene::Load& scene, double end,
                     const std::vector<scene::Contact>& contacts)
    : space_(space), end_(end) {
  if (scene.body)
    body_.emplace(term(*scene.body, "load.body"));
  const auto add = [&](Term made, Mat product) {
    made.product = product;
    made.force = space.vector();
    multiply(forces_.emplace_back(std::move(made)));
  };
  if (scene.gravity)
    add(term(*scene.gravity, "load.gravity"), M);
  for (std::size_t i = 0; i < scene.tractions.size(); ++i) {
    const auto key = [&](const char* name) { return fmt::format("load.traction[{}].{}", i, name); };
    const scene::Traction& traction = scene.tractions[i];
    (void)space.mesh().facets(traction.on, key("on")); // throws if the group is not a surface
    Term made = term(traction.value, key("value"));
    made.surface = fem::assemble_L2(space, traction.on, key("on"));
    const Mat product = made.surface;
    add(std::move(made), product);
  }
  for (std::size_t i = 0; i < scene.points.size(); ++i)
    points_.push_back(
        std::make_unique<PointForce>(space, scene.points[i], fmt::format("load.point[{}]", i), end));
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto& rigid = contacts[i].rigid;
    if (!rigid)
      continue;
    const std::size_t node = contact::virtual_node(contacts, i);
    if (rigid->force)
      points_.push_back(std::make_unique<PointForce>(
          space, node, *rigid->force, 1, scene::contact_key(contacts, i) + ".obstacle.force", end));
    if (scene.gravity)
      points_.push_back(
          std::make_unique<PointForce>(space, node, *scene.gravity, rigid->mass, "load.gravity", end));
  }
}

SceneLoad::Term SceneLoad::term(const scene::Components& components, const std::string& key) const {
  Term made{{space_.comm(), scene::Field(components, key, true), space_.points(), end_}, space_.vector()};
  if (!made.profile.field().depends_on_time()) {
    ++evaluations;
    space_.interpolate(made.profile.field(), 0, made.nodal);
  }
  return made;
}

void SceneLoad::multiply(const Term& term) {
  if (term.product)
    check(MatMult(term.product, term.nodal, term.force));
}

void SceneLoad::add_term(const Term& term, const TimeStep& step, Vec out) {
  if (term.profile.field().depends_on_time()) {
    ++evaluations;
    term.profile.mean(step.begin, step.end, petsc::WriteArray(term.nodal));
    multiply(term);
  }
  check(VecAXPY(out, 1, term.product ? term.force : term.nodal));
}

template <class Visit>
void SceneLoad::for_each(Visit&& visit) const {
  if (body_)
    visit(body_->profile);
  for (const Term& term : forces_)
    visit(term.profile);
  for (const auto& point : points_)
    visit(point->profile());
}

bool SceneLoad::depends_on_time() const {
  bool any = false;
  for_each([&](const fem::TimeProfile& profile) { any |= profile.field().depends_on_time(); });
  return any;
}

double SceneLoad::variation(double from, double to) const {
  double most = 0;
  for_each([&](const fem::TimeProfile& profile) { most = std::max(most, profile.variation(from, to)); });
  return most;
}

std::vector<Warning> SceneLoad::warnings() const {
  constexpr double noticeable = fem::TimeProfile::noticeable;
  std::vector<Warning> found;
  for_each([&](const fem::TimeProfile& profile) {
    if (const double off = profile.unresolved(); off > noticeable)
      found.push_back(
          {"load not integrated",
           fmt::format(
               "{}: the expression changes too fast to be integrated: its impulse may have a relative error "
               "of {:.2g}",
               profile.field().key(), off),
           off, noticeable});
  });
  return found;
}

double SceneLoad::surface_bytes() const {
  double sum = 0;
  for (const Term& term : forces_)
    sum += term.surface ? petsc::bytes(term.surface) : 0;
  return sum;
}

void SceneLoad::add(const TimeStep& step, NodalForce sum) const {
  if (body_)
    add_term(*body_, step, sum.density);
  for (const Term& term : forces_)
    add_term(term, step, sum.vector);
  for (const auto& point : points_)
    point->add(step, sum.vector);
}

} // namespace signorini::step
