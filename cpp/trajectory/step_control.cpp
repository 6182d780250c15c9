// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/step_control.h"
#include "fem/wave_time.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace signorini::trajectory {
using petsc::check;

namespace {

/// Distance of stored displacements in a run of equal steps, in levels and in steps. Number of equal steps
/// after which longer ones are considered, since four displacements are then stored.
constexpr int apart_levels = 2, apart = 1 << apart_levels, settled = 3 * apart;
/// Number of levels by which steps grow in a flight without vibration to resolve; least number of levels by
/// which a rejected step shrinks.
constexpr int flight_levels = 4, least_shortening = 2;
/// Fraction of the error limit that the predicted error of a longer step may reach.
constexpr double caution = 0.5;
/// Fractions of the tolerance: for the variation of loads, obstacles and clamps within a step; for
/// differences of mean forces, relative to the largest force.
constexpr double of_load = 0.1, of_force = 0.5;
/// Largest non-rigid part of an undeformed body's displacement, velocity or force, relative to the whole
/// field.
constexpr double undeformed = 0x1p-40;
/// Numbers of steps in a flight beyond which vibration is ignored: in all, and relative to the steps of the
/// last contact. The larger one counts.
constexpr int most_flight = 1000, most_of_contact = 10;
/// Cost of a new step length, in steps: of a factorisation in the plane, of one in space, with conjugate
/// gradients.
constexpr double price_in_plane = 40, price_in_space = 80, price_if_iterative = 10;

} // namespace

StepControl::StepControl(const step::Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), quantity_(scene.time.quantity), tolerance_(scene.time.tolerance),
      waves_(2 * fem::crossing_time(stepper.space(), scene.materials)), window_(stepper.wave_time()),
      steps_(*stepper.step_lengths()), floor_(steps_.step_lengths().levels), errors_(stepper, scene),
      approach_(stepper, scene, errors_), used_(static_cast<std::size_t>(floor_) + 1),
      rejections_(used_.size()), difference_(stepper.space().vector()) {
  price_ = stepper.solver().iterates()  ? price_if_iterative
           : stepper.space().dim() == 2 ? price_in_plane
                                        : price_in_space;
  used_.back() = true;
  for (petsc::Vector& y : displacements_)
    y = stepper.space().vector();
}

void StepControl::start(Vec y, Vec v, const step::ForceAtStep& load) {
  load_ = &load;
  errors_.start(y, v);
  steps_.clear();
  level_ = floor_;
  stored_ = flight_steps_ = rejected_ = least_level_ = 0;
  fresh_ = false;
  time_ = 0;
  vibration_ignored_ = false;
  std::ranges::fill(rejections_, 0);
  // An undeformed body that only rigid forces drive stays so, and steps of any length are exact.
  const fem::RigidMotions& rigid = errors_.rigid();
  const auto is_rigid = [&](Vec x) {
    const double size = errors_.size(x);
    check(VecCopy(x, difference_));
    rigid.subtract(rigid.coefficients(x), difference_);
    return errors_.size(difference_) <= undeformed * size;
  };
  const bool surrounded = stepper_.operators().surrounded(); // rigid motions then do not persist
  strained_ = surrounded || !is_rigid(y) || !is_rigid(v) || load.variation(0, stepper_.end()) > 0;
  if (!strained_) {
    const double tau = stepper_.step_lengths()->shortest_step();
    assemble(load.at({1, 0, tau, tau}), stepper_.operators(), difference_);
    stepper_.clamped().clear(difference_);
    PetscReal size = 0, rest = 0;
    check(VecNorm(difference_, NORM_INFINITY, &size));
    std::vector<double> acceleration = rigid.products(difference_);
    rigid.subtract_forces(acceleration, difference_);
    check(VecNorm(difference_, NORM_INFINITY, &rest));
    strained_ = rest > undeformed * size;
    errors_.set_acceleration(std::move(acceleration));
  }
  level_ = next(floor_);
}

