// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "contact/pressure.h"
#include "diagnostics/contact_forces.h"
#include "scene/scene.h"
#include "step/time_grid.h"
#include <span>
#include <string>
#include <vector>

/// The CSV files of a run with a row for each step and obstacle, or for each step, as text.
namespace signorini::io {

/// Header of obstacles.csv: one row per step and obstacle, step 0 the initial state.
std::string obstacles_header(int dim);

/// Appends the rows of step k. `contacts`: those of the scene, which have the obstacles' names.
void add_obstacle_rows(std::string& text, int k, double time, int dim,
                       const std::vector<scene::Contact>& contacts,
                       const diagnostics::ObstacleForces& forces);

/// Header of probes.csv: one row per step, row 0 the initial state.
std::string probes_header(const std::vector<std::string>& columns);

/// Appends row k.
void add_probes_row(std::string& text, int k, double time, std::span<const double> values);

/// contact.csv, as text: one row per stored step and candidate, with its point in the undeformed body, the
/// name of its obstacle, the obstacle's normal there (out of the obstacle, the direction of
/// the force on the body), area and pressure. Numbers have as many digits as tell them from all others.
class ContactTable {
public:
  /// `pressure` must outlive this object; `contacts`: those of the scene, which have the obstacles' names.
  ContactTable(const contact::ContactPairs& pairs, const contact::Pressure& pressure,
               const std::vector<scene::Contact>& contacts);

  [[nodiscard]] std::string header() const;

  /// Appends the rows of a step.
  void add_rows(std::string& text, const step::TimeStep& step, const contact::ContactState& contact) const;

private:
  /// What of each candidate's row never changes, before and behind gap and force.
  struct Fixed {
    std::string point, surface;
  };
  int dim_;
  const contact::Pressure& pressure_;
  std::vector<Fixed> fixed_;
};

} // namespace signorini::io
