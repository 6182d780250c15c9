// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"
#include "accuracy/restitution.h"
#include "contact/pressure.h"
#include "diagnostics/balance.h"
#include "diagnostics/contact_forces.h"
#include "diagnostics/largest_stress.h"
#include "diagnostics/warnings.h"
#include <limits>

namespace signorini::accuracy {

/// Samples a field at the sample points and times, in ascending order of time.
class SampledField {
public:
  SampledField(const SamplePoints& samples, const fem::Space& space)
      : samples_(samples), sampler_(space, samples.body.points), here_(space.vector()) {
    values_.reserve(samples.times.size() * samples.body.weights.size() *
                    static_cast<std::size_t>(space.dim()));
  }

  /// Takes the samples at all times up to t1 (s) that have not been taken; all remaining ones if `last`.
  /// `at(t, out)` evaluates the field at time t, up to t1.
  template <class At>
  void take_until(double t1, bool last, At&& at) {
    const double reach = last ? std::numeric_limits<double>::infinity() : t1;
    while (next_ < samples_.times.size() && samples_.times[next_] <= reach) {
      at(std::min(samples_.times[next_], t1), here_);
      const std::vector<double> values = sampler_(here_);
      values_.insert(values_.end(), values.begin(), values.end());
      ++next_;
    }
  }

  std::vector<double> take() {
    samples_.scale(values_);
    return std::move(values_);
  }

private:
  const SamplePoints& samples_;
  fem::Sampler sampler_;
  petsc::Vector here_;
  std::size_t next_ = 0;
  std::vector<double> values_;
};

/// Measures quantities of a motion frame by frame.
class MotionQuantities {
public:
  /// Prepares to measure the `wanted` quantities; others that need a motion's values are not computed.
  /// `samples`: where fields are sampled; null if no field is wanted. Collective. The references must outlive
  /// this object.
  MotionQuantities(const problem::Problem& problem, const std::vector<Quantity>& wanted,
                   const SamplePoints* samples);

  /// Takes the next frame; frames are passed in order, from frame 0 on. Collective.
  void operator()(const trajectory::Frame& frame);

  /// Stores the quantities, and the warnings of the motion, in `measured` after the last frame. Collective.
  void report(Measured& measured);

private:
  /// Relative error of the contact pressure in L2 of the contact surface. The pressure is the mean of the
  /// last two steps, since the forces of single steps alternate.
  [[nodiscard]] double pressure_error() const;

  const problem::Problem& problem_;
  const std::vector<Quantity>& wanted_;
  std::optional<diagnostics::Balance> weigh_; ///< for the loss of energy and the restitution
  std::optional<Restitution> restitution_;
  diagnostics::StepWarnings warnings_;
  diagnostics::ContactFigures contact_;
  std::optional<SampledField> displacement_;
  std::optional<contact::Pressure> pressure_;
  std::optional<fem::CellFields> fields_;
  std::optional<diagnostics::LargestStress> stress_;
  std::vector<std::vector<double>> last_forces_;
  double energy_ = 0, contact_loss_ = 0;
};

} // namespace signorini::accuracy
