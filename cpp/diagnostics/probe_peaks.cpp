// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/probe_peaks.h"
#include "diagnostics/channel_filter.h"
#include <algorithm>
#include <cmath>

namespace signorini::diagnostics {

ProbePeaks::ProbePeaks(const scene::Scene& scene, const std::vector<std::string>& columns) {
  for (const scene::Probe& probe : scene.output.probes)
    for (const char* quantity : {"acceleration", "force"}) {
      if (quantity == std::string("force") && !probe.filter)
        continue;
      const std::string start = probe.name + "." + quantity + "_";
      const auto belongs = [&](const std::string& column) { return column.starts_with(start); };
      const auto first = std::ranges::find_if(columns, belongs);
      if (first == columns.end())
        continue;
      std::optional<double> channel_class;
      if (probe.filter)
        channel_class = probe.filter->cfc;
      channels_.push_back({probe.name,
                           quantity,
                           channel_class,
                           static_cast<std::size_t>(first - columns.begin()),
                           static_cast<std::size_t>(std::count_if(first, columns.end(), belongs)),
                           {}});
    }
}

void ProbePeaks::observe(const step::TimeStep& step, std::span<const double> values) {
  if (step.k == 0 || channels_.empty())
    return;
  lengths_.push_back(step.tau);
  ends_.push_back(step.end);
  for (Channel& channel : channels_)
    for (std::size_t c = 0; c < channel.size; ++c)
      channel.series.push_back(values[channel.first + c]);
}

std::vector<ProbePeak> ProbePeaks::peaks() const {
  std::vector<ProbePeak> all;
  const std::size_t steps = lengths_.size();
  for (const Channel& channel : channels_) {
    ProbePeak& found = all.emplace_back(channel.probe, channel.quantity);
    const auto note = [](double squares, double time, Peak& peak) {
      if (const double value = std::sqrt(squares); value > peak.value)
        peak = {value, time};
    };
    for (std::size_t k = 1; k < steps; ++k) {
      double squares = 0;
      for (std::size_t c = 0; c < channel.size; ++c) {
        const double before = channel.series[(k - 1) * channel.size + c],
                     now = channel.series[k * channel.size + c],
                     mean = (lengths_[k - 1] * before + lengths_[k] * now) / (lengths_[k - 1] + lengths_[k]);
        squares += mean * mean;
      }
      note(squares, ends_[k - 1], found.mean);
    }
    if (!channel.channel_class || steps == 0)
      continue;
    found.channel_class = channel.channel_class;
    std::vector<double> squares(steps);
    for (std::size_t c = 0; c < channel.size; ++c) {
      std::vector<double> component(steps);
      for (std::size_t k = 0; k < steps; ++k)
        component[k] = channel.series[k * channel.size + c];
      component = channel_filtered(component, lengths_.front(), *channel.channel_class);
      for (std::size_t k = 0; k < steps; ++k)
        squares[k] += component[k] * component[k];
    }
    for (std::size_t k = 0; k < steps; ++k)
      note(squares[k], ends_[k] - lengths_[k] / 2, found.filtered);
    constexpr double reach = 0.5; // of the filter, in periods of the class
    found.at_end = found.filtered.time > ends_.back() - reach / *channel.channel_class;
  }
  return all;
}

} // namespace signorini::diagnostics
