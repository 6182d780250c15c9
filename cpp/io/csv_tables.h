// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "contact/pressure.h"
#include "diagnostics/balance.h"
#include "diagnostics/bodies.h"
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

/// Columns of steps.csv that not every run has.
struct StepsColumns {
  bool tracking = false;   ///< tracking error, in runs with an objective
  bool foundation = false; ///< energy and dissipation of foundations
  bool drag = false;       ///< dissipation by mass damping
  bool relaxation = false; ///< energy and dissipation of branches of a Prony series
  bool friction = false;   ///< works of friction, numbers of candidates that slip and stick
  bool rigid = false;      ///< energy and dissipation of obstacles with mass

  /// Columns of a scene; `tracking`: whether the run has an objective.
  static StepsColumns of(const scene::Scene& scene, bool tracking);
};

/// Header of steps.csv, which has one row per time step after row 0 for the initial state.
std::string steps_header(int dim, const StepsColumns& columns);

/// Appends row k of steps.csv. `time`: s; `normal_force`: sum of the moduli of the nodal contact forces, N
/// (in plane strain and plane stress N/m); `tracking_error`: L2 norm of y − y_d at `time`, m^5/2 (in plane
/// strain and plane stress m²), unused without that column.
void add_steps_row(std::string& text, const StepsColumns& columns, int k, double time, int dim,
                   const diagnostics::StepBalance& balance, const diagnostics::Invariants& invariants,
                   const contact::ContactState& contact, double normal_force, double tracking_error);

/// Table of history.csv: a row of numbers for each iterate of a search.
struct History {
  using Row = std::vector<std::pair<std::string, double>>; ///< pairs of a column's name and its value
  std::vector<std::string> columns;                        ///< names of the columns
  std::vector<double> numbers;                             ///< values (rows × columns)

  /// Appends a row; the first row defines the columns.
  void add(const Row& row);
  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : numbers.size() / columns.size(); }
  [[nodiscard]] double at(std::size_t row, const std::string& column) const;
  [[nodiscard]] double last(const std::string& column) const { return at(rows() - 1, column); }
  /// Text of the whole file: the header and all rows.
  [[nodiscard]] std::string table() const;
  /// Text of one row, which ends with a line feed.
  [[nodiscard]] std::string text(std::size_t row) const;
  /// Splits a header at its commas into the names of the columns.
  [[nodiscard]] static std::vector<std::string> split(const std::string& header);
};

/// Header of obstacles.csv, which has one row per step and obstacle; step 0 is the initial state.
std::string obstacles_header(int dim);

/// Appends the rows of step k to obstacles.csv, one per obstacle. `time`: s; `contacts`: the scene's tables
/// [contact], which name the obstacles.
void add_obstacle_rows(std::string& text, int k, double time, int dim,
                       const std::vector<scene::Contact>& contacts,
                       const diagnostics::ObstacleForces& forces);

/// Header of bodies.csv, which has one row per step and body; step 0 is the initial state.
std::string bodies_header(int dim);

/// Appends the rows of step k to bodies.csv, one per body. `time`: s; `bodies`: with the motions of the step.
void add_body_rows(std::string& text, int k, double time, int dim, const diagnostics::Bodies& bodies);

/// Header of probes.csv, which has one row per step after row 0 for the initial state. `columns`: names of
/// the columns after step and time.
std::string probes_header(const std::vector<std::string>& columns);

/// Appends row k of probes.csv. `time`: s; `values`: one for each column after step and time.
void add_probes_row(std::string& text, int k, double time, std::span<const double> values);

/// Text of contact.csv, which has one row per stored step and candidate. The columns after step and time are
/// the candidate's point in the undeformed body, gap, force, obstacle, the obstacle's outward normal at the
/// point (the direction of the force on the body), area, pressure and status; with friction also the friction
/// force on the body, the velocity of the slip, and the motion along the obstacle. Numbers have as many
/// digits as are needed to recover the exact double.
class ContactTable {
public:
  /// Prepares the constant part of each candidate's row. `contacts`: the scene's tables [contact], which name
  /// the obstacles. `pairs` and `pressure` must outlive this object.
  ContactTable(const contact::ContactPairs& pairs, const contact::Pressure& pressure,
               const std::vector<scene::Contact>& contacts);

  [[nodiscard]] std::string header() const;

  /// Appends the rows of a step, one per candidate.
  void add_rows(std::string& text, const step::TimeStep& step, const contact::ContactState& contact) const;

private:
  /// Constant text of a candidate's row.
  struct CandidateText {
    std::string point, surface; ///< text of the point's columns; text of the columns from obstacle to area
  };
  /// Appends the columns of the vector T x of a pair, times `factor`, for the tangential part of x (rows).
  void add_along(std::string& text, int pair, std::span<const double> rows, double factor) const;

  const contact::ContactPairs& pairs_;
  int dim_;
  const contact::Pressure& pressure_;
  std::vector<CandidateText> fixed_;
  bool friction_;
};

} // namespace signorini::io
