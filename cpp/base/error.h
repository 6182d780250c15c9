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

/// The scene, the mesh, an option or the output folder is wrong: exit status 2.
/// The text is one sentence: what is wrong, where, what was found, what to do.
class UserError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file or folder of the results cannot be written: exit status 2.
class OutputFailure : public UserError {
  using UserError::UserError;
};

/// A file cannot be written, possibly on some ranks only: exit status 2; on several ranks the program aborts
/// them all.
class WriteFailure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A solver failed: exit status 3. The text names the step, the reason and the residual.
class SolverFailure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The user asked to stop during a sweep: complete results are written, exit status 130.
class Interrupted : public std::exception {
public:
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

/// A warning about the results of a run.
struct Warning {
  std::string name;    ///< kind of the warning
  std::string message; ///< sentence with value and place
  double value, limit; ///< the value, and the limit above which there is a warning
};

} // namespace signorini
