// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/info.h"
#include "base/collective.h"
#include "base/machine.h"
#include "base/text.h"
#include "drivers/coarse_start.h"
#include "drivers/run_manifest.h"
#include "drivers/search.h"
#include "io/manifest.h"
#include "optimize/options.h"
#include "scene/parameters.h"
#include "trajectory/approach.h"
#include "trajectory/trajectory.h"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace signorini::app {
namespace {

/// Cost of an effect: matrices, memory, and work per step.
struct Cost {
  std::string matrices{};
  double bytes = 0; ///< memory of the matrices and vectors
  std::string step{};
};

/// Memory of the states and active sets that an optimisation keeps, summed over the ranks, bytes. Active sets
/// count with every candidate active in all steps, their upper bound. Adjoint states are not kept.
double motions_bytes(const problem::Problem& problem) {
  const bool computed = std::holds_alternative<scene::DesiredControl>(problem.scene.objective->desired);
  const scene::Trajectory& kept = problem.scene.trajectory;
  const int controlled = problem.scene.optimizer.method == scene::OptimizerMethod::newton_cg
                             ? 3
                             : 2; // iterate, trial, linearised
  // Kept on every rank: active sets, forces and, with friction, laws and tangential forces.
  const double sets = problem.stepper.predictor() ? 2 : 1;
  const double law = problem.stepper.frictional() ? sizeof(contact::LawEquation) + 2 * sizeof(double) : 0;
  const double candidate = sets * sizeof(int) + sizeof(double) + law;
  const double step =
      sizeof(contact::ContactLinearisation) + candidate * trajectory::candidates(problem.stepper);
  const double contact = step * (problem.steps() + 1) * ranks(problem.space.comm());
  const double states = problem::state_stores(problem).bytes();
  const double in_memory = kept.storage == scene::Storage::memory        ? (controlled + 1) * states
                           : kept.storage == scene::Storage::checkpoints ? (computed ? 2 : 1) * states
                                                                         : 0;
  return in_memory + (computed ? 3 : 2) * contact;
}

/// Describes the recomputed steps or the disk space that storing the states adds to a gradient.
std::string again(const problem::Problem& problem) {
  const scene::Trajectory& kept = problem.scene.trajectory;
  if (kept.storage == scene::Storage::memory)
    return "";
  const bool computed = std::holds_alternative<scene::DesiredControl>(problem.scene.objective->desired);
  const trajectory::StateStoreFactory storage = problem::state_stores(problem);
  if (kept.storage == scene::Storage::disk)
    return fmt::format(" (states on disk: {} for each motion)", bytes_text(storage.bytes()));
  const int slots =
      static_cast<int>(std::lround(storage.bytes() / trajectory::Checkpoint::bytes(problem.stepper)));
  const double made = static_cast<double>(trajectory::steps_made(problem.steps(), slots));
  return fmt::format(", and {:.2f} recomputed steps{} ({} checkpoints)", made / problem.steps() - 1,
                     computed ? " of each motion" : "", slots);
}

/// Costs of effects, by the names that io::effects() gives.
using Costs = std::map<std::string, Cost>;

std::string product_with_density(const fem::Operators& body) {
  return body.uniform_density ? "nothing: included in the product with M" : "a product with W";
}

/// Adds the costs of control and objective.
void add_control(const problem::Problem& problem, Costs& costs) {
  const scene::Scene& scene = problem.scene;
  const fem::Operators& body = problem.operators;
  const control::ControlSpace controls(problem.space, body, problem.grid, *scene.control);
  const bool own = controls.matrix_bytes() > 0;
  costs["control"] = {own ? "its L2" : "W",
                      (own ? controls.matrix_bytes() : petsc::bytes(*body.W)) + 5 * controls.control_bytes(),
                      own ? "a product" : product_with_density(body)};
  if (controls.bounded())
    costs["control bounds"].bytes =
        controls.cellwise()
            ? 0
            : controls.control_bytes() / (scene.control->constant_in_time ? 1 : problem.steps());
  const optimize::Options options = drivers::search_options(controls, scene.optimizer);
  if (scene.optimizer.method == scene::OptimizerMethod::lbfgs)
    costs["control"].bytes +=
        static_cast<double>(std::min(2 * options.lbfgs.pairs, options.vectors)) * controls.compact_bytes();
  costs["objective"] = {scene.objective->on         ? "L2 of objective.on"
                        : scene.objective->obstacle ? "translation of objective.obstacle"
                                                    : "W",
                        motions_bytes(problem),
                        "for a gradient: one adjoint step with one solve" + again(problem)};
}

/// Costs of all effects that add matrices, memory or work.
Costs costs(const problem::Problem& problem) {
  const scene::Scene& scene = problem.scene;
  const fem::Operators& body = problem.operators;
  const step::Stepper& stepper = problem.stepper;
  const double vector = sizeof(PetscScalar) * static_cast<double>(problem.space.dofs());
  Costs costs;
  costs["clamp"].step = "nothing: its unknowns are decoupled in D";
  if (body.B)
    costs["viscosity"] = {"B", petsc::bytes(*body.B), "nothing: included in D and R"};
  const auto if_any = [](Mat matrix) { return matrix ? petsc::bytes(matrix) : 0; };
  // Of an elastic body B has surroundings alone, to which it is counted.
  const double own_B = body.B && !body.viscous ? petsc::bytes(*body.B) : 0;
  costs["mass damping"] = {own_B > 0 && !body.foundation_B ? "B, and its part of B" : "its part of B",
                           if_any(body.drag) + (body.foundation_B ? 0 : own_B),
                           "nothing: included in D and R"};
  if (body.relaxation)
    costs["relaxation"] = {"stiffness that relaxes",
                           body.relaxation->bytes() + static_cast<double>(2 * stepper.branches()) * vector,
                           "at most two products for each material that relaxes"};
  costs["foundation"] = {own_B > 0 && body.foundation_B ? "B, its parts of A, B" : "its parts of A, B",
                         if_any(body.foundation_A) + if_any(body.foundation_B) +
                             (body.foundation_B ? own_B : 0),
                         "nothing: included in D and R"};
  costs["point force"].step = "its values";
  if (stepper.moving_clamps())
    costs["moving clamp"] = {"D without clamps",
                             petsc::bytes(stepper.of_length(stepper.first_length()).whole_D()), "a product"};
  if (const contact::ContactPairs* pairs = stepper.pairs()) {
    if (stepper.frictional())
      costs["friction"] = {fmt::format("{} tangents", pairs->rows().count() - pairs->count()), 0,
                           "Newton steps for stick and slip, in S"};
    costs["contact"] = {
        fmt::format("for {} candidates", pairs->count()), stepper.solver().memory().condensation,
        pairs->rows().act_open() ? "one inequality"
                                 : "without contact: check of the gaps; in contact: one inequality"};
    if (stepper.predictor())
      costs["contact-stabilized"] = {"the factor of M", stepper.predictor_bytes(),
                                     "in contact: one inequality with M"};
    if (const double bytes = stepper.redistribution_bytes(); bytes > 0)
      costs["massless contact"] = {"M redistributed", bytes,
                                   stepper.predictor() ? "velocities of contact nodes"
                                                       : "nothing: included in D and R"};
    if (pairs->moving())
      costs["moving obstacle"].step = "recomputed gaps";
  }
  if (problem.probes)
    costs["probes"].step = fmt::format("{} values", problem.probes->columns().size());
  if (problem.scene_load) {
    const std::string evaluated =
        problem.scene_load->depends_on_time() ? ", evaluated in each step" : ", evaluated once";
    if (scene.load->body)
      costs["body load"] = {"W", petsc::bytes(*body.W) + 2 * vector, product_with_density(body) + evaluated};
    if (scene.load->gravity)
      costs["gravity"] = {"", 2 * vector, "a vector added" + evaluated};
    if (!scene.load->tractions.empty())
      costs["traction"] = {"L2 of the surface", problem.scene_load->surface_bytes() + 3 * vector,
                           "a vector added" + evaluated};
  }
  if (!scene.unknowns.empty()) {
    const auto of_material = std::ranges::count_if(
        scene.unknowns, [](const scene::Unknown& unknown) { return scene::of_material(unknown.of); });
    costs["unknowns"] = {"derivatives",
                         static_cast<double>(of_material) * petsc::bytes(body.A) +
                             static_cast<double>(scene.unknowns.size()) * 2 * vector,
                         fmt::format("in a fit: {} linearised step{}", scene.unknowns.size(),
                                     scene.unknowns.size() == 1 ? "" : "s")};
  }
  costs["measurements"].step = "in a fit: evaluation of the measured quantities";
  if (scene.objective)
    add_control(problem, costs);
  return costs;
}

struct StepTimes {
  double free = 0, contact = 0, adjoint = 0; ///< seconds of a step without contact, with it, and adjoint
  int free_steps = 0, contact_steps = 0;
};

/// Times `steps` forward steps from the initial state and, if the scene has an objective, as many adjoint
/// steps with the active set of the last forward step.
StepTimes time_steps(const problem::Problem& problem, int steps) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  StepTimes times;
  const problem::GivenControl given(problem);
  step::Stepper::Workspace work = problem.stepper.workspace();
  step::AdjointState state = problem.stepper.adjoint_state();
  const int last = std::max(1, problem.steps() - 1); // with a step after it
  auto start = Clock::now();
  trajectory::integrate(
      problem.stepper, problem.grid.first(steps), problem.initial, given.load(),
      [&](const trajectory::Frame& frame) {
        const double seconds = seconds_since(start);
        const bool touches = !frame.contact.closed_set().empty();
        if (frame.step.k > 0) {
          (touches ? times.contact : times.free) += seconds;
          ++(touches ? times.contact_steps : times.free_steps);
        }
        if (frame.last && problem.scene.objective) {
          petsc::check(VecCopy(frame.after.y(), state.p_next));
          const auto at = [&](int k) { return step::StepContact{problem.grid.scheme(k), frame.contact}; };
          start = Clock::now();
          for (int k = 0; k < steps; ++k)
            problem.stepper.adjoint_step(
                {at(std::min(k + 1, last)), at(std::min(k + 2, last + 1)), {}, state}, work);
          times.adjoint = seconds_since(start) / steps;
        }
        start = Clock::now();
      });
  times.free /= std::max(times.free_steps, 1);
  times.contact /= std::max(times.contact_steps, 1);
  return times;
}

