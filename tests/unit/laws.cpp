// SPDX-License-Identifier: GPL-3.0-or-later
// Contact laws of more than one row, whose systems are not symmetric: friction.
#include "base/collective.h"
#include "contact/condensation.h"
#include "contact/friction.h"
#include "contact/solver/condensed.h"
#include "contact_parts.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <random>

using namespace signorini;
using petsc::check;
using test::Parts;

namespace {

constexpr double usual_friction = 0.5;

/// Whether the multipliers of a group are on the surface of the cone.
bool slips(std::span<const double> rho) {
  return std::hypot(rho[1], rho.size() > 2 ? rho[2] : 0) > (1 - 1e-9) * usual_friction * rho[0];
}

enum class Kind { factor, columns, on_demand, solves_on_demand };

/// A block that is pressed onto a plane with friction and pushed along it; the last candidate has none.
struct Rubbing {
  const Parts parts;
  const contact::Law& law;
  const contact::ConstraintRows H = make_rows();
  step::SolverChoice linear;
  std::unique_ptr<MumpsSolver> mumps;
  std::unique_ptr<SparseCholesky> cholesky;
  std::unique_ptr<contact::CondensedSolver> solver;
  contact::Workspace work;
  std::vector<double> psi;
  double friction = usual_friction;

  explicit Rubbing(Kind kind, bool space = false, const contact::Law& law = contact::coulomb)
      : parts(space ? Parts({}, 0, "tests/data/cube.toml") : Parts({"mesh.size=0.1"})), law(law),
        linear(Parts::copy(parts.D), nullptr, iterative(), true), solver(make_solver(kind)),
        work(solver->workspace()), psi(parts.pairs.psi().begin(), parts.pairs.psi().end()) {
    for (int i = parts.pairs.count(); i < H.count(); ++i) // of the step before
      psi.push_back(1e-3 * std::sin(i));
  }

  static scene::Solver iterative() {
    scene::Solver solver;
    solver.linear = scene::LinearMethod::iterative;
    return solver;
  }

  contact::ConstraintRows make_rows() const {
    std::vector<contact::ConstraintRows::Group> groups;
    const auto dim = static_cast<std::size_t>(parts.space.dim());
    for (int i = 0; i < parts.pairs.count(); ++i) {
      const double* n = &parts.pairs.normals()[dim * static_cast<std::size_t>(i)];
      const auto row = [&](const std::array<double, 3>& x) {
        std::vector<contact::ConstraintRows::Entry> entries;
        for (std::size_t c = 0; c < dim; ++c)
          entries.push_back({parts.pairs.first_dofs()[static_cast<std::size_t>(i)] + static_cast<PetscInt>(c),
                             x[c], false});
        return entries;
      };
      groups.push_back({.entries = row({n[0], n[1], dim == 3 ? n[2] : 0})});
      if (i + 1 == parts.pairs.count())
        break;
      const double across = std::hypot(n[0], n[1]);
      const std::array<double, 3> t{-n[1] / across, n[0] / across, 0};
      groups.back().others.push_back(row(t));
      if (dim == 3)
        groups.back().others.push_back(row({-n[2] * t[1], n[2] * t[0], n[0] * t[1] - n[1] * t[0]}));
      groups.back().law = &law;
    }
    const PetscInt first = parts.space.first_dof();
    return {parts.space.comm(), groups, first, first + parts.space.dim() * parts.space.owned_nodes()};
  }

