// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/parameter_rates.h"
#include "contact/mass_redistribution.h"
#include "fem/foundations.h"
#include "scene/parameters.h"
#include "step/relaxing_rates.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace signorini::step {
using petsc::check;

struct ParameterRates::Rate {
  petsc::Matrix A, B, M; ///< derivatives of these matrices; null if zero
  std::optional<RelaxingRate>
      relaxing;                     ///< derivative by the stiffness of a material that relaxes, not in A, B
  std::optional<SceneLoad> load;    ///< derivative of the loads; for a density: the weight
  std::optional<ForceAtStep> force; ///< evaluates `load` at a step
  std::optional<contact::ContactPairs::Rates> pairs;
  int obstacle = 0;
  bool friction = false;                        ///< whether the friction of `obstacle` is unknown
  double friction_value = 0;                    ///< its coefficient or bound
  std::optional<scene::Field> surface_velocity; ///< derivative of that of `obstacle`
  scene::ObstacleRate obstacle_rate;
  petsc::Vector y0, v0;

  [[nodiscard]] bool turns() const { return pairs && pairs->rows; }
};

ParameterRates::ParameterRates(const Stepper& stepper, const scene::Scene& scene,
                               std::span<const double> values)
    : stepper_(stepper), lambda_(stepper.rows()), zeta_(lambda_.size()), work_(stepper.space().vector()),
      components_(lambda_.size()) {
  for (petsc::Vector* one : {&sum_, &difference_, &inertia_, &jump_})
    *one = stepper.space().vector();
  if (stepper.branches() > 0)
    combination_ = stepper.space().vector();
  if (stepper.moving_clamps())
    motion_ = stepper.moving_clamps()->storage();
  for (std::size_t j = 0; j < scene.unknowns.size(); ++j) {
    const scene::Unknown& unknown = scene.unknowns[j];
    Rate& rate = *rates_.emplace_back(std::make_unique<Rate>());
    using enum scene::Parameter;
    switch (unknown.of) {
    case young:
    case poisson:
    case bulk:
    case shear:
    case alpha:
    case beta:
    case prony_g:
    case prony_k:
    case prony_time:
    case density:
      add_material(scene::with_values(scene, values), unknown, rate);
      break;
    case normal_stiffness:
    case tangential_stiffness:
    case normal_damping:
    case tangential_damping:
      add_foundation(scene, unknown, rate);
      break;
    case displacement:
    case velocity:
      add_initial(scene, unknown, rate);
      break;
    case friction:
      rate.friction = true;
      rate.friction_value = values[j];
      rate.obstacle = static_cast<int>(scene::contact_of(scene, unknown));
      break;
    case surface_velocity:
      rate.obstacle = static_cast<int>(scene::contact_of(scene, unknown));
      rate.surface_velocity.emplace(
          *scene.contacts[static_cast<std::size_t>(rate.obstacle)].surface_velocity,
          scene::contact_key(scene.contacts, static_cast<std::size_t>(rate.obstacle)) +
              ".obstacle.surface_velocity",
          true);
      break;
    case position:
    case angle:
    case center:
    case radius:
    case height:
      add_obstacle(scene, values, j, rate);
      break;
    case mass:
    case inertia:
    case rigid_velocity:
    case spring_stiffness:
    case dashpot_damping:
      add_rigid_body(scene::with_values(scene, values), unknown, rate);
      break;
    case body:
    case gravity:
    case traction:
      add_load(scene, values, unknown, rate);
    }
  }
}

ParameterRates::~ParameterRates() = default;

void ParameterRates::add_relaxing(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) {
  const std::size_t material = scene::material_of(scene, unknown);
  std::shared_ptr<const SplitStiffness>& stiffness = stiffness_[material];
  if (!stiffness)
    stiffness = std::make_shared<const SplitStiffness>(stepper_.space(), scene.materials, material);
  rate.relaxing.emplace(*stepper_.operators().relaxation, scene, unknown, stiffness);
  if (petsc::Matrix absorbing = fem::assemble_absorption_rate(stepper_.space(), scene.foundations,
                                                              scene.materials, material, unknown.of))
    rate.B = std::move(absorbing); // in whole blocks, since rows off the surfaces have no diagonal
}

