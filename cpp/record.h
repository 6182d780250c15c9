#pragma once
#include "forward/invariants.h"
#include "forward/plausibility.h"
#include "io/fields.h"
#include "io/tables.h"
#include "problem.h"
#include <optional>

namespace signorini {

/// Steps whose fields and contact a run stores: every n-th, and the last that it makes.
inline bool stored(int k, int every, bool last) { return k % every == 0 || last; }

/// Writes steps.csv, contact.csv and state.xdmf of a motion as it goes by, as much of them as the scene's
/// [output] asks for, and watches it.
class Recorder {
public:
  /// `objective` is null in a run without one. Collective. The arguments must outlive this object. Throws
  /// UserError, WriteFailure.
  Recorder(const Problem& problem, const io::OutputFolder& folder, const control::Objective* objective);

  /// Takes the frame after the last one, from frame 0 on. Collective. Throws UserError, WriteFailure; where
  /// the scene says so SolverFailure at the step that breaks an invariant.
  void operator()(const forward::Frame& frame);

  /// What was watched; null if nothing was.
  [[nodiscard]] const forward::Invariants* invariants() const {
    return invariants_ ? &*invariants_ : nullptr;
  }

  /// What makes the motion mean less than it seems to. Collective.
  [[nodiscard]] std::vector<forward::Warning> warnings() { return plausibility_.warnings(); }

  /// Closes the files. Collective. Throws UserError, WriteFailure.
  void finish();

private:
  void store(const forward::Frame& frame);

  const Problem& problem_;
  const control::Objective* objective_;
  std::optional<forward::Balance> balance_;
  std::optional<forward::Invariants> invariants_;
  forward::Plausibility plausibility_;
  std::optional<io::TextFile> steps_, contact_;
  std::optional<io::FieldFile> state_;
  std::string text_; ///< rows on their way
};

} // namespace signorini
