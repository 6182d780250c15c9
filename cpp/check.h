#pragma once
#include "base/progress.h"
#include "problem.h"

namespace signorini {

/// Checks the derivatives and the discrete invariants of a scene, prints a table, and returns whether all rows hold.
/// A contact scene whose body never touches the obstacle fails: it checks nothing of contact. Collective.
bool check_scene(const Problem& problem, const Console& console);

} // namespace signorini
