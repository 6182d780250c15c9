// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/measure.h"
#include "accuracy/error_estimate.h"
#include "accuracy/quantities.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/error.h"
#include "base/machine.h"
#include "contact/pressure.h"
#include "diagnostics/balance.h"
#include "diagnostics/contact_forces.h"
#include "diagnostics/largest_stress.h"
#include "diagnostics/warnings.h"
#include "drivers/check/evaluation_point.h"
#include "trajectory/step_control.h"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

namespace signorini::accuracy {
using petsc::check;

namespace {

bool has(const std::vector<Quantity>& wanted, const std::string& name) {
  return std::ranges::any_of(wanted, [&](const Quantity& quantity) { return quantity.name == name; });
}

/// Samples a field at the sample points and times, in ascending order of time.
class Series {
public:
  Series(const SamplePoints& samples, const fem::Space& space)
      : samples_(samples), sampler_(space, samples.body.points), here_(space.vector()) {
    values_.reserve(samples.times.size() * samples.body.weights.size() *
                    static_cast<std::size_t>(space.dim()));
  }

  /// Takes the samples at all times up to t1 (s) that have not been taken; all remaining ones if `last`.
  /// `at(t, out)` evaluates the field at time t, up to t1.
  template <class At>
  void take_until(double t1, bool last, At&& at) {
    const double reach = last ? std::numeric_limits<double>::infinity() : t1;
    while (next_ < samples_.times.size() && samples_.times[next_] <= reach) {
      at(std::min(samples_.times[next_], t1), here_);
      const std::vector<double> values = sampler_(here_);
      values_.insert(values_.end(), values.begin(), values.end());
      ++next_;
    }
  }

  std::vector<double> take() {
    samples_.scale(values_);
    return std::move(values_);
  }

private:
  const SamplePoints& samples_;
  fem::Sampler sampler_;
  petsc::Vector here_;
  std::size_t next_ = 0;
  std::vector<double> values_;
};

/// Measures the requested quantities of a motion frame by frame.
class Watch {
public:
  Watch(const problem::Problem& problem, const SamplePoints& samples, const std::vector<Quantity>& wanted)
      : problem_(problem), wanted_(wanted), weigh_(problem.stepper),
        warnings_(problem.stepper, problem.scene, problem.scene_loads()), contact_(problem.stepper) {
    if (has(wanted, "displacement"))
      displacement_.emplace(samples, problem.space);
    if (has(wanted, "pressure"))
      pressure_.emplace(problem.space, *problem.stepper.pairs(), problem.scene.contacts);
    if (has(wanted, of_stress)) {
      const std::vector<fem::Part> parts = fem::parts(problem.mesh, problem.scene.materials);
      fields_.emplace(problem.space, parts);
      stress_.emplace(problem.space, parts);
    }
  }

  void operator()(const trajectory::Frame& frame) {
    warnings_.observe(frame);
    const diagnostics::StepBalance balance = weigh_(frame);
    const double tau = frame.step.tau, t = frame.step.end;
    energy_ = std::max(energy_, balance.energy());
    contact_loss_ -= balance.contact_work - balance.friction_work - balance.belt_work;
    contact_(frame);
    if (displacement_)
      displacement_->take_until(t, frame.last, [&](double at, Vec y) {
        // Within a step y is quadratic and v linear, except for the jump of a projected predictor.
        const double s = frame.step.k == 0 ? 1 : 1 + (at - t) / tau;
        check(VecCopy(frame.after.y(), y));
        if (frame.step.k > 0 && s < 1) {
          check(VecAXPBY(y, 1 - s, s, frame.before->y()));
          check(VecAXPY(y, -tau / 2 * s * (1 - s), frame.after.v()));
          check(VecAXPY(y, tau / 2 * s * (1 - s), frame.before->v()));
        }
      });
    if (stress_) {
      fields_->set(frame.after.y(), frame.after.v(), frame.after.q());
      stress_->observe(*fields_, frame.after, t);
    }
    if (pressure_ && frame.step.k > 0) {
      constexpr std::size_t kept = 2;
      if (last_forces_.size() == kept)
        last_forces_.erase(last_forces_.begin());
      const std::span<const double> lambda = frame.contact.normal_lambda();
      last_forces_.emplace_back(lambda.begin(), lambda.end());
    }
  }

  void report(Measured& measured) {
    if (displacement_)
      measured.fields["displacement"] = displacement_->take();
    std::map<std::string, double> numbers = contact_.numbers(problem_.scene.time.end);
    numbers["energy_loss"] = energy_ > 0 ? contact_loss_ / energy_ : 0;
    for (const auto& [name, value] : numbers)
      if (has(wanted_, name))
        measured.numbers[name] = value;
    if (pressure_)
      measured.numbers["pressure"] = pressure_error();
    measured.warnings = warnings_.warnings();
    if (stress_) {
      measured.numbers[of_stress] = stress_->peak()->stress.largest.value;
      std::ranges::move(stress_->warnings(), std::back_inserter(measured.warnings));
    }
  }

private:
  /// Relative error of the contact pressure in L2 of the contact surface. The pressure is the mean of the
  /// last two steps, since the forces of single steps alternate.
  [[nodiscard]] double pressure_error() const {
    const scene::Field exact({*problem_.scene.exact->pressure}, "exact.pressure", false);
    const std::vector<double>& points = problem_.stepper.pairs()->points();
    std::vector<double> mean(points.size() / 3, 0.0);
    for (const std::vector<double>& force : last_forces_)
      for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] += force[i] / static_cast<double>(last_forces_.size());
    const std::vector<double> found = (*pressure_)(mean, problem_.grid.scheme(problem_.steps()).impulse());
    double error = 0, size = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double area = pressure_->area()[i];
      if (area <= 0)
        continue;
      double p = 0;
      exact.evaluate(&points[3 * i], 0, &p);
      error += area * (found[i] - p) * (found[i] - p);
      size += area * p * p;
    }
    return std::sqrt(error / size);
  }

  const problem::Problem& problem_;
  const std::vector<Quantity>& wanted_;
  diagnostics::Balance weigh_;
  diagnostics::StepWarnings warnings_;
  diagnostics::ContactFigures contact_;
  std::optional<Series> displacement_;
  std::optional<contact::Pressure> pressure_;
  std::optional<fem::CellFields> fields_;
  std::optional<diagnostics::LargestStress> stress_;
  std::vector<std::vector<double>> last_forces_;
  double energy_ = 0, contact_loss_ = 0;
};

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
  Series series(samples, problem.space);
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
  Watch watch(problem, samples, wanted);
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
