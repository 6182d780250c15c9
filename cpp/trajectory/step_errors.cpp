// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/step_errors.h"
#include "fem/wave_time.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::trajectory {
using petsc::check;

namespace {

/// Rounding error in the third difference of displacements, relative to a displacement.
constexpr double rounding_of_y = 0x1p-50;
/// Divisor in the error of a trapezoidal step, τ³/12 times the third derivative.
constexpr double trapezoidal = 12;
/// Largest sum of errors in contact without a warning, in units of the tolerance.
constexpr double most_accumulated = 5;
/// Largest shift of a touch by rotation from rounding without a warning, in units of the shortest step.
constexpr double most_turned = 0.2;
/// Weight of the shortest steps' errors in a flight between two touches, found by trials.
constexpr double of_shortest = 0.2;

/// Returns the factors of three values at times t, the newest first, whose weighted sum is the distance of
/// the newest value from the line through the others.
std::array<double, 3> distance(const std::array<double, 3>& t) {
  return {1, -(t[0] - t[2]) / (t[1] - t[2]), -(t[0] - t[1]) / (t[2] - t[1])};
}

} // namespace

StepErrors::StepErrors(const step::Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), tolerance_(scene.time.tolerance), quantity_(scene.time.quantity),
      crossing_(fem::crossing_time(stepper.space(), scene.materials)),
      rigid_(stepper.space(), stepper.clamped(), stepper.M()), weights_(fem::diagonal(stepper.M())),
      difference_(stepper.space().vector()), work_(stepper.space().vector()) {
  PetscScalar sum = 0;
  check(VecSum(weights_, &sum));
  check(VecScale(weights_, stepper.space().dim() / sum));
  check(VecSum(fem::diagonal(stepper.operators().A), &trace_));
  for (Mean& mean : means_)
    mean.w = stepper.space().vector();
  const contact::ContactPairs* pairs = stepper.pairs();
  if (!pairs)
    return;
  psi_ = pairs->gaps();
  gaps_.resize(static_cast<std::size_t>(pairs->count()));
  const std::size_t k = rigid_.count(), m = gaps_.size();
  normal_.resize(m * k);
  for (std::size_t j = 0; j < k; ++j) {
    pairs->rows().apply_transpose(rigid_.basis()[j], gaps_);
    for (std::size_t i = 0; i < m; ++i)
      normal_[i * k + j] = gaps_[i];
  }
  open_.resize(static_cast<std::size_t>(pairs->obstacle_count()));
  reach_.resize(open_.size());
  deformation_rate_.resize(open_.size());
  deformed_.resize(m);
}

void StepErrors::start(Vec y, Vec v) {
  known_ = 1; // the initial velocity, of t_0
  check(VecCopy(v, means_[1].w));
  means_[1].middle = 0;
  rigid_state_ = {rigid_.coefficients(y), rigid_.coefficients(v), std::vector<double>(rigid_.count())};
  std::ranges::fill(open_, ended);
  for (std::vector<double>* values : {&reach_, &deformation_rate_, &deformed_})
    std::ranges::fill(*values, 0);
  active_.clear();
  gaps_before_.clear();
  force_ = {};
  contact_ = coarsest_ = {};
  begins_.clear();
  first_long_ = std::numeric_limits<double>::infinity();
  vibration_ = {};
  flight_ = {};
  forces_of_two_ = {};
  last_force_ = last_length_ = contact_error_ = scale_ = travel_ = drift_ = 0;
  if (const contact::ContactPairs* pairs = stepper_.pairs())
    pairs->rows().gap(pairs->psi(0, *psi_), y, gaps_);
}

double StepErrors::size(Vec x) {
  check(VecPointwiseMult(work_, weights_, x));
  return std::sqrt(petsc::dot(work_, x));
}

double StepErrors::norm(Vec x) {
  if (quantity_ != scene::StepQuantity::energy)
    return size(x);
  check(MatMult(stepper_.operators().A, x, work_));
  return std::sqrt(std::max(0.0, petsc::dot(work_, x)));
}

double StepErrors::relative_rounding() const { return rounding_of_y + stepper_.solver().tolerance(); }

double StepErrors::rounding(Vec y) {
  if (quantity_ != scene::StepQuantity::energy)
    return relative_rounding() * size(y);
  PetscReal largest = 0;
  check(VecNorm(y, NORM_INFINITY, &largest));
  return relative_rounding() * largest * std::sqrt(trace_);
}

double StepErrors::error_of(Vec third_difference, Vec y) {
  return std::max(0.0, norm(third_difference) / trapezoidal - rounding(y));
}

