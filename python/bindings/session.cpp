// SPDX-License-Identifier: GPL-3.0-or-later
#include "session.h"
#include "base/petsc.h"
#include "base/threads.h"
#include <algorithm>
#include <array>
#include <spdlog/spdlog.h>
#include <vector>

namespace signorini::python {
namespace {

bool own_petsc = false;

/// In the order in which they were made, which is the same on every rank.
std::vector<Open*>& all_open() {
  static std::vector<Open*> all;
  return all;
}

} // namespace

void start() {
  PetscBool started = PETSC_FALSE;
  petsc::check(PetscInitialized(&started));
  if (!started) {
    // PETSc refers to these to its end. Signals are Python's, and a file .petscrc in a folder from elsewhere
    // could load code and overwrite files.
    static std::array<char, 10> program{"signorini"};
    static std::array<char, 19> no_signals{"-no_signal_handler"};
    static std::array<char, 14> no_file{"-skip_petscrc"};
    static std::array<char*, 4> words{program.data(), no_signals.data(), no_file.data(), nullptr};
    int count = 3;
    char** arguments = words.data();
    petsc::check(PetscInitialize(&count, &arguments, nullptr, nullptr));
    petsc::check(PetscOptionsSetValue(nullptr, "-options_left", "0"));
    own_petsc = true;
  }
  petsc::keep_error_messages();
  spdlog::set_level(spdlog::level::warn); // the libraries log warnings and errors only
  use_threads(MPI_COMM_WORLD, std::nullopt);
}

void finish() {
  while (!all_open().empty()) {
    all_open().back()->close();
    all_open().pop_back();
  }
  if (std::exchange(own_petsc, false))
    (void)PetscFinalize();
}

Open::Open() { all_open().push_back(this); }

Open::~Open() { std::erase(all_open(), this); }

} // namespace signorini::python
