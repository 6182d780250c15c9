#pragma once
#include "contact/pairs.h"

namespace signorini::contact {

/// Whether the direction of candidate i depends linearly on those of its node in an independent set.
[[nodiscard]] bool depends(const ContactPairs& pairs, const ActiveSet& set, int i);

/// Removes candidates that depend on earlier ones of their node.
void drop_dependent(const ContactPairs& pairs, ActiveSet& set);

/// The next set of a primal-dual step, independent, from the solution on an independent `set`: closed
/// candidates with λ > 0 and open ones with g < 0 (Hintermüller, Ito, Kunisch 2003). A candidate that depends
/// on others of its node replaces the one whose force falls to zero first as its own grows (ratio test).
void next_set(const ContactPairs& pairs, const ActiveSet& set, std::span<const double> lambda,
              std::span<const double> gap, ActiveSet& next);

/// Replaces the candidates of candidate i's node in `set` by those in `other`.
void take_node(const ContactPairs& pairs, const ActiveSet& other, int i, ActiveSet& set);

} // namespace signorini::contact