void StepErrors::set_mean(const Frame& frame) {
  const double rate = 1 / frame.step.tau;
  petsc::combine(means_[0].w, -rate, frame.before->y(), rate, frame.after.y());
  means_[0].middle = frame.step.begin + frame.step.tau / 2;
}

double StepErrors::error_of(const Frame& frame, bool abrupt) {
  const std::array times{means_[0].middle, means_[1].middle, means_[2].middle};
  const double tau = frame.step.tau;
  // In a smooth motion the distance grows with that of the earlier steps; after a sudden change it does not.
  const double part =
      abrupt ? 1 : std::min(1.0, 2 * tau * tau / ((times[0] - times[1]) * (times[0] - times[2])));
  std::array<double, 3> factors = distance(times);
  for (double& factor : factors)
    factor *= tau * part;
  if (quantity_ == scene::StepQuantity::energy) {
    petsc::combine(difference_, factors[0], means_[0].w, factors[1], means_[1].w);
    check(VecAXPY(difference_, factors[2], means_[2].w));
    return error_of(difference_, frame.after.y());
  }
  std::array<double, 2> squares{}; // the same in one pass, since it is made in every step
  {
    const petsc::ReadArray weight(weights_), w0(means_[0].w), w1(means_[1].w), w2(means_[2].w),
        y(frame.after.y());
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const double off = factors[0] * w0[i] + factors[1] * w1[i] + factors[2] * w2[i];
      squares[0] += weight[i] * off * off;
      squares[1] += weight[i] * y[i] * y[i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), 2, MPI_DOUBLE, MPI_SUM, stepper_.space().comm());
  return std::max(0.0, std::sqrt(squares[0]) / trapezoidal - relative_rounding() * std::sqrt(squares[1]));
}

bool StepErrors::passes(const Frame& frame) const {
  if (gaps_before_.empty() || frame.step.k < 2)
    return false;
  const contact::ContactPairs& pairs = *stepper_.pairs();
  const double tau = frame.step.tau, before = last_length_,
               deep = tolerance_ * scale_ + pairs.gap_tolerance();
  for (std::size_t i = 0; i < gaps_.size(); ++i) {
    if (contact(static_cast<std::size_t>(pairs.obstacles()[i])) ||
        pairs.obstacle(static_cast<int>(i))->moves())
      continue;
    const double g = frame.contact.gap[i], rate = (g - gaps_[i]) / tau,
                 bend = (rate - (gaps_[i] - gaps_before_[i]) / before) / (tau + before),
                 lowest = tau / 2 - rate / (2 * bend); // after t_{k−1}
    if (bend > 0 && lowest > 0 && lowest < tau &&
        gaps_[i] + rate * lowest - bend * lowest * (tau - lowest) < -deep)
      return true;
  }
  return false;
}

void StepErrors::coarsen(double t, double apart, Vec last, Vec before, Vec first) {
  const auto set = [&](Mean& mean, Vec y1, Vec y0, double end) {
    check(VecWAXPY(mean.w, -1, y0, y1));
    check(VecScale(mean.w, 1 / apart));
    mean.middle = end - apart / 2;
  };
  set(means_[1], last, before, t);
  set(means_[2], before, first, t - apart);
}

StepErrors::Step StepErrors::judge(const Frame& frame) {
  set_mean(frame);
  const double tau = frame.step.tau;
  Step step;
  // The first step has no history. The shortest steps are the reference for others: they count only where
  // vibration continues to the next touch.
  const bool shortest = stepper_.step_lengths()->level(frame.step.tau) >= stepper_.step_lengths()->levels;
  const bool judges = known_ > 1 && (!shortest || (!contact_.lasts && contact_.steps > 0));
  const double error = judges ? error_of(frame, frame.contact.active != active_) : 0;
  error_ = shortest ? of_shortest * error : error;
  step.error = shortest ? 0 : error;
  if (const contact::ContactPairs* pairs = stepper_.pairs()) {
    force_of_two_ = (tau * frame.normal_force() + last_length_ * last_force_) / (tau + last_length_);
    constexpr double parabola = 6;
    step.force_curvature = std::abs(force_of_two_ - 2 * forces_of_two_[0] + forces_of_two_[1]) / parabola;
    for (const int i : frame.contact.active)
      step.touches |= !contact(static_cast<std::size_t>(pairs->obstacles()[i]));
    step.touches = step.touches || passes(frame);
  }
  return step;
}

