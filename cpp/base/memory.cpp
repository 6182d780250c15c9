// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/memory.h"
#include <cstdio>
#include <fstream>
#include <string>
#include <sys/resource.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace signorini {

double peak_memory() {
  // That of getrusage would be at least what the program held that started this one, such as a notebook.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (double kib = 0; std::sscanf(line.c_str(), "VmHWM: %lf kB", &kib) == 1)
      return 1024 * kib;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
  constexpr double unit = 1;
#else
  constexpr double unit = 1024; // KiB
#endif
  return unit * static_cast<double>(usage.ru_maxrss);
}

double resident_memory() {
  double whole = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void forget_peak_memory() {
#ifdef __GLIBC__
  malloc_trim(0); // freed heap memory would count as resident
#endif
  std::ofstream("/proc/self/clear_refs") << "5";
}

double machine_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

} // namespace signorini
