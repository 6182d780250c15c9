// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/measurements.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::drivers {

/// Throws UserError unless a simulation into the folder `out` can write the files of a scene's measurements.
/// Each measurement must have a deviation, and each file be absent or, with `replace`, as
/// SyntheticData::write() left it. Files that the run itself reads or writes are refused. Collective.
void require_measurable(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                        bool replace);

/// Synthetic data for a fit: the scene's measurements in a simulation, at the ends of all steps. All members
/// collective.
class SyntheticData {
public:
  /// The references must outlive this object. Throws UserError.
  SyntheticData(const step::Stepper& stepper, const step::TimeGrid& grid, const scene::Scene& scene);

  /// Takes the frame after the last one, from frame 0 on.
  void observe(const trajectory::Frame& frame) { measurements_.observe(frame); }

  /// Writes the files, with normal noise of the scene's deviations generated from `seed` (0: no noise).
  /// Writes FILE.measured beside each, with the digests of the new file and of the one replaced. Returns
  /// lines on the files written. Throws UserError.
  [[nodiscard]] std::vector<std::string> write(int seed) const;

private:
  MPI_Comm comm_;
  const scene::Scene& scene_;
  std::vector<double> times_;
  control::Measurements measurements_;
};

} // namespace signorini::drivers
