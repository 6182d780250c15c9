// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/worker.h"
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <sys/wait.h>
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

namespace {

constexpr int idle = 10'000; // ms: what waits, loaded, holds some ten megabytes

union Descriptors {
  std::array<char, CMSG_SPACE(2 * sizeof(int))> bytes;
  cmsghdr aligned;
};

msghdr message(iovec& data, Descriptors& descriptors) {
  msghdr one{};
  one.msg_iov = &data;
  one.msg_iovlen = 1;
  one.msg_control = descriptors.bytes.data();
  one.msg_controllen = sizeof descriptors.bytes;
  return one;
}

bool receive_job(int socket, Job& job) {
  pollfd ready{.fd = socket, .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, idle) <= 0)
    return false;
  Descriptors descriptors{};
  iovec data{.iov_base = &job.seconds, .iov_len = sizeof job.seconds};
  msghdr received = message(data, descriptors);
  if (recvmsg(socket, &received, 0) != static_cast<ssize_t>(sizeof job.seconds))
    return false;
  const cmsghdr* header = CMSG_FIRSTHDR(&received);
  if (!header || header->cmsg_len != CMSG_LEN(2 * sizeof(int)))
    return false;
  std::array<int, 2> files{};
  std::memcpy(files.data(), CMSG_DATA(header), sizeof files);
  job.in = files[0];
  job.out = files[1];
  return true;
}

void die_with_parent() {
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
}

template <class Resource>
void limit(Resource resource, rlim_t most) {
  const rlimit both{.rlim_cur = most, .rlim_max = most};
  setrlimit(resource, &both);
}

} // namespace

bool send_job(int socket, const Job& job) {
  int seconds = job.seconds;
  Descriptors descriptors{};
  iovec data{.iov_base = &seconds, .iov_len = sizeof seconds};
  const msghdr sent = message(data, descriptors);
  cmsghdr* header = CMSG_FIRSTHDR(&sent);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(2 * sizeof(int));
  const std::array<int, 2> files{job.in, job.out};
  std::memcpy(CMSG_DATA(header), files.data(), sizeof files);
#ifdef MSG_NOSIGNAL
  constexpr int quiet = MSG_NOSIGNAL;
#else
  constexpr int quiet = 0;
#endif
  return sendmsg(socket, &sent, quiet) == static_cast<ssize_t>(sizeof seconds);
}

int serve(const std::function<std::string(const std::string&)>& answer) {
  for (int signal : {SIGINT, SIGTERM, SIGUSR1}) // the parent decides when to stop
    std::signal(signal, SIG_IGN);
  die_with_parent();
  limit(RLIMIT_CORE, 0);
  for (Job job{}; receive_job(STDIN_FILENO, job);) {
    const pid_t copy = fork(); // of a process without MPI and without threads
    if (copy == 0) {
      close(STDIN_FILENO);
      die_with_parent();
      if (job.seconds > 0)
        limit(RLIMIT_CPU, static_cast<rlim_t>(job.seconds));
      const std::optional<std::string> request = read_all(job.in, [] { return false; });
      _exit(write_all(job.out, answer(*request)) ? 0 : 1);
    }
    close(job.in);
    close(job.out);
    int status = 0;
    if (copy < 0 || waitpid(copy, &status, 0) < 0 || write(STDIN_FILENO, &status, sizeof status) < 0)
      return 1;
  }
  return 0;
}

} // namespace signorini::worker