void ParameterRates::add_material(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) {
  const std::size_t material = scene::material_of(scene, unknown);
  const scene::Rayleigh rayleigh = scene.materials[material].rayleigh.value_or(scene::Rayleigh{});
  const auto assembled = [&](fem::Form form) {
    return fem::assemble_rate(stepper_.space(), scene.materials, material, form);
  };
  // B' = absorbing dashpots' + α M' + β A'
  const auto set_damping = [&](double factor, const petsc::Matrix& elastic_or_mass) {
    petsc::Matrix absorbing = fem::assemble_absorption_rate(stepper_.space(), scene.foundations,
                                                            scene.materials, material, unknown.of);
    if (!absorbing && factor == 0)
      return;
    petsc::Matrix B;
    check(MatDuplicate(elastic_or_mass, MAT_COPY_VALUES, B.put()));
    check(MatScale(B, factor));
    if (absorbing)
      check(MatAXPY(B, 1, absorbing, SUBSET_NONZERO_PATTERN));
    rate.B = symmetric_half(B);
  };
  using enum scene::Parameter;
  const bool elastic = unknown.of == young || unknown.of == poisson || unknown.of == beta;
  if (scene::of_branch(unknown.of) || (elastic && scene.materials[material].relaxes()))
    return add_relaxing(scene, unknown, rate);
  switch (unknown.of) {
  case young:
  case poisson: {
    const petsc::Matrix A = assembled(unknown.of == young ? fem::Form::a_young : fem::Form::a_poisson);
    rate.A = symmetric_half(A);
    set_damping(rayleigh.beta, A);
    break;
  }
  case bulk:
    rate.B = symmetric_half(assembled(fem::Form::b_kappa));
    break;
  case shear:
    rate.B = symmetric_half(assembled(fem::Form::b_eta));
    break;
  case alpha:
    rate.B = symmetric_half(assembled(fem::Form::m));
    break;
  case beta:
    rate.B = symmetric_half(assembled(fem::Form::a));
    break;
  default: {
    petsc::Matrix M = assembled(fem::Form::m_rho);
    set_damping(rayleigh.alpha, M);
    if (std::ranges::any_of(scene.contacts, &scene::Contact::loses_mass))
      M = contact::redistributed_mass(
          contact::velocity_extrapolation(stepper_.space(), *stepper_.pairs(), scene.contacts, M), M);
    rate.M = symmetric_half(M);
    add_gravity(scene, rate);
  }
  }
}

void ParameterRates::add_foundation(const scene::Scene& scene, const scene::Unknown& unknown,
                                    Rate& rate) const {
  using enum scene::Parameter;
  const bool springs = unknown.of == normal_stiffness || unknown.of == tangential_stiffness,
             normal = unknown.of == normal_stiffness || unknown.of == normal_damping;
  (springs ? rate.A : rate.B) = fem::assemble_foundation_rate(stepper_.space(), scene.foundations,
                                                              scene::foundation_of(scene, unknown), normal);
}

void ParameterRates::add_gravity(const scene::Scene& scene, Rate& rate,
                                 const std::vector<scene::Contact>& contacts) const {
  if (!scene.load || !scene.load->gravity)
    return;
  scene::Load gravity;
  gravity.gravity = scene.load->gravity;
  rate.load.emplace(stepper_.space(), rate.M, gravity, stepper_.end(), contacts);
  rate.force.emplace(stepper_.space(), *rate.load);
}