  std::unique_ptr<contact::CondensedSolver> make_solver(Kind kind) {
    std::unique_ptr<contact::Condensation> condensation;
    if (kind == Kind::factor) {
      std::vector<int> trailing_block;
      for (const PetscInt dof : parts.pairs.first_dofs())
        trailing_block.push_back(static_cast<int>(dof / parts.space.dim()));
      cholesky = std::make_unique<SparseCholesky>(parts.D, trailing_block);
      cholesky->factorise();
      condensation = std::make_unique<contact::TrailingBlockCondensation>(H, *cholesky);
    } else if (kind == Kind::columns) {
      mumps = std::make_unique<MumpsSolver>(parts.D);
      mumps->factorise();
      condensation =
          std::make_unique<contact::StoredColumnsCondensation>(H, *mumps, parts.space.vector(), 1e9);
    } else {
      condensation = std::make_unique<contact::ColumnsOnDemand>(
          H, dynamic_cast<const ConjugateGradients&>(linear.linear()), parts.D,
          kind == Kind::on_demand ? 1e9 : 0);
    }
    return std::make_unique<contact::CondensedSolver>(H, parts.pairs.diameter(), fem::diagonal(parts.D),
                                                      std::move(condensation), contact::Residual());
  }

  contact::ContactState solve(Vec r, Vec y) {
    contact::ContactState state(H.groups(), H.count());
    state.friction.assign(static_cast<std::size_t>(H.groups()), friction);
    const contact::ActiveSet previous{};
    const contact::ContactProblem step{r, psi, previous, state, y};
    solver->solve(step, work);
    return state;
  }

  /// Checks that a solution obeys the laws.
  void obeyed(const contact::ContactState& state, Vec r, Vec y) const {
    const double force = 1e-9 * test::largest(r), gap = 1e-9 * test::largest(y);
    for (int i = 0; i < H.groups(); ++i) {
      const std::array<double, 3> rho = H.of_group(i, state.lambda), U = H.of_group(i, state.gap);
      CHECK(H.law(i).holds({rho.data(), H.size(i)}, {U.data(), H.size(i)}, friction, force, gap));
    }
  }

  petsc::Vector force(int which) const {
    petsc::Vector r = parts.pressing(which), along = test::smooth(parts.space, which + 7);
    petsc::Vector pushed = petsc::zero_like(r);
    check(VecScale(along, 0.1));
    check(MatMult(parts.D, along, pushed));
    check(VecAXPY(r, 1, pushed));
    return r;
  }
};

double pairing(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += a[i] * b[i];
  return sum;
}

} // namespace

TEST_CASE("groups of several rows are numbered by their first ones", "[contact]") {
  const Rubbing body(Kind::columns);
  const contact::ConstraintRows& H = body.H;
  const int m = body.parts.pairs.count();
  REQUIRE(H.groups() == m);
  CHECK(H.count() == 2 * m - 1);
  CHECK_FALSE(H.symmetric());
  CHECK(H.size(0) == 2);
  CHECK(H.size(m - 1) == 1);
  CHECK(H.row(2, 0) == 2);
  CHECK(H.row(2, 1) == static_cast<std::size_t>(m) + 2);
  std::vector<double> all(static_cast<std::size_t>(H.count()));
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = static_cast<double>(i);
  CHECK(H.of_group(1, all) == std::array<double, 3>{1, m + 1.0, 0});
  contact::ContactLinearisation contact;
  contact.active = {0, m - 1};
  contact.forces = {5, 6, 7};
  H.spread(contact, all);
  CHECK(all[0] == 5);
  CHECK(all[static_cast<std::size_t>(m)] == 6);
  CHECK(all[static_cast<std::size_t>(m) - 1] == 7);
  CHECK(pairing(all, all) == 110);
  CHECK_THROWS_AS(contact::ConstraintRows(MPI_COMM_SELF,
                                          {{.entries = {{0, 1, false}}, .others = {{{1, 1, false}}}}}, 0, 2),
                  std::logic_error);
}

