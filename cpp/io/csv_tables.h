// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "diagnostics/balance.h"
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The CSV files of a run, as text.
namespace signorini::io {

/// Header of steps.csv: one row per time step, row 0 the initial state; the column of the tracking error only
/// with `tracking`, in a run with an objective.
std::string steps_header(int dim, bool tracking);

/// Appends row k; `normal_force` is the sum of the moduli of the nodal contact forces (N, in 2D N/m),
/// `tracking_error` is ‖y_k − y_d,k‖ in L2 (m², in 3D m^5/2).
void add_steps_row(std::string& text, int k, double time, int dim, const diagnostics::StepBalance& balance,
                   const diagnostics::Invariants& invariants, const contact::ContactState& contact,
                   double normal_force, std::optional<double> tracking_error);

/// history.csv: a row of numbers for each iterate of a search.
struct History {
  using Row = std::vector<std::pair<std::string, double>>; ///< column, value
  std::vector<std::string> columns;
  std::vector<double> numbers; ///< (rows × columns)

  /// Columns are those of the first row.
  void add(const Row& row);
  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : numbers.size() / columns.size(); }
  [[nodiscard]] double at(std::size_t row, const std::string& column) const;
  [[nodiscard]] double last(const std::string& column) const { return at(rows() - 1, column); }
  /// The file, and a row of it.
  [[nodiscard]] std::string table() const;
  [[nodiscard]] std::string text(std::size_t row) const;
  /// Names from a header.
  [[nodiscard]] static std::vector<std::string> split(const std::string& header);
};

} // namespace signorini::io
