// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "step/time_grid.h"
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Largest modulus of a vector over time, and when, s.
struct Peak {
  double value = 0, time = 0;
};

/// Peak of an acceleration (m/s²) or a force (N) that a probe records.
struct ProbePeak {
  std::string probe, quantity; ///< name of the probe; "acceleration" or "force"
  Peak mean;                   ///< largest mean over two steps
  std::optional<double> channel_class{};
  Peak filtered{};     ///< largest value of the filtered channel; set with a class
  bool at_end = false; ///< whether `filtered` is so near to the end that it depends on what comes later
};

/// Collects the accelerations of probes, and the forces of probes with a filter, for their peaks.
class ProbePeaks {
public:
  /// `columns`: names of the probes' values, as Probes::columns() returns them.
  ProbePeaks(const scene::Scene& scene, const std::vector<std::string>& columns);
  /// Takes the probes' values of the next step; steps are passed in order, from 0 on.
  void observe(const step::TimeStep& step, std::span<const double> values);
  [[nodiscard]] std::vector<ProbePeak> peaks() const;

private:
  struct Channel {
    std::string probe, quantity;
    std::optional<double> channel_class;
    std::size_t first, size;    ///< columns of the vector's components
    std::vector<double> series; ///< components of the steps 1, 2, …
  };
  std::vector<Channel> channels_;
  std::vector<double> lengths_, ends_; ///< of the steps, s
};

} // namespace signorini::diagnostics
