// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/obstacle_surface.h"
#include "diagnostics/balance.h"
#include "diagnostics/impact_summary.h"
#include "diagnostics/largest_stress.h"
#include "diagnostics/plausibility.h"
#include "diagnostics/probe_peaks.h"
#include "diagnostics/warnings.h"
#include "io/csv_tables.h"
#include "io/field_writer.h"
#include "io/manifest.h"
#include "io/obstacle_surfaces.h"
#include "io/output_folder.h"
#include "problem/problem.h"
#include <functional>
#include <optional>

namespace signorini::drivers {

/// Whether a run stores fields and contact of a step. Runs store the initial state, the last step, and every
/// `every`-th step. If `every` is 0, they store the first step after each of Output::most_frames equal parts
/// of the time from 0 to `end` (s). MotionWriter also stores the step of the largest contact force.
bool stored(const step::TimeStep& step, double end, int every, bool last);

/// Writes the files of a motion, as the scene's [output] selects: steps.csv, contact.csv, obstacles.csv,
/// probes.csv and the fields of the state frame by frame, and the obstacles' surfaces at the end. Also
/// summarises the motion, and monitors its invariants and plausibility.
class MotionWriter {
public:
  /// Opens the files. `objective`: objective of a search, null without one; `controlled`: whether a control
  /// acts; `errors`: errors of the time steps if their lengths are chosen during the motion, else null.
  /// Throws UserError, WriteFailure. Collective. The arguments must outlive this object.
  MotionWriter(const problem::Problem& problem, const io::OutputFolder& folder,
               const control::Objective* objective, bool controlled,
               const trajectory::StepErrors* errors = nullptr);

  /// Records a frame; must be called for all frames in order, from frame 0 on. Throws UserError,
  /// WriteFailure, and SolverFailure if a step violates an invariant and run.invariants is "stop".
  /// Collective.
  void operator()(const trajectory::Frame& frame);

  /// Monitored invariants; null if no invariants are monitored.
  [[nodiscard]] const diagnostics::Invariants* invariants() const {
    return invariants_ ? &*invariants_ : nullptr;
  }

  /// Summary of the motion; null if the balances of its steps are not computed.
  [[nodiscard]] const diagnostics::ImpactSummary* summary() const { return summary_ ? &*summary_ : nullptr; }

  /// Whether the first bounce is over; only of scenes with time.end = "auto".
  [[nodiscard]] bool bounced() const { return summary_ && summary_->bounced(); }

  /// Bodies in contact with each other, with their motions in the last frame; null unless the scene has some.
  [[nodiscard]] const diagnostics::Bodies* bodies() const { return bodies_ ? &*bodies_ : nullptr; }

  /// Peaks of accelerations and filtered forces of the probes.
  [[nodiscard]] std::vector<diagnostics::ProbePeak> probe_peaks() const {
    return peaks_ ? peaks_->peaks() : std::vector<diagnostics::ProbePeak>();
  }

  /// From now on every doubles with each Output::most_frames stored times: for a motion whose end is unknown,
  /// of which the caller chose `every`.
  void thin_out() { thins_out_ = true; }
  /// Steps between stored times at the end of the motion; 0: chosen by time.
  [[nodiscard]] int every() const { return every_; }

  /// Steps whose fields and contact were stored, ascending; complete after finish().
  [[nodiscard]] const std::vector<int>& stored() const { return stored_; }

  /// Largest von Mises stress of any cell at the stored times; absent if no stress is stored. Collective.
  [[nodiscard]] std::optional<diagnostics::LargestStress::Peak> von_mises() {
    return largest_stress_ ? largest_stress_->peak() : std::nullopt;
  }

  /// Warnings that the motion leaves the range of the model, or that the mesh does not resolve the motion.
  /// Collective.
  [[nodiscard]] std::vector<Warning> warnings();

