// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/lane_solver.h"
#include <algorithm>
#include <deque>

namespace signorini {

/// z ← L⁻¹ P b or x ← Pᵀ L⁻ᵀ z.
class LaneSolver::Half final : public SharedSolve {
public:
  Half(LaneSolver& solver, bool forward, Vec vector, const KeptPlace& place)
      : vector(vector), place(place), solver_(solver), forward_(forward) {}
  void make(std::span<SharedSolve* const> all) override {
    forward_ ? solver_.forward(all) : solver_.backward(all);
  }
  [[nodiscard]] const void* kind() const override {
    return reinterpret_cast<const char*>(&solver_) + (forward_ ? 0 : 1);
  }
  static Half& of(SharedSolve* one) { return static_cast<Half&>(*one); }
  [[nodiscard]] std::size_t number() const { return LaneSolver::number(place); }

  Vec vector;
  const KeptPlace& place;
  std::span<double> result{};            ///< of a forward half: the trailing values
  std::span<const double> replacement{}; ///< for a backward half: trailing values

private:
  LaneSolver& solver_;
  bool forward_;
};

LaneSolver::LaneSolver(const cholmod_factor& L, std::size_t trailing)
    : order_(static_cast<const int*>(L.Perm)), n_(L.n), trailing_(trailing), solves_(L) {}

std::size_t LaneSolver::bytes() const { return solves_.bytes() + kept_->values.bytes() + work_.bytes(); }

void LaneSolver::forward(Lockstep& lockstep, Vec b, KeptPlace& place, std::span<double> trailing) {
  if (place.kept_ != kept_) {
    place.leave();
    const auto free = std::ranges::find(kept_->used, false);
    place.number_ = static_cast<std::size_t>(free - kept_->used.begin());
    if (free == kept_->used.end()) {
      const std::size_t before = kept_->used.size(), more = std::max(before + 1, lockstep.tasks());
      SideBySide larger;
      larger.resize(n_, more);
      for (std::size_t i = 0; i < before; ++i)
        larger.copy_column(kept_->values, i, i);
      std::swap(kept_->values, larger);
      kept_->used.resize(more, false);
    }
    kept_->used[place.number_] = true;
    place.kept_ = kept_;
  }
  Half half(*this, true, b, place);
  half.result = trailing;
  lockstep.wait(half);
}

void LaneSolver::backward(Lockstep& lockstep, const KeptPlace& place, std::span<const double> trailing,
                          Vec x) {
  Half half(*this, false, x, place);
  half.replacement = trailing;
  lockstep.wait(half);
}

bool LaneSolver::whole(std::span<SharedSolve* const> all) const {
  for (std::size_t k = 0; k < all.size(); ++k)
    if (Half::of(all[k]).number() != k)
      return false;
  return all.size() == kept_->used.size();
}

void LaneSolver::forward(std::span<SharedSolve* const> all) {
  std::deque<petsc::ReadArray> arrays;
  std::vector<const double*> from;
  for (SharedSolve* const one : all)
    from.push_back(std::span<const double>(arrays.emplace_back(Half::of(one).vector)).data());
  const bool in_place = whole(all);
  work_.resize(n_, all.size());
  SideBySide& z = in_place ? kept_->values : work_;
  z.gather(from, order_);
  solves_.forward(z.groups());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Half& one = Half::of(all[k]);
    const SideBySide::Column values = z.column(k);
    for (std::size_t i = 0; i < trailing_; ++i)
      one.result[i] = values[n_ - trailing_ + i];
    if (!in_place)
      kept_->values.copy_column(work_, k, one.number());
  }
}

void LaneSolver::backward(std::span<SharedSolve* const> all) {
  work_.resize(n_, all.size());
  if (whole(all))
    work_.copy(kept_->values);
  else
    for (std::size_t k = 0; k < all.size(); ++k)
      work_.copy_column(kept_->values, Half::of(all[k]).number(), k);
  std::deque<petsc::WriteArray> arrays;
  std::vector<double*> to;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Half& one = Half::of(all[k]);
    const SideBySide::Column values = work_.column(k);
    for (std::size_t i = 0; i < one.replacement.size(); ++i)
      values[n_ - trailing_ + i] = one.replacement[i];
    to.push_back(std::span<double>(arrays.emplace_back(one.vector)).data());
  }
  solves_.backward(work_.groups());
  work_.scatter(order_, to);
}

} // namespace signorini