TEST_CASE("laws that are not symmetric are obeyed, linearised and transposed", "[contact]") {
  const Kind kind = GENERATE(Kind::factor, Kind::columns, Kind::on_demand, Kind::solves_on_demand);
  const bool space = GENERATE(false, true);
  CAPTURE(static_cast<int>(kind), space);
  if (kind == Kind::factor && ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  const double accuracy = kind == Kind::factor || kind == Kind::columns ? 1e-12 : 1e-9;
  Rubbing body(kind, space);
  const contact::ConstraintRows& H = body.H;
  const auto rows = static_cast<std::size_t>(H.count());
  int stick = 0, slip = 0, open = 0, free = 0;
  double unlike = 0;
  for (int which = 0; which < 6; ++which) {
    const petsc::Vector r = body.force(which);
    petsc::Vector y = body.parts.space.vector(), defect = body.parts.space.vector();
    const contact::ContactState state = body.solve(r, y);
    REQUIRE(state.equations.size() == state.active.size());
    // D y + Hρ = r, and the law.
    check(MatMult(body.parts.D, y, defect));
    check(VecAXPY(defect, -1, r));
    H.apply(1, state.lambda, defect);
    CHECK(test::largest(defect) < accuracy * test::largest(r));
    body.obeyed(state, r, y);
    for (int i = 0; i < H.groups(); ++i) {
      const std::array<double, 3> rho = H.of_group(i, state.lambda);
      const bool closed = rho[0] > 1e-9 * test::largest(r);
      open += !closed;
      if (H.size(i) == 1)
        free += closed;
      else if (closed)
        (slips({rho.data(), H.size(i)}) ? slip : stick) += 1;
    }

    // The derivative by r and by ψ is a difference: in the plane, where the solution is linear between
    // kinks, to rounding, in space to first order.
    const petsc::Vector change = body.parts.pressing(which + 20);
    constexpr double epsilon = 1e-6;
    petsc::Vector moved = petsc::copy(r), z = petsc::copy(y), x = body.parts.space.vector();
    check(VecAXPY(moved, epsilon, change));
    std::vector<double> value(rows), mu(rows);
    for (std::size_t i = 0; i < rows; ++i) {
      value[i] = std::cos(static_cast<double>(i));
      body.psi[i] += epsilon * value[i];
    }
    const contact::ContactState other = body.solve(moved, z);
    for (std::size_t i = 0; i < rows; ++i)
      body.psi[i] -= epsilon * value[i];
    REQUIRE(other.active == state.active);
    const contact::LinearisedContact step{change, state.active, state.equations, value, x, mu};
    body.solver->solve_linearised(step, body.work);
    check(VecAXPBY(z, -1 / epsilon, 1 / epsilon, y));
    const double first_order = space ? 100 * epsilon : 0;
    CHECK(test::difference(z, x) < (accuracy / epsilon * 1e-1 + first_order) * test::largest(x));
    std::vector<double> difference(rows);
    for (std::size_t i = 0; i < rows; ++i)
      difference[i] = (other.lambda[i] - state.lambda[i]) / epsilon - mu[i];
    const auto size = [](const std::vector<double>& a) { return std::sqrt(pairing(a, a)); };
    CHECK(size(difference) <= (accuracy / epsilon + first_order) * (size(state.lambda) + size(mu)));

    // The transpose: r·p + value·Eᵀn = ȳ·x + ρ̄·ρ over the set.
    const petsc::Vector y_bar = test::smooth(body.parts.space, which + 40);
    petsc::Vector p = body.parts.space.vector();
    std::vector<double> rho_bar(rows), n(rows);
    for (const int i : state.active)
      for (std::size_t c = 0; c < H.size(i); ++c)
        rho_bar[H.row(i, c)] = std::sin(3.0 * i + static_cast<double>(c));
    const contact::LinearisedContact transposed{y_bar, state.active, state.equations, rho_bar, p, n};
    body.solver->solve_transposed(transposed, body.work);
    const double left = petsc::dot(change, p) + pairing(value, n),
                 right = petsc::dot(y_bar, x) + pairing(rho_bar, mu);
    CHECK(std::abs(left - right) < accuracy * (std::abs(petsc::dot(y_bar, x)) + std::abs(left)));
    body.solver->solve_linearised(transposed, body.work);
    unlike = std::max(unlike, std::abs(petsc::dot(change, p) + pairing(value, n) - right) / std::abs(right));
  }
  CHECK(unlike > 1e-3); // the step itself is not its transpose
  CHECK(stick > 0);
  CHECK(slip > 0);
  CHECK(open > 0);
  CHECK(free > 0);
}

TEST_CASE("each method for friction finds what obeys the laws", "[contact]") {
  using Method = contact::LawSolver::Method;
  const bool space = GENERATE(false, true);
  const Method method = GENERATE(Method::newton, Method::hardening, Method::pivots, Method::sweeps);
  const double friction = GENERATE(0.2, 1.0, 2.0);
  const bool bounded = GENERATE(false, true); // Tresca friction, with bounds of about the normal forces
  CAPTURE(space, static_cast<int>(method), friction, bounded);
  Rubbing body(Kind::columns, space,
               bounded ? static_cast<const contact::Law&>(contact::tresca) : contact::coulomb);
  const contact::DelassusOperator S(body.H, std::make_unique<contact::StoredColumnsCondensation>(
                                                body.H, *body.mumps, body.parts.space.vector(), 1e9));
  const contact::Complementarity scales(body.H, 1, fem::diagonal(body.parts.D));
  const contact::LawSolver solver(body.H, S, scales.compliances());
  contact::Workspace work = S.workspace();
  body.friction = friction;
  if (bounded) {
    petsc::Vector y = body.parts.space.vector();
    body.friction = 0;
    body.friction = friction * test::largest(body.solve(body.force(0), y).normal_lambda());
  }
  int own = 0, stick = 0, slip = 0;
  for (int which = 0; which < 20; ++which) {
    const petsc::Vector r = body.force(which), y = body.parts.space.vector();
    contact::ContactState state(body.H.groups(), body.H.count());
    state.friction.assign(static_cast<std::size_t>(body.H.groups()), body.friction);
    S.predict_gap(r, {y, {}}, body.psi, work.gap0, work.half_solve);
    const double negligible = 1e-12 * test::largest(work.gap0);
    own += solver.solve({}, negligible, state, work, method) == method;
    CHECK(solver.residual(state) <= negligible);
    S.finish(body.psi, state.lambda, state.gap, y, work);
    body.obeyed(state, r, y);
    // all methods find the same
    const petsc::Vector z = body.parts.space.vector();
    const contact::ContactState other = body.solve(r, z);
    CHECK(test::difference(y, z) < 1e-9 * test::largest(z));
    stick += other.count(contact::Motion::sticks);
    slip += other.count(contact::Motion::slips);
  }
  CHECK(slip > 0);
  CHECK(stick + slip >= 20);
  CHECK((own >= 18 || (method == Method::pivots && (space || bounded)))); // Lemke's method is for the plane
}

namespace {

/// A given matrix S, of a body that is not there.
class GivenCondensation final : public contact::WholeCondensation {
public:
  GivenCondensation(const contact::ConstraintRows& rows, std::vector<double> S) : WholeCondensation(rows) {
    S_ = std::move(S);
  }
  [[nodiscard]] contact::HalfSolve half_solve() const override { return {}; }
  void predict(Vec, const contact::Guess&, contact::HalfSolve&, std::span<double>) const override {
    throw std::logic_error("there is no body");
  }
  void finish(contact::HalfSolve&, std::span<const double>, Vec) const override {
    throw std::logic_error("there is no body");
  }
  [[nodiscard]] double bytes() const override { return 0; }
};

/// Random rows of m candidates with friction, and a symmetric positive definite S with strong couplings.
struct RandomProblem {
  contact::ConstraintRows rows;
  std::vector<double> S, gap0;

  RandomProblem(int m, int dim, std::mt19937& generator)
      : rows(MPI_COMM_SELF, groups(m, dim), 0, m * dim), S(static_cast<std::size_t>(m * dim * m * dim)) {
    std::normal_distribution<double> normal;
    const auto n = static_cast<std::size_t>(m * dim);
    std::vector<double> B(n * n);
    for (double& entry : B)
      entry = normal(generator);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        S[i * n + j] = i == j ? 0.1 : 0;
        for (std::size_t k = 0; k < n; ++k)
          S[i * n + j] += B[i * n + k] * B[j * n + k] / static_cast<double>(n);
      }
    for (std::size_t i = 0; i < n; ++i)
      gap0.push_back(normal(generator) - (i < static_cast<std::size_t>(m) ? 0.5 : 0));
  }

  /// Compliances of each candidate alone, for the inverse of S.
  [[nodiscard]] std::vector<contact::Compliance> compliances(const std::vector<double>& inverse) const {
    std::vector<contact::Compliance> all;
    const auto own = [&](std::size_t row) { return 1 / inverse[row * gap0.size() + row]; };
    for (int i = 0; i < rows.groups(); ++i) {
      contact::Compliance& at = all.emplace_back(own(rows.row(i, 0)), 0);
      for (std::size_t c = 1; c < rows.size(i); ++c)
        at.tangential += own(rows.row(i, c)) / static_cast<double>(rows.size(i) - 1);
    }
    return all;
  }

  static std::vector<contact::ConstraintRows::Group> groups(int m, int dim) {
    std::vector<contact::ConstraintRows::Group> all;
    for (int i = 0; i < m; ++i) {
      const auto row = [&](int c) {
        std::vector<contact::ConstraintRows::Entry> entries;
        for (int k = 0; k < dim; ++k)
          entries.push_back({i * dim + k, k == c ? 1.0 : 0.0, false});
        return entries;
      };
      all.push_back({.entries = row(0), .law = &contact::coulomb});
      for (int c = 1; c < dim; ++c)
        all.back().others.push_back(row(c));
    }
    return all;
  }
};

} // namespace