  /// Stores the step of the largest contact force if it is not stored yet, and closes the files. Throws
  /// UserError, WriteFailure. Collective.
  void finish();

private:
  void weigh(const trajectory::Frame& frame, diagnostics::StepBalance& balance);
  void add_rows(const trajectory::Frame& frame, const diagnostics::StepBalance& balance);
  void open_tables(const io::OutputFolder& folder, bool probed);
  /// Opens the files of the state if the scene stores a field in them.
  void open_state(const io::OutputFolder& folder);
  /// State and contact at the end of a step.
  struct Snapshot {
    step::TimeStep step;
    const step::State& state;
    const contact::ContactState& contact;
  };
  /// Copy of a step that finish() stores unless a later step has a larger contact force.
  struct Aside {
    step::TimeStep step;
    step::State state; ///< set only if fields are stored
    contact::ContactState contact;
    std::streamoff rows; ///< position of the step's rows in contact.csv
  };
  void put_aside(const trajectory::Frame& frame);
  void write_step(const Snapshot& now);
  void store_fields(const Snapshot& now, std::size_t number);
  /// Whether surfaces.h5 is written.
  [[nodiscard]] bool with_surfaces() const { return problem_.stepper.pairs() && (state_ || contact_); }
  /// Notes where body and obstacles are at the displacement y (m) of the stored step `number`: extends body_
  /// so that it contains this rank's nodes. Collective.
  void follow(Vec y, std::size_t number);
  void write_obstacle_surfaces() const;
  void insert(const Aside& peak);
  /// Rows of a step in contact.csv, valid until the next call.
  [[nodiscard]] const std::string& contact_rows(const step::TimeStep& step,
                                                const contact::ContactState& contact);

  const problem::Problem& problem_;
  const io::OutputFolder& folder_;
  const control::Objective* objective_;
  io::StepsColumns columns_;
  std::optional<diagnostics::Balance> balance_;
  std::optional<diagnostics::Invariants> invariants_;
  diagnostics::Plausibility plausibility_;
  diagnostics::ObstacleForces forces_;
  diagnostics::ContactResolution resolution_;
  diagnostics::StepWarnings step_warnings_;
  std::optional<diagnostics::Bodies> bodies_; ///< if parts of the body are in contact
  std::optional<diagnostics::ImpactSummary> summary_;
  std::optional<diagnostics::ProbePeaks> peaks_; ///< of probes that are recorded
  std::optional<io::TextFile> steps_, contact_, obstacles_, bodies_file_, probes_;
  std::optional<contact::Pressure> pressure_;
  petsc::Vector friction_{}; ///< tangential traction at the nodes; null until it is written
  std::optional<io::ContactTable> contact_table_;
  std::optional<io::FieldWriter> state_;
  std::optional<fem::CellFields> cell_fields_;
  std::optional<diagnostics::LargestStress> largest_stress_;
  int every_;                      ///< steps between stored times, as `stored()` has it
  bool thins_out_ = false;         ///< whether every_ grows
  std::vector<int> stored_;        ///< numbers of the stored steps
  std::vector<double> times_;      ///< ends of the stored steps, s
  std::vector<io::Places> places_; ///< of each obstacle at the stored times; empty without mass
  contact::Box body_;              ///< box around this rank's nodes at the stored times
  diagnostics::LargestForce largest_force_;
  std::optional<Aside> aside_; ///< step of the largest force, unless that step is stored already
  std::string text_;           ///< buffer of rows
  std::vector<double> values_; ///< buffer of a row
};

/// Function that computes the adjoint states and passes each to `store`; p is valid only during the call of
/// `store`.
using AdjointStates = std::function<void(const std::function<void(int k, Vec p)>& store)>;

/// Writes the fields of control and adjoint state for the steps in `stored`, as the scene's [output] selects.
/// Calls `adjoint_states` only if adjoint states are to be written. Throws UserError, WriteFailure.
/// Collective.
void write_control(const io::OutputFolder& folder, const problem::Problem& problem,
                   const control::ControlSpace& controls, const control::Control& u,
                   const AdjointStates& adjoint_states, const std::vector<int>& stored);

} // namespace signorini::drivers
