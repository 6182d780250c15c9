// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/measure.h"
#include "accuracy/error_estimate.h"
#include "accuracy/motion_quantities.h"
#include "accuracy/quantities.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/error.h"
#include "base/machine.h"
#include "drivers/check/evaluation_point.h"
#include "trajectory/step_control.h"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

namespace signorini::accuracy {
using petsc::check;

namespace {

/// Total seconds of the phases that every run needs, such as meshing, factorisation and sweeps.
double seconds(const Timers& timers) {
  double sum = 0;
  for (const char* phase : {"mesh", "assembly", "solver", "desired state", "forward", "objective", "adjoint",
                            "states written", "states read", "states recomputed", "lengths of steps"})
    if (const auto found = timers.entries().find(phase); found != timers.entries().end())
      sum += found->second.seconds;
  return sum;
}

std::vector<double> sampled(const problem::Problem& problem, const SamplePoints& samples,
                            const control::ControlSpace& controls, const control::Control& g) {
  SampledField series(samples, problem.space);
  std::vector<double> mean(controls.size());
  const int n = g.count();
  const auto middle = [&](int j) { return controls.begin(j) + controls.length(j) / 2; };
  for (int j = 1; j <= n; ++j) // values in the middle of intervals, linear in between, constant beyond
    series.take_until(middle(j), j == n, [&](double t, Vec out) {
      const double s = j == 1 ? 1 : std::clamp((t - middle(j - 1)) / (middle(j) - middle(j - 1)), 0.0, 1.0);
      for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] = s < 1 ? s * g.at(j)[i] + (1 - s) * g.at(j - 1)[i] : g.at(j)[i];
      controls.extend(mean, out);
    });
  return series.take();
}

} // namespace

void simulate(problem::Problem& problem, const step::ForceAtStep& load,
              const trajectory::StepObserver& watch) {
  const auto timer = problem.timers.time("forward");
  const auto take = [&](const trajectory::Frame& frame) {
    const auto other = problem.timers.time("watching");
    watch(frame);
  };
  int done = 0;
  if (problem.grid.complete()) {
    done = trajectory::integrate(problem.stepper, problem.grid, problem.initial, load, take);
  } else {
    trajectory::StepControl control(problem.stepper, problem.scene);
    problem.grid = trajectory::integrate_choosing(problem.stepper, problem.initial, load, control, take);
    done = problem.steps();
  }
  if (!problem.grid.complete() || done < problem.steps())
    throw Interrupted();
}

SamplePoints::SamplePoints(MPI_Comm comm, const scene::Scene& scene) {
  constexpr std::size_t most = 12'000;
  constexpr int intervals = 100;
  scene::Mesh mesh = scene.mesh;
  for (std::size_t before = std::numeric_limits<std::size_t>::max();;) {
    const mesh::Mesh read(comm, mesh);
    dim = read.dim();
    body = fem::quadrature(read);
    digest = read.digest();
    const std::size_t points = body.weights.size();
    if (points <= most || mesh.meshed() || points >= before) // the .geo sets its own density
      break;
    before = points;
    (mesh.size ? *mesh.size : mesh.scale) *= 2;
  }
  for (int j = 0; j <= intervals; ++j)
    times.push_back(scene.time.end * j / intervals);
  digest = Digest().add(digest).add(body.points).add(body.weights).add(times).text();
}

void SamplePoints::scale(std::vector<double>& values) const {
  const std::size_t n = body.weights.size(), components = values.size() / (n * times.size());
  const double interval = times[1] - times[0];
  for (std::size_t j = 0; j < times.size(); ++j)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t c = 0; c < components; ++c)
        values[(j * n + i) * components + c] *=
            std::sqrt(body.weights[i] * (j == 0 || j + 1 == times.size() ? interval / 2 : interval));
}

Exact exact_values(const scene::Scene& scene, const SamplePoints& samples) {
  // Contact with obstacles at rest loses no energy, and the pressure's number already is its error.
  Exact exact{{{"energy_loss", 0}, {"pressure", 0}}, {}};
  if (!scene.exact)
    return exact;
  const auto number = [&](const char* name, const std::optional<double>& value) {
    if (value)
      exact.numbers[name] = *value;
  };
  number("impulse", scene.exact->impulse);
  number("peak_force", scene.exact->peak_force);
  number("contact_start", scene.exact->contact_start);
  number("contact_time", scene.exact->contact_time);
  if (scene.exact->displacement) {
    const scene::Field field(*scene.exact->displacement, "exact.displacement", true);
    const std::size_t n = samples.body.weights.size(), dim = field.size();
    std::vector<double> values(samples.times.size() * n * dim);
    for (std::size_t j = 0; j < samples.times.size(); ++j)
      for (std::size_t i = 0; i < n; ++i)
        field.evaluate(&samples.body.points[3 * i], samples.times[j], &values[(j * n + i) * dim]);
    samples.scale(values);
    exact.fields["displacement"] = std::move(values);
  }
  return exact;
}

Measured measure(MPI_Comm comm, const scene::Scene& scene, const SamplePoints& samples,
                 const std::vector<Quantity>& wanted, bool estimate) {
  forget_peak_memory();
  const double before = resident_memory(); // such as the samples of other rungs
  Measured measured;
  Timers timers;
  problem::Problem problem(comm, scene, problem::study_needs(scene), timers);
  measured.unknowns = problem.free_dofs();
  MotionQuantities watch(problem, wanted, &samples);
  const auto peak = [&] {
    double memory = std::max(0.0, peak_memory() - before);
    MPI_Allreduce(MPI_IN_PLACE, &memory, 1, MPI_DOUBLE, MPI_SUM, comm);
    return memory;
  };
  if (!scene.objective) {
    const problem::GivenControl given(problem);
    simulate(problem, given.load(), std::ref(watch));
    measured.memory = peak();
  } else {
    const Console silent(false, false);
    problem::choose_steps(problem, silent);
    problem::ControlProblem control_problem(problem, silent);
    control::ReducedProblem& reduced = control_problem.reduced;
    std::string where;
    measured.numbers["J"] = reduced.value(drivers::evaluation_point(problem, control_problem, where));
    reduced.accept();
    if (has(wanted, "gradient")) {
      const control::Control g = reduced.l2_gradient();
      measured.memory = peak();
      measured.fields["gradient"] = sampled(problem, samples, control_problem.controls, g);
    } else {
      measured.memory = peak();
    }
    measured.seconds = seconds(timers);
    simulate(problem, reduced.load(), std::ref(watch));
    if (estimate && not_estimated(scene).empty())
      measured.estimate = estimate_error(problem, control_problem);
  }
  measured.steps = problem.steps();
  watch.report(measured);
  if (!scene.objective)
    measured.seconds = seconds(timers);
  MPI_Allreduce(MPI_IN_PLACE, &measured.seconds, 1, MPI_DOUBLE, MPI_MAX, comm);
  return measured;
}

} // namespace signorini::accuracy
