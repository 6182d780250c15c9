// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/solver/law_solver.h"
#include "base/collective.h"
#include "contact/coulomb.h"
#include "contact/lcp/lemke.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace signorini::contact {

double LawSolver::residual(int group, const ContactState& state) const {
  const std::array<double, 3> rho = rows_.of_group(group, state.lambda), U = rows_.of_group(group, state.gap);
  const std::size_t k = rows_.size(group);
  const double found = laws_[group]->residual({rho.data(), k}, {U.data(), k}, delassus_.column(group)[group],
                                              state.friction_of(static_cast<std::size_t>(group)));
  return std::isfinite(found) ? found : std::numeric_limits<double>::infinity();
}

double LawSolver::residual(const ContactState& state) const {
  double largest = 0;
  for (int i = 0; i < rows_.groups(); ++i)
    largest = std::max(largest, residual(i, state));
  return largest;
}

bool LawSolver::next(int group, const ContactState& state, LawEquation& equation) const {
  const std::array<double, 3> rho = rows_.of_group(group, state.lambda), U = rows_.of_group(group, state.gap);
  const std::size_t k = rows_.size(group);
  return laws_[group]->newton_equation({rho.data(), k}, {U.data(), k}, delassus_.column(group)[group],
                                       state.friction_of(static_cast<std::size_t>(group)), equation);
}

void LawSolver::add_to_multiplier(int row, double change, ContactState& state) const {
  if (change == 0)
    return;
  state.lambda[row] += change;
  const std::span<const double> column = delassus_.column(row);
  for (std::size_t j = 0; j < column.size(); ++j)
    state.gap[j] += column[j] * change;
}

void LawSolver::start(std::span<const double> lambda, ContactState& state, Workspace& work) const {
  state.several = false;
  std::ranges::fill(state.lambda, 0);
  std::ranges::copy(work.gap0, state.gap.begin());
  for (std::size_t row = 0; row < lambda.size(); ++row)
    add_to_multiplier(static_cast<int>(row), lambda[row], state);
}

void LawSolver::newton_step(ContactState& state, Workspace& work) const {
  work.set.clear();
  work.equations.clear();
  work.b.clear();
  ActiveSet opens;
  for (int i = 0; i < rows_.groups(); ++i) {
    LawEquation law;
    if (next(i, state, law)) {
      work.set.push_back(i);
      work.equations.push_back(law);
    } else if (state.lambda[i] != 0)
      opens.push_back(i);
  }
  for (const int i : opens)
    for (std::size_t c = 0; c < rows_.size(i); ++c) {
      const int row = static_cast<int>(rows_.row(i, c));
      add_to_multiplier(row, -state.lambda[row], state);
      state.lambda[row] = 0; // not a rounding error
    }
  for (std::size_t j = 0; j < work.set.size(); ++j) { // E S δρ + F δρ = −E U − F ρ
    const LawEquation& law = work.equations[j];
    const int i = work.set[j];
    for (std::size_t c = 0, k = rows_.size(i); c < k; ++c)
      work.b.push_back(-times(law.E, k, c, rows_.of_group(i, state.gap)) -
                       times(law.F, k, c, rows_.of_group(i, state.lambda)));
  }
  state.several = delassus_.solve_equations(work.set, work.equations, false, work.b, work) < 0;
  auto change = work.b.begin();
  for (const int i : work.set)
    for (std::size_t c = 0; c < rows_.size(i); ++c)
      add_to_multiplier(static_cast<int>(rows_.row(i, c)), *change++, state);
  ++state.vi_iterations;
}

void LawSolver::shorten(std::span<const double> lambda, std::span<const double> gap, double before,
                        ContactState& state) const {
  constexpr int most = 10;
  for (int i = 0; i < most && residual(state) >= before; ++i) {
    for (std::size_t row = 0; row < lambda.size(); ++row) {
      state.lambda[row] = (state.lambda[row] + lambda[row]) / 2;
      state.gap[row] = (state.gap[row] + gap[row]) / 2;
    }
  }
}

