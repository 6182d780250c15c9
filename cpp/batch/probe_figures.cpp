// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/probe_figures.h"
#include <algorithm>

namespace signorini::batch {

ProbeFigures::ProbeFigures(const problem::Problem& problem, bool controlled)
    : probes_(*problem.probes), forces_(problem.stepper), peaks_(problem.scene, problem.probes->columns()) {
  if (probes_.need_reactions())
    balance_.emplace(problem.stepper, diagnostics::Balance::Wanted{true, controlled, problem.scene_loads()});
}

void ProbeFigures::observe(const trajectory::Frame& frame) {
  if (balance_)
    (void)(*balance_)(frame);
  forces_.observe(frame);
  now_.clear();
  probes_.add_values(frame, forces_, balance_ ? balance_->reactions() : nullptr, now_);
  peaks_.observe(frame.step, now_);
  if (frame.step.k == 0) {
    least_ = largest_ = now_;
    return;
  }
  for (std::size_t i = 0; i < now_.size(); ++i) {
    least_[i] = std::min(least_[i], now_[i]);
    largest_[i] = std::max(largest_[i], now_[i]);
  }
}

std::vector<std::pair<std::string, double>> ProbeFigures::numbers() const {
  std::vector<std::pair<std::string, double>> all;
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const std::string& column = probes_.columns()[i];
    all.emplace_back(column + ".min", least_[i]);
    all.emplace_back(column + ".max", largest_[i]);
    all.emplace_back(column + ".end", now_[i]);
  }
  for (const diagnostics::ProbePeak& peak : peaks_.peaks())
    all.emplace_back(peak.probe + "." + peak.quantity + ".peak",
                     peak.channel_class ? peak.filtered.value : peak.mean.value);
  return all;
}

} // namespace signorini::batch
