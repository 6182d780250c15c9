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
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
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

/// Starts the worker in a group of its own, that ends as a whole, with nothing of this process but its input
/// and output.
pid_t start(const std::filesystem::path& program, int in, int out, std::optional<unsigned> seconds) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, out, STDOUT_FILENO);
  // The C library prints when it detects a corrupt heap.
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE); // which this process ignores
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  std::string path = program.string(), limit = seconds ? std::to_string(*seconds) : "";
  std::array<char*, 3> arguments{path.data(), limit.data(), nullptr};
  pid_t process = -1;
  const int error = posix_spawn(&process, path.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    fail(fmt::format("{} cannot be started", path), error);
  return process;
}

} // namespace

std::optional<std::string> in_subprocess(const std::filesystem::path& program, const std::string& request,
                                         std::optional<unsigned> seconds) {
  const File in = request_file(request);
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0)
    fail("no pipe can be opened", errno);
  for (const int end : ends) // the worker gets its own descriptor
    fcntl(end, F_SETFD, FD_CLOEXEC);
  pid_t process = -1;
  try {
    process = start(program, fileno(in.get()), ends[1], seconds);
  } catch (...) {
    close(ends[0]);
    close(ends[1]);
    throw;
  }
  close(ends[1]);
  std::optional<std::string> text = worker::read_all(ends[0], [] { return stop_requested(); });
  close(ends[0]);
  if (!text)
    kill(-process, SIGKILL);
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (!text)
    throw Interrupted();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !text->ends_with(worker::whole))
    return std::nullopt;
  text->pop_back();
  return text;
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
