// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/trajectory.h"
#include "accuracy/error_estimate.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/scratch_file.h"
#include "base/timers.h"
#include "fixtures.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cstdlib>
#include <fmt/format.h>
#include <limits>
#include <numeric>

using namespace signorini;
using petsc::check;

namespace {

long &recomputed = count("recomputed steps"), &vectors = count("trajectory vectors");

scene::Trajectory checkpoints(const step::Stepper& stepper, int slots) {
  return {.storage = scene::Storage::checkpoints, .budget = slots * trajectory::Checkpoint::bytes(stepper)};
}

/// ‖a − b‖∞ over all steps.
double difference(const control::Control& a, const control::Control& b) {
  double largest = 0;
  for (int k = 1; k <= a.count(); ++k)
    largest = std::max(largest, test::difference(a.at(k), b.at(k)));
  return largest;
}

control::Control some(const control::ControlSpace& controls, double size) {
  control::Control u = controls.interpolate({"-0.4*cos(9*t)", "-0.9 + 0.3*sin(7*t)"}, "test");
  u.scale(size);
  return u;
}

} // namespace

TEST_CASE("the binomial schedule makes as few steps as a dynamic programme finds", "[forward]") {
  constexpr int most_steps = 120, most_slots = 12;
  std::vector<std::vector<long>> least(most_slots + 1, std::vector<long>(most_steps + 1));
  for (int l = 1; l <= most_steps; ++l)
    least[0][l] = static_cast<long>(l) * (l + 1) / 2;
  for (int s = 1; s <= most_slots; ++s)
    for (int l = 1; l <= most_steps; ++l) {
      least[s][l] = std::numeric_limits<long>::max();
      for (int m = 1; m <= l; ++m)
        least[s][l] = std::min(least[s][l], m + least[s - 1][l - m] + least[s][m - 1]);
      REQUIRE(trajectory::steps_made(l, s) == least[s][l]);
      const int m = trajectory::next_checkpoint(l, s);
      REQUIRE((m >= 1 && m <= l));
      REQUIRE(m + least[s - 1][l - m] + least[s][m - 1] == least[s][l]);
    }
  // Without a slot, and with one for each step but the last.
  CHECK(trajectory::steps_made(most_steps, 0) == least[0][most_steps]);
  CHECK(trajectory::steps_made(most_steps, most_steps - 1) == most_steps);
}

TEST_CASE("states come back from every storage to the last bit, by as few steps as can be", "[forward]") {
  // On several ranks MUMPS sums in no fixed order.
  const test::Ready ready("tests/data/block.toml",
                          {ranks(MPI_COMM_WORLD) > 1 ? "solver.linear=iterative" : "solver.linear=direct"});
  const problem::Problem& problem = ready.problem;
  const test::Recorded expected(problem);
  const int N = problem.steps();
  REQUIRE(std::ranges::any_of(expected.contact,
                              [](const contact::ContactLinearisation& c) { return !c.active.empty(); }));
  Timers timers;
  std::vector<std::pair<scene::Trajectory, long>> storages{{{}, 0}, {{.storage = scene::Storage::disk}, 0}};
  for (int slots : {1, 2, 3, 7, N - 1, 5 * N})
    storages.emplace_back(checkpoints(problem.stepper, slots),
                          trajectory::steps_made(N, std::min(slots, N - 1)) - N);
  for (const auto& [scene, again] : storages) {
    INFO(scene::name(scene.storage) << " " << scene.budget);
    const trajectory::StateStoreFactory storage(problem.stepper, problem.grid, scene, 1, timers);
    trajectory::Trajectory trajectory(problem.stepper, problem.initial, storage, true);
    int shown = 0;
    trajectory.run(problem.load(), [&](const trajectory::Frame& frame) {
      CHECK(frame.step.k == shown++);
      CHECK(frame.last == (frame.step.k == N));
    });
    CHECK(trajectory.steps() == N);
    const auto is_right = [&](int k) {
      const step::State& state = trajectory.at(k);
      const auto i = static_cast<std::size_t>(k);
      CHECK(test::difference(state.y(), expected.y[i]) == 0);
      CHECK(test::difference(state.v(), expected.v[i]) == 0);
      CHECK(trajectory.contact()[i].active == expected.contact[i].active);
      CHECK(trajectory.contact()[i].weak == expected.contact[i].weak);
      CHECK(trajectory.contact()[i].predictor == expected.contact[i].predictor);
    };
    long before = recomputed;
    for (int k = N; k >= 1; --k)
      is_right(k);
    CHECK(recomputed - before == again);
    before = recomputed;
    for (int k = N; k >= 1; --k) // once more, by a sweep more
      is_right(k);
    CHECK(recomputed - before == (scene.storage == scene::Storage::checkpoints ? again + N - 1 : 0));
    for (int k : {0, 1, 1, 2, 3, N, N - 1, 5, 17, 4, N, 0}) // and in no order at all
      is_right(k);
    for (const contact::ContactLinearisation& sets : trajectory.contact()) // free flight takes no room
      CHECK((sets.active.empty() ? sets.active.capacity() : sets.weak.capacity()) <= sets.active.size());
    // Another motion in the same storage, and this one again.
    trajectory::Trajectory other(problem.stepper, problem.initial, storage);
    other.run({problem.space, {}});
    CHECK(test::difference(other.at(N).y(), expected.y.back()) > 0);
    is_right(N);
    is_right(N / 2);
  }
}

