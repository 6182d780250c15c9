// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/first_touch.h"
#include "fem/rigid_motions.h"
#include "trajectory/integrate.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::trajectory {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// The rigid motion of all candidates along ν (m each): position, velocity and acceleration at one time.
class RigidFlight {
public:
  RigidFlight(const step::Stepper& stepper, const scene::Scene& scene, int intervals)
      : stepper_(stepper), grid_(stepper.end() / intervals, intervals),
        rigid_(stepper.space(), stepper.clamped(), stepper.M()), rows_(stepper.pairs()->rows()),
        force_(stepper.space().vector()) {
    const auto m = static_cast<std::size_t>(stepper.pairs()->count());
    for (const petsc::Vector& motion : rigid_.basis())
      rows_.apply_transpose(motion, motions_.emplace_back(m));
    const step::State initial = initial_state(stepper, scene.initial);
    rows_.apply_transpose(initial.y(), position_ = std::vector<double>(m));
    velocity_ = along(rigid_.coefficients(initial.v()));
    acceleration_.resize(m);
    if (scene.load)
      load_.emplace(stepper.space(), stepper.M(), *scene.load, grid_.end());
    if (load_)
      sum_.emplace(stepper.space(), *load_);
  }

  /// Takes the mean acceleration over an interval, 1 … intervals.
  void accelerate(int interval) {
    if (!load_ || (interval > 1 && !load_->depends_on_time()))
      return;
    assemble(sum_->at(grid_.step(interval)), stepper_.operators(), force_);
    acceleration_ = along(rigid_.products(force_));
  }
  void advance(double s) {
    for (std::size_t i = 0; i < position_.size(); ++i) {
      position_[i] += s * velocity_[i] + s * s / 2 * acceleration_[i];
      velocity_[i] += s * acceleration_[i];
    }
  }

  /// Whether clamps keep no rigid motion from moving the candidate along ν.
  [[nodiscard]] bool flies(std::size_t i) const {
    return std::ranges::any_of(motions_, [i](const std::vector<double>& one) { return one[i] != 0; });
  }
  [[nodiscard]] double position(std::size_t i) const { return position_[i]; }
  [[nodiscard]] double velocity(std::size_t i) const { return velocity_[i]; }
  [[nodiscard]] double acceleration(std::size_t i) const { return acceleration_[i]; }

private:
  [[nodiscard]] std::vector<double> along(const std::vector<double>& coefficients) const {
    std::vector<double> sum(position_.size());
    for (std::size_t j = 0; j < motions_.size(); ++j)
      for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += coefficients[j] * motions_[j][i];
    return sum;
  }

  const step::Stepper& stepper_;
  step::TimeGrid grid_; ///< of the intervals
  fem::RigidMotions rigid_;
  const contact::ConstraintRows& rows_;
  petsc::Vector force_;
  std::vector<std::vector<double>> motions_;
  std::vector<double> position_, velocity_, acceleration_;
  std::optional<step::SceneLoad> load_;
  std::optional<step::ForceAtStep> sum_;
};

} // namespace

double first_root(double g, double v, double a) {
  if (g <= 0)
    return 0;
  const double square = v * v - 2 * a * g;
  if (square < 0 || (v >= 0 && a >= 0))
    return never;
  return 2 * g / (std::sqrt(square) - v); // the smaller root, without cancellation
}

std::vector<FirstTouch> first_touches(const step::Stepper& stepper, const scene::Scene& scene) {
  const contact::ContactPairs* pairs = stepper.pairs();
  if (!pairs)
    return {};
  constexpr int samples = 256;
  const double h = stepper.end() / samples;
  RigidFlight flight(stepper, scene, samples);
  std::vector<FirstTouch> found(static_cast<std::size_t>(pairs->obstacle_count()));
  contact::ContactPairs::Gaps at = pairs->gaps();
  const auto psi_at = [&](double t) {
    const std::span<const double> psi = pairs->psi(t, at);
    return std::vector<double>(psi.begin(), psi.end());
  };
  std::vector<double> psi = psi_at(0);
  for (int j = 0; j < samples; ++j) {
    flight.accelerate(j + 1);
    const double t = j * h;
    const std::vector<double> next = pairs->moving() ? psi_at(t + h) : psi;
    for (std::size_t i = 0; i < psi.size(); ++i) {
      FirstTouch& one = found[static_cast<std::size_t>(pairs->obstacles()[i])];
      const double gap = psi[i] - flight.position(i), rate = (next[i] - psi[i]) / h - flight.velocity(i),
                   bend = -flight.acceleration(i);
      if (j == 0)
        one.gap = std::min(one.gap, gap);
      one.flies = one.flies || flight.flies(i) || next[i] != psi[i];
      const double s = first_root(gap - pairs->gap_tolerance(), rate, bend);
      if (s <= h && t + s < one.time) {
        one.time = t + s;
        one.speed = -(rate + bend * s);
      }
      const double lowest = bend > 0 ? std::clamp(-rate / bend, 0.0, h) : rate < 0 ? h : 0;
      if (const double least = gap + lowest * rate + lowest * lowest / 2 * bend; least < one.nearest) {
        one.nearest = least;
        one.nearest_time = t + lowest;
      }
    }
    psi = next;
    flight.advance(h);
  }
  return found;
}

std::vector<std::string> first_touch_lines(const step::Stepper& stepper, const scene::Scene& scene) {
  const std::vector<FirstTouch> all = first_touches(stepper, scene);
  const char* const without = scene.control ? ", without the control" : "";
  std::vector<std::string> lines;
  for (std::size_t o = 0; o < all.size(); ++o) {
    const FirstTouch& one = all[o];
    std::string text = fmt::format("first touch of \"{}\": ", scene.contacts[o].name);
    if (!one.flies)
      text += fmt::format("by deformation alone, clamps hold the body; gap {:.4g} m", one.gap);
    else if (one.time == 0)
      text += "at the start";
    else if (one.occurs())
      text += fmt::format("at {:.4g} s with {:.4g} m/s, by the rigid motion from a gap of {:.4g} m{}",
                          one.time, one.speed, one.gap, without);
    else
      text += fmt::format("none before {:.4g} s by the rigid motion{}; gap {:.4g} m, at least {:.4g} m (at "
                          "{:.4g} s)",
                          stepper.end(), without, one.gap, one.nearest, one.nearest_time);
    lines.push_back(std::move(text));
  }
  return lines;
}

} // namespace signorini::trajectory