std::string estimate(const problem::Problem& problem, int timed_steps) {
  const int steps = std::min(timed_steps, problem.steps());
  const StepTimes times = time_steps(problem, steps);
  const double all = times.free * times.free_steps + times.contact * times.contact_steps;
  std::string text = fmt::format("{} steps timed:", steps);
  if (times.free_steps)
    text += fmt::format(" {:.3g} ms per step without contact", 1e3 * times.free);
  if (times.contact_steps)
    text += fmt::format("{} {:.3g} ms per step in contact ({} steps)", times.free_steps ? "," : "",
                        1e3 * times.contact, times.contact_steps);
  const double sweep = all / steps * problem.steps();
  text += fmt::format("\n{} {} steps: {:.2g} s", problem.scene.time.until_bounce ? "at most" : "all",
                      problem.steps(), sweep);
  if (problem.scene.objective)
    text += fmt::format("; with the adjoint sweep, as in each iteration of optimize: {:.2g} s",
                        sweep + times.adjoint * problem.steps());
  if (problem.stepper.pairs() && !times.contact_steps)
    text += "\n(none of the timed steps was in contact; steps in contact take longer)";
  return text;
}

/// Describes the peak memory of the ranks. Collective.
std::string memory_of_ranks(MPI_Comm comm) {
  double least = peak_memory(), most = least, all = least;
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, comm);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm);
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_DOUBLE, MPI_SUM, comm);
  if (ranks(comm) == 1)
    return bytes_text(all);
  return fmt::format("{} in all, {} to {} on each of {} ranks", bytes_text(all), bytes_text(least),
                     bytes_text(most), ranks(comm));
}

