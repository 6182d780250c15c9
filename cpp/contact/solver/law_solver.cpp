// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/solver/law_solver.h"
#include "base/collective.h"
#include "contact/friction.h"
#include "contact/lcp/lemke.h"
#include "linalg/dense.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace signorini::contact {

Compliance LawSolver::diagonal(int group) const {
  const auto own = [&](std::size_t row, double otherwise) {
    const std::span<const double> column = delassus_.column(static_cast<int>(row));
    return column.empty() ? otherwise : column[row]; // groups without columns have been open so far
  };
  const auto& [normal, tangential] = compliances_[group];
  const std::size_t k = rows_.size(group);
  double sum = 0;
  for (std::size_t c = 1; c < k; ++c)
    sum += own(rows_.row(group, c), tangential);
  return {own(rows_.row(group, 0), normal), k > 1 ? sum / static_cast<double>(k - 1) : 0};
}

LawSolver::Values LawSolver::values(int group, const ContactState& state, const Contacts& contacts) const {
  const Compliance &one = compliances_[group], S = diagonal(group);
  const Compliance soft{contacts.softness * S.normal, contacts.softness * S.tangential};
  const auto between = [&](double node, double body, double softening) {
    return std::pow(node + softening, 1 - contacts.share) * std::pow(body + softening, contacts.share);
  };
  Values found{.size = rows_.size(group),
               .multipliers = rows_.of_group(group, state.lambda),
               .gaps = rows_.of_group(group, state.gap),
               .compliance = {between(one.normal, S.normal, soft.normal),
                              between(one.tangential, S.tangential, soft.tangential)},
               .softening = {soft.normal, soft.tangential, soft.tangential},
               .friction = state.friction_of(static_cast<std::size_t>(group))};
  for (std::size_t c = 0; c < found.size; ++c)
    found.gaps[c] += found.softening[c] * found.multipliers[c];
  return found;
}

double LawSolver::residual(int group, const ContactState& state, double softness) const {
  const Values at = values(group, state, {softness, 0});
  const double found = laws_[group]->residual(at.rho(), at.U(), at.compliance, at.friction);
  return std::isfinite(found) ? found : std::numeric_limits<double>::infinity();
}

double LawSolver::residual(const ContactState& state, double softness) const {
  double largest = 0;
  for (int i = 0; i < rows_.groups(); ++i)
    largest = std::max(largest, residual(i, state, softness));
  return largest;
}

bool LawSolver::next(int group, const ContactState& state, const Contacts& contacts,
                     LawEquation& equation) const {
  const Values at = values(group, state, contacts);
  if (!laws_[group]->newton_equation(at.rho(), at.U(), at.compliance, at.friction, equation))
    return false;
  for (std::size_t i = 0; i < at.size; ++i) // E (U + softening ρ) + F ρ = c
    for (std::size_t j = 0; j < at.size; ++j)
      equation.F[i * at.size + j] += equation.E[i * at.size + j] * at.softening[j];
  return true;
}

void LawSolver::add_to_gaps(int row, double change, ContactState& state) const {
  if (change == 0)
    return;
  const std::span<const double> column = delassus_.column(row);
  for (std::size_t j = 0; j < column.size(); ++j)
    state.gap[j] += column[j] * change;
}

void LawSolver::start(std::span<const double> lambda, ContactState& state, Workspace& work) const {
  state.several = false;
  std::ranges::fill(state.lambda, 0);
  std::ranges::copy(lambda, state.lambda.begin());
  set_gaps(state, work);
}

void LawSolver::set_gaps(ContactState& state, const Workspace& work) const {
  std::ranges::copy(work.gap0, state.gap.begin());
  for (std::size_t row = 0; row < state.lambda.size(); ++row)
    add_to_gaps(static_cast<int>(row), state.lambda[row], state);
}

void LawSolver::newton_step(ContactState& state, Workspace& work, const Contacts& contacts) const {
  work.set.clear();
  work.equations.clear();
  work.b.clear();
  ActiveSet opens;
  for (int i = 0; i < rows_.groups(); ++i) {
    LawEquation law;
    if (next(i, state, contacts, law)) {
      work.set.push_back(i);
      work.equations.push_back(law);
    } else if (state.lambda[i] != 0)
      opens.push_back(i);
  }
  for (const int i : opens)
    for (std::size_t c = 0; c < rows_.size(i); ++c) {
      const std::size_t row = rows_.row(i, c);
      add_to_gaps(static_cast<int>(row), -state.lambda[row], state);
      state.lambda[row] = 0;
    }
  for (std::size_t j = 0; j < work.set.size(); ++j) { // E S δρ + F δρ = c − E U − F ρ
    const LawEquation& law = work.equations[j];
    const int i = work.set[j];
    for (std::size_t c = 0, k = rows_.size(i); c < k; ++c)
      work.b.push_back(law.constant[c] - times(law.E, k, c, rows_.of_group(i, state.gap)) -
                       times(law.F, k, c, rows_.of_group(i, state.lambda)));
  }
  state.several = delassus_.solve_equations(work.set, work.equations, false, work.b, work) < 0;
  auto change = work.b.begin();
  for (std::size_t j = 0; j < work.set.size(); ++j) {
    const int i = work.set[j];
    for (std::size_t c = 0; c < rows_.size(i); ++c)
      state.lambda[rows_.row(i, c)] += *change++;
    if (!work.equations[j].closed)
      state.lambda[i] = 0; // not a rounding error
  }
  set_gaps(state, work); // without the rounding of earlier, larger multipliers
  ++state.vi_iterations;
}

