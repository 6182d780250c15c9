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

/// Requests a stop if Ctrl-C came before a StopOnInterrupt stood: Python has noted it, and would raise
/// KeyboardInterrupt only after the computation.
inline void take_earlier_interrupt() {
  const nanobind::gil_scoped_acquire python;
  if (PyOS_InterruptOccurred())
    request_stop();
}

/// Calls `work` without Python's lock, so that other threads run; Ctrl-C requests a stop. Passes a request
/// that came too late for `work` on to Python's own handler.
template <class Work>
auto compute(Work&& work) {
  const nanobind::gil_scoped_release others;
  const std::lock_guard alone(computing());
  StopOnInterrupt stop;
  take_earlier_interrupt();
  auto result = work();
  if (stop.release())
    PyErr_SetInterrupt();
  return result;
}

} // namespace signorini::python
