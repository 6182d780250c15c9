// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/subprocess.h"
#include "base/error.h"
#include "base/signals.h"
#include "base/worker.h"
#include "version.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <memory>
#include <spawn.h>
#include <stdexcept>
#include <string_view>
#include <sys/socket.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

extern "C" char** environ;

namespace signorini {
namespace {

[[noreturn]] void fail(const std::string& what, int error) {
  throw std::runtime_error(fmt::format("{}: {}", what, std::generic_category().message(error)));
}

using File = std::unique_ptr<FILE, int (*)(FILE*)>;

/// A file without a name: a worker that ends before it has read a pipe would break that.
File request_file(const std::string& request) {
  File file(std::tmpfile(), &std::fclose);
  if (!file || !worker::write_all(fileno(file.get()), request) || lseek(fileno(file.get()), 0, SEEK_SET) != 0)
    fail("a request for a worker cannot be written to a temporary file", errno);
  return file;
}

/// A worker that waits for requests, in a group of its own, that ends as a whole, with nothing of this
/// process but its end of a socket.
class Worker {
public:
  explicit Worker(std::filesystem::path program)
      : program_(std::move(program)), folder_(here()), owner_(getpid()) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0)
      fail("no socket can be opened", errno);
    for (const int end : ends) // the worker gets its own descriptor
      fcntl(end, F_SETFD, FD_CLOEXEC);
    socket_ = ends[0];
    const int error = start(ends[1]);
    close(ends[1]);
    if (error != 0) {
      close(socket_);
      fail(fmt::format("{} cannot be started", program_.string()), error);
    }
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    close(socket_);
    if (owner_ != getpid()) // a copy of the process that started it
      return;
    kill(-process_, SIGKILL);
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
  }

  /// Whether it is of this program, was started by this process, and stands where relative paths are this
  /// one's.
  [[nodiscard]] bool serves(const std::filesystem::path& program) const {
    return program == program_ && owner_ == getpid() && folder_ == here();
  }

  bool take(const worker::Job& job) const { return worker::send_job(socket_, job); }

  /// How the job ended, as waitpid() says it; nothing if the worker itself did.
  [[nodiscard]] std::optional<int> status() const {
    int status = 0;
    ssize_t count = 0;
    while ((count = recv(socket_, &status, sizeof status, MSG_WAITALL)) < 0 && errno == EINTR) {
    }
    return count == static_cast<ssize_t>(sizeof status) ? std::optional(status) : std::nullopt;
  }

private:
  static std::filesystem::path here() {
    std::error_code gone;
    return std::filesystem::current_path(gone);
  }

  int start(int socket) {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, socket, STDIN_FILENO);
    // What libraries print, and the C library when it detects a corrupt heap.
    for (const int file : {STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&files, file, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE); // which this process ignores
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    std::string path = program_.string();
    std::array<char*, 2> arguments{path.data(), nullptr};
    const int error = posix_spawn(&process_, path.c_str(), &files, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return error;
  }

  std::filesystem::path program_, folder_;
  pid_t owner_, process_ = -1;
  int socket_ = -1;
};

} // namespace

std::optional<std::string> in_subprocess(const std::filesystem::path& program, const std::string& request,
                                         std::optional<unsigned> seconds) {
  static std::optional<Worker> worker;
  const bool waited = worker && worker->serves(program);
  if (!waited)
    worker.emplace(program);
  const File in = request_file(request);
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0)
    fail("no pipe can be opened", errno);
  for (const int end : ends)
    fcntl(end, F_SETFD, FD_CLOEXEC);
  const bool taken = worker->take(
      {.in = fileno(in.get()), .out = ends[1], .seconds = static_cast<int>(seconds.value_or(0))});
  close(ends[1]);
  const std::optional<std::string> text =
      taken ? worker::read_all(ends[0], [] { return stop_requested(); }) : std::string();
  close(ends[0]);
  if (!text) {
    worker.reset();
    throw Interrupted();
  }
  const std::optional<int> status = taken ? worker->status() : std::nullopt;
  if (!status) {
    worker.reset();
    // One that had waited may have let go in the same moment.
    return waited ? in_subprocess(program, request, seconds) : std::nullopt;
  }
  if (!WIFEXITED(*status))
    return std::nullopt;
  return WEXITSTATUS(*status) == 0 ? text : "";
}

std::filesystem::path own_folder() {
  Dl_info code{};
  std::error_code missing;
  std::filesystem::path file;
  // Of a program the loader knows what it was called by, which may be a name found on PATH.
  if (dladdr(reinterpret_cast<const void*>(&own_folder), &code) != 0 && code.dli_fname)
    file = code.dli_fname;
  if (!file.has_parent_path())
    file = "/proc/self/exe";
  file = std::filesystem::canonical(file, missing);
  if (missing)
    throw std::runtime_error("the place of the running program is not known");
  return file.parent_path();
}

std::filesystem::path find_worker(const std::string& name) {
  const std::filesystem::path folder = own_folder();
  std::vector<std::filesystem::path> places{folder, folder / "../..", folder / "../libexec/signorini",
                                            folder / "../../../../libexec/signorini",
                                            std::filesystem::path(version::libexec) / "signorini"};
  // A program of somebody else's that the library is linked into may be anywhere.
  if (const char* path = std::getenv("PATH"))
    for (std::string_view left = path; !left.empty();) {
      const std::string_view at = left.substr(0, left.find(':'));
      if (at.starts_with('/'))
        places.push_back(std::filesystem::path(at) / "../libexec/signorini");
      left.remove_prefix(std::min(at.size() + 1, left.size()));
    }
  std::string tried;
  for (const std::filesystem::path& at : places) {
    const std::filesystem::path program = (at / name).lexically_normal();
    if (access(program.c_str(), X_OK) == 0)
      return program;
    tried += (tried.empty() ? "" : ", ") + program.string();
  }
  throw std::runtime_error(fmt::format("the program {} is not where it is expected: {}", name, tried));
}

} // namespace signorini