TEST_CASE("gradients and Hessian products are the same to the last bit from every storage", "[control]") {
  using Settings = std::vector<std::string>;
  const Settings disc{"mesh.size=2.5", "time.step=1e-4"}, ball{"mesh.size=5", "time.step=2.5e-4"};
  std::vector<std::pair<const char*, Settings>> cases;
  for (const Settings& scheme : {Settings{}, {"time.scheme=contact-stabilized"}, {"contact.mass=massless"}})
    for (const char* linear : {"solver.linear=direct", "solver.linear=iterative"})
      for (const auto& [file, size] :
           {std::pair{"scenes/half-disc.toml", disc}, {"scenes/half-ball.toml", ball}}) {
        if (ranks(MPI_COMM_WORLD) > 2 && (size == ball || !scheme.empty()))
          continue; // thousands of small solves, of which three ranks learn nothing that two do not
        Settings settings = size;
        settings.insert(settings.end(), scheme.begin(), scheme.end());
        settings.emplace_back(linear);
        cases.emplace_back(file, settings);
      }
  cases.emplace_back("tests/data/block.toml", Settings{"solver.vi=full"});
  cases.emplace_back("tests/data/block.toml", Settings{"objective.desired={displacement=[\"t\", \"-t\"]}"});
  cases.emplace_back("tests/data/block.toml",
                     Settings{"control.on=rest", "objective.on=rest", "load.body=[\"0\", \"-1-t\"]",
                              "contact.obstacle.point=[0, \"-0.1+0.02*t\"]"});
  for (const auto& [file, settings] : cases) {
    std::string what = file;
    for (const std::string& setting : settings)
      what += " " + setting;
    INFO(what);
    test::Ready ready(file, settings);
    const problem::Problem& problem = ready.problem;
    // On several ranks MUMPS sums in no fixed order, so that not even two gradients from one storage are the
    // same.
    const bool fixed = ranks(MPI_COMM_WORLD) == 1 || problem.stepper.solver().tolerance() > 0;
    const bool in_space = problem.space.dim() == 3;
    std::optional<control::Control> g, h;
    for (scene::Storage kind : {scene::Storage::memory, scene::Storage::disk, scene::Storage::checkpoints}) {
      ready.scene.trajectory = checkpoints(problem.stepper, 8); // 4 of the motion, 4 of the desired one
      ready.scene.trajectory.storage = kind;
      problem::ControlProblem control_problem(problem, test::silent());
      control::ReducedProblem& reduced = control_problem.reduced;
      const control::ControlSpace& controls = control_problem.controls;
      const auto control = [&](double size) {
        if (!in_space)
          return some(controls, size);
        control::Control u =
            controls.interpolate({"-0.1*cos(9*t)", "0.2*x*t", "-0.9 + 0.3*sin(7*t)"}, "test");
        u.scale(size);
        return u;
      };
      const long before = recomputed;
      reduced.simulate(control(1));
      reduced.accept();
      REQUIRE(std::ranges::any_of(reduced.trajectory().contact(),
                                  [](const contact::ContactLinearisation& c) { return !c.active.empty(); }));
      const control::Control gradient = reduced.gradient().u;
      const control::Control product = reduced.l2_hessian_product(control(0.5));
      reduced.simulate(control(0.7)); // a trial that is rejected
      const control::Control once_more = reduced.gradient().u;
      CHECK((recomputed > before) == (kind == scene::Storage::checkpoints));
      REQUIRE(controls.norm(gradient) > 0);
      REQUIRE(controls.norm(product) > 0);
      if (!g) {
        g.emplace(gradient);
        h.emplace(product);
      }
      const double rounding = fixed ? 0 : 1e-9;
      CHECK(difference(gradient, *g) <= rounding * controls.norm(gradient));
      CHECK(difference(product, *h) <= rounding * controls.norm(product));
      CHECK(difference(once_more, *g) <= rounding * controls.norm(gradient));
    }
  }
}

