// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <exception>
#include <stdexcept>
#include <string>

namespace signorini {

/// Exit statuses of the program.
namespace exit_status {
constexpr int done = 0, check_failed = 1, wrong_input = 2, solver_failed = 3, interrupted = 130;
}

/// Error of the user's input: the scene, the mesh, an option or the output folder is wrong (exit status 2).
/// The text is one sentence: what is wrong, where, what was found, what to do.
class UserError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Failure to write a file or folder of the results, reported like an error of the user (exit status 2).
class OutputFailure : public UserError {
  using UserError::UserError;
};

/// Failure to write a file, possibly on some ranks only (exit status 2). A program that runs on several ranks
/// therefore aborts all ranks.
class WriteFailure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Failure of a solver (exit status 3). The text names the step, the reason and the residual.
class SolverFailure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Thrown when a requested stop ends a computation: the program writes all complete results and exits with
/// status 130.
class Interrupted : public std::exception {
public:
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

/// Warning about the results of a run, issued because a value exceeds its limit.
struct Warning {
  std::string name;    ///< kind of the warning
  std::string message; ///< sentence with the value and where it occurs
  double value, limit; ///< the value, and the limit that it exceeds; both in the same unit
};

} // namespace signorini
