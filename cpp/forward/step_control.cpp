// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/step_control.h"
#include "base/collective.h"
#include "contact/normal_operator.h"
#include <algorithm>
#include <cmath>

namespace signorini::forward {
using petsc::check;

namespace {

/// Part of the tolerance that a step may use: errors of ten steps, as of touch and release, add up to it.
constexpr double share = 0.1;
/// A length is taken if the estimate for it is below this part of what is allowed, else it would often be
/// made again.
constexpr double caution = 0.7;
/// By how many halvings a step is shortened at most before it is judged anew.
constexpr double most_halvings = 6;
/// Steps that cost as much as the factorisation of another length, by measurements in two and three
/// dimensions.
constexpr double length_price = 20;
/// Lengths at hand are near if they are shorter than what is allowed by so many halvings.
constexpr int near_allowed = 2, near_touch = 3;
/// Halvings that another length saves at least if it is not the one that is wanted, but one that begins here.
constexpr int worth_it = 2;
/// Part of the time until a touch, which gravity shortens, that a step before it may take.
constexpr double approach = 0.8;

/// Factors of values at times t, the newest first, in the distance of the newest from the polynomial through
/// the others.
template <std::size_t n>
std::array<double, n> distance(const std::array<double, n>& t) {
  std::array<double, n> factors{1};
  for (std::size_t i = 1; i < n; ++i) {
    double weight = 1;
    for (std::size_t j = 1; j < n; ++j)
      if (j != i)
        weight *= (t[0] - t[j]) / (t[i] - t[j]);
    factors[i] = -weight;
  }
  return factors;
}

double norm(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

} // namespace

StepControl::StepControl(const Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), quantity_(scene.time.quantity), tolerance_(scene.time.tolerance),
      ladder_(scene.time), prescribed_(stepper.space(), scene), weights_(fem::diagonal(stepper.M())),
      difference_(stepper.space().vector()), work_(stepper.space().vector()),
      start_(stepper.space().vector()), gaps_(static_cast<std::size_t>(candidates(stepper))),
      used_(static_cast<std::size_t>(ladder_.levels) + 1) {
  const fem::Space& space = stepper.space();
  for (int c = 0; c < space.dim(); ++c) {
    const petsc::Vector e = space.vector();
    {
      const petsc::WriteArray values(e);
      for (std::size_t i = static_cast<std::size_t>(c); i < values.size();
           i += static_cast<std::size_t>(space.dim()))
        values[i] = 1;
    }
    petsc::Vector& Me = rigid_[static_cast<std::size_t>(c)] = space.vector();
    check(MatMult(stepper.M(), e, Me));
    mass_ = petsc::dot(e, Me);
  }
  PetscScalar trace = 0;
  check(VecSum(weights_, &trace));
  check(VecScale(weights_, mass_ * space.dim() / trace));
  int clamped = !stepper.clamped().dofs().empty();
  MPI_Allreduce(MPI_IN_PLACE, &clamped, 1, MPI_INT, MPI_MAX, space.comm());
  free_ = clamped == 0;
  for (Mean& mean : means_)
    mean.w = space.vector();
}

void StepControl::start(Vec y, Vec v, int level) {
  check(VecCopy(y, start_));
  known_ = 1; // the initial velocity, of t_0
  Mean& initial = means_[1];
  check(VecCopy(v, initial.w));
  for (std::size_t c = 0; c < static_cast<std::size_t>(stepper_.space().dim()); ++c)
    initial.rigid[c] = petsc::dot(rigid_[c], v) / mass_;
  initial.middle = initial.end = initial.tau = 0;
  initial.force = {};
  impulse_ = 0;
  rejected_ = 0;
  again_ = false;
  touching_level_ = 0;
  lost_ = 0;
  held_until_ = 0;
  phase_ = {};
  level_ = resolving(level, 0);
  if (const contact::ContactPairs* pairs = stepper_.pairs())
    contact::NormalOperator(*pairs).gap(pairs->psi(), y, gaps_);
}

void StepControl::Phase::observe(double from, double to, bool touches) {
  constexpr double pause = 0.1; // of the phase so far: contact that is made again so soon goes on
  constexpr int resolved = 10;  // steps; fewer are those of a single node, such as a corner
  if (!touches)
    return;
  if (steps == 0 || from - last > pause * (last - begun)) {
    begun = from;
    steps = 0;
  }
  last = to;
  if (++steps >= resolved)
    longest = std::max(longest, last - begun);
}

double StepControl::size(Vec x) const {
  check(VecPointwiseMult(work_, weights_, x));
  return std::sqrt(petsc::dot(work_, x) / mass_);
}

void StepControl::take_sizes(const Frame& frame) {
  used_[static_cast<std::size_t>(stepper_.grid().level(frame.k))] = true;
  set_means(frame);
  energy_ = std::max(energy_, mass_ * std::pow(size(frame.v1), 2) / 2);
  check(VecWAXPY(difference_, -1, start_, frame.y1));
  displacement_ = std::max(displacement_, size(difference_));
}

void StepControl::size_up(const Frame& frame) {
  take_sizes(frame);
  coarse_impulse_ += means_[0].tau * norm(means_[0].force);
  level_ = resolving(stepper_.grid().least_level(), stepper_.grid().time(frame.k));
}

void StepControl::set_means(const Frame& frame) {
  const TimeGrid& grid = stepper_.grid();
  const double tau = grid.length(frame.k);
  Mean& now = means_[0];
  check(VecWAXPY(now.w, -1, frame.y0, frame.y1));
  check(VecScale(now.w, 1 / tau));
  now.middle = grid.load_time(frame.k);
  now.end = grid.time(frame.k);
  now.tau = tau;
  const auto dim = static_cast<std::size_t>(stepper_.space().dim());
  for (std::size_t c = 0; c < dim; ++c)
    now.rigid[c] = petsc::dot(rigid_[c], now.w) / mass_;
  now.force = {};
  if (const contact::ContactPairs* pairs = stepper_.pairs()) {
    const double impulse = grid.scheme(frame.k).impulse();
    for (std::size_t i = 0; i < frame.contact.lambda.size(); ++i)
      for (std::size_t c = 0; c < dim; ++c)
        now.force[c] -= frame.contact.lambda[i] / impulse * pairs->normals()[dim * i + c];
  }
}

double StepControl::displacement_error(const Frame& frame, double factor, double part) const {
  double error = factor * size(difference_);
  if (free_ && known_ == most_known) {
    const auto factors =
        distance<4>({means_[0].middle, means_[1].middle, means_[2].middle, means_[3].middle});
    std::array<double, 3> off{};
    for (std::size_t i = 0; i < factors.size(); ++i)
      for (std::size_t c = 0; c < off.size(); ++c)
        off[c] += factors[i] * means_[i].rigid[c];
    error += part * norm(off) / 12 * (stepper_.grid().end() - stepper_.grid().time(frame.k));
  }
  return displacement_ > 0 ? error / displacement_ : 0;
}

double StepControl::force_error(double tau, double part) const {
  const double scale = std::max({impulse_, coarse_impulse_, std::sqrt(2 * energy_ * mass_)});
  if (known_ < most_known || !(scale > 0))
    return 0;
  std::array<double, 3> times{}, off{};
  for (std::size_t i = 0; i < times.size(); ++i)
    times[i] = means_[i].end - means_[i].tau;
  const auto factors = distance<3>(times);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const Mean &now = means_[i], &before = means_[i + 1];
    for (std::size_t c = 0; c < off.size(); ++c)
      off[c] += factors[i] * (now.tau * now.force[c] + before.tau * before.force[c]) / (now.tau + before.tau);
  }
  return part * tau / 12 * norm(off) / scale;
}

double StepControl::energy_error(double factor) {
  check(MatMult(stepper_.operators().A, difference_, work_));
  const double squared = std::max(0.0, petsc::dot(difference_, work_));
  return energy_ > 0 ? factor * std::sqrt(squared / (2 * energy_)) : 0;
}

double StepControl::error(const Frame& frame, bool abrupt) {
  take_sizes(frame);
  if (known_ == 1) // the first step has nothing to be compared with
    return 0;
  const double tau = stepper_.grid().length(frame.k);
  const std::array<double, 3> times{means_[0].middle, means_[1].middle, means_[2].middle};
  const auto factors = distance<3>(times);
  check(VecAXPBYPCZ(difference_, factors[0], factors[1], 0, means_[0].w, means_[1].w));
  check(VecAXPY(difference_, factors[2], means_[2].w));
  const double part =
      abrupt ? 1 : std::min(1.0, 2 * tau * tau / ((times[0] - times[1]) * (times[0] - times[2])));
  const double factor = tau / 12 * part;
  switch (quantity_) {
  case scene::StepQuantity::displacement:
    return displacement_error(frame, factor, part);
  case scene::StepQuantity::contact_force:
    return force_error(tau, part);
  case scene::StepQuantity::energy:
    break;
  }
  return energy_error(factor);
}

double StepControl::until_touch(const Frame& frame) {
  double until = stepper_.grid().end();
  const double tau = stepper_.grid().length(frame.k);
  for (std::size_t i = 0; i < gaps_.size(); ++i) {
    const double now = frame.contact.gap[i], nearer = gaps_[i] - now;
    if (nearer > 0)
      until = std::min(until, tau * std::max(now, 0.0) / nearer);
    gaps_[i] = now;
  }
  return until;
}

int StepControl::at_hand(int allowed, int near) const {
  const int last = std::min(ladder_.levels, allowed + near);
  for (int level = allowed; level <= last; ++level)
    if (used_[static_cast<std::size_t>(level)])
      return level;
  return -1;
}

int StepControl::resolving(int level, double t) const {
  while (level < ladder_.levels && t < ladder_.end &&
         !prescribed_.resolves(t, std::min(t + ladder_.length(level), ladder_.end), share * tolerance_))
    ++level;
  return level;
}

int StepControl::next_level(const Frame& frame, double found) {
  const TimeGrid& grid = stepper_.grid();
  const int now = grid.level(frame.k), least = grid.least_level();
  const double touch = until_touch(frame);
  if (known_ == 1)
    return now;
  // Of third order in the length; smooth motions have no error at all.
  const double doublings = std::floor(std::log2(caution / std::max(found, 1e-12)) / 3);
  int allowed = now - std::clamp(static_cast<int>(doublings), 0, now);
  if (grid.time(frame.k) < held_until_)
    allowed = std::max(allowed, held_level_);
  if (frame.contact.active.empty()) {
    const double longest = std::max(approach * touch, ladder_.length(touching_level_));
    while (allowed < ladder_.levels && ladder_.length(allowed) > longest)
      ++allowed;
    if (allowed > now) {
      const int known = at_hand(allowed, near_touch);
      return std::max(known >= 0 ? known : std::min(allowed + near_touch, touching_level_), least);
    }
  }
  if (allowed == now || least >= now) {
    lost_ = std::max(0.0, lost_ - 1);
    return std::max(now, least);
  }
  const int known = at_hand(std::max(allowed, least), now);
  lost_ += 1 - std::exp2(allowed - known);
  const int next = std::max(allowed, least);
  if (lost_ < length_price || (next != allowed && next > now - worth_it))
    return known;
  lost_ = 0;
  return next;
}

bool StepControl::accepts(const Frame& frame, const contact::ContactSets& before) {
  const TimeGrid& grid = stepper_.grid();
  const int level = grid.level(frame.k);
  const bool abrupt = again_ || frame.contact.active != before.active;
  const double found = error(frame, abrupt) / (share * tolerance_);
  const bool touches = before.active.empty() && !frame.contact.active.empty(),
             releases = !before.active.empty() && frame.contact.active.empty();
  const double event = touches || releases ? tolerance_ * phase_.longest : 0, // length of a step for it, s
      sharpness = event > 0 ? grid.length(frame.k) / event : 0;
  again_ = std::max(found, sharpness) > 1 && level < ladder_.levels;
  if (again_) {
    const double halvings =
        std::max(std::ceil(std::log2(found / caution) / (abrupt ? 1 : 3)), std::ceil(std::log2(sharpness)));
    level_ = std::min(ladder_.levels, level + static_cast<int>(std::clamp(halvings, 1.0, most_halvings)));
    if (const int known = at_hand(level_, near_allowed); known >= 0)
      level_ = known;
    if (touches)
      touching_level_ = level_;
    if (releases) {
      held_level_ = level_;
      held_until_ = grid.time(frame.k);
    }
  } else {
    phase_.observe(grid.time(frame.k - 1), grid.time(frame.k), !frame.contact.active.empty());
    level_ = resolving(next_level(frame, found), grid.time(frame.k));
  }
  // Every rank has the same sums, but a difference in rounding must not divide them.
  std::array<int, 2> decided{again_, level_};
  MPI_Bcast(decided.data(), static_cast<int>(decided.size()), MPI_INT, 0, stepper_.space().comm());
  again_ = decided[0] != 0;
  level_ = decided[1];
  if (again_) {
    ++rejected_;
    return false;
  }
  impulse_ += grid.length(frame.k) * norm(means_[0].force);
  std::rotate(means_.begin(), means_.end() - 1, means_.end());
  known_ = std::min(known_ + 1, most_known);
  return true;
}

} // namespace signorini::forward
