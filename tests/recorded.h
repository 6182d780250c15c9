// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/balance.h"
#include "problem/problem.h"
#include <functional>
#include <vector>

namespace signorini::test {

/// Forces or duals by functions of the step, which add to a density, a vector or both.
template <class Part>
class ByFunctions final : public step::StepByStep<Part> {
public:
  using Add = std::function<void(int k, Vec out)>;
  explicit ByFunctions(Add density, Add vector = {})
      : density_(std::move(density)), vector_(std::move(vector)) {}
  [[nodiscard]] bool has_density() const override { return static_cast<bool>(density_); }
  [[nodiscard]] bool has_vector() const override { return static_cast<bool>(vector_); }
  void add(const step::TimeStep& step, Part sum) const override {
    if (density_)
      density_(step.k, sum.density);
    if (vector_)
      vector_(step.k, sum.vector);
  }

private:
  Add density_, vector_;
};
using Force = ByFunctions<step::NodalForce>;
using Dual = ByFunctions<step::StateDual>;

/// The displacements of a motion that was recorded.
class Displacements final : public step::Displacements {
public:
  explicit Displacements(const petsc::Series& y) : y_(y) {}
  [[nodiscard]] Vec y(const step::TimeStep& step) const override {
    return y_[static_cast<std::size_t>(step.k)];
  }

private:
  const petsc::Series& y_;
};

/// A motion with all that can be looked at, of the steps 0…N.
struct Recorded {
  petsc::Series y, v;
  std::vector<petsc::Series> q; ///< internal displacements of the branches, by steps
  std::vector<contact::ContactState> contact;
  std::vector<diagnostics::StepBalance> balance;
  int steps = 0;

  Recorded(const problem::Problem& problem, const step::ForceAtStep& load) {
    diagnostics::Balance weigh(problem.stepper);
    steps = trajectory::integrate(problem.stepper, problem.grid, problem.initial, load,
                                  [&](const trajectory::Frame& frame) {
                                    y.push_back(petsc::copy(frame.after.y()));
                                    v.push_back(petsc::copy(frame.after.v()));
                                    petsc::Series& of_step = q.emplace_back();
                                    for (const petsc::Vector& one : frame.after.q())
                                      of_step.push_back(petsc::copy(one));
                                    contact.push_back(frame.contact);
                                    balance.push_back(weigh(frame));
                                  });
  }
  /// Of the steps 0…N.
  [[nodiscard]] std::vector<contact::ContactLinearisation> sets() const {
    std::vector<contact::ContactLinearisation> all;
    for (const contact::ContactState& one : contact)
      all.push_back(one.linearisation());
    return all;
  }
  explicit Recorded(const problem::Problem& problem) : Recorded(problem, problem.load()) {}
};

} // namespace signorini::test
