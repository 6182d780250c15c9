// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <functional>
#include <optional>
#include <string>

/// Both ends of what a program and its workers send each other; see base/subprocess.h.
namespace signorini::worker {

/// A request: files to read it from and to write the answer to, and the seconds of processor time that the
/// answer may take, 0 for any.
struct Job {
  int in, out, seconds;
};

/// The main function of a worker. Answers the requests of in_subprocess(), each in a copy (fork) of the
/// process that waits here loaded, and lets go if none comes for ten seconds. `answer` must not throw.
int serve(const std::function<std::string(const std::string& request)>& answer);

/// False if the other end of `socket` is gone.
bool send_job(int socket, const Job& job);

/// False if not all can be written.
bool write_all(int file, const std::string& text);

/// All that comes until the other end is closed; nothing once `stop` says so.
std::optional<std::string> read_all(int file, bool (*stop)());

} // namespace signorini::worker
