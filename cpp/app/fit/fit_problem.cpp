// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/fit_problem.h"
#include "base/signals.h"
#include "io/fit_tables.h"
#include <cmath>
#include <limits>

namespace signorini {
namespace {

double on_scale(const scene::Unknown& unknown, double value) {
  return unknown.logarithmic() ? std::log(value) : value;
}

/// The bounds of an unknown on its scale: those given, else those of its nature.
std::pair<double, double> bounds_of(const scene::Unknown& unknown) {
  constexpr double nearly = 1e-6; // of limits that are excluded
  const scene::NaturalLimits natural = scene::natural_limits(unknown.of);
  const double inside = natural.open ? nearly : 0;
  double lower = natural.least + inside, upper = natural.greatest - inside;
  if (natural.open && natural.least == 0)
    lower = std::numeric_limits<double>::min(); // in whatever unit
  if (unknown.logarithmic()) {
    // The curvature of J by log θ falls with θ² towards 0, and with 1/θ² towards ∞: beyond the root of the
    // rounding it is rounding of J, and a search sees no minimum any more.
    const double root = std::sqrt(std::numeric_limits<double>::epsilon());
    lower = std::max(lower, root * unknown.start);
    upper = std::min(upper, unknown.start / root);
  }
  lower = unknown.lower.value_or(std::min(lower, unknown.start));
  upper = unknown.upper.value_or(std::max(upper, unknown.start));
  return {on_scale(unknown, lower), on_scale(unknown, upper)};
}

/// The largest change of an unknown on its scale in one step. A change of log θ by −1 takes the linearised
/// θ (1 + δ) to 0, by +1 the linearised 1/θ: a longer one has no meaning.
double longest_step(const scene::Unknown& unknown) {
  return unknown.logarithmic() ? 1 : std::numeric_limits<double>::infinity();
}

} // namespace

FitProblem::FitProblem(std::shared_ptr<const Discretisation> discretisation, const scene::Scene& scene,
                       Timers& timers)
    : scene_(scene), timers_(timers), discretisation_(std::move(discretisation)),
      data_(io::read_data(discretisation_->space.comm(), scene)) {
  for (const control::Data& one : data_)
    count_ += one.times.size();
  for (const scene::Unknown& unknown : scene.unknowns) {
    const auto [lower, upper] = bounds_of(unknown);
    box_.lower.push_back(lower);
    box_.upper.push_back(upper);
    box_.longest.push_back(longest_step(unknown));
  }
}

std::vector<double> FitProblem::values(std::span<const double> x) const {
  std::vector<double> theta;
  for (std::size_t j = 0; j < x.size(); ++j)
    theta.push_back(scene_.unknowns[j].logarithmic() ? std::exp(x[j]) : x[j]);
  return theta;
}

std::vector<double> FitProblem::on_scales(std::span<const double> values) const {
  std::vector<double> x;
  for (std::size_t j = 0; j < values.size(); ++j)
    x.push_back(on_scale(scene_.unknowns[j], values[j]));
  return x;
}

std::vector<double> FitProblem::slopes(std::span<const double> x) const {
  std::vector<double> slopes = values(x);
  for (std::size_t j = 0; j < x.size(); ++j)
    if (!scene_.unknowns[j].logarithmic())
      slopes[j] = 1;
  return slopes;
}

std::vector<std::vector<double>> FitProblem::times() const {
  std::vector<std::vector<double>> times;
  for (const control::Data& one : data_)
    times.push_back(one.times);
  return times;
}

std::vector<scene::TableDoubt> FitProblem::doubts() const {
  std::vector<scene::TableDoubt> all;
  for (const control::Data& one : data_)
    all.insert(all.end(), one.doubts.begin(), one.doubts.end());
  return all;
}

std::vector<double> FitProblem::residuals(const std::vector<double>& simulated,
                                          std::span<const double> x) const {
  std::vector<double> r;
  for (const control::Data& one : data_)
    for (std::size_t k = 0; k < one.times.size(); ++k)
      r.push_back((simulated[r.size()] - one.values[k]) / one.deviations[k]);
  for (std::size_t j = 0; j < x.size(); ++j)
    if (const auto& prior = scene_.unknowns[j].prior)
      r.push_back((x[j] - on_scale(scene_.unknowns[j], prior->mean)) / prior->deviation);
  return r;
}

forward::Stepper::Needs FitProblem::needs() const {
  forward::Stepper::Needs needs = fit_needs(scene_);
  if (iterative_) { // as it was decided, by the clock, for the first values
    needs.passes = 0;
    needs.iterative = *iterative_ && scene_.solver.linear == scene::LinearMethod::automatic;
  }
  return needs;
}

void FitProblem::decide(bool iterates) {
  if (!iterative_)
    iterative_ = iterates;
}

std::vector<double> FitProblem::by_values(const std::vector<double>& residuals) const {
  std::vector<double> derivative;
  for (const control::Data& one : data_)
    for (const double deviation : one.deviations)
      derivative.push_back(residuals[derivative.size()] / deviation);
  return derivative;
}

std::vector<double> FitProblem::on_scale_gradient(std::vector<double> by_theta,
                                                  const std::vector<double>& residuals,
                                                  std::span<const double> x) const {
  const std::vector<double> slope = slopes(x);
  std::size_t next = count_;
  for (std::size_t j = 0; j < x.size(); ++j) {
    by_theta[j] *= slope[j];
    if (const auto& prior = scene_.unknowns[j].prior)
      by_theta[j] += residuals[next++] / prior->deviation;
  }
  return by_theta;
}

/// The problem at x, with what its motion needs.
struct FitProblem::Setup {
  Setup(FitProblem& fit, std::span<const double> x, std::size_t columns,
        forward::Stops stops = forward::Stops::obeyed)
      : theta(fit.values(x)), scene(scene::with_values(fit.scene_, theta)),
        problem(fit.discretisation_, scene, fit.needs(), fit.timers_, stops), given(problem),
        measurements(problem.stepper, problem.grid, scene, fit.times(), columns),
        rates(problem.stepper, fit.scene_, theta) {
    fit.decide(problem.stepper.solver().iterates());
  }

