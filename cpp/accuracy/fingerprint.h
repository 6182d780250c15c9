// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"

namespace signorini::accuracy {

/// All inputs that determine the results of a rung, by name: texts, or digests of files. Rungs with equal
/// fingerprints have equal results.
using Fingerprint = std::map<std::string, std::string>;

/// Inputs of a run of the scene besides the scene itself: versions, PETSc's options, and the contents of the
/// files that the scene names. Call this before the first solver, since solvers add their defaults to the
/// options. Not collective.
Fingerprint inputs(const scene::Scene& scene);

/// Computes the fingerprints of a study's rungs from their common part, which is determined once. Used on
/// rank 0, where SamplePoints has a digest.
class Origin {
public:
  /// Determines the common part, including PETSc's options. Construct before the first solver, since solvers
  /// add their defaults to these options. The references must outlive this object.
  Origin(const scene::Scene& scene, const SamplePoints& samples, int ranks);

  /// Fingerprint of a rung.
  [[nodiscard]] Fingerprint of(const Rung& rung) const;
  /// Fingerprint of a search with the scene's own size, step, degree and scheme.
  [[nodiscard]] Fingerprint of_search() const;

private:
  const scene::Scene& scene_;
  int dim_;
  Fingerprint common_;
};

/// Describes the first input in which two fingerprints differ; empty if the fingerprints are equal.
std::string difference(const Fingerprint& kept, const Fingerprint& now);

} // namespace signorini::accuracy
