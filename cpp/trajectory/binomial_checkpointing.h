// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini::trajectory {

/// Binomial checkpointing (Griewank and Walther 2000, Algorithm 799): the states of a motion of l steps are
/// needed from the last to the first, the first one and s others (slots) can be kept, and the rest are
/// recomputed from the nearest checkpoint before them.

/// Number of steps from the last checkpoint to the next one, for `steps` ≥ 1 from the last checkpoint on and
/// `slots` ≥ 1 still free.
int next_checkpoint(int steps, int slots);

/// Total number of steps, the first run included; the minimum over all choices of checkpoints.
long steps_made(int steps, int slots);

} // namespace signorini::trajectory
