// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/signals.h"
#include "base/collective.h"
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sys/time.h>
#include <utility>

namespace signorini {
namespace {

volatile std::sig_atomic_t requested = 0, late = 0;

void on_signal(int signal) {
  requested = 1;
  std::signal(signal, SIG_DFL);
}

void on_alarm(int) { late = 1; }

bool on_any(MPI_Comm comm, bool here) {
  int any = here;
  if (ranks(comm) > 1)
    MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm);
  return any != 0;
}

void set_timer(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - std::floor(seconds)));
  setitimer(ITIMER_REAL, &timer, nullptr);
}

} // namespace

void stop_after(double seconds) {
  std::signal(SIGALRM, on_alarm);
  constexpr double least = 1e-6; // zero would disarm the timer
  set_timer(std::max(seconds, least));
}

void forget_deadline() {
  set_timer(0);
  late = 0;
}

void catch_stop_signals() {
  for (int signal : {SIGINT, SIGTERM, SIGUSR1})
    std::signal(signal, on_signal);
}

StopOnInterrupt::StopOnInterrupt() {
  requested = 0;
  sigaction(SIGINT, nullptr, &before_);
  if (before_.sa_handler == SIG_IGN) // as in the background of a shell
    return;
  struct sigaction ours{};
  ours.sa_handler = [](int) { requested = 1; };
  ours.sa_flags = SA_RESTART;
  sigaction(SIGINT, &ours, nullptr);
}

bool StopOnInterrupt::release() {
  if (std::exchange(released_, true))
    return false;
  sigaction(SIGINT, &before_, nullptr); // first: a signal that comes now is the previous handler's
  const bool asked = requested != 0;
  requested = 0;
  return asked;
}

void request_stop() { requested = 1; }

void ignore_broken_pipes() { std::signal(SIGPIPE, SIG_IGN); }

bool stop_requested() { return requested != 0 || late != 0; }

bool stop_requested(MPI_Comm comm) { return on_any(comm, stop_requested()); }

bool time_is_up(MPI_Comm comm) { return on_any(comm, late != 0); }

} // namespace signorini
