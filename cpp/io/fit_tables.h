// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/measurements.h"
#include "scene/scene.h"
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace signorini::io {

/// Reads the data of a scene's measurements from their files; empty for those that are not fitted.
/// Collective; rank 0 reads. Throws UserError naming key, file and line if a file cannot be read, has times
/// outside of the motion, or has no deviation where the scene gives none.
std::vector<control::Data> read_data(MPI_Comm comm, const scene::Scene& scene);

/// Text of a file of measurements: a column of times, and a column of values for each name.
std::string data_table(const std::vector<double>& times, const std::vector<std::string>& names,
                       const std::vector<std::vector<double>>& columns);

/// Result of a fit for one unknown.
struct FittedUnknown {
  std::string name{}, of{}, unit{}, scale{};
  double value = 0, deviation = 0; ///< standard deviation; ∞ if the data do not determine the value
  double start = 0, lower = 0, upper = 0;
  bool at_bound = false;
  double gradient = 0; ///< dJ/dθ
};

/// A measurement, and its simulated values in the fitted scene.
struct Comparison {
  std::string name;
  std::vector<double> times, data, deviations, simulated;
};

/// A measured value of the contact as a whole, compared with the simulated one but not fitted.
struct ComparedFigure {
  std::string name, unit;
  double value, deviation, simulated; ///< deviation 0: not given, simulated nan: no contact
};

/// The outcome of a fit.
struct Fit {
  std::vector<FittedUnknown> unknowns;
  std::vector<double> correlations; ///< (unknowns × unknowns)
  std::vector<double> singular_values;
  std::vector<std::string> unidentified; ///< sentences on numbers that the data do not determine
  std::vector<Comparison> measurements;
  std::vector<ComparedFigure> compared;
  double value = 0;  ///< J
  double misfit = 0; ///< root mean square of the residuals of the data, in standard deviations
  long data = 0;     ///< number of values
  /// Newton decrement √(gᵀH⁻¹g) at the end of the fit, in standard deviations of the parameters; absent if a
  /// control is sought too.
  std::optional<double> decrement{};
};

/// Texts of parameters.csv and measurements.csv.
std::string parameters_table(const Fit& fit);
std::string measurements_table(const Fit& fit);

} // namespace signorini::io
