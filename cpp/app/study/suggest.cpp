#include "app/study/density.h"
#include "app/study/measure.h"
#include "app/study/quantities.h"
#include "app/study/study.h"
#include "app/study/trials.h"
#include "base/error.h"
#include "scene/names.h"
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace signorini::study {
namespace {

using Clock = std::chrono::steady_clock;

/// The observed order between two trials, or `otherwise` if they do not determine one.
double order(double coarse, double fine, double ratio, double otherwise) {
  constexpr double least = 0.5, most = 2.5; // of fronts of an impact, and above that of the schemes
  if (!(ratio > 1.1) || !(coarse > 0) || !(fine > 0))
    return otherwise;
  return std::clamp(std::log(coarse / fine) / std::log(ratio), least, most);
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
  next.size *= factor(from.space, share * target, r);
  next.size = std::stod(fmt::format("{:.2g}", next.size));
  const double steps = std::ceil(from.rung.steps / factor(from.time, (1 - share) * target, q));
  next.steps = static_cast<int>(std::min<double>(steps, scene::Time::most_steps));
  return next;
}

/// The quantity to be accurate: that asked for, or J. Throws UserError.
Quantity the_quantity(const scene::Scene& scene, const std::vector<std::string>& names, int dim) {
  std::vector<std::string> allowed;
  for (const Quantity& quantity : quantities(scene, dim))
    if (!quantity.absolute) // whose error is known without
      allowed.push_back(quantity.name);
  if (names.empty() && !scene.objective)
    throw UserError(
        fmt::format("--suggest: needs --quantity in a scene without an objective, allowed is one of {}",
                    scene::list(allowed)));
  const Quantity found = names.empty() ? Quantity{"J", "J", ""} : chosen(scene, names, dim).front();
  if (names.size() > 1 || found.absolute)
    throw UserError(fmt::format("--suggest: found --quantity {}, allowed is one of {}", fmt::join(names, ","),
                                scene::list(allowed)));
  return found;
}

void require_size(const scene::Scene& scene, const Quantity& quantity) {
  if (scene.mesh.file.extension() == ".msh")
    throw UserError("--suggest: found a .msh, which is meshed already, allowed is a .geo");
  if (quantity.name == "J" && scene.mesh.degree != 1)
    throw UserError(fmt::format("--suggest: found mesh.degree = {}, allowed is 1: the estimate in space "
                                "looks at what functions of degree 2 "
                                "have beyond those of degree 1",
                                scene.mesh.degree));
}

/// Goes from trial to trial until one meets the tolerance.
class Search {
public:
  Search(MPI_Comm comm, const scene::Scene& scene, double tolerance, std::optional<double> budget, int dim,
         const Console& console)
      : comm_(comm), scene_(scene), tolerance_(tolerance), budget_(budget), dim_(dim), console_(console) {}

  /// The trial that meets it, else the last.
  Trial operator()(Trials& trials) const {
    Trial last = run(
        trials,
        ladder(scene_, {{scene_.mesh.size.value_or(scene_.mesh.scale)}, {scene_.time.step}, {}, {}}).front());
    std::optional<Trial> met = last.error() <= tolerance_ ? std::optional(last) : std::nullopt;
    double r = trials.order(), q = trials.order();
    constexpr int most = 5;
    constexpr double aim =
        0.8; // of the tolerance, so that a little more error than foreseen does not cost another run
    for (int i = 0; i < most; ++i) {
      const Rung next = trials.nearest(proposal(last, aim * tolerance_, dim_, r, q));
      if (next == last.rung || beyond_budget(next, last))
        break;
      const Trial trial = run(trials, next);
      r = order(last.space, trial.space, last.rung.size / next.size, r);
      q = order(last.time, trial.time, static_cast<double>(next.steps) / last.rung.steps, q);
      last = trial;
      if (last.error() > tolerance_)
        continue;
      if (!met || last.seconds < met->seconds)
        met = last;
      break;
    }
    return met.value_or(last);
  }

  [[nodiscard]] double passed() const {
    double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    MPI_Bcast(&seconds, 1, MPI_DOUBLE, 0, comm_);
    return seconds;
  }

private:
  [[nodiscard]] Trial run(Trials& trials, const Rung& rung) const {
    const Trial trial = trials.run(trials.nearest(rung));
    console_.line(fmt::format("{}: {}", words(trial.rung, scene_), trial.said));
    return trial;
  }

  [[nodiscard]] bool beyond_budget(const Rung& next, const Trial& last) const {
    const double predicted = last.cost * work(next, dim_) / work(last.rung, dim_);
    console_.line(fmt::format("next: {}, about {:.2g} s", words(next, scene_), predicted));
    const bool beyond = budget_ && passed() + predicted > *budget_;
    if (beyond)
      console_.line("that is beyond the budget");
    return beyond;
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  double tolerance_;
  std::optional<double> budget_;
  int dim_;
  const Console& console_;
  Clock::time_point start_ = Clock::now();
};

} // namespace

int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
            const Console& console) {
  require_size(scene, the_quantity(scene, options.quantities, 2));
  require_answer(comm, scene);
  const Samples samples(comm, scene);
  const Quantity quantity = the_quantity(scene, options.quantities, samples.dim);
  const std::unique_ptr<Trials> trials = quantity.name == "J" ? adjoint_trials(comm, scene, samples)
                                                              : ladder_trials(comm, scene, samples, quantity);
  const Search search(comm, scene, tolerance, options.budget, samples.dim, console);
  const Trial found = search(*trials);
  const bool met = found.error() <= tolerance;
  console.line(fmt::format("{:g} in {} is {}: {}, {}, {:.2g} s; found in {:.2g} s", tolerance, quantity.title,
                           met ? "met by" : "not met; the nearest is", words(found.rung, scene),
                           found.grounds, found.seconds, search.passed()));
  return met ? 0 : 1;
}

} // namespace signorini::study
