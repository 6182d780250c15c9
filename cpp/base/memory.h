#pragma once

namespace signorini {

/// Peak resident memory of this process, bytes.
double peak_memory();

/// Memory of the machine, bytes.
double machine_memory();

} // namespace signorini
