// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"
#include "recorded.h"
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace signorini::test {

inline scene::Scene parse(const std::filesystem::path& file, const std::vector<std::string>& overrides = {}) {
  return scene::parse(scene::read(file), file, overrides);
}

/// A file of the checkout, whose place main.cpp alone is compiled with: other files compile alike in any
/// checkout.
std::filesystem::path source(const std::string& file);

/// The mesh of a scene and the functions on it, once for all scenes with equal ones: each mesh takes a
/// process. Collective.
std::shared_ptr<const problem::SpaceDiscretisation> discretised(const scene::Scene& scene);
/// Before MPI ends.
void forget_discretisations();

/// A scene of the repository made ready, with its derivative machinery.
struct Ready {
  scene::Scene scene;
  Timers timers;
  problem::Problem problem;

  explicit Ready(const std::string& file, const std::vector<std::string>& overrides = {})
      : scene(parse(source(file), overrides)),
        problem(discretised(scene), scene, {.derivatives = true}, timers) {}
};

/// A PETSc option for as long as this object lives.
class Option {
public:
  Option(const char* name, const char* value) : name_(name) {
    petsc::check(PetscOptionsSetValue(nullptr, name, value));
  }
  ~Option() { (void)PetscOptionsClearValue(nullptr, name_); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

private:
  const char* name_;
};

inline const Console& silent() {
  static const Console console(false, false);
  return console;
}

/// A smooth vector of V that does not depend on the number of ranks; `which` picks one of several.
inline petsc::Vector smooth(const fem::Space& space, int which) {
  petsc::Vector x = space.vector();
  const petsc::WriteArray values(x);
  for (int node = 0; node < space.owned_nodes(); ++node) {
    const double* p = &space.points()[static_cast<std::size_t>(3 * node)];
    for (int c = 0; c < space.dim(); ++c)
      values[static_cast<std::size_t>(node * space.dim() + c)] =
          std::sin(1.3 * p[0] - 0.7 * p[1] + 0.9 * p[2] + which + 1.1 * c) +
          0.2 * which * std::cos(2.1 * p[1]);
  }
  return x;
}

/// Largest modulus of an entry. Collective.
inline double largest(Vec x) {
  PetscReal value = 0;
  petsc::check(VecNorm(x, NORM_INFINITY, &value));
  return value;
}

/// ‖x − y‖∞. Collective.
inline double difference(Vec x, Vec y) {
  petsc::Vector d = petsc::copy(x);
  petsc::check(VecAXPY(d, -1, y));
  return largest(d);
}

/// The same of arrays that the ranks hold parts of. Collective.
inline double largest(std::span<const double> x) {
  double value = 0;
  for (double entry : x)
    value = std::max(value, std::abs(entry));
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return value;
}

inline double difference(std::span<const double> x, std::span<const double> y) {
  std::vector<double> d(x.begin(), x.end());
  axpy(-1, y, d);
  return largest(d);
}

/// Number of true values over all ranks.
inline long total(long mine) {
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_LONG, MPI_SUM, MPI_COMM_WORLD);
  return mine;
}

} // namespace signorini::test
