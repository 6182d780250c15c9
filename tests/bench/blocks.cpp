// SPDX-License-Identifier: GPL-3.0-or-later
// Seconds of a motion among 4, 16 and 64 that make their steps together, and of one alone. The motions start
// with different velocities. Factors are made before. The environment variable SIGNORINI_REGISTERS limits the
// numbers in a vector register: 4 as on machines with AVX2, 2 as on any.
//
// usage: signorini-bench-blocks SCENE REPEATS [key.path=value …]    prints one JSON object
#include "bench.h"
#include "linalg/lane_kernels.h"
#include "step/united.h"
#include <cstdlib>

using namespace signorini;

namespace {

/// Initial states that differ by their velocity: the scene's times 1 + i/1000.
std::vector<step::State> starts(const problem::Problem& problem, std::size_t count) {
  std::vector<step::State> all;
  for (std::size_t i = 0; i < count; ++i) {
    all.push_back(problem.stepper.state());
    all.back().copy(problem.initial);
    petsc::check(VecScale(all.back().v(), 1 + static_cast<double>(i) / 1000));
  }
  return all;
}

nlohmann::ordered_json measure(const scene::Scene& scene, int repeats) {
  const char* const limit = std::getenv("SIGNORINI_REGISTERS");
  const int registers = limit_lane_registers(limit ? std::atoi(limit) : std::numeric_limits<int>::max());
  Timers timers;
  const problem::Problem problem(MPI_COMM_WORLD, scene, {}, timers);
  const problem::GivenControl given(problem);
  const double tau = problem.stepper.first_length(), infinity = std::numeric_limits<double>::infinity();
  constexpr std::size_t most = 64;
  const std::vector<step::State> initial = starts(problem, most);
  int touching = 0;
  const auto motion = [&](std::size_t i) {
    trajectory::integrate(problem.stepper, problem.grid, initial[i], given.load(),
                          [&](const trajectory::Frame& frame) { touching += frame.normal_force() > 0; });
  };
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  double alone = infinity;
  Watch watch;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    watch.lap();
    motion(0);
    alone = std::min(alone, watch.lap());
  }
  for (const std::size_t count : {std::size_t{4}, std::size_t{16}, most}) {
    Lockstep lockstep;
    std::vector<std::function<void()>> tasks;
    for (std::size_t i = 0; i < count; ++i)
      tasks.emplace_back([&, i] { motion(i); });
    const double before = resident_memory();
    double seconds = infinity;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      watch.lap();
      {
        const step::United united(problem.stepper, tau, lockstep);
        lockstep.run(tasks);
      }
      const double all = watch.lap();
      if (repeat > 0 || repeats == 1) // the first one copies matrices
        seconds = std::min(seconds, all / static_cast<double>(count));
    }
    rows.push_back({{"motions", count},
                    {"seconds", seconds},
                    {"times", alone / seconds},
                    {"megabytes", (resident_memory() - before) / 1e6}});
  }
  return {{"free_unknowns", problem.free_dofs()},
          {"steps", problem.steps()},
          {"contact_steps", touching},
          {"registers", registers},
          {"alone", alone},
          {"together", rows}};
}

} // namespace

int main(int argc, char** argv) { return bench::run("signorini-bench-blocks", argc, argv, measure); }