/// Describes the coarse meshes on which optimize starts; empty if there are none.
std::string coarse_levels(const problem::Problem& problem) {
  std::string sizes;
  for (const int multiple : drivers::coarse_multiples(problem))
    sizes += fmt::format("{}{:.4g} m", sizes.empty() ? "" : ", then ", *problem.scene.mesh.size * multiple);
  return sizes;
}

} // namespace

void print_info(problem::Problem& problem, int timed_steps, const Console& console) {
  problem::choose_steps(problem, console);
  const fem::Operators& body = problem.operators;
  const step::Stepper& stepper = problem.stepper;
  console.line(fmt::format(
      "{}: unknowns: {} ({} free), cells: {}, candidates: {}, steps: {}{} of {}\nsolver: {}",
      problem.scene.name, problem.space.dofs(), problem.free_dofs(), problem.mesh.cells(),
      trajectory::candidates(stepper), problem.scene.time.until_bounce ? "at most " : "", problem.steps(),
      problem.grid.equal() ? fmt::format("{} s", problem.scene.time.step) : "varying length",
      stepper.solver().choice()));
  console.line(drivers::body_lines(problem));
  for (const std::string& line : trajectory::first_touch_lines(stepper, problem.scene))
    console.line(line);
  if (stepper.pairs() && !problem.scene.time.automatic())
    console.line(fmt::format("a pressure wave crosses an element in contact in {:.3g} s: a good first "
                             "time.step for impacts is half of it",
                             stepper.wave_time()));
  console.line(fmt::format("memory for the whole run: matrices M {}, A {}, R {}, {} {}. Each step takes one "
                           "solve with D and products with R and M",
                           bytes_text(petsc::bytes(body.M)), bytes_text(petsc::bytes(body.A)),
                           bytes_text(petsc::bytes(stepper.of_length(stepper.first_length()).R())),
                           stepper.solver().tolerance() > 0 ? "D and its preconditioner" : "the factor of D",
                           bytes_text(stepper.solver().memory().factor)));
  console.line(
      "M: mass, A: elasticity, B: viscosity, W: mass for density 1; a step of length τ solves D y = R "
      "y_before + τ M v_before + forces\n");
  constexpr const char* row = "{:<22}{:<24}{:>10}   {}";
  console.line(fmt::format(row, "effects", "adds matrices", "memory", "adds in each step"));
  Costs all = costs(problem);
  std::string off;
  for (const auto& [name, on] : io::effects(problem.scene)) {
    if (!on) {
      off += (off.empty() ? "" : ", ") + name;
      continue;
    }
    const Cost& cost = all[name];
    const std::string line =
        fmt::format(row, name, cost.matrices, cost.bytes > 0 ? bytes_text(cost.bytes) : "", cost.step);
    console.line(line.substr(0, line.find_last_not_of(' ') + 1));
  }
  console.line(fmt::format("off: {}", off.empty() ? "none" : off));
  double setup = 0;
  for (const auto& [phase, entry] : problem.timers.entries())
    setup += entry.seconds;
  if (const std::string levels = coarse_levels(problem); !levels.empty())
    console.line(fmt::format("optimize starts on coarser meshes, of size {}", levels));
  console.line(
      fmt::format("\nset-up took {:.2g} s; peak memory {}", setup, memory_of_ranks(problem.space.comm())));
  console.line(timed_steps > 0 ? estimate(problem, timed_steps) : "to estimate the run time, add --time 20");
}

} // namespace signorini::app
