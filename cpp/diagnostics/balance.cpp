// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/balance.h"
#include "diagnostics/body_figures.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

namespace signorini::diagnostics {
using petsc::check;
using petsc::dot;

namespace {

using Components = std::array<double, 3>;

/// Sets `force` to the contact forces on the body, −(2/τ²) Σ λ_i ν_i (N). Clamped components are included;
/// contact forces in these act on the clamps alone.
void contact_forces(const step::Stepper& stepper, const step::Scheme& scheme,
                    const contact::ContactState& contact, Vec force) {
  check(VecZeroEntries(force));
  if (stepper.pairs())
    stepper.pairs()->rows().apply_whole(-1 / scheme.impulse(), contact.lambda, force);
}

} // namespace

/// Sums of a balance. They take one pass over the dofs for each product with a matrix, and one reduction over
/// the ranks.
struct Balance::Sums {
  double kinetic = 0, elastic = 0;               ///< v·Mv and y·Ay
  double momentum_moduli = 0;                    ///< sum of the moduli of Mv
  double internal_moduli = 0;                    ///< sum of the moduli of Ay and of Σ A_j q̄_j
  double viscous = 0;                            ///< w·Bw
  double rigid = 0, rigid_dashpots = 0;          ///< shares of virtual nodes in v·Mv + y·Ay and in w·Bw
  double foundation = 0, dashpots = 0, drag = 0; ///< shares of foundations and drag in y·Ay and w·Bw
  double branches = 0, relaxed = 0;              ///< Σ q_j·A_j q_j and Σ q̄_j·A_j q̄_j/t_j
  double load = 0, contact = 0;                  ///< work of the loads, of contact
  double jump = 0, clamped_jump = 0; ///< products of inertia and the jump, on all dofs and the clamped ones
  double reaction_power = 0;         ///< power of the clamps' reactions
  Components momentum{}, rate{}, applied{}, contact_force{}, reaction{}, surroundings{};