bool LawSolver::settle(double negligible, bool backtracking, ContactState& state, Workspace& work) const {
  using Pattern = std::vector<Motion>; // of each group
  std::vector<Pattern> seen;
  constexpr int most = 20, most_short = 60;
  double now = residual(state);
  for (int i = 0; i < (backtracking ? most_short : most); ++i) {
    if (now <= negligible)
      return true;
    const std::vector<double> lambda = state.lambda, gap = state.gap;
    try {
      newton_step(state, work);
    } catch (const SolverFailure&) { // a singular system, on all ranks: the next method tries
      return false;
    }
    const double before = std::exchange(now, residual(state));
    if (backtracking && now > before) {
      shorten(lambda, gap, before, state);
      now = residual(state);
      continue;
    }
    Pattern pattern(static_cast<std::size_t>(rows_.groups()), Motion::open);
    for (std::size_t j = 0; j < work.set.size(); ++j)
      pattern[static_cast<std::size_t>(work.set[j])] = work.equations[j].motion;
    if (!seen.empty() && pattern == seen.back())
      continue; // the step of one pattern converges
    if (!backtracking && std::ranges::find(seen, pattern) != seen.end())
      return now <= negligible;
    seen.push_back(std::move(pattern));
  }
  return now <= negligible;
}

void LawSolver::relax(int group, ContactState& state) const {
  constexpr int most = 20;
  constexpr double rounding = 1e-14;
  const std::size_t k = rows_.size(group);
  LawEquation law;
  for (int i = 0; i < most; ++i) {
    const std::array<double, 3> rho = rows_.of_group(group, state.lambda),
                                U = rows_.of_group(group, state.gap);
    std::array<double, 3> change{-rho[0], -rho[1], -rho[2]};
    if (next(group, state, law)) {
      std::array<double, 9> X{}; // E S + F of the group, column by column
      for (std::size_t j = 0; j < k; ++j) {
        const std::array<double, 3> S =
            rows_.of_group(group, delassus_.column(static_cast<int>(rows_.row(group, j))));
        for (std::size_t c = 0; c < k; ++c)
          X[j * k + c] = times(law.E, k, c, S) + law.F[c * k + j];
      }
      for (std::size_t c = 0; c < k; ++c)
        change[c] = -times(law.E, k, c, U) - times(law.F, k, c, rho);
      if (solve_general({X.data(), k * k}, k, false, {change.data(), k}) != 0)
        return;
    }
    double moved = 0, size = 0;
    for (std::size_t c = 0; c < k; ++c) {
      add_to_multiplier(static_cast<int>(rows_.row(group, c)), change[c], state);
      moved = std::max(moved, std::abs(change[c]));
      size = std::max(size, std::abs(rho[c]));
    }
    if (moved <= rounding * size)
      return;
  }
}

void LawSolver::prepare_all() const {
  std::vector<int> all(static_cast<std::size_t>(rows_.count()));
  std::iota(all.begin(), all.end(), 0);
  delassus_.prepare(all);
}

void LawSolver::sweep(int most, double negligible, ContactState& state, Workspace& work) const {
  prepare_all();
  on_root<SolverFailure>(rows_.comm(), [&] {
    start(std::vector<double>(state.lambda), state, work); // gaps without the rounding of earlier steps
    for (int i = 0; i < most && residual(state) > negligible; ++i, ++state.vi_iterations)
      for (int group = 0; group < rows_.groups(); ++group)
        relax(group, state);
  });
  MPI_Bcast(&state.vi_iterations, 1, MPI_INT, 0, rows_.comm());
  for (std::vector<double>* values : {&state.lambda, &state.gap})
    MPI_Bcast(values->data(), static_cast<int>(values->size()), MPI_DOUBLE, 0, rows_.comm());
}

