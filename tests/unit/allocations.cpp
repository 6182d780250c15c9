// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/sweep.h"
#include "base/collective.h"
#include "diagnostics/balance.h"
#include "fixtures.h"
#include "trajectory/trajectory.h"
#include <atomic>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cstdlib>

// Counts every call of malloc and its relatives in this program and its libraries, PETSc's and CHOLMOD's
// included. The sanitizers have an allocator of their own, so there the test is left out.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)

namespace {

std::atomic<long> calls = 0;
std::atomic<bool> counting = false;

void count() {
  if (counting)
    ++calls;
}

} // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count();
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  count();
  return __libc_realloc(p, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
  count();
  *p = __libc_memalign(alignment, size);
  return *p ? 0 : 12;
}
}

namespace signorini {
namespace {

/// Calls of malloc during `work`.
template <class Work>
long allocations(Work&& work) {
  calls = 0;
  counting = true;
  work();
  counting = false;
  return calls;
}

} // namespace

TEST_CASE("steps and adjoint steps allocate nothing", "[forward]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // messages and MUMPS allocate
  REQUIRE(allocations([] {
            int* volatile kept = new int; // not to be optimised away
            delete kept;
          }) == 1);
  const char* setting =
      GENERATE(as<const char*>{}, "solver.linear=direct", "solver.linear=iterative", "contact.mass=massless",
               "time.scheme=contact-stabilized", "material.prony=[{g=0.3, k=0.1, time=1e-3}]");
  CAPTURE(setting);
  const test::Ready ready("scenes/half-disc.toml", {"mesh.size=1", setting});
  const problem::Problem& problem = ready.problem;
  const control::ControlSpace controls(problem.space, problem.operators, problem.grid, *ready.scene.control);
  const control::Control u = controls.interpolate({"0", "-1"}, "u");
  const control::ControlForce force(controls, u);
  const auto load = [&] { return problem.load(&force); };
  Timers timers;
  const trajectory::StateStoreFactory storage(problem.stepper, problem.grid, {}, 1, timers);
  trajectory::Trajectory trajectory(problem.stepper, problem.initial, storage);
  trajectory.run(load()); // work space that CHOLMOD and PETSc make once
  long stepping = 0, before = 0;
  int contact_steps = 0, set_changes = 0;
  (void)allocations([&] {
    trajectory.run(load(), [&](const trajectory::Frame& frame) {
      stepping +=
          frame.step.k > 1 ? calls - before : 0; // what comes before the first step is made once a run
      contact_steps += !frame.contact.active.empty();
      set_changes += frame.contact.vi_iterations > 0;
      before = calls;
    });
  });
  CHECK(contact_steps > 50);
  CHECK(set_changes > 5);
  CHECK(stepping == 0);
  diagnostics::Balance weigh(problem.stepper);
  long streaming = 0;
  const auto stream = [&] {
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, load(),
                          [&](const trajectory::Frame& frame) {
                            weigh(frame);
                            streaming += frame.step.k > 1 ? calls - before : 0;
                            before = calls;
                          });
  };
  (void)allocations(stream);
  CHECK(streaming == 0);
  petsc::Vector dual = test::smooth(problem.space, 1);
  long back = 0;
  step::Stepper::Workspace work = problem.stepper.workspace();
  (void)allocations([&] {
    const test::Dual derivative([&](int, Vec density) { petsc::check(VecAXPY(density, 1, dual)); });
    adjoint::sweep(problem.stepper, work, problem.grid, trajectory.contact(), {problem.space, derivative},
                   [&](int k, Vec) {
                     back += k < problem.steps() ? calls - before : 0;
                     before = calls;
                   });
  });
  CHECK(back == 0);
}

TEST_CASE("steps between several obstacles, one of which moves, allocate nothing", "[forward]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return;
  // Three obstacles for every node of a body in the plane depend on each other.
  const test::Ready ready(
      "tests/data/block.toml",
      {"initial.velocity=[\"-1\", \"-1\"]",
       "contact=[{on=\"boundary\", obstacle={shape=\"half-space\", point=[0, \"-0.1 + 0.1*t\"], normal=[0.3, "
       "1]}}, "
       "{on=\"boundary\", obstacle={shape=\"half-space\", point=[-0.1, 0], normal=[1, 0]}}, "
       "{on=\"boundary\", obstacle={shape=\"half-space\", point=[0, 1.5], normal=[0, -1]}}]"});
  const problem::Problem& problem = ready.problem;
  REQUIRE(problem.stepper.pairs()->rows().dependent());
  const auto run = [&](const trajectory::StepObserver& watch) {
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, problem.load(), watch);
  };
  run([](const trajectory::Frame&) {});
  long stepping = 0, before = 0;
  std::array<bool, 3> touched{};
  (void)allocations([&] {
    run([&](const trajectory::Frame& frame) {
      stepping += frame.step.k > 1 ? calls - before : 0;
      for (int i : frame.contact.active)
        touched[static_cast<std::size_t>(problem.stepper.pairs()->obstacles()[static_cast<std::size_t>(i)])] =
            true;
      before = calls;
    });
  });
  CHECK(touched[0]);
  CHECK(touched[1]);
  CHECK(stepping == 0);
}

} // namespace signorini

#endif
