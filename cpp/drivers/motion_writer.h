// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/obstacle_surface.h"
#include "diagnostics/balance.h"
#include "diagnostics/impact_summary.h"
#include "diagnostics/plausibility.h"
#include "diagnostics/warnings.h"
#include "io/csv_tables.h"
#include "io/field_writer.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "problem/problem.h"
#include <functional>
#include <optional>

namespace signorini::drivers {

/// Whether a run that ends at the time `end` (s) stores fields and contact of a step. It does so for the
/// initial state, the last step, and every n-th step or, where `every` is 0, the first one after each of
/// Output::most_frames equal parts of the time. MotionWriter also stores the step of the largest force.
bool stored(const step::TimeStep& step, double end, int every, bool last);

/// Writes the files of a motion that the scene's [output] selects, frame by frame: steps.csv, contact.csv,
/// obstacles.csv, probes.csv and state.xdmf, and at the end surfaces.h5. Sums the motion up, and monitors its
/// invariants and plausibility.
class MotionWriter {
public:
  /// Opens the files. `objective`: null in a run without one; `controlled`: whether a control acts; `errors`:
  /// errors of the steps, if they are chosen during the motion. Collective. The arguments must outlive this
  /// object. Throws UserError, WriteFailure.
  MotionWriter(const problem::Problem& problem, const io::OutputFolder& folder,
               const control::Objective* objective, bool controlled,
               const trajectory::StepErrors* errors = nullptr);

  /// Takes the frame after the last one, from frame 0 on. Collective. Throws UserError, WriteFailure; with
  /// run.invariants = "stop" SolverFailure at the step that violates an invariant.
  void operator()(const trajectory::Frame& frame);

  /// Monitored invariants; null if none are.
  [[nodiscard]] const diagnostics::Invariants* invariants() const {
    return invariants_ ? &*invariants_ : nullptr;
  }

  /// Summary of the motion; null if nothing needs the balances of its steps.
  [[nodiscard]] const diagnostics::ImpactSummary* summary() const { return summary_ ? &*summary_ : nullptr; }

  /// Steps whose fields and contact were stored, ascending; complete after finish().
  [[nodiscard]] const std::vector<int>& stored() const { return stored_; }

  /// The largest von Mises stress of a cell at the stored times; absent if no stress is stored. Collective.
  [[nodiscard]] std::optional<diagnostics::LargestStress::Peak> von_mises() {
    return largest_stress_ ? largest_stress_->peak() : std::nullopt;
  }

  /// Warnings where the motion leaves the range of the model, or the mesh does not resolve it. Collective.
  [[nodiscard]] std::vector<Warning> warnings();

  /// Stores the step of the largest contact force, and closes the files. Collective. Throws UserError,
  /// WriteFailure.
  void finish();

private:
  void weigh(const trajectory::Frame& frame, diagnostics::StepBalance& balance);
  void add_rows(const trajectory::Frame& frame, const diagnostics::StepBalance& balance);
  void open_tables(const io::OutputFolder& folder, bool probed);
  /// Opens state.xdmf if the scene stores a field in it.
  void open_state(const io::OutputFolder& folder);
  /// The state and contact after a step.
  struct Snapshot {
    step::TimeStep step;
    const step::State& state;
    const contact::ContactState& contact;
  };
  /// A step that is to be stored unless a later one has a larger contact force.
  struct Aside {
    step::TimeStep step;
    step::State state; ///< set only with fields
    contact::ContactState contact;
    std::streamoff rows; ///< position of the step's rows in contact.csv
  };
  void put_aside(const trajectory::Frame& frame);
  void store(const Snapshot& now);
  void store_fields(const Snapshot& now, std::size_t number);
  /// Whether surfaces.h5 is written.
  [[nodiscard]] bool with_surfaces() const { return problem_.stepper.pairs() && (state_ || contact_); }
  /// Extends the box of the body.
  void follow_body(Vec y);
  void write_surfaces() const;
  void insert(const Aside& peak);
  /// Rows of a step in contact.csv, valid until the next call.
  [[nodiscard]] const std::string& contact_rows(const step::TimeStep& step,
                                                const contact::ContactState& contact);

  const problem::Problem& problem_;
  const io::OutputFolder& folder_;
  const control::Objective* objective_;
  std::optional<diagnostics::Balance> balance_;
  std::optional<diagnostics::Invariants> invariants_;
  diagnostics::Plausibility plausibility_;
  diagnostics::ObstacleForces forces_;
  diagnostics::ContactResolution resolution_;
  diagnostics::StepWarnings step_warnings_;
  std::optional<diagnostics::ImpactSummary> summary_;
  std::optional<io::TextFile> steps_, contact_, obstacles_, probes_;
  std::optional<contact::Pressure> pressure_;
  std::optional<io::ContactTable> contact_table_;
  std::optional<io::FieldWriter> state_;
  std::optional<fem::CellFields> cell_fields_;
  std::optional<diagnostics::LargestStress> largest_stress_;
  std::vector<int> stored_;   ///< stored steps
  std::vector<double> times_; ///< ends of these steps, s
  contact::Box body_;         ///< box around this rank's nodes at these times
  diagnostics::LargestForce largest_force_;
  std::optional<Aside> aside_; ///< step of the largest force, if it is not stored yet
  std::string text_;           ///< buffer of rows
  std::vector<double> values_; ///< buffer of a row
};

/// Passes adjoint states to `store`, each valid during that call.
using AdjointStates = std::function<void(const std::function<void(int k, Vec p)>& store)>;

/// Writes control.xdmf and adjoint.xdmf of the `stored` steps, as the scene's [output] selects; evaluates
/// `adjoint_states` only if they are written. Collective. Throws UserError, WriteFailure.
void write_control(const io::OutputFolder& folder, const problem::Problem& problem,
                   const control::ControlSpace& controls, const control::Control& u,
                   const AdjointStates& adjoint_states, const std::vector<int>& stored);

} // namespace signorini::drivers
