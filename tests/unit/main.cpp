// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixtures.h"
#include <catch2/catch_session.hpp>
#include <cstdio>
#include <dlfcn.h>
#include <exception>
#include <spdlog/spdlog.h>

std::filesystem::path signorini::test::source(const std::string& file) {
  return std::filesystem::path(SIGNORINI_SOURCE_DIR) / file;
}

namespace {
int rank = 0;
}

/// In place of the runtime's, names what ranks other than the first throw. Where a rank throws alone the
/// others wait for it for ever, often within the unwinding itself, and its test is never reported.
extern "C" [[noreturn]] void __cxa_throw(void* object, void* type, void (*destroy)(void*)) {
  if (rank != 0) {
    const auto& thrown = *static_cast<const std::type_info*>(type);
    void* as_exception = object;
    const bool known = typeid(std::exception).__do_catch(&thrown, &as_exception, 1);
    std::fprintf(stderr, "rank %d throws %s: %s\n", rank, thrown.name(),
                 known ? static_cast<std::exception*>(as_exception)->what() : "no exception of the library");
  }
  using Throw = void (*)(void*, void*, void (*)(void*));
  reinterpret_cast<Throw>(dlsym(RTLD_NEXT, "__cxa_throw"))(object, type, destroy);
  std::terminate(); // it does not come back
}

/// Runs the tests on every rank; rank 0 reports, and the run fails if any rank does.
int main(int argc, char** argv) {
  int petsc_argc = 1;
  if (PetscInitialize(&petsc_argc, &argv, nullptr, nullptr) != PETSC_SUCCESS)
    return 1;
  signorini::petsc::keep_error_messages();
  spdlog::set_level(spdlog::level::warn);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0 && !std::freopen("/dev/null", "w", stdout))
    return 1;
  int failed = Catch::Session().run(argc, argv);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  signorini::test::forget_discretisations();
  (void)PetscFinalize();
  return failed;
}
