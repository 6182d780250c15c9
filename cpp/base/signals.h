// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <csignal>
#include <mpi.h>

namespace signorini {

/// Makes SIGINT, SIGTERM and SIGUSR1 request a stop of the run at the next safe point instead of ending the
/// process. A second signal of the same kind ends the process at once. Under mpirun use SIGUSR1, which mpirun
/// forwards to its ranks; on SIGINT and SIGTERM it kills them.
void catch_stop_signals();

/// Scope guard for programs that use this code as a library and have signal handlers of their own. SIGINT
/// requests a stop, however often it arrives, unless the program ignores SIGINT; the destructor restores the
/// previous handler. Only one guard may exist at a time.
class StopOnInterrupt {
public:
  StopOnInterrupt();
  ~StopOnInterrupt() { (void)release(); }
  /// Restores the previous handler. Returns whether a stop was requested, and clears the request.
  bool release();
  StopOnInterrupt(const StopOnInterrupt&) = delete;
  StopOnInterrupt& operator=(const StopOnInterrupt&) = delete;

private:
  struct sigaction before_{};
  bool released_ = false;
};

/// Requests a stop of the run, as the signals of catch_stop_signals() do.
void request_stop();

/// Ignores SIGPIPE, so that a write to a closed pipe fails instead of ending the process.
void ignore_broken_pipes();

/// Starts a timer that requests a stop of the run after `seconds` (s, above 0).
void stop_after(double seconds);
/// Whether the timer of stop_after() has expired on any rank. Collective.
bool time_is_up(MPI_Comm comm);
/// Cancels the timer of stop_after() and the stop that it has requested.
void forget_deadline();

/// Whether a signal, request_stop() or stop_after() has requested a stop of this process. Not collective.
bool stop_requested();
/// Whether a stop was requested on any rank. Collective.
bool stop_requested(MPI_Comm comm);

} // namespace signorini
