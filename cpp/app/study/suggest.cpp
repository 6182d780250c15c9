#include "app/study/density.h"
#include "app/study/measure.h"
#include "app/study/study.h"
#include "base/error.h"
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace signorini::study {
namespace {

/// A run and its estimated error relative to J, in two parts: that of the mesh and that of the steps.
struct Trial {
  Rung rung;
  adjoint::ErrorParts parts;
  double seconds;
  [[nodiscard]] double error() const { return parts.sum_of_moduli(); }
  [[nodiscard]] double time() const { return std::abs(parts.time); }
  [[nodiscard]] double space() const { return error() - time(); }
};

std::string listed(const adjoint::ErrorParts& parts) {
  std::string text = fmt::format("space {:+.2e}, time {:+.2e}", *parts.space, parts.time);
  if (parts.initial != 0)
    text += fmt::format(", initial data {:+.2e}", parts.initial);
  if (parts.desired != 0)
    text += fmt::format(", desired displacement {:+.2e}", parts.desired);
  return text;
}

/// The observed order between two trials, or `otherwise` if they do not determine one.
double order(double coarse, double fine, double ratio, double otherwise) {
  if (!(ratio > 1.1) || !(coarse > 0) || !(fine > 0))
    return otherwise;
  return std::clamp(std::log(coarse / fine) / std::log(ratio), 0.8, 2.5);
}

/// The cheapest size h and step τ for which both parts add up to `target`, with a cost of h^(−dim p) / τ and
/// parts proportional to h^r and τ^q.
Rung proposal(const Trial& from, double target, int dim, double r, double q) {
  const double share = (dim * step_power(dim) / r) / (dim * step_power(dim) / r + 1 / q);
  // Limits the change of either to where the leading terms of the error can be trusted.
  constexpr double most = 8;
  const auto factor = [&](double part, double budget, double slope) {
    return part > 0 ? std::clamp(std::pow(budget / part, 1 / slope), 1 / most, 2.0) : 2.0;
  };
  Rung next = from.rung;
  next.size *= factor(from.space(), share * target, r);
  next.size = std::stod(fmt::format("{:.2g}", next.size));
  const double steps = std::ceil(from.rung.steps / factor(from.time(), (1 - share) * target, q));
  next.steps = static_cast<int>(std::min<double>(steps, scene::Time::most_steps));
  return next;
}

} // namespace

int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, std::optional<double> budget,
            const Console& console) {
  if (!scene.objective)
    throw UserError(
        "--suggest: needs an objective, whose error is estimated; allowed with [control] and [objective]");
  if (scene.mesh.degree != 1)
    throw UserError(fmt::format("--suggest: found mesh.degree = {}, allowed is 1: the estimate in space "
                                "looks at what functions of degree 2 "
                                "have beyond those of degree 1",
                                scene.mesh.degree));
  if (scene.mesh.file.extension() == ".msh")
    throw UserError("--suggest: found a .msh, which is meshed already, allowed is a .geo");
  require_answer(comm, scene);
  using Clock = std::chrono::steady_clock;
  const Samples samples(comm, scene);
  const auto run = [&](const Rung& rung) {
    const Measured measured = measure(comm, on_rung(scene, rung), samples, {}, true);
    const double J = std::abs(measured.numbers.at("J"));
    const adjoint::ErrorParts& parts = *measured.estimate;
    const Trial trial{
        rung, {*parts.space / J, parts.time / J, parts.initial / J, parts.desired / J}, measured.seconds};
    console.line(fmt::format("{}: J {:.6e}, estimated error at most {:.2e} ({}), {} unknowns, {:.2g} s",
                             words(rung, scene), measured.numbers.at("J"), trial.error(), listed(trial.parts),
                             measured.unknowns, measured.seconds));
    return trial;
  };
  const auto start = Clock::now();
  Trial last =
      run(ladder(scene, {{scene.mesh.size.value_or(scene.mesh.scale)}, {scene.time.step}, {}, {}}).front());
  double r = 2, q = 2;
  constexpr int trials = 5;
  constexpr double aim =
      0.8; // of the tolerance, so that a little more error than foreseen does not cost another run
  for (int i = 0; i < trials; ++i) {
    const Rung next = proposal(last, aim * tolerance, samples.dim, r, q);
    if (next == last.rung)
      break;
    const double predicted = last.seconds * work(next, samples.dim) / work(last.rung, samples.dim);
    console.line(fmt::format("next: {}, about {:.2g} s", words(next, scene), predicted));
    double passed = std::chrono::duration<double>(Clock::now() - start).count();
    MPI_Bcast(&passed, 1, MPI_DOUBLE, 0, comm);
    if (budget && passed + predicted > *budget) {
      console.line("that is beyond the budget");
      break;
    }
    const Trial trial = run(next);
    r = order(last.space(), trial.space(), last.rung.size / next.size, r);
    q = order(last.time(), trial.time(), static_cast<double>(next.steps) / last.rung.steps, q);
    last = trial;
    if (last.error() <= tolerance)
      break;
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const bool met = last.error() <= tolerance;
  console.line(fmt::format(
      "{:g} in J is {}: {}, by the moduli of their own estimate's parts {:.2e}, {:.2g} s; found in {:.2g} s",
      tolerance, met ? "met by" : "not met; the nearest is", words(last.rung, scene), last.error(),
      last.seconds, seconds));
  return met ? 0 : 1;
}

} // namespace signorini::study
