#include "base/signals.h"
#include <csignal>
#include <initializer_list>

namespace signorini {
namespace {

volatile std::sig_atomic_t requested = 0;

void on_signal(int signal) {
  requested = 1;
  std::signal(signal, SIG_DFL);
}

} // namespace

void catch_stop_signals() {
  for (int signal : {SIGINT, SIGTERM, SIGUSR1})
    std::signal(signal, on_signal);
}

void ignore_broken_pipes() { std::signal(SIGPIPE, SIG_IGN); }

bool stop_requested() { return requested != 0; }

bool stop_requested(MPI_Comm comm) {
  int mine = requested, any = mine, size = 1;
  MPI_Comm_size(comm, &size);
  if (size > 1)
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, comm);
  return any != 0;
}

} // namespace signorini
