#pragma once
#include "contact/constraints.h"
#include "contact/contact_state.h"
#include "forward/balance.h"
#include <limits>
#include <string>
#include <vector>

/// The CSV files of a run, as text.
namespace signorini::io {

/// steps.csv: one row per time step, row 0 the initial state. `tracking_error` holds ‖y_k − y_d,k‖ in L2 (m², in 3D m^5/2),
/// or nothing if the run has no objective: then the column is left out.
std::string steps_table(const std::vector<forward::StepBalance>& balance, const std::vector<contact::ContactState>& contact,
                        const std::vector<double>& tracking_error, const forward::Scheme& scheme, int dim);

/// contact.csv: one row per stored step and candidate, at its place in the undeformed body.
std::string contact_table(const std::vector<int>& steps, const std::vector<contact::ContactState>& contact,
                          const contact::Constraints& constraints, const forward::Scheme& scheme);

/// One row of history.csv.
struct HistoryRow {
  int iteration = 0;
  double objective = 0, tracking = 0, terminal = 0, control_cost = 0;
  double gradient_norm = 0, step_length = 0;
  int forward_sweeps = 0, adjoint_sweeps = 0; ///< so far
  double seconds = 0;                         ///< so far
  double relative_distance_to_reference = std::numeric_limits<double>::quiet_NaN(); ///< nan without a reference control
};

std::string history_table(const std::vector<HistoryRow>& rows);

} // namespace signorini::io
