// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/trajectory.h"
#include "base/error.h"
#include "base/scratch_file.h"
#include "base/timers.h"
#include <algorithm>
#include <cmath>
#include <deque>
#include <fmt/format.h>
#include <vector>

namespace signorini::trajectory {
using petsc::check;

namespace {
long &vectors = count("trajectory vectors"), &recomputed = count("recomputed steps");
constexpr const char *writing = "states written", *reading = "states read",
                     *recomputing = "states recomputed";
} // namespace

/// Stores every state in memory.
class StateStoreFactory::InMemory final : public StateStore {
public:
  InMemory(const step::Stepper& stepper, int steps, std::size_t parts) {
    const petsc::Vector layout = stepper.space().vector();
    for (int k = 0; k <= steps; ++k)
      states_.emplace_back(layout, parts);
    vectors += static_cast<long>(states_.size() * parts);
  }

  void keep(const Checkpoint& now) override { states_[now.k].copy(now.state); }
  const step::State& at(int k) override { return states_[k]; }

private:
  std::vector<step::State> states_;
};

/// Stores every state in files, one for each rank and part of a state, and the state read last in memory.
class StateStoreFactory::OnDisk final : public StateStore {
public:
  OnDisk(const step::Stepper& stepper, int steps, std::size_t parts, Timers& timers)
      : timers_(timers), last_(stepper.space().vector(), parts) {
    const auto dofs = static_cast<std::size_t>(stepper.space().layout().nodes()) *
                      static_cast<std::size_t>(stepper.space().dim());
    for (std::size_t i = 0; i < parts; ++i)
      files_.emplace_back(static_cast<std::size_t>(steps) + 1, dofs);
  }

  void keep(const Checkpoint& now) override {
    const auto timer = timers_.time(writing);
    held_ = -1;
    for (std::size_t i = 0; i < files_.size(); ++i)
      files_[i].write(static_cast<std::size_t>(now.k), petsc::ReadArray(now.state.parts()[i]));
  }

  const step::State& at(int k) override {
    if (k != held_) {
      const auto timer = timers_.time(reading);
      for (std::size_t i = 0; i < files_.size(); ++i)
        files_[i].read(static_cast<std::size_t>(k), petsc::WriteArray(last_.parts()[i]));
      held_ = k;
    }
    return last_;
  }

private:
  Timers& timers_;
  std::deque<ScratchFile> files_; ///< a deque, which does not move its elements
  step::State last_;
  int held_ = -1;
};

/// Pool of checkpoints, which belong to one motion at a time.
struct StateStoreFactory::Pool {
  std::size_t room; ///< largest number of checkpoints
  std::vector<std::unique_ptr<Checkpoint>> free;
  std::vector<std::unique_ptr<Checkpoint>> used; ///< checkpoints in use, in the order of k
  const void* owner = nullptr;

  /// Frees the checkpoints later than t_k.
  void release_beyond(int k) {
    for (; !used.empty() && used.back()->k > k; used.pop_back())
      free.push_back(std::move(used.back()));
  }
  void keep(const step::Stepper& stepper, const Checkpoint& now) {
    if (free.empty())
      free.push_back(std::make_unique<Checkpoint>(stepper));
    used.push_back(std::move(free.back()));
    free.pop_back();
    used.back()->take(now);
  }
};

class StateStoreFactory::Checkpoints final : public StateStore {
public:
  Checkpoints(const step::Stepper& stepper, const step::TimeGrid& grid, std::shared_ptr<Pool> pool,
              TimeIntegrator& integrator, Timers& timers)
      : stepper_(stepper), grid_(grid), pool_(std::move(pool)), integrator_(integrator), timers_(timers) {}
  ~Checkpoints() override {
    if (pool_->owner == this)
      pool_->owner = nullptr;
  }

  void keep(const Checkpoint& now) override {
    own();
    if (now.k == 0)
      pool_->release_beyond(0);
    went_back_ = false;
    place(grid_.steps());
  }

  const step::State& at(int k) override {
    own();
    const bool back = integrator_.now().k < 0 || integrator_.now().k > k, up = integrator_.now().k < k;
    if (up && std::exchange(went_back_, false)) // the reverse sweep has ended; free its checkpoints
      pool_->release_beyond(0);
    if (back) {
      went_back_ = true;
      pool_->release_beyond(k);
      if (pool_->used.empty())
        integrator_.restart();
      else
        integrator_.resume(*pool_->used.back());
    }
    if (integrator_.now().k < k) {
      const auto timer = timers_.time(recomputing);
      for (; integrator_.now().k < k; ++recomputed) {
        place(back ? k : grid_.steps());
        integrator_.advance(grid_.step(integrator_.now().k + 1));
      }
    }
    return integrator_.now().state;
  }

private:
  /// Takes over the pool; checkpoints of another motion are discarded.
  void own() {
    if (std::exchange(pool_->owner, this) != this)
      pool_->release_beyond(0);
  }

