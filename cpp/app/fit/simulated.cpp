// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/simulated.h"
#include "forward/contact_times.h"
#include <limits>
#include <numeric>

namespace signorini {
namespace {

/// Contact times of the measurements that ask for them, of a motion that is looked at frame by frame.
class TimesCompared {
public:
  TimesCompared(const forward::Stepper& stepper, const scene::Scene& scene) {
    for (const scene::Measurement& measurement : scene.measurements) {
      if (measurement.fitted())
        continue;
      const contact::ContactPairs& pairs = *stepper.pairs();
      std::vector<int> candidates;
      for (int i = 0; i < pairs.count(); ++i)
        if (const auto obstacle = static_cast<std::size_t>(pairs.obstacles()[static_cast<std::size_t>(i)]);
            !measurement.obstacle || scene.contacts[obstacle].name == *measurement.obstacle)
          candidates.push_back(i);
      watched_.push_back({measurement, forward::ContactTimes(stepper.grid(), candidates)});
    }
  }

  void observe(const forward::Frame& frame) {
    for (auto& [measurement, times] : watched_)
      times.observe(frame.k, frame.contact);
  }

  [[nodiscard]] std::vector<io::ComparedTime> compared() const {
    std::vector<io::ComparedTime> all;
    for (const auto& [measurement, times] : watched_) {
      const auto intervals = times.intervals();
      const bool start = measurement.of == scene::Quantity::contact_start;
      double simulated = start ? std::numeric_limits<double>::quiet_NaN() : 0;
      if (!intervals.empty())
        simulated =
            start ? intervals.front().start
                  : std::accumulate(intervals.begin(), intervals.end(), 0.0,
                                    [](double sum, const auto& one) { return sum + one.end - one.start; });
      all.push_back({measurement.name, *measurement.value, measurement.deviation.value_or(0), simulated});
    }
    return all;
  }

private:
  struct Watched {
    const scene::Measurement& measurement;
    forward::ContactTimes times;
  };
  std::vector<Watched> watched_;
};

} // namespace

Simulated simulate_measured(const Problem& problem, const FitProblem& fit, const forward::ForceAtStep& load,
                            MotionWriter& recorder) {
  const auto timer = problem.timers.time("replay");
  control::Measurements measurements(problem.stepper, problem.scene, fit.times());
  TimesCompared compared(problem.stepper, problem.scene);
  forward::integrate(
      problem.stepper, problem.initial, load, problem.steps(),
      [&](const forward::Frame& frame) {
        recorder(frame);
        measurements.observe(frame);
        compared.observe(frame);
      },
      forward::Stops::ignored);
  recorder.finish();
  return {measurements.values(), compared.compared()};
}

} // namespace signorini
