// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "forward/invariants.h"
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// The CSV files of a run, as text.
namespace signorini::io {

/// Header of steps.csv: one row per time step, row 0 the initial state; the column of the tracking error only
/// with `tracking`, in a run with an objective.
std::string steps_header(int dim, bool tracking);

/// Appends row k; `normal_force` is the sum of the moduli of the nodal contact forces (N, in 2D N/m),
/// `tracking_error` is ‖y_k − y_d,k‖ in L2 (m², in 3D m^5/2).
void add_steps_row(std::string& text, int k, double time, int dim, const forward::StepBalance& balance,
                   const forward::Invariants& invariants, const contact::ContactState& contact,
                   double normal_force, std::optional<double> tracking_error);

/// One row of history.csv.
struct HistoryRow {
  int iteration = 0;
  double objective = 0, tracking = 0, terminal = 0, control_cost = 0;
  double gradient_norm = 0, step_length = 0;
  int forward_sweeps = 0, adjoint_sweeps = 0; ///< so far
  double seconds = 0;                         ///< so far
  double relative_distance_to_reference =
      std::numeric_limits<double>::quiet_NaN(); ///< nan without a reference control
};

/// history.csv with its header, and rows alone.
std::string history_table(const std::vector<HistoryRow>& rows);
std::string history_rows(const std::vector<HistoryRow>& rows);

} // namespace signorini::io
