#pragma once

namespace signorini::forward {

/// Binomial checkpointing (Griewank and Walther 2000, Algorithm 799): a motion of l steps is wanted from its
/// last state back to its first, the first one and s others (slots) can be kept, and what is not kept is made
/// again from the nearest that is.

/// The next state to keep: so many steps beyond the last one kept, for `steps` ≥ 1 from that one on and
/// `slots` ≥ 1 still free.
int next_checkpoint(int steps, int slots);

/// Steps made in all, which no other choice of checkpoints makes fewer: the first time included.
long steps_made(int steps, int slots);

} // namespace signorini::forward
