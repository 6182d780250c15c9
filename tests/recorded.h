#pragma once
#include "forward/balance.h"
#include "problem.h"
#include <vector>

namespace signorini::test {

/// A motion with all that can be looked at, of the steps 0…N.
struct Recorded {
  petsc::Series y, v;
  std::vector<contact::ContactState> contact;
  std::vector<forward::StepBalance> balance;
  int steps = 0;

  Recorded(const Problem& problem, const forward::Load& load) {
    forward::Balance weigh(problem.stepper);
    steps = forward::stream(problem.stepper, problem.initial, load, problem.steps(),
                            [&](const forward::Frame& frame) {
                              y.push_back(petsc::copy(frame.y1));
                              v.push_back(petsc::copy(frame.v1));
                              contact.push_back(frame.contact);
                              balance.push_back(weigh(frame));
                            });
  }
  /// Of the steps 0…N.
  [[nodiscard]] std::vector<contact::ContactSets> sets() const { return {contact.begin(), contact.end()}; }
  explicit Recorded(const Problem& problem) : Recorded(problem, problem.load()) {}
};

} // namespace signorini::test
