// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/sweep.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/machine.h"
#include "problem/problem.h"
#include "trajectory/time_integrator.h"
#include <chrono>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

/// What the programs of the benchmark share.
namespace signorini {

/// Wall-clock seconds between calls, the slowest rank's.
class Watch {
public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    double seconds = std::chrono::duration<double>(now - last_).count();
    MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    last_ = std::chrono::steady_clock::now();
    return seconds;
  }

private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Memory of the operators that a problem keeps, bytes.
inline double operator_bytes(const problem::Problem& problem) {
  const fem::Operators& operators = problem.operators;
  double sum = petsc::bytes(operators.M) + petsc::bytes(operators.A) +
               petsc::bytes(problem.stepper.of_length(problem.grid.length(1)).R());
  for (const std::optional<petsc::Matrix>& matrix : {std::cref(operators.B), std::cref(operators.W)})
    if (matrix)
      sum += petsc::bytes(*matrix);
  for (const petsc::Matrix& matrix :
       {std::cref(operators.foundation_A), std::cref(operators.foundation_B), std::cref(operators.drag)})
    if (matrix)
      sum += petsc::bytes(matrix);
  return sum + (operators.relaxation ? operators.relaxation->bytes() : 0);
}

namespace bench {

/// Runs `measure(scene, repeats)` on the scene of the command line SCENE REPEATS [key.path=value …] and
/// prints the JSON that it returns.
template <class Measure>
int run(const char* program, int argc, char** argv, Measure&& measure) {
  if (argc < 3 || std::atoi(argv[2]) < 1) {
    std::cerr << "usage: " << program << " SCENE REPEATS [key.path=value …]\n";
    return 2;
  }
  std::vector<std::string> overrides(argv + 3, argv + argc);
  int status = 0;
  int no_arguments = 1; // PETSc's options come by PETSC_OPTIONS
  if (PetscInitialize(&no_arguments, &argv, nullptr, nullptr) != PETSC_SUCCESS)
    return 3;
  // Defaults that the program sets for solvers not in use are no spelling mistakes.
  (void)PetscOptionsSetValue(nullptr, "-options_left", "0");
  try {
    petsc::keep_error_messages();
    spdlog::set_level(spdlog::level::warn); // dolfinx tells every step of its own
    std::string text;
    on_root(MPI_COMM_WORLD, [&] { text = scene::read(argv[1]); });
    const scene::Scene scene = scene::parse(broadcast(MPI_COMM_WORLD, text), argv[1], overrides);
    const nlohmann::ordered_json result = measure(scene, std::atoi(argv[2]));
    if (rank(MPI_COMM_WORLD) == 0)
      std::cout << result.dump(2) << std::endl;
  } catch (const std::exception& error) {
    std::cerr << program << ": " << error.what() << "\n";
    MPI_Abort(MPI_COMM_WORLD, status = 3);
  }
  return PetscFinalize() == PETSC_SUCCESS ? status : 3;
}

} // namespace bench

} // namespace signorini
