// SPDX-License-Identifier: GPL-3.0-or-later
#include "session.h"
#include "base/collective.h"
#include "base/machine.h"
#include "base/petsc.h"
#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <spdlog/spdlog.h>
#include <utility>
#include <vector>

namespace signorini::python {
namespace {

bool own_petsc = false, own_mpi = false;

std::vector<Open*>& all_open() {
  static std::vector<Open*> all;
  return all;
}

/// Resources of dropped Python objects by the objects' numbers, the order in which all ranks free them.
std::map<long, std::shared_ptr<const void>>& dropped() {
  static std::map<long, std::shared_ptr<const void>> all;
  return all;
}

/// Frees resources that were dropped on all ranks. Collective.
void free_dropped() {
  std::vector<long> mine;
  for (const auto& [number, owned] : dropped())
    mine.push_back(number);
  std::map<long, int> ranks_with;
  for (const long number : gather(MPI_COMM_WORLD, mine))
    ++ranks_with[number];
  for (const auto& [number, count] : ranks_with)
    if (count == ranks(MPI_COMM_WORLD))
      dropped().erase(number);
}

void finish() {
  while (!dropped().empty())
    dropped().erase(std::prev(dropped().end()));
  if (std::exchange(own_petsc, false))
    (void)PetscFinalize();
}

/// Registers finish() as the callback on deletion of an MPI attribute. As the oldest attribute it is the last
/// that MPI_Finalize() deletes, after PETSc's own.
void finish_with_mpi() {
  constexpr auto on_delete = [](MPI_Comm, int, void*, void*) {
    finish();
    return MPI_SUCCESS;
  };
  int key = MPI_KEYVAL_INVALID;
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, on_delete, &key, nullptr);
  MPI_Comm_set_attr(MPI_COMM_SELF, key, nullptr);
  MPI_Comm_free_keyval(&key);
}

} // namespace

void start() {
  int mpi_runs = 0;
  MPI_Initialized(&mpi_runs);
  own_mpi = mpi_runs == 0;
  if (!own_mpi)
    finish_with_mpi();
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

void leave() {
  for (Open* object : all_open())
    if (auto owned = object->release())
      dropped().emplace(object->number(), std::move(owned));
  all_open().clear();
  if (own_mpi)
    finish();
}

Open::Open() {
  static long count = 0;
  number_ = count++;
  all_open().push_back(this);
  if (ranks(MPI_COMM_WORLD) > 1)
    free_dropped();
}

Open::~Open() { std::erase(all_open(), this); }

void Open::drop(std::shared_ptr<const void> owned) const {
  if (!owned)
    return;
  if (ranks(MPI_COMM_WORLD) > 1)
    dropped().emplace(number_, std::move(owned));
  else
    alone([&] { owned.reset(); });
}

} // namespace signorini::python