double StepControl::limit(double tau) const {
  const double part = std::pow(tolerance_, 1.5); // e ∼ τ³, the error of all steps ∼ τ²
  if (errors_.contact())
    return part * errors_.scale();
  if (ignores_vibration())
    return std::numeric_limits<double>::infinity();
  const double until = approach_.all_candidates_movable() ? until_touch_ : errors_.closing(),
               flight = time_ - errors_.last_contact().end + std::min(until, stepper_.end() - time_);
  const double scale =
      stepper_.operators().surrounded() ? std::max(errors_.scale(), errors_.travel()) : errors_.scale();
  return std::min(part, tolerance_ * tau / (2 * flight)) * scale; // phases add up
}

bool StepControl::ignores_vibration() const {
  if (vibration_ignored_ || errors_.without_phases() <= tolerance_ * errors_.scale())
    return true;
  return quantity_ == scene::StepQuantity::contact_force && stepper_.pairs() &&
         approach_.all_candidates_movable() && std::isinf(until_touch_) &&
         !stepper_.operators().surrounded() && !(load_->variation(time_, stepper_.end()) > 0);
}

int StepControl::judged(const Frame& frame) {
  const int level = steps_.step_lengths().level(frame.step.tau);
  const StepErrors::Step step = errors_.judge(frame);
  if (level == floor_)
    return level;
  if (step.touches)
    return floor_;
  if (!strained_)
    return level;
  int again = level;
  if (const double most = limit(frame.step.tau); step.error > most) {
    constexpr double most_levels = 40;
    const double thirds = std::min(std::ceil(std::log2(step.error / most) / 6), most_levels);
    again += std::max(least_shortening, 2 * static_cast<int>(thirds));
  }
  if (errors_.contact() && forces_matter() &&
      step.force_curvature > tolerance_ * errors_.last_contact().largest_force)
    again = std::max(again, level + least_shortening);
  return std::min(again, floor_);
}

bool StepControl::accepts(const Frame& frame) {
  const int level = steps_.step_lengths().level(frame.step.tau);
  int decided = judged(frame);
  // Every rank has the same sums, up to rounding: the decision of rank 0 counts for all.
  MPI_Bcast(&decided, 1, MPI_INT, 0, stepper_.space().comm());
  used_[level] = true;
  if (decided != level) {
    ++rejected_;
    ++rejections_[level];
    stored_ = 0;
    level_ = decided;
    steps_.remove();
    return false;
  }
  const bool contact = errors_.contact();
  remember(frame);
  errors_.accept(frame);
  time_ = frame.step.end;
  strained_ = strained_ || errors_.contact();
  flight_steps_ = errors_.contact() ? 0 : flight_steps_ + 1;
  vibration_ignored_ =
      !errors_.contact() &&
      (vibration_ignored_ ||
       flight_steps_ > std::max(most_flight, most_of_contact * errors_.last_contact().steps));
  level_ = steps_.complete() ? level : next(level);
  MPI_Bcast(&level_, 1, MPI_INT, 0, stepper_.space().comm());
  if (level_ < level && fresh_ && stored_ > 2)
    errors_.coarsen(time_, apart * frame.step.tau, displacements_[0], displacements_[1], displacements_[2]);
  if (level_ != level || contact != errors_.contact())
    stored_ = 0;
  return true;
}

void StepControl::remember(const Frame& frame) {
  const auto take = [&](Vec y) {
    std::rotate(displacements_.begin(), displacements_.end() - 1, displacements_.end());
    check(VecCopy(y, displacements_[0]));
    ++stored_;
  };
  // Whether a longer step may begin here.
  const auto fits = [longer = steps_.step_lengths().level(frame.step.tau) - apart_levels](int least) {
    return least <= longer;
  };
  if (stored_ == 0 && fits(least_level_))
    take(frame.before->y());
  least_level_ = steps_.least_level();
  fresh_ = stored_ > 0 && fits(least_level_);
  if (fresh_)
    take(frame.after.y());
}

