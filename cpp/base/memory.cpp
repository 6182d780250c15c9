// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/memory.h"
#include <fstream>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

namespace signorini {

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss); // Linux counts in KiB
}

double resident_memory() {
  double whole = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void forget_peak_memory() {
  malloc_trim(0); // freed heap memory would count as resident
  std::ofstream("/proc/self/clear_refs") << "5";
}

double machine_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

} // namespace signorini
