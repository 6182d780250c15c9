// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <functional>
#include <optional>
#include <string>

/// Both ends of the pipes between a program and its workers; see base/subprocess.h.
namespace signorini::worker {

/// The main function of a worker: answers the one request of in_subprocess(). Arguments: the seconds of
/// processor time that it may take, empty for any. `answer` must not throw.
int serve(int argc, char** argv, const std::function<std::string(const std::string& request)>& answer);

constexpr char whole = '.'; ///< the last byte of a complete answer

/// False if not all can be written.
bool write_all(int file, const std::string& text);

/// All that comes until the other end is closed; nothing once `stop` says so.
std::optional<std::string> read_all(int file, bool (*stop)());

} // namespace signorini::worker
