// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/collective.h"
#include <string>

namespace signorini::io {

/// A file or folder of the results cannot be written. Thrown on every rank alike, as a UserError is.
class OutputFailure : public UserError {
  using UserError::UserError;
};

/// on_root() for work that writes results: an OutputFailure is one on every rank. Collective.
template <class Work>
void write_on_root(MPI_Comm comm, Work&& work) {
  if (ranks(comm) == 1) {
    work();
    return;
  }
  std::string failure;
  on_root(comm, [&] {
    try {
      work();
    } catch (const OutputFailure& error) {
      failure = error.what();
    }
  });
  failure = broadcast(comm, failure);
  if (!failure.empty())
    throw OutputFailure(failure);
}

} // namespace signorini::io