  void add_up(MPI_Comm comm) {
    MPI_Allreduce(MPI_IN_PLACE, this, sizeof(Sums) / sizeof(double), MPI_DOUBLE, MPI_SUM, comm);
  }
};

Balance::Balance(const step::Stepper& stepper, Wanted wanted)
    : stepper_(stepper), reactions_(wanted.reactions) {
  for (petsc::Vector* x : {&Ay0_, &Ay1_, &Mv0_, &Mv1_, &Bw_, &w_, &load_, &force_, &defect_})
    *x = stepper.space().vector();
  if (stepper.operators().surrounded())
    for (petsc::Vector* x : {&foundation0_, &foundation1_, &dashpots_, &drag_})
      *x = stepper.space().vector();
  if (const auto& relaxation = stepper.operators().relaxation)
    branches_.emplace(Branches{petsc::zero_series(w_, relaxation->branches().size()), petsc::zero_like(w_),
                               petsc::zero_like(w_), petsc::zero_like(w_)});
  if (stepper.frictional())
    ways_.resize(stepper.rows());
  if (wanted.other_forces)
    loads_alone_.emplace(step::ForceAtStep(stepper.space(), {wanted.loads}));
}

StepBalance Balance::operator()(const trajectory::Frame& frame) {
  Sums sums;
  StepBalance now;
  std::swap(Ay0_, Ay1_), std::swap(Mv0_, Mv1_), std::swap(foundation0_, foundation1_);
  add_state(frame, sums);
  if (branches_ && frame.step.k == 0) // q_j is zero at the start
    for (const petsc::Vector& force : branches_->forces)
      check(VecZeroEntries(force));
  if (frame.step.k > 0)
    now.load_work = add_step(frame, sums);
  if (frame.step.k > 0 && stepper_.operators().surrounded())
    add_surroundings(sums);
  sums.add_up(stepper_.space().comm());
  now.kinetic_energy = sums.kinetic / 2;
  now.rigid_energy = sums.rigid / 2;
  now.foundation_energy = sums.foundation / 2;
  now.relaxation_energy = sums.branches / 2;
  now.elastic_energy = sums.elastic / 2 - now.foundation_energy;
  for (std::size_t c = 0; c < 3; ++c)
    if (!stepper_.space().translates(c))
      for (Components* resultant : {&sums.momentum, &sums.rate, &sums.applied, &sums.contact_force,
                                    &sums.reaction, &sums.surroundings})
        (*resultant)[c] = 0;
  now.momentum = sums.momentum;
  const double before = std::exchange(energy_, now.energy());
  if (frame.step.k == 0)
    return now;
  const double tau = frame.step.tau;
  if (!loads_alone_)
    now.load_work = sums.load;
  now.foundation_dissipation = tau * sums.dashpots;
  now.drag_dissipation = tau * sums.drag;
  now.rigid_dissipation = tau * sums.rigid_dashpots;
  now.relaxation_dissipation = tau * sums.relaxed;
  if (stepper_.operators().viscous)
    now.viscous_dissipation =
        tau * (sums.viscous - sums.rigid_dashpots) - now.foundation_dissipation - now.drag_dissipation;
  now.external_work = sums.load;
  now.contact_work = sums.contact;
  if (!ways_.empty())
    add_friction(frame, now);
  // Where j = y_k − y_{k−1} − τ (v_{k−1} + v_k)/2 is not zero, the kinetic energy changes by −j·M (v_k −
  // v_{k−1})/τ in addition to the work on y_k − y_{k−1}. On free dofs this is work of contact, since the
  // predictor's jump moves the body without work; on clamped dofs it is work of the clamps' motion.
  if (stepper_.predictor())
    now.contact_work -= sums.jump - sums.clamped_jump;
  if (stepper_.moving_clamps())
    now.external_work += tau * sums.reaction_power - sums.clamped_jump;
  // E_k − E_{k−1} + τ w·Bw + Σ τ/t_j q̄_j·A_j q̄_j − (f_k + s W u_k)·(y_k − y_{k−1}) − F_k·(y_k − y_{k−1})
  // (method.md, section 2)
  now.energy_residual = energy_ - before + tau * sums.viscous + now.relaxation_dissipation -
                        now.external_work - now.contact_work;
  now.contact_force = sums.contact_force;
  // M (v_k − v_{k−1})/τ less loads, contact forces, reactions and forces of the surroundings, summed over the
  // nodes
  for (std::size_t c = 0; c < 3; ++c)
    now.momentum_residual[c] =
        sums.rate[c] - sums.applied[c] - sums.contact_force[c] - sums.reaction[c] - sums.surroundings[c];
  // Internal forces must cancel, and the rate is a difference of momenta.
  now.momentum_scale = length(sums.rate) + length(sums.applied) + length(sums.contact_force) +
                       sums.internal_moduli + sums.momentum_moduli / tau;
  return now;
}

void Balance::add_state(const trajectory::Frame& frame, Sums& sums) {
  check(MatMult(stepper_.operators().A, frame.after.y(), Ay1_));
  check(MatMult(stepper_.M(), frame.after.v(), Mv1_));
  const petsc::ReadArray y(frame.after.y()), v(frame.after.v()), Ay(Ay1_), Mv(Mv1_);
  const auto dim = static_cast<std::size_t>(stepper_.space().dim()),
             mesh = stepper_.space().layout().mesh_dofs();
  for (std::size_t i = mesh; i < y.size(); ++i)
    sums.rigid += v[i] * Mv[i] + y[i] * Ay[i];
  for (std::size_t i = 0; i < mesh;)
    for (std::size_t c = 0; c < dim; ++c, ++i) {
      sums.kinetic += v[i] * Mv[i];
      sums.elastic += y[i] * Ay[i];
      sums.momentum_moduli += std::abs(Mv[i]);
      sums.internal_moduli += std::abs(Ay[i]);
      sums.momentum[c] += Mv[i];
    }
  if (stepper_.operators().foundation_A) {
    check(MatMult(stepper_.operators().foundation_A, frame.after.y(), foundation1_));
    const petsc::ReadArray of_foundation(foundation1_);
    for (std::size_t i = 0; i < y.size(); ++i)
      sums.foundation += y[i] * of_foundation[i];
  }
}

double Balance::add_step(const trajectory::Frame& frame, Sums& sums) {
  const fem::Operators& body = stepper_.operators();
  const double tau = frame.step.tau;
  check(VecWAXPY(w_, -1, frame.before->y(), frame.after.y())); // w is y_k − y_{k−1} until it is divided by τ
  double load_work = 0;
  if (loads_alone_) {
    assemble(loads_alone_->at(frame.step), body, load_);
    load_work = dot(load_, w_);
  }
  check(VecScale(w_, 1 / tau));
  if (branches_)
    add_branches(frame, sums);
  if (body.B)
    check(MatMult(*body.B, w_, Bw_)); // w is (v_{k−1} + v_k)/2 unless there is a jump or a moving clamp
  assemble(frame.load, body, load_);
  contact_forces(stepper_, frame.step.scheme(), frame.contact, force_);
  const petsc::ReadArray y0(frame.before->y()), y1(frame.after.y()), v0(frame.before->v()),
      v1(frame.after.v()), w(w_), Ay0(Ay0_), Ay1(Ay1_), Mv0(Mv0_), Mv1(Mv1_), Bw(Bw_), load(load_),
      force(force_);
  const petsc::WriteArray defect(defect_);
  const auto inertia = [&](std::size_t i) { return (Mv1[i] - Mv0[i]) / tau; };
  const auto jump = [&](std::size_t i) { return tau * (w[i] - (v0[i] + v1[i]) / 2) * inertia(i); };
  const auto dim = static_cast<std::size_t>(stepper_.space().dim()),
             mesh = stepper_.space().layout().mesh_dofs();
  const auto add_work = [&](std::size_t i) {
    const double moved = y1[i] - y0[i];
    sums.viscous += w[i] * Bw[i];
    sums.load += load[i] * moved;
    sums.contact += force[i] * moved;
    sums.jump += jump(i);
  };
  for (std::size_t i = mesh; i < w.size(); ++i) {
    add_work(i);
    sums.rigid_dashpots += w[i] * Bw[i];
    defect[i] = 0;
  }
  for (std::size_t i = 0; i < mesh;)
    for (std::size_t c = 0; c < dim; ++c, ++i) {
      add_work(i);
      sums.rate[c] += inertia(i);
      sums.applied[c] += load[i];
      sums.contact_force[c] += force[i];
      // M (v_k − v_{k−1})/τ + B w + A (y_{k−1} + y_k)/2 + Σ A_j q̄_j − f_k − s W u_k − F_k: the clamps'
      // reaction on the clamped dofs and zero elsewhere. The forces of branches are added below.
      defect[i] = inertia(i) + Bw[i] + (Ay0[i] + Ay1[i]) / 2 - load[i] - force[i];
    }
  if (branches_) {
    const petsc::ReadArray mean(branches_->mean);
    for (std::size_t i = 0; i < w.size(); ++i) {
      defect[i] += mean[i];
      sums.internal_moduli += std::abs(mean[i]);
    }
  }
  for (const int dof : stepper_.clamped().dofs()) {
    const auto i = static_cast<std::size_t>(dof);
    sums.reaction[i % dim] += defect[i];
    sums.reaction_power += defect[i] * w[i];
    sums.clamped_jump += jump(i);
  }
  return load_work;
}

void Balance::add_branches(const trajectory::Frame& frame, Sums& sums) {
  const fem::Relaxation& relaxation = *stepper_.operators().relaxation;
  const double tau = frame.step.tau;
  check(VecZeroEntries(branches_->mean));
  for (const fem::Relaxation::Stiffness& material : relaxation.stiffnesses()) {
    for (const auto& [matrix, product] : {std::pair(Mat(material.shear), Vec(branches_->shear)),
                                          std::pair(Mat(material.bulk), Vec(branches_->bulk))})
      if (matrix)
        check(MatMult(matrix, w_, product));
      else
        check(VecZeroEntries(product));
    const petsc::ReadArray shear(branches_->shear), bulk(branches_->bulk);
    const petsc::WriteArray mean(branches_->mean);
    for (std::size_t j = material.first; j < material.first + material.count; ++j) {
      const fem::Relaxation::Branch& branch = relaxation.branches()[j];
      const auto [gain, decay] = scene::branch_step(tau, branch.time);
      const petsc::ReadArray q0(frame.before->q()[j]), q1(frame.after.q()[j]);
      const petsc::WriteArray force(branches_->forces[j]);
      double energy = 0, relaxed = 0;
      for (std::size_t i = 0; i < force.size(); ++i) {
        // A_j q_j follows the recursion of q_j, so that one product per matrix serves all branches.
        const double before = force[i],
                     after = decay * before + gain * tau * (branch.g * shear[i] + branch.k * bulk[i]);
        energy += q1[i] * after;
        relaxed += (q0[i] + q1[i]) / 2 * (before + after) / 2;
        mean[i] += (before + after) / 2;
        force[i] = after;
      }
      sums.branches += energy;
      sums.relaxed += relaxed / branch.time;
    }
  }
}

void Balance::add_friction(const trajectory::Frame& frame, StepBalance& now) {
  stepper_.pairs()->obstacle_ways(frame.step.begin, frame.step.end, ways_);
  const double impulse = frame.step.scheme().impulse();
  const contact::ContactState& contact = frame.contact;
  for (std::size_t row = contact.status.size(); row < ways_.size(); ++row) { // U_t = −w
    now.friction_work += contact.lambda[row] / impulse * contact.gap[row];
    now.belt_work -= contact.lambda[row] / impulse * ways_[row];
  }
}

void Balance::add_surroundings(Sums& sums) {
  const fem::Operators& body = stepper_.operators();
  if (body.foundation_B)
    check(MatMult(body.foundation_B, w_, dashpots_));
  if (body.drag)
    check(MatMult(body.drag, w_, drag_));
  const petsc::ReadArray w(w_), before(foundation0_), after(foundation1_), dashpots(dashpots_), drag(drag_);
  const auto dim = static_cast<std::size_t>(stepper_.space().dim());
  for (std::size_t i = 0; i < w.size();)
    for (std::size_t c = 0; c < dim; ++c, ++i) {
      sums.dashpots += w[i] * dashpots[i];
      sums.drag += w[i] * drag[i];
      sums.surroundings[c] -= (before[i] + after[i]) / 2 + dashpots[i] + drag[i];
    }
}

namespace {

/// Returns whether the defect a is worse than b; NaN is the worst.
bool worse(double a, double b) { return a > b || (std::isnan(a) && !std::isnan(b)); }

double worst_of(double a, double b) { return worse(b, a) ? b : a; }

/// Returns `value` relative to `whole`; 0 if `value` is not positive.
double part(double value, double whole) { return value <= 0 ? 0 : value / whole; }

/// Returns the largest diagonal entry of the stiffness at the instant of loading, A + Σ A_j. Collective.
double largest_stiffness(const fem::Operators& body) {
  const petsc::Vector diagonal = fem::diagonal(body.A);
  if (body.relaxation)
    for (const fem::Relaxation::Stiffness& material : body.relaxation->stiffnesses()) {
      double g = 0, k = 0;
      for (const fem::Relaxation::Branch& branch :
           body.relaxation->branches().subspan(material.first, material.count))
        g += branch.g, k += branch.k;
      for (const auto& [fraction, matrix] :
           {std::pair(g, Mat(material.shear)), std::pair(k, Mat(material.bulk))})
        if (matrix)
          check(VecAXPY(diagonal, fraction, fem::diagonal(matrix)));
    }
  PetscReal largest = 0;
  check(VecNorm(diagonal, NORM_INFINITY, &largest));
  return largest;
}

/// Returns the norm of the displacements of a state, those of branches included. Collective.
double size_of(const step::State& state) {
  PetscReal size = 0;
  check(VecNorm(state.y(), NORM_2, &size));
  for (const petsc::Vector& q : state.q()) {
    PetscReal one = 0;
    check(VecNorm(q, NORM_2, &one));
    size = std::max(size, one);
  }
  return size;
}

} // namespace

Invariants::Invariants(const step::Stepper& stepper, const BodyFigures& body)
    : stepper_(stepper), stiffness_(largest_stiffness(stepper.operators())), mass_(body.mass),
      crossing_(body.crossing) {}

void Invariants::observe(const trajectory::Frame& frame, const StepBalance& balance) {
  // Rounding of Ay and y·Ay, of A_j q_j and q_j·A_j q_j, limits the accuracy of forces and energies. It is
  // large where strains are small relative to the displacement, as for a stiff body in flight.
  const double size = size_of(frame.after);
  const double rounding_of_forces = 10 * std::numeric_limits<double>::epsilon() * stiffness_ * size,
               rounding = rounding_of_forces * size;
  energy_ = std::max(energy_, balance.energy());
  forces_ = std::max(forces_, balance.momentum_scale);
  now_ = {};
  now_[0] = part(std::abs(balance.energy_residual) - rounding, energy_);
  now_[1] = part(length(balance.momentum_residual) - rounding_of_forces, forces_);
  const double diameter = stepper_.space().mesh().diameter();
  const contact::ContactState& state = frame.contact;
  const double unit = frame.step.k > 0 ? frame.step.scheme().impulse() : 1; // ratio of λ to forces
  for (const double lambda : state.normal_lambda())
    contact_force_ = std::max(contact_force_, std::abs(lambda) / unit);
  const double scale = std::max(contact_force_, std::sqrt(2 * energy_ * mass_) / crossing_);
  for (std::size_t i = 0; i < state.status.size(); ++i) {
    now_[2] = worst_of(now_[2], part(-state.gap[i], diameter));
    now_[3] = worst_of(now_[3], part(-state.lambda[i] / unit, scale));
    now_[4] = worst_of(now_[4], part(std::abs(state.lambda[i] / unit * state.gap[i]), scale * diameter));
  }
  if (stepper_.frictional())
    now_[5] = friction_defect(state, unit, scale);
  for (std::size_t j = 0; j < now_.size(); ++j)
    if (worse(now_[j], defects_[j].worst)) {
      defects_[j].worst = now_[j];
      defects_[j].step = frame.step.k;
    }
}

double Invariants::friction_defect(const contact::ContactState& state, double unit, double scale) const {
  const contact::ConstraintRows& rows = stepper_.pairs()->rows();
  const double diameter = stepper_.space().mesh().diameter();
  double worst = 0;
  for (int i = 0; i < rows.groups(); ++i) {
    if (rows.size(i) == 1)
      continue;
    const std::array<double, 3> rho = rows.of_group(i, state.lambda), U = rows.of_group(i, state.gap);
    const double bound = rows.law(i).bound(state.friction_of(static_cast<std::size_t>(i)), rho[0]) / unit,
                 force = std::hypot(rho[1], rho[2]) / unit, slip = std::hypot(U[1], U[2]),
                 work = (rho[1] * U[1] + rho[2] * U[2]) / unit;
    worst = worst_of(worst, part(force - bound, scale));
    worst = worst_of(worst, part(std::abs(work + bound * slip), std::max(scale, bound) * diameter));
  }
  return worst;
}

double Invariants::complementarity() const {
  return worst_of(worst_of(worst_of(now_[2], now_[3]), now_[4]), now_[5]);
}

std::optional<std::string> Invariants::violation(double tolerance) const {
  std::size_t worst = 0;
  for (std::size_t j = 1; j < now_.size(); ++j)
    if (worse(now_[j], now_[worst]))
      worst = j;
  if (now_[worst] <= tolerance)
    return std::nullopt;
  return fmt::format("{} is {:.2e}, above run.tolerance = {:.0e}", defects_[worst].name, now_[worst],
                     tolerance);
}

} // namespace signorini::diagnostics
