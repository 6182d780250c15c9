// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "base/signals.h"
#include <Python.h>
#include <memory>
#include <mutex>
#include <nanobind/nanobind.h>

/// What the program's main function does around a run, for a library within Python.
namespace signorini::python {

/// Starts PETSc, and MPI unless mpi4py has. Then PETSc ends within MPI_Finalize(), which mpi4py calls last:
/// a rank that fails reaches MPI_Abort() first, and no other one waits for it. Collective.
void start();

/// At Python's end: takes what all open objects own, so that nothing of it is freed in an order of this rank
/// alone; ends PETSc, and MPI, if start() began that. Collective only then.
void leave();

/// An object of Python that owns objects of MPI and PETSc. To free those is collective, and Python drops its
/// objects on each rank when it likes: what all ranks have dropped is freed when the next object is made.
class Open {
public:
  /// Collective.
  Open();
  Open(const Open&) = delete;
  Open& operator=(const Open&) = delete;
  virtual ~Open();
  /// Gives away what it owns.
  virtual std::shared_ptr<const void> release() = 0;
  /// The same on every rank, and larger than those of older objects.
  [[nodiscard]] long number() const { return number_; }

protected:
  /// Frees what it owned; on several ranks later.
  void drop(std::shared_ptr<const void> owned) const;

private:
  long number_;
};

/// One computation at a time.
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
  const std::lock_guard guard(computing());
  StopOnInterrupt stop;
  take_earlier_interrupt();
  auto result = work();
  if (stop.release())
    PyErr_SetInterrupt();
  return result;
}

} // namespace signorini::python
