// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini {

/// Peak resident memory of this process since its start or the last forget_peak_memory(), bytes.
double peak_memory();

/// Resident memory of this process now, bytes; 0 where the system does not tell (Linux does).
double resident_memory();

/// Resets the peak to the present resident memory where the system allows it (Linux); first returns free heap
/// memory to the system.
void forget_peak_memory();

/// Physical memory of the machine, bytes.
double machine_memory();

} // namespace signorini
