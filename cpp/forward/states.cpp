#include "forward/states.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/scratch_file.h"
#include "forward/schedule.h"
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

/// Every state.
class Storage::InMemory final : public States {
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

/// Every state, in files of the ranks, and one in memory.
class Storage::OnDisk final : public States {
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
struct Storage::Pool {
  std::size_t room; ///< for so many
  std::vector<std::unique_ptr<State>> free;
  std::vector<std::unique_ptr<State>> used; ///< ascending
  const void* owner = nullptr;

  /// Gives up the checkpoints beyond t_k.
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

class Storage::Checkpoints final : public States {
public:
  Checkpoints(const Stepper& stepper, int steps, std::shared_ptr<Pool> pool, March& march, Timers& timers)
      : stepper_(stepper), steps_(steps), pool_(std::move(pool)), march_(march), timers_(timers) {}
  ~Checkpoints() override {
    if (pool_->owner == this)
      pool_->owner = nullptr;
  }

  void keep(const State& state) override {
    own();
    if (state.k == 0)
      pool_->release_beyond(0);
    went_back_ = false;
    place(steps_);
  }

  View at(int k) override {
    own();
    const bool back = march_.state().k < 0 || march_.state().k > k, up = march_.state().k < k;
    if (up && std::exchange(went_back_,
                            false)) // a way back is over: those kept for it are in the way of the next one's
      pool_->release_beyond(0);
    if (back) {
      went_back_ = true;
      pool_->release_beyond(k);
      if (pool_->used.empty())
        march_.restart();
      else
        march_.resume(*pool_->used.back());
    }
    if (march_.state().k < k) {
      const auto timer = timers_.time(recomputing);
      for (; march_.state().k < k; ++recomputed) {
        place(back ? k : steps_);
        march_.advance();
      }
    }
    return {march_.state().y, march_.state().v};
  }

private:
  void own() {
    if (std::exchange(pool_->owner, this) != this)
      pool_->release_beyond(0);
  }

  /// Keeps where the march is, if that is due on the way to t_last and back.
  void place(int last) {
    const int here = march_.state().k, from = pool_->used.empty() ? 0 : pool_->used.back()->k,
              slots = static_cast<int>(pool_->room - pool_->used.size());
    if (slots > 0 && here < last && here > from && here >= from + next_checkpoint(last - from, slots))
      pool_->keep(stepper_, march_.state());
  }

  const Stepper& stepper_;
  int steps_;
  std::shared_ptr<Pool> pool_;
  March& march_;
  Timers& timers_;
  bool went_back_ = false; ///< with the last state asked for
};

Storage::Storage(const Stepper& stepper, const scene::Trajectory& scene, int steps, double share,
                 Timers& timers)
    : stepper_(stepper), scene_(scene), steps_(steps), timers_(timers) {
  if (scene.storage != "checkpoints")
    return;
  const double one = State::bytes(stepper), room = share * scene.budget / one;
  if (room < 1)
    throw UserError(
        fmt::format("trajectory.budget: found {:.6g} bytes, allowed are {:.6g} or more: a checkpoint takes "
                    "{:.3g} MB, and {}",
                    scene.budget, std::ceil(one / share), one * 1e-6,
                    share < 1 ? "the desired motion needs one of its own" : "there must be one"));
  pool_ = std::make_shared<Pool>(static_cast<std::size_t>(std::min(room, std::max(steps - 1.0, 0.0))));
}

std::unique_ptr<States> Storage::place(March& march, bool velocities) const {
  if (pool_)
    return std::make_unique<Checkpoints>(stepper_, steps_, pool_, march, timers_);
  if (in_memory())
    return std::make_unique<InMemory>(stepper_, steps_, velocities);
  return std::make_unique<OnDisk>(stepper_, steps_, velocities, timers_);
}

double Storage::bytes() const {
  return pool_ ? static_cast<double>(pool_->room) * State::bytes(stepper_)
               : sizeof(PetscScalar) * static_cast<double>(stepper_.space().dofs()) * (steps_ + 1.0);
}

} // namespace signorini::forward
