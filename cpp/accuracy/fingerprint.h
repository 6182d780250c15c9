// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"

namespace signorini::accuracy {

/// Inputs that determine the numbers of a rung, by name: texts, or digests of contents. Rungs with equal
/// fingerprints have equal results.
using Fingerprint = std::map<std::string, std::string>;

/// The common part of the fingerprints of a study's rungs, determined once. Used on rank 0, whose Samples
/// have their digest.
class Origin {
public:
  /// Reads PETSc's options too: construct it before the first solver, since each adds its defaults to them.
  /// The references must outlive this object.
  Origin(const scene::Scene& scene, const Samples& samples, int ranks);

  [[nodiscard]] Fingerprint of(const Rung& rung) const;
  /// Fingerprint of a search on the scene's own rung.
  [[nodiscard]] Fingerprint of_search() const;

private:
  const scene::Scene& scene_;
  int dim_;
  Fingerprint common_;
};

/// Describes the first part in which two fingerprints differ; empty if there is none.
std::string difference(const Fingerprint& kept, const Fingerprint& now);

} // namespace signorini::accuracy
