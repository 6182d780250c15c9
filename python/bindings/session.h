// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "base/signals.h"
#include <Python.h>
#include <memory>
#include <mutex>
#include <nanobind/nanobind.h>

/// Start and end of the libraries, and guards of computations, for a library within Python.
namespace signorini::python {

/// Starts PETSc, and MPI unless mpi4py has started it. In that case PETSc ends within MPI_Finalize(), which
/// mpi4py calls last: a rank that fails reaches MPI_Abort() first, and no other one waits for it. Collective.
void start();

/// Ends the session as Python exits. Takes the resources of all open objects, so that none is freed in an
/// order of this rank alone; ends PETSc and MPI if start() started MPI. Collective only in that case.
void leave();

/// Python object that owns objects of MPI and PETSc. Freeing these is collective, but Python drops its
/// objects on each rank at any time. So objects that all ranks have dropped are freed when the next one is
/// made.
class Open {
public:
  /// Registers the object and frees those that all ranks have dropped. Collective.
  Open();
  Open(const Open&) = delete;
  Open& operator=(const Open&) = delete;
  virtual ~Open();
  /// Releases the resources that the object owns.
  virtual std::shared_ptr<const void> release() = 0;
  /// Number of the object: the same on every rank, and larger than those of older objects.
  [[nodiscard]] long number() const { return number_; }

protected:
  /// Frees resources that the object owned; on several ranks later.
  void drop(std::shared_ptr<const void> owned) const;

private:
  long number_;
};

/// Mutex that admits one computation at a time.
inline std::mutex& computing() {
  static std::mutex one;
  return one;
}

/// Calls `work`, which is short, without Python's lock, once no other thread computes.
template <class Work>
auto alone(Work&& work) {
  const nanobind::gil_scoped_release others;
  const std::lock_guard guard(computing());
  return work();
}

/// Requests a stop if Ctrl-C came before a StopOnInterrupt existed: Python has noted it, and would raise
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
  const std::lock_guard guard(computing());
  StopOnInterrupt stop;
  take_earlier_interrupt();
  auto result = work();
  if (stop.release())
    PyErr_SetInterrupt();
  return result;
}

} // namespace signorini::python