bool LawSolver::pivot(ContactState& state, Workspace& work) const {
  const auto m = static_cast<std::size_t>(rows_.groups()), count = static_cast<std::size_t>(rows_.count()),
             rubbing = count - m; // groups with a tangential row
  constexpr std::size_t most = 2000;
  const std::size_t n = m + 3 * rubbing;
  for (int i = 0; i < rows_.groups(); ++i)
    if (rows_.size(i) > 2 || (laws_[i] != &coulomb && laws_[i] != &unilateral))
      return false;
  if (n > most)
    return false;
  prepare_all();
  int solved = 0;
  on_root<SolverFailure>(rows_.comm(), [&] {
    // z = (λ, β⁺, β⁻, γ): σ = β⁺ − β⁻, γ = |U_t|; in units in which S has a unit diagonal
    std::vector<double> unit(count), M(n * n), q(n);
    for (std::size_t row = 0; row < count; ++row)
      unit[row] = 1 / std::sqrt(delassus_.column(static_cast<int>(row))[row]);
    const auto add = [&](std::size_t row, std::size_t column, double entry) { M[row * n + column] += entry; };
    const auto add_gap = [&](std::size_t at, std::size_t row, double sign) { // sign · U_row
      q[at] = sign * unit[row] * work.gap0[row];
      for (std::size_t j = 0; j < count; ++j) {
        const double S = sign * unit[row] * unit[j] * delassus_.column(static_cast<int>(j))[row];
        add(at, j, S);
        if (j >= m)
          add(at, j + rubbing, -S);
      }
    };
    for (std::size_t i = 0; i < m; ++i) {
      add_gap(i, i, 1);
      if (rows_.size(static_cast<int>(i)) == 1)
        continue;
      const std::size_t plus = rows_.row(static_cast<int>(i), 1), minus = plus + rubbing,
                        gamma = minus + rubbing;
      add_gap(plus, plus, 1);
      add_gap(minus, plus, -1);
      add(plus, gamma, 1);
      add(minus, gamma, 1);
      add(gamma, i, state.friction_of(i) * unit[i] / unit[plus]);
      add(gamma, plus, -1);
      add(gamma, minus, -1);
    }
    std::vector<double> z = lemke(M, q);
    if (z.empty())
      return;
    for (std::size_t row = 0; row < count; ++row)
      z[row] = unit[row] * (z[row] - (row >= m ? z[row + rubbing] : 0));
    start(std::span(z).first(count), state, work);
    solved = 1;
  });
  MPI_Bcast(&solved, 1, MPI_INT, 0, rows_.comm());
  for (std::vector<double>* values : {&state.lambda, &state.gap})
    MPI_Bcast(values->data(), static_cast<int>(values->size()), MPI_DOUBLE, 0, rows_.comm());
  return solved != 0;
}

void LawSolver::fail(const ContactState& state) const {
  int worst = 0;
  for (int i = 1; i < rows_.groups(); ++i)
    if (residual(i, state) > residual(worst, state))
      worst = i;
  const double largest = residual(worst, state);
  const std::array<double, 3> S = rows_.of_group(worst, delassus_.column(worst));
  throw LawFailure(fmt::format("the contact laws of {} candidates are not satisfied after {} iterations; the "
                               "largest residual is {:.3e} m",
                               rows_.groups(), state.vi_iterations, largest),
                   worst, state.friction_of(static_cast<std::size_t>(worst)), S[0] / std::hypot(S[1], S[2]));
}

bool LawSolver::solve_by(Method method, double negligible, ContactState& state, Workspace& work) const {
  using enum Method;
  constexpr int most = 20'000;
  switch (method) {
  case newton:
    return settle(negligible, false, state, work);
  case backtracking:
    return settle(negligible, true, state, work);
  case sweeps:
    for (const int sweeps : {30, 300}) {
      sweep(sweeps, negligible, state, work);
      if (settle(negligible, false, state, work))
        return true;
    }
    return false;
  case pivots:
    return pivot(state, work) && settle(negligible, false, state, work);
  case sweeps_alone:
    sweep(most, negligible, state, work);
    return residual(state) <= negligible;
  }
  return false;
}

void LawSolver::solve(std::span<const double> guess, double negligible, ContactState& state, Workspace& work,
                      Method first) const {
  std::vector<int> rows(static_cast<std::size_t>(rows_.groups()));
  std::iota(rows.begin(), rows.end(), 0);
  for (std::size_t row = rows.size(); row < guess.size(); ++row)
    if (guess[row] != 0)
      rows.push_back(static_cast<int>(row));
  delassus_.prepare(rows);
  using enum Method;
  for (const Method method : {newton, backtracking, sweeps, pivots, sweeps_alone}) {
    if (method < first)
      continue;
    start(method == newton ? guess : std::span<const double>(), state, work);
    if (solve_by(method, negligible, state, work))
      return;
  }
  fail(state);
}

} // namespace signorini::contact
