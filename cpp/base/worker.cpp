// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/worker.h"
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

namespace signorini::worker {

bool write_all(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR)
      return false;
    done += count > 0 ? static_cast<std::size_t>(count) : 0;
  }
  return true;
}

std::optional<std::string> read_all(int file, bool (*stop)()) {
  constexpr int look = 100; // ms, from one look for such a request to the next
  std::string text;
  std::array<char, 1 << 16> part{};
  while (!stop()) {
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

int serve(int argc, char** argv, const std::function<std::string(const std::string&)>& answer) {
  for (int signal : {SIGINT, SIGTERM, SIGUSR1}) // the parent decides when to stop
    std::signal(signal, SIG_IGN);
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  const rlimit none{.rlim_cur = 0, .rlim_max = 0};
  setrlimit(RLIMIT_CORE, &none);
  if (argc > 1 && *argv[1]) {
    const auto seconds = static_cast<rlim_t>(std::strtoul(argv[1], nullptr, 10));
    const rlimit time{.rlim_cur = seconds, .rlim_max = seconds};
    setrlimit(RLIMIT_CPU, &time);
  }
  // What libraries print must not come between the answer's bytes.
  const int out = dup(STDOUT_FILENO);
  if (out < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
    return 1;
  const std::optional<std::string> request = read_all(STDIN_FILENO, [] { return false; });
  return write_all(out, answer(*request) + whole) ? 0 : 1;
}

} // namespace signorini::worker
