// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "contact/pressure.h"
#include "diagnostics/balance.h"
#include "diagnostics/contact_forces.h"
#include "scene/scene.h"
#include "step/time_grid.h"
#include <optional>
#include <span>
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

  /// Appends a row; the first one defines the columns.
  void add(const Row& row);
  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : numbers.size() / columns.size(); }
  [[nodiscard]] double at(std::size_t row, const std::string& column) const;
  [[nodiscard]] double last(const std::string& column) const { return at(rows() - 1, column); }
  /// Text of the whole file, and of one row.
  [[nodiscard]] std::string table() const;
  [[nodiscard]] std::string text(std::size_t row) const;
  /// Names of columns from a header.
  [[nodiscard]] static std::vector<std::string> split(const std::string& header);
};

/// Header of obstacles.csv: one row per step and obstacle, step 0 the initial state.
std::string obstacles_header(int dim);

/// Appends the rows of step k. `contacts`: the scene's, with the obstacles' names.
void add_obstacle_rows(std::string& text, int k, double time, int dim,
                       const std::vector<scene::Contact>& contacts,
                       const diagnostics::ObstacleForces& forces);

/// Header of probes.csv: one row per step, row 0 the initial state.
std::string probes_header(const std::vector<std::string>& columns);

/// Appends row k.
void add_probes_row(std::string& text, int k, double time, std::span<const double> values);

/// Text of contact.csv: one row per stored step and candidate. Its columns are the point in the undeformed
/// body, gap, force, obstacle, the obstacle's normal there (out of it, the direction of the force on the
/// body), area, pressure and status. Numbers have as many digits as distinguish them from all others.
class ContactTable {
public:
  /// `pressure` must outlive this object; `contacts`: the scene's, with the obstacles' names.
  ContactTable(const contact::ContactPairs& pairs, const contact::Pressure& pressure,
               const std::vector<scene::Contact>& contacts);

  [[nodiscard]] std::string header() const;

  /// Appends the rows of a step.
  void add_rows(std::string& text, const step::TimeStep& step, const contact::ContactState& contact) const;

private:
  /// Constant text of a candidate's row, before and behind gap and force.
  struct Fixed {
    std::string point, surface;
  };
  int dim_;
  const contact::Pressure& pressure_;
  std::vector<Fixed> fixed_;
};

} // namespace signorini::io
