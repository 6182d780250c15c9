#pragma once

namespace signorini {

/// Peak resident memory of this process since it started or since the last forget_peak_memory(), bytes.
double peak_memory();

/// Resident memory of this process now, bytes.
double resident_memory();

/// Starts the peak afresh, where the system lets it (Linux).
void forget_peak_memory();

/// Memory of the machine, bytes.
double machine_memory();

} // namespace signorini
