#include "fixtures.h"
#include <catch2/catch_session.hpp>
#include <cstdio>
#include <spdlog/spdlog.h>

std::filesystem::path signorini::test::source(const std::string& file) {
  return std::filesystem::path(SIGNORINI_SOURCE_DIR) / file;
}

/// Runs the tests on every rank; rank 0 reports, and the run fails if any rank does.
int main(int argc, char** argv) {
  int petsc_argc = 1;
  if (PetscInitialize(&petsc_argc, &argv, nullptr, nullptr) != PETSC_SUCCESS)
    return 1;
  signorini::petsc::keep_error_messages();
  spdlog::set_level(spdlog::level::warn);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0 && !std::freopen("/dev/null", "w", stdout))
    return 1;
  int failed = Catch::Session().run(argc, argv);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  (void)PetscFinalize();
  return failed;
}