int StepControl::next(int level) {
  const step::StepLengths& step_lengths = steps_.step_lengths();
  until_touch_ = approach_.until_touch(time_);
  const double left = step_lengths.end - time_, ahead = std::min(until_touch_, left);
  if (errors_.contact()) {
    level = affordable_level(grown_level(level), std::min(expected_contact_time(), ahead));
  } else if (!strained_ || ignores_vibration()) {
    level = affordable_level(longest_within(ahead), ahead);
  } else {
    level = affordable_level(grown_level(level), ahead);
  }
  if (step_lengths.length(level) > until_touch_)
    level = affordable_level(longest_within(until_touch_), ahead);
  const auto resolved = [&](int one) {
    const double to = std::min(time_ + step_lengths.length(one), step_lengths.end);
    return load_->variation(time_, to) <= of_load * tolerance_ &&
           approach_.smooth(time_, to, of_load * tolerance_ * errors_.scale(), of_load * tolerance_);
  };
  while (level < floor_ && !resolved(level))
    level = affordable_level(std::min(level + apart_levels, floor_), left);
  return level;
}

int StepControl::longest_within(double time) const {
  constexpr double hair = 1e-9; // where a length fills the time, in any unit
  int level = floor_;
  while (level >= flight_levels && steps_.step_lengths().length(level - flight_levels) <= (1 + hair) * time)
    level -= flight_levels;
  return level;
}

int StepControl::affordable_level(int level, double ahead) const {
  const step::StepLengths& step_lengths = steps_.step_lengths();
  int known = std::max(level, steps_.least_level());
  while (!used_[known])
    ++known; // to the floor
  if (level < steps_.least_level() || known == level)
    return known;
  const double saved = ahead / step_lengths.length(known) - ahead / step_lengths.length(level);
  return saved > price_ ? level : known;
}

int StepControl::grown_level(int level) {
  const step::StepLengths& step_lengths = steps_.step_lengths();
  const double tau = step_lengths.length(level);
  const int steps = apart * (stored_ - 1);
  if (!fresh_ || steps < settled)
    return level;
  const auto rested = [&](int to) { // after the rejection of a length
    constexpr int most_doublings = 4;
    return steps >= settled << std::min(rejections_[to], most_doublings);
  };
  check(VecWAXPY(difference_, -1, displacements_[3], displacements_[0]));
  check(VecAXPBYPCZ(difference_, -3, 3, 1, displacements_[1], displacements_[2]));
  const double error = errors_.error_of(difference_, displacements_[0]); // of steps of the length 4 τ
  const auto allowed = [&](int to) {
    const double growth = std::exp2(level - to), of_to = error * std::pow(growth / apart, 3);
    return to >= 0 && rested(to) && of_to <= caution * limit(growth * tau);
  };
  int longer = level - apart_levels;
  if (!allowed(longer) || (errors_.contact() && forces_matter() && !forces_agree(tau)))
    return level;
  while (!errors_.contact() && allowed(longer - apart_levels))
    longer -= apart_levels;
  return longer;
}

double StepControl::expected_contact_time() const {
  const double since = time_ - errors_.last_contact().begin;
  return std::max(waves_ - since, since);
}

bool StepControl::forces_matter() const {
  return quantity_ == scene::StepQuantity::contact_force || approach_.all_candidates_movable();
}

bool StepControl::forces_agree(double tau) const {
  const ImpulseRecord& force = errors_.force();
  const double half = apart * tau, last = time_ - std::max(half, window_);
  double worst = 0;
  for (int step = 0; step <= settled; ++step) {
    const double middle = last - step * tau;
    worst = std::max(worst, std::abs(force.mean(middle - half, middle + half) -
                                     force.mean(middle - window_, middle + window_)));
  }
  return worst <= of_force * tolerance_ * errors_.last_contact().largest_force;
}

} // namespace signorini::trajectory
