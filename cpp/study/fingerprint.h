#pragma once
#include "study/measure.h"

namespace signorini::study {

/// All that a rung's numbers depend on, by what it is: texts, or digests of contents. Rungs with the same one
/// are the same.
using Fingerprint = std::map<std::string, std::string>;

/// What the fingerprints of one study's rungs have in common, looked at once. Used on rank 0, whose Samples
/// know their digest.
class Origin {
public:
  /// Before the first solver is made: each adds what it takes by default to PETSc's options. The references
  /// must outlive this object.
  Origin(const scene::Scene& scene, const Samples& samples, int ranks);

  [[nodiscard]] Fingerprint of(const Rung& rung) const;

private:
  const scene::Scene& scene_;
  int dim_;
  Fingerprint common_;
};

/// Of two fingerprints a part that is not the same, in words; empty if there is none.
std::string difference(const Fingerprint& kept, const Fingerprint& now);

} // namespace signorini::study
