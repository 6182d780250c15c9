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

/// Reads the data files of a scene's measurements. Returns the data of each measurement; they are empty for
/// measurements that are not fitted. Throws UserError, naming key and file, if a file cannot be read, has
/// times outside of the motion, or if neither the file nor the scene gives standard deviations. Rank 0 reads.
/// Collective.
std::vector<control::Data> read_data(MPI_Comm comm, const scene::Scene& scene);

/// Text of a CSV file of measurements: a column of times (s), then a column of values for each name.
std::string data_table(const std::vector<double>& times, const std::vector<std::string>& names,
                       const std::vector<std::vector<double>>& columns);

/// Result of a fit for one unknown.
struct FittedUnknown {
  std::string name{}, quantity{}, unit{}, scale{}; ///< name, physical quantity, unit, linear or logarithmic
  double value = 0, deviation = 0; ///< fitted value, standard deviation (∞ if the data do not determine it)
  double start = 0, lower = 0, upper = 0; ///< start value and bounds
  bool at_bound = false;                  ///< whether the fitted value is at a bound
  double gradient = 0;                    ///< derivative of J with respect to the value
};

/// A measurement compared with its simulation in the fitted scene.
struct Comparison {
  std::string name;
  std::vector<double> times, data, deviations, simulated; ///< times in s; others in the measurement's unit
};

/// A measured quantity of the whole contact, such as its duration, compared with the simulation but not
/// fitted. `deviation` is 0 if the scene gives none. If there is no contact in the simulation, `simulated` is
/// 0 for the contact time and NaN for other quantities.
struct ComparedQuantity {
  std::string name, unit;
  double value, deviation, simulated;
};

/// The outcome of a fit.
struct Fit {
  std::vector<FittedUnknown> unknowns;
  std::vector<double> correlations; ///< correlations of the unknowns (unknowns × unknowns)
  std::vector<double> singular_values;
  std::vector<std::string> unidentified; ///< sentences on unknowns that are poorly determined or undetermined
  std::vector<Comparison> measurements;
  std::vector<ComparedQuantity> compared;
  double value = 0;  ///< objective J
  double misfit = 0; ///< root mean square of the residuals, each divided by its datum's standard deviation
  long data = 0;     ///< number of measured values
  /// Newton decrement √(gᵀH⁻¹g) at the end of the fit, in standard deviations of the parameters; absent if a
  /// control is sought too.
  std::optional<double> decrement{};
};

/// Text of parameters.csv: one row for each unknown.
std::string parameters_table(const Fit& fit);
/// Text of measurements.csv: one row for each measured value.
std::string measurements_table(const Fit& fit);

} // namespace signorini::io