TEST_CASE("errors are estimated alike from every storage", "[adjoint]") {
  const char* scheme =
      GENERATE(as<const char*>{}, "time.scheme=contact-implicit", "time.scheme=contact-stabilized");
  CAPTURE(scheme);
  test::Ready ready("tests/data/block.toml", {"solver.linear=iterative", scheme});
  std::optional<adjoint::ErrorParts> expected;
  for (scene::Storage kind : {scene::Storage::memory, scene::Storage::disk, scene::Storage::checkpoints}) {
    ready.scene.trajectory = checkpoints(ready.problem.stepper, 6);
    ready.scene.trajectory.storage = kind;
    problem::ControlProblem problem(ready.problem, test::silent());
    problem.reduced.simulate(some(problem.controls, 1));
    problem.reduced.accept();
    REQUIRE(std::ranges::any_of(problem.reduced.trajectory().contact(),
                                [](const contact::ContactLinearisation& c) { return !c.active.empty(); }));
    const long before = recomputed;
    const adjoint::ErrorParts error = accuracy::estimate_error(ready.problem, problem);
    CHECK((recomputed > before) == (kind == scene::Storage::checkpoints));
    if (!expected)
      expected = error;
    CHECK(std::abs(error.time) > 0);
    CHECK(error.time == expected->time);
    // On more than two ranks the matrices of degree 2, made anew each time, are summed up in no fixed
    // order. Their rounding adds to the residual what a change ε y of the motion does, as the Courant
    // number is about one, and that changes J by ε J in a step.
    const double unit = std::numeric_limits<double>::epsilon() * problem.reduced.value().total();
    const double rounding = ranks(MPI_COMM_WORLD) > 2 ? ready.problem.steps() * unit : 0;
    REQUIRE(rounding < 1e-8 * std::abs(*error.space));
    CHECK(std::abs(*error.space - *expected->space) <= rounding);
  }
}

namespace {

/// Bytes of the scratch files that this rank has open: they have no name, but /proc shows what it was.
double scratch_bytes() {
  double bytes = 0;
  for (const auto& open : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone; // the folder's own
    const std::string name = std::filesystem::read_symlink(open.path(), gone).string();
    if (!gone && name.ends_with("/states (deleted)"))
      bytes += static_cast<double>(std::filesystem::file_size(open.path()));
  }
  return bytes;
}

} // namespace

TEST_CASE("a store of states takes the room that is told, with velocities and without", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"mesh.size=0.04", "solver.linear=direct"});
  const step::Stepper& stepper = ready.problem.stepper;
  const step::State& initial = ready.problem.initial;
  const int N = ready.problem.steps();
  const double vector = sizeof(PetscScalar) * static_cast<double>(ready.problem.space.dofs());
  Timers timers;
  for (const scene::Trajectory& scene :
       {scene::Trajectory{}, scene::Trajectory{.storage = scene::Storage::disk}, checkpoints(stepper, 7),
        checkpoints(stepper, 5 * N)})
    for (const bool velocities : {false, true}) {
      INFO(scene::name(scene.storage) << " " << scene.budget << (velocities ? " with velocities" : ""));
      trajectory::TimeIntegrator integrator(
          stepper, initial,
          [](const step::TimeStep&, const step::State& from, step::State& to) { to.copy(from); });
      const long before = vectors;
      const trajectory::StateStoreFactory storage(stepper, ready.problem.grid, scene, 1, timers);
      const std::unique_ptr<trajectory::StateStore> store = storage.place(integrator, velocities);
      for (integrator.restart(); integrator.now().k < N;
           integrator.advance(ready.problem.grid.step(integrator.now().k + 1)))
        store->keep(integrator.now());
      store->keep(integrator.now());
      for (int k = N; k >= 1; --k)
        (void)store->at(k);
      const double told = storage.bytes(velocities);
      if (scene.storage != scene::Storage::disk) {
        CHECK(static_cast<double>(vectors - before) * vector == told);
        continue;
      }
      double stored = scratch_bytes();
      MPI_Allreduce(MPI_IN_PLACE, &stored, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
      CHECK(stored >= told);
      CHECK(stored < 1.1 * told); // HDF5's own entries: a few kilobytes a file
    }
}