TEST_CASE("random problems with strong couplings are solved", "[contact]") {
  const int dim = GENERATE(2, 3);
  CAPTURE(dim);
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  long iterations = 0;
  int failed = 0, stick = 0, slip = 0, open = 0, most = 0;
  constexpr int problems = 1000;
  for (int which = 0; which < problems; ++which) {
    const RandomProblem problem(3 + which % 10, dim, generator);
    const contact::DelassusOperator S(problem.rows,
                                      std::make_unique<GivenCondensation>(problem.rows, problem.S));
    const contact::LawSolver solver(problem.rows, S, problem.compliances(S.inverse()));
    contact::Workspace work = S.workspace();
    work.gap0 = problem.gap0;
    const double friction = 0.05 * std::pow(60, uniform(generator)); // up to 3
    contact::ContactState state(problem.rows.groups(), problem.rows.count());
    state.friction.assign(static_cast<std::size_t>(problem.rows.groups()), friction);
    constexpr double negligible = 1e-12;
    try {
      solver.solve({}, negligible, state, work);
    } catch (const contact::LawFailure&) {
      ++failed;
      CHECK(friction > 1);
      continue;
    }
    iterations += state.vi_iterations;
    most = std::max(most, state.vi_iterations);
    for (int i = 0; i < problem.rows.groups(); ++i) {
      const std::array<double, 3> rho = problem.rows.of_group(i, state.lambda),
                                  U = problem.rows.of_group(i, state.gap);
      const std::size_t k = problem.rows.size(i);
      constexpr double rounding = 1e-9;
      CHECK(contact::coulomb.holds({rho.data(), k}, {U.data(), k}, friction, rounding, rounding));
      const double way = contact::length(std::span(U).subspan(1, k - 1));
      (rho[0] <= rounding ? open : way > rounding ? slip : stick) += 1;
    }
  }
  INFO(fmt::format("{} of {} problems failed; {:.2f} iterations, at most {}; {} open, {} stick, {} slip",
                   failed, problems, static_cast<double>(iterations) / problems, most, open, stick, slip));
  CHECK(failed <= 2);
  CHECK(stick > problems / 2);
  CHECK(slip > problems / 2);
  CHECK(open > problems / 2);
}