bool LawSolver::settle(double negligible, ContactState& state, Workspace& work,
                       const Contacts& contacts) const {
  constexpr int most = 20;
  constexpr double rounding = 1e-9;
  std::vector<double> seen; // residuals
  for (int i = 0; i < most; ++i) {
    const double now = residual(state, contacts.softness);
    if (now <= negligible)
      return true;
    if (std::ranges::any_of(seen, [&](double before) { return std::abs(now - before) <= rounding * now; }))
      return false; // a cycle
    seen.push_back(now);
    try {
      newton_step(state, work, contacts);
    } catch (const SolverFailure&) { // a singular system, on all ranks: the next method tries
      return false;
    }
  }
  return residual(state, contacts.softness) <= negligible;
}

bool LawSolver::harden(double negligible, ContactState& state, Workspace& work) const {
  constexpr double first = 1, softest = 1e8, hardest = 1e-20, largest_ratio = 10, least_ratio = 1.05,
                   loose = 10;
  constexpr std::array shares{1.0, 0.0, 0.5};
  constexpr int most = 600;
  double softness = first, solved = 0, ratio = largest_ratio;
  double least = 1e-10; // softness from which on hard contacts are tried
  std::vector<double> lambda;
  const auto settled = [&] {
    return std::ranges::any_of(shares, [&](double share) {
      if (share != shares.front())
        start(lambda, state, work);
      return settle(softness == 0 ? negligible : loose * negligible, state, work, {softness, share});
    });
  };
  for (const int before = state.vi_iterations; state.vi_iterations - before < most;) {
    const bool hard = softness == 0;
    if (settled()) {
      if (hard)
        return true;
      lambda = state.lambda;
      solved = softness;
      ratio = std::min(largest_ratio, ratio * std::sqrt(ratio));
    } else if (solved == 0) { // with softer contacts the candidates hardly interact
      softness *= largest_ratio * largest_ratio;
      if (softness > softest)
        return false;
      start({}, state, work);
      continue;
    } else {
      if (hard)
        least *= 1e-3;
      else
        ratio = std::sqrt(ratio);
      if (ratio < least_ratio || least < hardest)
        return false;
      start(lambda, state, work);
    }
    softness = solved / ratio < least ? 0 : solved / ratio;
  }
  return false;
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
    if (next(group, state, {}, law)) {
      std::array<double, 9> X{}; // E S + F of the group, column by column
      for (std::size_t j = 0; j < k; ++j) {
        const std::array<double, 3> S =
            rows_.of_group(group, delassus_.column(static_cast<int>(rows_.row(group, j))));
        for (std::size_t c = 0; c < k; ++c)
          X[j * k + c] = times(law.E, k, c, S) + law.F[c * k + j];
      }
      for (std::size_t c = 0; c < k; ++c)
        change[c] = law.constant[c] - times(law.E, k, c, U) - times(law.F, k, c, rho);
      if (solve_general({X.data(), k * k}, k, false, {change.data(), k}) != 0)
        return;
    }
    double moved = 0, size = 0;
    for (std::size_t c = 0; c < k; ++c) {
      const std::size_t row = rows_.row(group, c);
      state.lambda[row] += change[c];
      add_to_gaps(static_cast<int>(row), change[c], state);
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
    set_gaps(state, work);
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
  delassus_.prepare(std::array{worst});
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
    return settle(negligible, state, work, {});
  case hardening:
    return harden(negligible, state, work);
  case pivots:
    return pivot(state, work) && settle(negligible, state, work, {});
  case sweeps:
    sweep(most, negligible, state, work);
    return residual(state) <= negligible || settle(negligible, state, work, {});
  }
  return false;
}

LawSolver::Method LawSolver::solve(std::span<const double> guess, double negligible, ContactState& state,
                                   Workspace& work, Method first) const {
  std::vector<int> rows;
  for (int i = 0; i < rows_.groups(); ++i) {
    const std::array<double, 3> U = rows_.of_group(i, work.gap0);
    bool acts = !laws_[i]->stays_open({U.data(), rows_.size(i)});
    for (std::size_t c = 0; c < rows_.size(i) && !guess.empty(); ++c)
      acts = acts || guess[rows_.row(i, c)] != 0;
    for (std::size_t c = 0; c < rows_.size(i) && acts; ++c)
      rows.push_back(static_cast<int>(rows_.row(i, c)));
  }
  delassus_.prepare(rows);
  using enum Method;
  for (const Method method : {newton, hardening, pivots, sweeps}) {
    if (method < first)
      continue;
    start(method == newton ? guess : std::span<const double>(), state, work);
    if (solve_by(method, negligible, state, work))
      return method;
  }
  fail(state);
}

} // namespace signorini::contact