void StepErrors::accept(const Frame& frame) {
  std::rotate(means_.begin(), means_.end() - 1, means_.end());
  known_ = 2;
  take_rigid(frame);
  if (stepper_.pairs()) {
    take_contact(frame);
    take_deformation(frame);
    gaps_before_ = gaps_;
    std::ranges::copy(frame.contact.gap, gaps_.begin());
    active_ = frame.contact.active;
  } else {
    take_deformation(frame);
  }
}

void StepErrors::observe(const Frame& frame) {
  if (frame.step.k == 0)
    return start(frame.after.y(), frame.after.v());
  (void)judge(frame);
  accept(frame);
}

void StepErrors::take_rigid(const Frame& frame) {
  rigid_state_.position = rigid_.coefficients(frame.after.y());
  const bool free = frame.contact.active.empty() && frame.contact.predictor.empty();
  if (!free && open_.size() == 1) // nothing else can be touched
    return;
  std::vector<double> velocity = rigid_.coefficients(frame.after.v());
  for (std::size_t j = 0; free && j < velocity.size(); ++j)
    rigid_state_.acceleration[j] = (velocity[j] - rigid_state_.velocity[j]) / frame.step.tau;
  rigid_state_.velocity = std::move(velocity);
}

void StepErrors::take_deformation(const Frame& frame) {
  const contact::ContactPairs* pairs = stepper_.pairs();
  double most = 0;
  if (pairs) {
    const std::span<const double> psi = pairs->psi(frame.step.end, *psi_);
    const std::size_t k = rigid_.count();
    const double tau = frame.step.tau;
    for (std::size_t o = 0; o < reach_.size(); ++o)
      if (contact(o))
        reach_[o] = deformation_rate_[o] = 0;
    for (std::size_t i = 0; i < gaps_.size(); ++i) {
      const auto o = static_cast<std::size_t>(pairs->obstacles()[i]);
      double along = psi[i] - frame.contact.gap[i];
      travel_ = std::max(travel_, std::abs(along));
      for (std::size_t j = 0; j < k; ++j)
        along -= rigid_state_.position[j] * normal_[i * k + j];
      reach_[o] = std::max(reach_[o], std::abs(along));
      deformation_rate_[o] = std::max(deformation_rate_[o], std::abs(along - deformed_[i]) / tau);
      deformed_[i] = along;
    }
    most = reach_.empty() ? 0 : std::ranges::max(reach_);
  }
  if (!contact_.lasts || !pairs || quantity_ == scene::StepQuantity::energy) {
    rigid_.without(rigid_state_.position, frame.after.y(), difference_);
    const double deformed = norm(difference_), tau = frame.step.tau;
    flight_.time += tau;
    flight_.squares += tau * deformed * deformed;
    if (!pairs || quantity_ == scene::StepQuantity::energy) {
      most = deformed;
      travel_ = std::max(travel_, norm(frame.after.y()));
    }
  }
  scale_ = std::max(scale_, most);
}

void StepErrors::take_contact(const Frame& frame) {
  const double tau = frame.step.tau, begin = frame.step.begin, end = frame.step.end;
  std::vector<bool> closed(open_.size());
  for (const int i : frame.contact.active)
    closed[stepper_.pairs()->obstacles()[i]] = true;
  bool any = false, lasts = false;
  for (std::size_t o = 0; o < open_.size(); ++o) {
    open_[o] = closed[o] ? 0 : std::min(open_[o] + 1, ended);
    any = any || closed[o], lasts = lasts || contact(o);
  }
  const double force = frame.normal_force();
  if (any && begins_.empty() && !gaps_before_.empty())
    judge_flight(frame);
  if (any && !contact_.lasts) {
    if (const double error = std::min(flight_.error, without_phases()); error > vibration_.error)
      vibration_ = {begin, std::ranges::max(reach_), error};
    begins_.push_back(begin);
    // Contact that resumes after a short pause is the same contact.
    constexpr double pause = 0.1;
    if (contact_.steps == 0 || begin - contact_.end > pause * (contact_.end - contact_.begin)) {
      coarsest_ = coarsest_contact();
      contact_ = {.begin = begin};
    }
  }
  if (any) {
    contact_.end = end;
    ++contact_.steps;
  }
  contact_.impulse += tau * force;
  if (lasts)
    contact_.largest_force = std::max(contact_.largest_force, force_of_two_);
  if (!lasts) {
    flight_.error += error_;
  } else {
    flight_ = {};
    if (stepper_.step_lengths()->level(frame.step.tau) < stepper_.step_lengths()->levels) {
      contact_error_ += error_;
      first_long_ = std::min(first_long_, begin);
    }
  }
  contact_.lasts = lasts;
  force_.add(end, force);
  last_force_ = force, last_length_ = tau;
  forces_of_two_ = {force_of_two_, forces_of_two_[0]};
}

