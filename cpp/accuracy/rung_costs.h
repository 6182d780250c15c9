// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"

namespace signorini::accuracy {

/// What runs of one degree take: a set-up and so much for each step, either a constant and a power of the
/// unknowns n, a + b n^p, with the exponent of step_power(). On coarse meshes the constants are most of it.
class CostModel {
public:
  /// A set-up and a step with this many unknowns, s.
  struct Timed {
    double unknowns, setup, step;
  };

  /// From those on one mesh, where constants are not told apart and taken for nothing, or on a coarse and a
  /// finer one.
  CostModel(const std::vector<Timed>& timed, int dim);

  /// Of a whole run, s.
  [[nodiscard]] double seconds(double unknowns, double steps) const;

private:
  struct Power {
    double constant = 0, factor = 0;
  };
  double exponent_;
  Power setup_, step_;
};

/// Predicted unknowns and seconds of rungs.
class RungCosts {
public:
  /// Of the meshes of one degree.
  struct DegreeCost {
    int degree;
    int dim;
    std::map<double, double> unknowns; ///< by size, of one or more meshes
    CostModel cost;
  };
  /// `steps_by_width`: chosen steps times their Rung::step_width(), of any tolerance.
  RungCosts(std::vector<DegreeCost> known, double steps_by_width)
      : known_(std::move(known)), steps_by_width_(steps_by_width) {}

  /// Powers of the size between those that are known; beyond them it is the dimension's.
  [[nodiscard]] double unknowns(const Rung& rung) const;
  [[nodiscard]] double seconds(const Rung& rung) const;

  /// Corrects the predictions by what a rung has taken: all of them by the same factor.
  void learn(const Rung& rung, double seconds);

private:
  [[nodiscard]] const DegreeCost& of(const Rung& rung) const;
  [[nodiscard]] double priced(const Rung& rung) const;
  std::vector<DegreeCost> known_;
  double steps_by_width_;
  double expected_ = 0, found_ = 0; ///< of the rungs that have run
};

/// RungCosts a ladder by runs of few steps, for each degree on its coarsest mesh and on one of some thousand
/// unknowns, as many steps as it takes for them to be half as long as the set-up. Steps that the motion
/// chooses are priced like as many of one length; how many there will be, that of the largest tolerance on
/// the coarsest mesh tells. `estimate`: that of the
/// error of J is part of a run. Collective. Throws UserError, SolverFailure, Interrupted.
RungCosts price(MPI_Comm comm, const scene::Scene& scene, const std::vector<Rung>& rungs,
                const Samples& samples, const std::vector<Quantity>& wanted, bool estimate);

} // namespace signorini::accuracy
