// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/subprocess.h"
#include "base/error.h"
#include "base/signals.h"
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace signorini {
namespace {

constexpr char whole = '.'; // the last byte of a complete answer

bool write_all(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR)
      return false;
    done += count > 0 ? static_cast<std::size_t>(count) : 0;
  }
  return true;
}

/// All that comes; nothing if this process is asked to stop.
std::optional<std::string> read_all(int file) {
  constexpr int look = 100; // ms, from one look for such a request to the next
  std::string text;
  std::array<char, 1 << 16> part{};
  while (!stop_requested()) {
    pollfd ready{.fd = file, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, look) <= 0)
      continue;
    const ssize_t count = read(file, part.data(), part.size());
    if (count == 0 || (count < 0 && errno != EINTR))
      return text;
    if (count > 0)
      text.append(part.data(), static_cast<std::size_t>(count));
  }
  return std::nullopt;
}

[[noreturn]] void child(int out, const std::function<std::string()>& make, std::optional<unsigned> seconds) {
  setpgid(0, 0); // a group of its own, that ends as a whole
  for (int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPIPE}) // the parent's handlers would print
    std::signal(signal, SIG_DFL);
  for (int signal : {SIGINT, SIGTERM, SIGUSR1}) // the parent decides when to stop
    std::signal(signal, SIG_IGN);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nowhere = open("/dev/null", O_WRONLY); // the C library prints when it detects a corrupt heap
  if (nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  const rlimit none{.rlim_cur = 0, .rlim_max = 0};
  setrlimit(RLIMIT_CORE, &none);
  if (seconds) {
    const rlimit time{.rlim_cur = *seconds, .rlim_max = *seconds};
    setrlimit(RLIMIT_CPU, &time);
  }
  _exit(write_all(out, make() + whole) ? 0 : 1); // not exit(): buffers and MPI belong to the parent
}

} // namespace

std::optional<std::string> in_subprocess(const std::function<std::string()>& make,
                                         std::optional<unsigned> seconds) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0)
    throw std::runtime_error("no pipe can be opened");
  (void)std::fflush(nullptr); // lest the child writes the same buffered text again
  const pid_t process = fork();
  if (process == 0) {
    close(ends[0]);
    child(ends[1], make, seconds);
  }
  close(ends[1]);
  if (process > 0)
    setpgid(process, process); // whichever of the two comes first
  std::optional<std::string> text = process > 0 ? read_all(ends[0]) : "";
  close(ends[0]);
  if (process < 0)
    throw std::runtime_error("no process can be started");
  if (!text)
    kill(-process, SIGKILL);
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (!text)
    throw Interrupted();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !text->ends_with(whole))
    return std::nullopt;
  text->pop_back();
  return text;
}

} // namespace signorini