void StepErrors::judge_flight(const Frame& frame) {
  double speed = 0;
  for (const int i : frame.contact.active)
    if (const auto at = static_cast<std::size_t>(i); last_length_ > 0)
      speed = std::max(speed, (gaps_before_[at] - gaps_[at]) / last_length_);
  // Measured rotation of a body in flight without strain by rounding of A y; y grows with the time.
  constexpr double turned = 0.05;
  const double time = frame.step.end / stepper_.wave_time(), window = speed * stepper_.wave_time();
  if (window > 0)
    drift_ = turned * std::numeric_limits<double>::epsilon() * time * time * size(frame.before->y()) / window;
}

double StepErrors::closing() const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < gaps_before_.size(); ++i)
    if (gaps_[i] < gaps_before_[i])
      least = std::min(least, last_length_ * gaps_[i] / (gaps_before_[i] - gaps_[i]));
  return least;
}

double StepErrors::without_phases() const {
  // Twice the mean square of the vibration: its own and that of the numerical one.
  return flight_.time > crossing_ ? std::sqrt(2 * flight_.squares / flight_.time)
                                  : std::numeric_limits<double>::infinity();
}

std::vector<Warning> StepErrors::warnings() const {
  std::vector<Warning> found;
  if (!(scale_ > 0))
    return found;
  if (vibration_.error > tolerance_ * scale_)
    found.push_back(
        {"vibration",
         fmt::format("at the touch at t = {1:.6g} s the body still vibrated by up to {0:.2g} of its largest "
                     "deformation, which the steps did not resolve. Step errors add up to {2:.2g} of the "
                     "largest deformation; time.tolerance is {3:g}",
                     vibration_.amplitude / scale_, vibration_.time, vibration_.error / scale_, tolerance_),
         vibration_.error / scale_, tolerance_});
  if (const double most = most_turned * stepper_.step_lengths()->shortest_step() / stepper_.wave_time();
      drift_ > most)
    found.push_back({"rounding in flight",
                     fmt::format("the body flies so long before the touch at t = {:.6g} s that rounding may "
                                 "turn it. The rotation moves nodes by {:.2g} times the path of the body "
                                 "while a wave crosses an element (limit {:.2g}). Start the motion nearer to "
                                 "the touch",
                                 begins_.front(), drift_, most),
                     drift_, most});
  if (const double sum = contact_error_ / scale_, most = most_accumulated * tolerance_; sum > most)
    found.push_back(
        {"accumulated error",
         fmt::format("the errors of steps in contact add up to {:.2g} of the largest deformation, above "
                     "{:g} (5 times time.tolerance): forces may be wrong; lower time.tolerance",
                     sum, most),
         sum, most});
  if (const Contact& few = coarsest_contact(); few.impulse > tolerance_ * force_.total())
    found.push_back(
        {"few steps in contact",
         fmt::format(
             "the contact that begins at t = {:.6g} s gives {:.2g} of the impulse within {} step{}, so that "
             "its force and duration are not resolved. Refine the mesh there, or lower time.shortest",
             few.begin, few.impulse / force_.total(), few.steps, few.steps == 1 ? "" : "s"),
         static_cast<double>(few.steps), few_steps});
  if (force_.total() > 0)
    if (const std::optional<Warning> peak = wave_peak_warning())
      found.push_back(*peak);
  return found;
}

std::optional<Warning> StepErrors::wave_peak_warning() const {
  const ImpulseRecord::Peak peak = force_.peak(sustained * stepper_.wave_time());
  const bool at_onset = std::ranges::any_of(
      begins_, [&](double touch) { return touch <= peak.mean.end && peak.mean.end <= touch + crossing_; });
  constexpr double sharp = 3, unlike = 5, after_long_steps = 1.5; // times the tolerance, by trials
  const double most =
      std::min(peak.smooth && !at_onset ? std::numeric_limits<double>::infinity() : sharp * tolerance_,
               peak.expected + (peak.mean.end > first_long_ ? after_long_steps : unlike) * tolerance_);
  if (!(peak.excess > most))
    return std::nullopt;
  const std::string unit = std::string("N") + stepper_.space().mesh().per_depth();
  return Warning{
      peak_of_the_mesh,
      fmt::format(
          "the largest mean force is {:.4g} {} over {:.2g} s, but {:.4g} {} over twice that time: the peak "
          "depends on elements and steps. Refine the mesh, lower time.tolerance, or compare impulses",
          peak.mean.force, unit, peak.mean.over, peak.twice, unit),
      peak.excess, most};
}

} // namespace signorini::trajectory