petsc::Matrix ParameterRates::redistributed_mass_rate(const scene::Scene& scene,
                                                      std::span<const double> values, std::size_t j) const {
  // Central differences of order 6, whose error for steps of a thousandth of the obstacle's own scale is
  // 1e-18, below their rounding of 1e-13.
  constexpr std::array weights{45.0 / 60, -9.0 / 60, 1.0 / 60};
  constexpr double thousandth = 1e-3;
  const scene::Scene now = scene::with_values(scene, values);
  const contact::Obstacle obstacle(now.contacts[scene::contact_of(scene, scene.unknowns[j])].obstacle.value(),
                                   "obstacle", stepper_.space().dim(), stepper_.pairs()->diameter(),
                                   stepper_.space().mesh().axisymmetric());
  const double radius = obstacle.place(0).radius, h = thousandth * (std::isfinite(radius) ? radius : 1);
  const petsc::Matrix M = fem::assemble_mass(stepper_.space(), now.materials);
  petsc::Matrix rate;
  check(MatDuplicate(M, MAT_DO_NOT_COPY_VALUES, rate.put()));
  for (std::size_t i = 0; i < weights.size(); ++i)
    for (const double side : {-1.0, 1.0}) {
      std::vector<double> beside(values.begin(), values.end());
      beside[j] += side * static_cast<double>(i + 1) * h;
      const contact::ContactPairs pairs(stepper_.space(), stepper_.clamped(),
                                        scene::with_values(scene, beside).contacts, scene.time);
      const petsc::Matrix moved = contact::redistributed_mass(
          contact::velocity_extrapolation(stepper_.space(), pairs, scene.contacts, M), M);
      check(MatAXPY(rate, side * weights[i] / h, moved, DIFFERENT_NONZERO_PATTERN));
    }
  return symmetric_half(rate);
}

void ParameterRates::add_obstacle(const scene::Scene& scene, std::span<const double> values, std::size_t j,
                                  Rate& rate) const {
  rate.obstacle = static_cast<int>(scene::contact_of(scene, scene.unknowns[j]));
  rate.obstacle_rate = scene::obstacle_rate(scene, values, j);
  rate.pairs = stepper_.pairs()->rates(rate.obstacle, rate.obstacle_rate);
  if (rate.turns() && scene.contacts[rate.obstacle].massless()) {
    rate.M = redistributed_mass_rate(scene, values, j);
    add_gravity(scene::with_values(scene, values), rate); // of the mass that moves from node to node
  }
}

void ParameterRates::add_rigid_body(const scene::Scene& scene, const scene::Unknown& unknown,
                                    Rate& rate) const {
  const fem::Space& space = stepper_.space();
  const std::vector<scene::Contact> contacts = scene::rigid_body_rate(scene, unknown);
  const std::vector<fem::VirtualNode> nodes =
      contact::virtual_nodes(contacts, space.dim(), space.mesh().axisymmetric());
  rate.M = fem::assemble_virtual(space, nodes, fem::Form::m);
  rate.A = fem::assemble_virtual(space, nodes, fem::Form::a);
  rate.B = fem::assemble_virtual(space, nodes, fem::Form::b);
  if (rate.M)
    add_gravity(scene, rate, contacts);
  if (unknown.of == scene::Parameter::rigid_velocity) {
    rate.v0 = space.vector();
    contact::RigidMotion(space, contacts, scene::contact_of(scene, unknown)).set_velocity(rate.v0);
  }
}