TEST_CASE("a scratch file has no name, and says when it cannot be", "[forward]") {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("signorini-scratch-{}", rank(MPI_COMM_WORLD));
  std::filesystem::create_directory(folder);
  const char* known = std::getenv("TMPDIR");
  const std::string before = known ? known : "";
  setenv("TMPDIR", folder.c_str(), 1);
  {
    constexpr std::size_t rows = 5, columns = 1000;
    ScratchFile file(rows, columns);
    std::vector<double> values(columns), found(columns);
    for (std::size_t row = 0; row < rows; ++row) {
      std::iota(values.begin(), values.end(), 1e-3 + static_cast<double>(row));
      file.write(row, values);
    }
    CHECK(std::filesystem::is_empty(folder));
    for (std::size_t row = rows; row-- > 0;) {
      std::iota(values.begin(), values.end(), 1e-3 + static_cast<double>(row));
      file.read(row, found);
      CHECK(found == values);
    }
  }
  std::filesystem::remove(folder);
  CHECK_THROWS_AS(ScratchFile(2, 2), WriteFailure);
  CHECK_THROWS_WITH(ScratchFile(2, 2), Catch::Matchers::ContainsSubstring("No such file") &&
                                           Catch::Matchers::ContainsSubstring("TMPDIR"));
  if (known)
    setenv("TMPDIR", before.c_str(), 1);
  else
    unsetenv("TMPDIR");
}

TEST_CASE("a budget without room for a checkpoint is refused with what is needed", "[control]") {
  const std::string needed = fmt::format(
      "{:.6g}", 2 * trajectory::Checkpoint::bytes(
                        test::Ready("tests/data/block.toml").problem.stepper)); // and the desired one's
  const test::Ready small("tests/data/block.toml", {"trajectory={storage=\"checkpoints\", budget=1000}"});
  CHECK_THROWS_AS(problem::ControlProblem(small.problem, test::silent()), UserError);
  CHECK_THROWS_WITH(problem::ControlProblem(small.problem, test::silent()),
                    Catch::Matchers::ContainsSubstring("trajectory.budget: found 1000 bytes") &&
                        Catch::Matchers::ContainsSubstring(needed));
  const test::Ready enough("tests/data/block.toml",
                           {"trajectory={storage=\"checkpoints\", budget=" + needed + "}"});
  problem::ControlProblem problem(enough.problem, test::silent());
  CHECK(problem.reduced.value(problem.controls.zero()) > 0);
}

TEST_CASE("a trajectory that runs again shows the last run's states, from every storage", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"solver.linear=iterative"});
  const problem::Problem& problem = ready.problem;
  const int N = problem.steps();
  const test::Recorded loaded(problem), falling(problem, {problem.space, {}});
  REQUIRE(test::difference(loaded.y.back(), falling.y.back()) > 0);
  Timers timers;
  for (const scene::Trajectory& scene :
       {scene::Trajectory{}, scene::Trajectory{.storage = scene::Storage::disk},
        checkpoints(problem.stepper, 3)}) {
    INFO(scene::name(scene.storage));
    const trajectory::StateStoreFactory storage(problem.stepper, problem.grid, scene, 1, timers);
    trajectory::Trajectory trajectory(problem.stepper, problem.initial, storage, true);
    for (const test::Recorded* expected : {&loaded, &falling, &loaded}) {
      trajectory.run(expected == &loaded ? problem.load() : step::ForceAtStep(problem.space, {}));
      for (int k : {N, N, N / 2, 1}) { // the last one asked for before the next run too
        CAPTURE(k);
        const step::State& state = trajectory.at(k);
        CHECK(test::difference(state.y(), expected->y[static_cast<std::size_t>(k)]) == 0);
        CHECK(test::difference(state.v(), expected->v[static_cast<std::size_t>(k)]) == 0);
      }
      (void)trajectory.at(N);
    }
  }
}
