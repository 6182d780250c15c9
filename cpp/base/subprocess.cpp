// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/subprocess.h"
#include "base/error.h"
#include "base/signals.h"
#include "version.h"
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <memory>
#include <poll.h>
#include <ranges>
#include <spawn.h>
#include <stdexcept>
#include <string_view>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <vector>

extern "C" char** environ;

namespace signorini {
bool write_all(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR)
      return false;
    done += count > 0 ? static_cast<std::size_t>(count) : 0;
  }
  return true;
}

namespace {

[[noreturn]] void fail(const std::string& what, int error) {
  throw std::runtime_error(fmt::format("{}: {}", what, std::generic_category().message(error)));
}

/// Reads from the descriptor until its other end is closed; returns nothing if a stop is requested meanwhile.
std::optional<std::string> read_all(int file) {
  constexpr int look = 100; // ms between two checks for such a request
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

using File = std::unique_ptr<FILE, int (*)(FILE*)>;

/// Writes a request to an unnamed temporary file: a pipe would break if the program ended before it had read
/// everything.
File request_file(const std::string& request) {
  File file(std::tmpfile(), &std::fclose);
  if (!file || !write_all(fileno(file.get()), request) || lseek(fileno(file.get()), 0, SEEK_SET) != 0)
    fail("a request for a subprocess cannot be written to a temporary file", errno);
  return file;
}

/// Starts a program in a process group of its own, which can be killed as a whole. The program inherits only
/// the request and the writing end of the answer's pipe.
pid_t start(std::vector<std::string> command, int request, int answer) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, request, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, answer, answer_file);
  // Discards the output of libraries, and of the C library when it detects a corrupt heap.
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
  std::vector<char*> arguments;
  for (std::string& word : command)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t process = -1;
  const int error = posix_spawnp(&process, arguments.front(), &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    fail(fmt::format("{} cannot be started", command.front()), error);
  return process;
}

} // namespace

std::optional<std::string> in_subprocess(const std::vector<std::string>& command,
                                         const std::string& request) {
  const File in = request_file(request);
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0)
    fail("no pipe can be opened", errno);
  for (const int end : ends)
    fcntl(end, F_SETFD, FD_CLOEXEC);
  pid_t process = -1;
  try {
    process = start(command, fileno(in.get()), ends[1]);
  } catch (...) {
    close(ends[0]);
    close(ends[1]);
    throw;
  }
  close(ends[1]);
  const std::optional<std::string> text = read_all(ends[0]);
  close(ends[0]);
  if (!text)
    kill(-process, SIGKILL);
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (!text)
    throw Interrupted();
  if (!WIFEXITED(status))
    return std::nullopt;
  return WEXITSTATUS(status) == 0 ? text : "";
}

std::filesystem::path own_folder() {
  Dl_info code{};
  std::error_code missing;
  std::filesystem::path file;
  // For a program the loader returns the name by which it was called, which may be one found on PATH.
  if (dladdr(reinterpret_cast<const void*>(&own_folder), &code) != 0 && code.dli_fname)
    file = code.dli_fname;
  if (!file.has_parent_path())
    file = "/proc/self/exe";
  file = std::filesystem::canonical(file, missing);
  if (missing)
    throw std::runtime_error("the path of the running program cannot be determined");
  return file.parent_path();
}

std::filesystem::path find_program(const std::string& name) {
  const std::filesystem::path folder = own_folder();
  std::vector<std::filesystem::path> places{folder, folder / "../..", folder / "../libexec/signorini",
                                            folder / "../../../../libexec/signorini",
                                            std::filesystem::path(version::libexec) / "signorini"};
  // A program into which others link the library may be anywhere.
  if (const char* path = std::getenv("PATH"))
    for (const auto part : std::views::split(std::string_view(path), ':'))
      if (const std::string_view at(part.begin(), part.end()); at.starts_with('/'))
        places.push_back(std::filesystem::path(at) / "../libexec/signorini");
  std::string tried;
  for (const std::filesystem::path& at : places) {
    const std::filesystem::path program = (at / name).lexically_normal();
    if (access(program.c_str(), X_OK) == 0)
      return program;
    tried += (tried.empty() ? "" : ", ") + program.string();
  }
  throw std::runtime_error(fmt::format("the program {} was not found; paths tried: {}", name, tried));
}

std::vector<std::string> python_command(const std::string& script) {
  const std::filesystem::path folder = own_folder(); // in a build it has a link to the scripts of its sources
  const std::filesystem::path own = "postprocess", shared = "signorini/postprocess";
  // The Python module's library is in a folder below that of the build, or far from share/.
  const std::vector<std::pair<std::filesystem::path, bool>> places{
      {folder / own, false},
      {folder / "../.." / own, false},
      {folder / "../share" / shared, true},
      {folder / "../../../../share" / shared, true},
      {std::filesystem::path(version::data) / shared, true}};
  std::string tried;
  for (const auto& [at, installed] : places) {
    const std::filesystem::path file = (at / script).lexically_normal();
    if (access(file.c_str(), R_OK) == 0) {
      std::vector<std::string> command{"python3"};
      if (installed) // leaves no compiled files there, which the package does not list
        command.emplace_back("-B");
      command.push_back(file.string());
      return command;
    }
    tried += (tried.empty() ? "" : ", ") + file.string();
  }
  throw std::runtime_error(fmt::format("the script {} was not found; paths tried: {}", script, tried));
}

} // namespace signorini