void ParameterRates::add_initial(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const {
  const bool velocity = unknown.of == scene::Parameter::velocity;
  scene::Components field = velocity ? *scene.initial.velocity : *scene.initial.displacement;
  if (unknown.component)
    for (std::size_t c = 0; c < field.size(); ++c)
      field[c] = static_cast<scene::Component>(c) == *unknown.component ? 1.0 : 0.0;
  petsc::Vector& x = velocity ? rate.v0 : rate.y0;
  x = stepper_.space().vector();
  stepper_.space().interpolate({field, velocity ? "initial.velocity" : "initial.displacement", false}, 0, x);
  stepper_.clamped().clear(x);
  if (velocity)
    stepper_.extrapolate(x, work_);
}

void ParameterRates::add_load(const scene::Scene& scene, std::span<const double> values,
                              const scene::Unknown& unknown, Rate& rate) const {
  scene::Load load;
  std::vector<scene::Contact> contacts; // with weight
  if (unknown.of == scene::Parameter::body) {
    load.body = scene.load->body;
  } else if (unknown.of == scene::Parameter::gravity) {
    load.gravity = scene.load->gravity;
    contacts = scene::with_values(scene, values).contacts;
    for (scene::Contact& contact : contacts)
      if (contact.rigid)
        contact.rigid->force.reset();
  } else {
    std::ranges::copy_if(scene.load->tractions, std::back_inserter(load.tractions),
                         [&](const scene::Traction& one) { return scene::scales(unknown, one); });
  }
  rate.load.emplace(stepper_.space(), stepper_.M(), load, stepper_.end(), contacts);
  rate.force.emplace(stepper_.space(), *rate.load);
}

bool ParameterRates::turn() const {
  return std::ranges::any_of(rates_, [](const auto& rate) { return rate->turns(); });
}

void ParameterRates::set(const StepMade& made) {
  made_.emplace(made);
  if (turn())
    stepper_.pairs()->rows().spread(made.contact, lambda_);
  const Scheme scheme = made.step.scheme();
  check(VecWAXPY(sum_, 1, made.from.y(), made.to.y()));
  check(VecWAXPY(difference_, -1, made.from.y(), made.to.y()));
  jumps_ = stepper_.predictor() && !made.contact.predictor.empty();
  Vec momentum = made.from.v();
  if (jumps_) { // z − x, by the update of the velocity
    check(VecWAXPY(jump_, 1, made.from.v(), made.to.v()));
    check(VecAYPX(jump_, -1 / scheme.rate(), difference_));
    stepper_.clamped().clear(jump_);
    check(VecWAXPY(inertia_, scheme.jump_rate(), jump_, momentum));
    momentum = inertia_;
  }
  if (motion_) {
    stepper_.moving_clamps()->evaluate(made.step, *motion_);
    momentum = stepper_.moving_clamps()->starting_velocity(*motion_, made.from.y(), momentum);
  }
  check(VecAXPBY(inertia_, scheme.momentum(), 0, momentum));
  check(VecAXPY(inertia_, -1, difference_));
  if (jumps_ && turn()) {
    check(MatMult(stepper_.M(), jump_, work_));
    check(VecScale(work_, -1)); // H ζ = −M j
    stepper_.pairs()->rows().multipliers(made.contact.predictor, work_, zeta_);
  }
}

/// Calls add(matrix, factor, vector) for each product of a matrix that s_kj contains.
template <class Add>
void ParameterRates::for_each_product(const Rate& rate, const Scheme& scheme, Add&& add) {
  if (rate.A)
    add(rate.A, -scheme.stiffness(), sum_);
  if (rate.B)
    add(rate.B, -scheme.tau / 2, difference_);
  if (rate.M)
    add(rate.M, 1, inertia_);
  if (rate.relaxing)
    rate.relaxing->for_each_product({scheme, sum_, difference_, made_->from}, combination_,
                                    [&](Mat matrix, Vec x) { add(matrix, 1, x); });
}

void ParameterRates::add_step_source(std::size_t j, Vec sum) {
  const Rate& rate = *rates_[j];
  const Scheme scheme = made_->step.scheme();
  for_each_product(rate, scheme, [&](Mat matrix, double factor, Vec x) {
    check(MatMult(matrix, x, work_));
    check(VecAXPY(sum, factor, work_));
  });
  if (rate.force) {
    assemble(rate.force->at(made_->step), stepper_.operators(), work_);
    check(VecAXPY(sum, scheme.impulse(), work_));
  }
  if (rate.turns())
    rate.pairs->rows->apply(-1, lambda_, sum);
}

void ParameterRates::add_branch_source(std::size_t j, const State& sum) {
  if (const auto& relaxing = rates_[j]->relaxing)
    relaxing->add_branches({made_->step.scheme(), sum_, difference_, made_->from}, sum);
}

double ParameterRates::pairing(std::size_t j, Vec p, const petsc::Series& z) {
  const Rate& rate = *rates_[j];
  const Scheme scheme = made_->step.scheme();
  double sum = 0;
  for_each_product(rate, scheme, [&](Mat matrix, double factor, Vec x) {
    check(MatMult(matrix, x, work_));
    sum += factor * petsc::dot(p, work_);
  });
  if (rate.relaxing)
    sum += rate.relaxing->branch_pairing({scheme, sum_, difference_, made_->from}, z, combination_, work_);
  if (rate.force) {
    const NodalForce force = rate.force->at(made_->step);
    if (force.density) {
      check(MatMult(*stepper_.operators().W, force.density, work_));
      sum += scheme.impulse() * petsc::dot(p, work_);
    }
    if (force.vector)
      sum += scheme.impulse() * petsc::dot(p, force.vector);
  }
  if (rate.turns()) {
    rate.pairs->rows->apply_transpose(p, components_);
    for (int i : made_->contact.active)
      sum -= lambda_[i] * components_[i];
  }
  return sum;
}

bool ParameterRates::constraint(std::size_t j, std::span<double> c) {
  Rate& rate = *rates_[j];
  if (rate.surface_velocity) {
    std::ranges::fill(c, 0);
    stepper_.pairs()->add_surface_ways(rate.obstacle, *rate.surface_velocity, made_->step.begin,
                                       made_->step.end, c);
    return true;
  }
  if (!rate.pairs)
    return false;
  stepper_.pairs()->set_time(rate.obstacle, rate.obstacle_rate, made_->step.end, *rate.pairs);
  std::ranges::fill(c, 0); // of tangential rows
  std::ranges::copy(rate.pairs->psi, c.begin());
  if (rate.turns()) {
    rate.pairs->rows->apply_transpose(made_->to.y(), components_);
    for (std::size_t i = 0; i < c.size(); ++i)
      c[i] -= components_[i];
  }
  return true;
}

bool ParameterRates::law(std::size_t j, std::span<double> c) const {
  const Rate& rate = *rates_[j];
  if (!rate.friction)
    return false;
  const contact::ContactPairs& pairs = *stepper_.pairs();
  const contact::ContactLinearisation& contact = made_->contact;
  std::ranges::fill(c, 0);
  std::size_t at = 0;
  for (std::size_t n = 0; n < contact.active.size(); ++n) {
    const int i = contact.active[n];
    const std::size_t k = pairs.rows().size(i);
    if (pairs.obstacles()[i] == rate.obstacle &&
        contact.equations[n].motion == contact::Motion::slips) // σ = s d, s proportional to the unknown
      for (std::size_t row = 1; row < k; ++row)
        for (std::size_t other = 1; other < k; ++other)
          c[pairs.rows().row(i, row)] +=
              contact.equations[n].F[row * k + other] * contact.forces[at + other] / rate.friction_value;
    at += k;
  }
  return true;
}

bool ParameterRates::predictor(std::size_t j, Vec r, std::span<double> e) {
  const Rate& rate = *rates_[j];
  if (!jumps_ || (!rate.M && !rate.pairs))
    return false;
  check(VecZeroEntries(r));
  std::ranges::fill(e, 0);
  if (rate.M) {
    check(MatMult(rate.M, jump_, r));
    check(VecScale(r, -1));
  }
  if (!constraint(j, e))
    return true;
  if (rate.turns()) { // ν·z in place of ν·y_k, z = y + τ v + j
    rate.pairs->rows->apply(-1, zeta_, r);
    check(VecWAXPY(work_, made_->step.tau, made_->from.v(), made_->from.y()));
    check(VecAXPY(work_, 1, jump_));
    rate.pairs->rows->apply_transpose(work_, components_);
    for (std::size_t i = 0; i < e.size(); ++i)
      e[i] = rate.pairs->psi[i] - components_[i];
  }
  return true;
}

const contact::ConstraintRows* ParameterRates::rows(std::size_t j) const {
  return rates_[j]->turns() ? &*rates_[j]->pairs->rows : nullptr;
}

Vec ParameterRates::displacement(std::size_t j) const { return rates_[j]->y0; }
Vec ParameterRates::velocity(std::size_t j) const { return rates_[j]->v0; }

} // namespace signorini::step
