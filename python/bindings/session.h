// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "base/signals.h"
#include <Python.h>
#include <mutex>
#include <nanobind/nanobind.h>

/// What the program's main function does around a run, for a library within Python.
namespace signorini::python {

/// Starts PETSc, and MPI unless mpi4py has. Collective.
void start();

/// Closes all that is open and ends PETSc, if start() began it, while there still is MPI. Collective.
void finish();

/// Something that owns objects of MPI and PETSc, which finish() takes from it in the end.
class Open {
public:
  Open();
  Open(const Open&) = delete;
  Open& operator=(const Open&) = delete;
  virtual ~Open();
  virtual void close() = 0;
};

/// One computation at a time.
inline std::mutex& computing() {
  static std::mutex one;
  return one;
}

/// Calls `work` while Python's other threads go on and Ctrl-C asks it to stop. If it is over before it has
/// seen that, Python's own handler is told.
template <class Work>
auto compute(Work&& work) {
  const nanobind::gil_scoped_release others;
  const std::lock_guard alone(computing());
  const StopOnInterrupt stop;
  auto result = work();
  if (stop_requested())
    PyErr_SetInterrupt();
  return result;
}

} // namespace signorini::python