  std::vector<double> theta;
  scene::Scene scene;
  Problem problem;
  GivenControl given;
  control::Measurements measurements;
  forward::ParameterRates rates;
};

optimize::LeastSquares FitProblem::evaluate(std::span<const double> x, const forward::Load* control,
                                            forward::Stops stops) {
  Setup setup(*this, x, 1 + x.size(), stops);
  forward::Tangents tangents(setup.problem.stepper, setup.rates);
  {
    const auto timer = timers_.time("forward");
    const int steps = forward::integrate(
        setup.problem.stepper, setup.problem.grid, setup.problem.initial,
        control ? setup.problem.load(control) : setup.given.load(),
        [&](const forward::Frame& frame) {
          const auto linearised = timers_.time("linearised");
          tangents.observe(frame);
          setup.measurements.observe(frame, tangents, setup.rates);
        },
        stops);
    if (steps < setup.problem.steps())
      throw Interrupted();
  }
  sweeps_ += 1 + static_cast<int>(x.size());
  optimize::LeastSquares found{.residuals = residuals(setup.measurements.values(), x), .jacobian = {}};
  const std::vector<double> slope = slopes(x);
  for (std::size_t j = 0; j < x.size(); ++j) {
    std::vector<double> column = setup.measurements.values(j + 1);
    std::size_t i = 0;
    for (const control::Data& one : data_)
      for (const double deviation : one.deviations)
        column[i++] *= slope[j] / deviation;
    for (std::size_t p = 0; p < x.size(); ++p)
      if (const auto& prior = scene_.unknowns[p].prior)
        column.push_back(p == j ? 1 / prior->deviation : 0);
    found.jacobian.insert(found.jacobian.end(), column.begin(), column.end());
  }
  return found;
}

FitProblem::Gradient FitProblem::swept(std::span<const double> x, bool adjoint) {
  Setup setup(*this, x, 1);
  const forward::StateStoreFactory storage(setup.problem.stepper, setup.problem.grid, scene_.trajectory, 1,
                                           timers_);
  forward::Trajectory motion(setup.problem.stepper, setup.problem.initial, storage, true);
  {
    const auto timer = timers_.time("forward");
    motion.run(setup.given.load(), [&](const forward::Frame& frame) { setup.measurements.observe(frame); });
  }
  if (motion.steps() < setup.problem.steps())
    throw Interrupted();
  ++sweeps_;
  const std::vector<double> r = residuals(setup.measurements.values(), x);
  Gradient found{.value = optimize::LeastSquares{r, {}}.value(),
                 .residuals = r,
                 .by_x = {},
                 .contact = motion.contact()};
  for (const contact::ContactLinearisation& sets : found.contact)
    found.weak += static_cast<long>(sets.weak.size());
  if (!adjoint)
    return found;
  setup.measurements.set_derivative(by_values(r));
  forward::Stepper::Workspace work = setup.problem.stepper.workspace();
  {
    const auto timer = timers_.time("adjoint");
    found.by_x = adjoint::sweep(setup.problem.stepper, work, motion,
                                {setup.problem.space, setup.measurements}, setup.measurements, setup.rates);
  }
  found.by_x = on_scale_gradient(std::move(found.by_x), r, x);
  return found;
}

FitProblem::Gradient FitProblem::gradient(std::span<const double> x) { return swept(x, true); }
FitProblem::Gradient FitProblem::value(std::span<const double> x) { return swept(x, false); }

} // namespace signorini