  /// Makes a checkpoint of the integrator's state if binomial checkpointing places one here, for the steps up
  /// to number `last` and their reversal.
  void place(int last) {
    const int here = integrator_.now().k, from = pool_->used.empty() ? 0 : pool_->used.back()->k,
              slots = static_cast<int>(pool_->room - pool_->used.size());
    if (slots > 0 && here < last && here > from && here >= from + next_checkpoint(last - from, slots))
      pool_->keep(stepper_, integrator_.now());
  }

  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  std::shared_ptr<Pool> pool_;
  TimeIntegrator& integrator_;
  Timers& timers_;
  bool went_back_ = false; ///< a reverse sweep is under way
};

StateStoreFactory::StateStoreFactory(const step::Stepper& stepper, const step::TimeGrid& grid,
                                     const scene::Trajectory& scene, double share, Timers& timers)
    : stepper_(stepper), scene_(scene), grid_(grid), timers_(timers) {
  if (scene.storage != scene::Storage::checkpoints)
    return;
  const double one = Checkpoint::bytes(stepper), room = share * scene.budget / one;
  if (room < 1)
    throw UserError(
        fmt::format("trajectory.budget: found {:.6g} bytes; expected at least {:.6g} bytes, "
                    "since a checkpoint takes {:.3g} MB and {}",
                    scene.budget, std::ceil(one / share), one * 1e-6,
                    share < 1 ? "the desired motion needs its own checkpoint" : "at least one is needed"));
  pool_ = std::make_shared<Pool>(static_cast<std::size_t>(std::min(room, std::max(grid.steps() - 1.0, 0.0))));
}

std::unique_ptr<StateStore> StateStoreFactory::place(TimeIntegrator& integrator, bool whole_states) const {
  if (pool_)
    return std::make_unique<Checkpoints>(stepper_, grid_, pool_, integrator, timers_);
  if (in_memory())
    return std::make_unique<InMemory>(stepper_, grid_.steps(), parts(whole_states));
  return std::make_unique<OnDisk>(stepper_, grid_.steps(), parts(whole_states), timers_);
}

double StateStoreFactory::bytes(bool whole_states) const {
  return pool_ ? static_cast<double>(pool_->room) * Checkpoint::bytes(stepper_)
               : static_cast<double>(parts(whole_states)) * sizeof(PetscScalar) *
                     static_cast<double>(stepper_.space().dofs()) * (grid_.steps() + 1.0);
}

namespace {

/// Returns the number of steps of the longest motion that can be reversed with s = `slots` and no step made
/// more than r = `repeats` times: C(s + r + 1, r) − 1. Numbers above 1e9, more than any motion has, are not
/// exact.
long reach(int slots, int repeats) {
  constexpr long enough = 1'000'000'000;
  long binomial = 1;
  for (int i = 1; i <= repeats && binomial < enough; ++i)
    binomial = binomial * (slots + 1 + i) / i;
  return binomial - 1;
}

} // namespace

int next_checkpoint(int steps, int slots) {
  int repeats = 1;
  while (reach(slots, repeats) < steps)
    ++repeats;
  // The steps before the checkpoint must be reversible with all slots, those after it with one fewer, each
  // with the remaining repeats.
  return static_cast<int>(std::min(1 + reach(slots, repeats - 1), steps - reach(slots - 1, repeats - 1)));
}

long steps_made(int steps, int slots) {
  long made = 0; // each number of repeats that falls short adds one run of the steps beyond its reach
  for (int repeats = 0; reach(slots, repeats) < steps; ++repeats)
    made += steps - reach(slots, repeats);
  return made;
}

Trajectory::Trajectory(const step::Stepper& stepper, const step::State& initial,
                       const StateStoreFactory& storage, bool whole_states)
    : stepper_(stepper), grid_(storage.grid()), contact_(static_cast<std::size_t>(grid_.steps()) + 1),
      now_(stepper.contact_state()), work_(stepper.workspace()),
      integrator_(stepper, initial,
                  [this](const step::TimeStep& step, const step::State& from, step::State& to) {
                    acting_ = load_->at(step);
                    stepper_.step({step, from, acting_, contact_[static_cast<std::size_t>(step.k) - 1]},
                                  {to, now_}, work_);
                  }),
      states_(storage.place(integrator_, whole_states)) {}

void Margins::take(const contact::ContactState& contact, step::Scheme scheme) {
  for (std::size_t i = 0; i < contact.status.size(); ++i)
    if (contact.status[i] == contact::Status::open) {
      gap = std::min(gap, contact.gap[i]);
    } else {
      const double force = contact.lambda[i] / scheme.impulse();
      least_force = std::min(least_force, force);
      largest_force = std::max(largest_force, force);
    }
}

void Trajectory::run(step::ForceAtStep load, const StepObserver& watch) {
  load_ = std::move(load);
  steps_ = 0;
  now_ = stepper_.contact_state();
  margins_ = {};
  const auto contact = [this](int) -> contact::ContactState& { return now_; };
  integrate_with(stepper_, grid_, integrator_, Stops::obeyed, contact, acting_, [&](const Frame& frame) {
    steps_ = frame.step.k;
    contact_[frame.step.k] = now_.linearisation();
    if (frame.step.k > 0)
      margins_.take(now_, frame.step.scheme());
    states_->keep(integrator_.now());
    if (watch)
      watch(frame);
  });
}

} // namespace signorini::trajectory
