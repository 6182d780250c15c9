// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/passage.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::diagnostics {
namespace {

constexpr double most = 0.5; ///< of a depth

/// The extent of the body along a normal, m.
double depth_along(const double* nu, const std::array<double, 3>& extent, std::size_t dim) {
  double sum = 0;
  for (std::size_t c = 0; c < dim; ++c)
    sum += std::abs(nu[c]) * extent[c];
  return sum;
}

} // namespace

Passage::Passage(const step::Stepper& stepper) : stepper_(stepper) {
  if (const contact::ContactPairs* pairs = stepper.pairs()) {
    now_ = pairs->gaps(), before_ = pairs->gaps();
    gaps_.resize(static_cast<std::size_t>(pairs->count()));
    moved_.resize(gaps_.size());
    worst_.resize(static_cast<std::size_t>(pairs->obstacle_count()));
  }
}

void Passage::observe(const trajectory::Frame& frame) {
  const contact::ContactPairs* pairs = stepper_.pairs();
  if (!pairs)
    return;
  std::swap(now_, before_);
  const std::span<const double> psi = pairs->psi(frame.step.end, *now_);
  const auto dim = static_cast<std::size_t>(pairs->dim());
  struct Closing {
    double body = 0, gap = std::numeric_limits<double>::infinity(), depth = 0; ///< m
    double level = 0; ///< by which a level set comes closer, m
    const contact::Obstacle* shape = nullptr;
  };
  std::vector<Closing> all(worst_.size());
  for (std::size_t i = 0; i < gaps_.size(); ++i) {
    const double moved = psi[i] - frame.contact.gap[i], before = std::exchange(moved_[i], moved),
                 gap = std::exchange(gaps_[i], frame.contact.gap[i]);
    Closing& one = all[static_cast<std::size_t>(pairs->obstacles()[i])];
    one.shape = &pairs->obstacle(static_cast<int>(i));
    one.body = std::max(one.body, std::abs(moved - before));
    one.level = std::max(one.level, std::abs(frame.contact.gap[i] - gap + moved - before));
    if (gap < one.gap) {
      one.gap = gap;
      one.depth = depth_along(&pairs->normals()[dim * i], stepper_.space().mesh().extent(), dim);
    }
  }
  for (std::size_t o = 0; frame.step.k > 0 && o < all.size(); ++o) {
    const Closing& one = all[o];
    const contact::Obstacle::Place &from = before_->place[o], &to = now_->place[o];
    const double way = std::hypot(to.point[0] - from.point[0], to.point[1] - from.point[1],
                                  to.point[2] - from.point[2]),
                 path = one.body + std::max(way, one.level),
                 depth = one.shape->surrounds() ? one.depth : std::min(one.depth, 2 * to.radius);
    if (path > most * depth && one.gap < path && path / depth > worst_[o].share)
      worst_[o] = {path / depth, path, depth, frame.step};
  }
}

std::vector<Warning> Passage::warnings() const {
  std::vector<Warning> found;
  for (std::size_t o = 0; o < worst_.size(); ++o)
    if (const Worst& worst = worst_[o]; worst.share > most)
      found.push_back(
          {"passage within a step",
           fmt::format(
               "{}: in the step to t = {:.6g} s the obstacle and the body approach by {:.3g} m, {:.3g} "
               "times the {:.3g} m that the thinner one is deep: what happens within the step is "
               "not seen, and one may pass through the other; let time.step be below {:.2g} s",
               stepper_.pairs()->key(static_cast<int>(o)), worst.step.end, worst.path, worst.share,
               worst.depth, worst.step.tau * most / worst.share),
           worst.share, most});
  return found;
}

} // namespace signorini::diagnostics
