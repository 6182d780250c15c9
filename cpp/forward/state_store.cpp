// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/state_store.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/scratch_file.h"
#include "forward/binomial_checkpointing.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <vector>

namespace signorini::forward {
using petsc::check;

namespace {
long &vectors = count("trajectory vectors"), &recomputed = count("recomputed steps");
constexpr const char *writing = "states written", *reading = "states read",
                     *recomputing = "states recomputed";
} // namespace

/// Every state, in memory.
class StateStoreFactory::InMemory final : public StateStore {
public:
  InMemory(const Stepper& stepper, int steps, bool velocities)
      : y_(petsc::zero_series(stepper.space().vector(), static_cast<std::size_t>(steps) + 1)),
        v_(velocities ? petsc::zero_series(y_.front(), y_.size()) : petsc::Series()) {
    vectors += static_cast<long>(y_.size() + v_.size());
  }

  void keep(const State& state) override {
    const auto i = static_cast<std::size_t>(state.k);
    check(VecCopy(state.y, y_[i]));
    if (!v_.empty())
      check(VecCopy(state.v, v_[i]));
  }

  View at(int k) override {
    const auto i = static_cast<std::size_t>(k);
    return {y_[i], v_.empty() ? nullptr : Vec(v_[i])};
  }

private:
  petsc::Series y_, v_;
};

/// Every state, in files of the ranks, and the one read last in memory.
class StateStoreFactory::OnDisk final : public StateStore {
public:
  OnDisk(const Stepper& stepper, int steps, bool velocities, Timers& timers)
      : timers_(timers), y_(stepper, steps) {
    if (velocities)
      v_.emplace(stepper, steps);
  }

  void keep(const State& state) override {
    const auto timer = timers_.time(writing);
    held_ = -1;
    y_.write(state.k, state.y);
    if (v_)
      v_->write(state.k, state.v);
  }

  View at(int k) override {
    if (k != held_) {
      const auto timer = timers_.time(reading);
      y_.read(k);
      if (v_)
        v_->read(k);
      held_ = k;
    }
    return {y_.last, v_ ? Vec(v_->last) : nullptr};
  }

private:
  struct Table {
    ScratchFile file;
    petsc::Vector last;

    Table(const Stepper& stepper, int steps)
        : file(static_cast<std::size_t>(steps) + 1, static_cast<std::size_t>(stepper.space().owned_nodes()) *
                                                        static_cast<std::size_t>(stepper.space().dim())),
          last(stepper.space().vector()) {}
    void write(int k, Vec x) { file.write(static_cast<std::size_t>(k), petsc::ReadArray(x)); }
    void read(int k) const { file.read(static_cast<std::size_t>(k), petsc::WriteArray(last)); }
  };

  Timers& timers_;
  Table y_;
  std::optional<Table> v_;
  int held_ = -1;
};

/// Checkpoints of one motion at a time.
struct StateStoreFactory::Pool {
  std::size_t room; ///< largest number of checkpoints
  std::vector<std::unique_ptr<State>> free;
  std::vector<std::unique_ptr<State>> used; ///< ascending
  const void* owner = nullptr;

  /// Frees the checkpoints beyond t_k.
  void release_beyond(int k) {
    for (; !used.empty() && used.back()->k > k; used.pop_back())
      free.push_back(std::move(used.back()));
  }
  void keep(const Stepper& stepper, const State& state) {
    if (free.empty())
      free.push_back(std::make_unique<State>(stepper));
    used.push_back(std::move(free.back()));
    free.pop_back();
    used.back()->take(state);
  }
};

class StateStoreFactory::Checkpoints final : public StateStore {
public:
  Checkpoints(const Stepper& stepper, const TimeGrid& grid, std::shared_ptr<Pool> pool,
              TimeIntegrator& integrator, Timers& timers)
      : stepper_(stepper), grid_(grid), pool_(std::move(pool)), integrator_(integrator), timers_(timers) {}
  ~Checkpoints() override {
    if (pool_->owner == this)
      pool_->owner = nullptr;
  }

  void keep(const State& state) override {
    own();
    if (state.k == 0)
      pool_->release_beyond(0);
    went_back_ = false;
    place(grid_.steps());
  }

  View at(int k) override {
    own();
    const bool back = integrator_.state().k < 0 || integrator_.state().k > k, up = integrator_.state().k < k;
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
    if (integrator_.state().k < k) {
      const auto timer = timers_.time(recomputing);
      for (; integrator_.state().k < k; ++recomputed) {
        place(back ? k : grid_.steps());
        integrator_.advance(grid_.step(integrator_.state().k + 1));
      }
    }
    return {integrator_.state().y, integrator_.state().v};
  }

private:
  /// Takes over the pool; checkpoints of another motion are discarded.
  void own() {
    if (std::exchange(pool_->owner, this) != this)
      pool_->release_beyond(0);
  }

  /// Makes a checkpoint of the integrator's state if one is due for the steps to t_last and back.
  void place(int last) {
    const int here = integrator_.state().k, from = pool_->used.empty() ? 0 : pool_->used.back()->k,
              slots = static_cast<int>(pool_->room - pool_->used.size());
    if (slots > 0 && here < last && here > from && here >= from + next_checkpoint(last - from, slots))
      pool_->keep(stepper_, integrator_.state());
  }

  const Stepper& stepper_;
  TimeGrid grid_;
  std::shared_ptr<Pool> pool_;
  TimeIntegrator& integrator_;
  Timers& timers_;
  bool went_back_ = false; ///< a reverse sweep is under way
};

StateStoreFactory::StateStoreFactory(const Stepper& stepper, const TimeGrid& grid,
                                     const scene::Trajectory& scene, double share, Timers& timers)
    : stepper_(stepper), scene_(scene), grid_(grid), timers_(timers) {
  if (scene.storage != scene::Storage::checkpoints)
    return;
  const double one = State::bytes(stepper), room = share * scene.budget / one;
  if (room < 1)
    throw UserError(
        fmt::format("trajectory.budget: found {:.6g} bytes, allowed are {:.6g} or more: a checkpoint takes "
                    "{:.3g} MB, and {}",
                    scene.budget, std::ceil(one / share), one * 1e-6,
                    share < 1 ? "the desired motion needs one of its own" : "there must be one"));
  pool_ = std::make_shared<Pool>(static_cast<std::size_t>(std::min(room, std::max(grid.steps() - 1.0, 0.0))));
}

std::unique_ptr<StateStore> StateStoreFactory::place(TimeIntegrator& integrator, bool velocities) const {
  if (pool_)
    return std::make_unique<Checkpoints>(stepper_, grid_, pool_, integrator, timers_);
  if (in_memory())
    return std::make_unique<InMemory>(stepper_, grid_.steps(), velocities);
  return std::make_unique<OnDisk>(stepper_, grid_.steps(), velocities, timers_);
}

double StateStoreFactory::bytes(bool velocities) const {
  return pool_ ? static_cast<double>(pool_->room) * State::bytes(stepper_)
               : (velocities ? 2 : 1) * sizeof(PetscScalar) * static_cast<double>(stepper_.space().dofs()) *
                     (grid_.steps() + 1.0);
}

} // namespace signorini::forward
