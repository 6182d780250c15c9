#include "forward/balance.h"
#include <cmath>

namespace signorini::forward {
using petsc::check;
using petsc::dot;

namespace {

/// Component sums of a vector of V over all nodes.
std::array<double, 3> resultant(const Stepper& stepper, Vec x) {
  std::array<double, 3> sum{};
  {
    const petsc::ReadArray values(x);
    const auto dim = static_cast<std::size_t>(stepper.space().dim());
    for (std::size_t i = 0; i < values.size(); ++i)
      sum[i % dim] += values[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, stepper.space().comm());
  return sum;
}

double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

/// F_k = −(2/τ²) N λ_k: the contact forces on the body (N).
void contact_forces(const Stepper& stepper, const contact::ContactState& contact, Vec force) {
  check(VecZeroEntries(force));
  if (stepper.constraints())
    stepper.constraints()->add_normal(-1 / stepper.scheme().impulse(), contact.lambda, force);
}

} // namespace

std::vector<StepBalance> balance(const Stepper& stepper, const Load& load_of, const Trajectory& trajectory) {
  const fem::Operators& body = stepper.operators();
  const double tau = stepper.scheme().tau;
  std::vector<StepBalance> steps(static_cast<std::size_t>(trajectory.steps) + 1);
  Vec layout = trajectory.y[0];
  petsc::Vector Ay0 = petsc::zero_like(layout), Ay1 = petsc::zero_like(layout),
                Mv0 = petsc::zero_like(layout), Mv1 = petsc::zero_like(layout), Bw = petsc::zero_like(layout),
                w = petsc::zero_like(layout), load = petsc::zero_like(layout),
                force = petsc::zero_like(layout), inertia = petsc::zero_like(layout),
                defect = petsc::zero_like(layout);
  const LoadAtStep load_at(stepper.space(), load_of);
  for (int k = 0; k <= trajectory.steps; ++k) {
    StepBalance& now = steps[static_cast<std::size_t>(k)];
    Vec y1 = trajectory.y[k], v1 = trajectory.v[k];
    std::swap(Ay0, Ay1), std::swap(Mv0, Mv1);
    check(MatMult(body.A, y1, Ay1));
    check(MatMult(body.M, v1, Mv1));
    now.kinetic_energy = dot(v1, Mv1) / 2;
    now.elastic_energy = dot(y1, Ay1) / 2;
    if (k == 0)
      continue;
    const StepBalance& before = steps[static_cast<std::size_t>(k) - 1];
    check(VecWAXPY(w, -1, trajectory.y[k - 1], y1)); // w holds y_k − y_{k−1} until it is divided by τ
    const StepLoad parts = load_at(k);
    check(VecZeroEntries(load));
    if (parts.density)
      check(MatMult(body.W, parts.density, load));
    if (parts.force)
      check(VecAXPY(load, 1, parts.force));
    contact_forces(stepper, trajectory.contact[k], force);
    now.external_work = dot(load, w);
    now.contact_work = dot(force, w);
    check(VecScale(w, 1 / tau));
    check(VecZeroEntries(Bw));
    if (body.B) {
      check(MatMult(*body.B, w, Bw)); // w is also the mean of v_{k−1} and v_k
      now.viscous_dissipation = tau * dot(w, Bw);
    }
    // Crank–Nicolson form: its defect is the clamp's reaction on the clamped dofs and zero elsewhere.
    check(VecWAXPY(inertia, -1, Mv0, Mv1));
    check(VecScale(inertia, 1 / tau));
    check(VecCopy(inertia, defect));
    check(VecAXPY(defect, 1, Bw));
    check(VecAXPBYPCZ(defect, 0.5, 0.5, 1, Ay0, Ay1));
    check(VecAXPY(defect, -1, load));
    check(VecAXPY(defect, -1, force));
    const std::array<double, 3> whole = resultant(stepper, defect);
    const double reaction_work = stepper.motion() ? tau * dot(defect, w) : 0;
    stepper.clamped().clear(defect);
    if (stepper.motion())
      now.external_work += reaction_work - tau * dot(defect, w);
    now.energy_residual = now.kinetic_energy + now.elastic_energy - before.kinetic_energy -
                          before.elastic_energy + now.viscous_dissipation - now.external_work -
                          now.contact_work;
    const std::array<double, 3> free = resultant(stepper, defect);
    const std::array<double, 3> rate = resultant(stepper, inertia), applied = resultant(stepper, load);
    now.contact_force = resultant(stepper, force);
    for (std::size_t c = 0; c < 3; ++c)
      now.momentum_residual[c] = rate[c] - applied[c] - now.contact_force[c] - (whole[c] - free[c]);
    PetscReal internal = 0;
    check(VecNorm(Ay1, NORM_1, &internal)); // the internal forces, whose sum must cancel
    now.momentum_scale = length(rate) + length(applied) + length(now.contact_force) + internal;
  }
  return steps;
}

} // namespace signorini::forward
