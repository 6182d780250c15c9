// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/measurements.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::drivers {

/// Throws UserError unless a simulation into the folder `out` can write the files of a scene's measurements.
/// Each measurement must have a deviation. Each file must be absent or, if `replace`, unchanged since
/// SyntheticData::write() wrote it. The run itself must not read or write the files. Collective.
void require_measurable(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                        bool replace);

/// Synthetic data for a fit: the scene's measurements, taken from a simulation at the ends of all steps. All
/// members are collective.
class SyntheticData {
public:
  /// Prepares the measurements. Throws UserError. The references must outlive this object.
  SyntheticData(const step::Stepper& stepper, const step::TimeGrid& grid, const scene::Scene& scene);

  /// Records a frame; must be called for all frames in order, from frame 0 on.
  void observe(const trajectory::Frame& frame) { measurements_.observe(frame); }

  /// Writes the files of the measurements, with normally distributed noise of the scene's deviations. `seed`:
  /// seed of the noise; 0: no noise. Writes a note FILE.measured beside each file, with the digests of the
  /// new file and of the replaced one. Returns lines on the files written. Throws UserError.
  [[nodiscard]] std::vector<std::string> write(int seed) const;

private:
  MPI_Comm comm_;
  const scene::Scene& scene_;
  std::vector<double> times_;
  control::Measurements measurements_;
};

} // namespace signorini::drivers
