// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"

namespace signorini::accuracy {

/// Cost of runs of one degree: a set-up and a time for each step, both of the form a + b n^p in the unknowns
/// n with the exponent of step_power(). On coarse meshes the constants dominate.
class CostModel {
public:
  /// Measured set-up and step with this many unknowns, s.
  struct Timed {
    double unknowns, setup, step;
  };

  /// Fits the costs on one mesh, where constant costs cannot be separated and are neglected, or on a coarse
  /// and a finer one.
  CostModel(const std::vector<Timed>& timed, int dim);

  /// Predicted seconds of a whole run.
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
  /// Unknowns and cost of the meshes of one degree.
  struct DegreeCost {
    int degree;
    int dim;
    std::map<double, double> unknowns; ///< number of unknowns by size, of one or more meshes
    CostModel cost;
  };
  /// `steps_by_width`: number of chosen steps times Rung::step_width(), the same for any tolerance.
  RungCosts(std::vector<DegreeCost> known, double steps_by_width)
      : known_(std::move(known)), steps_by_width_(steps_by_width) {}

  /// Predicted number of unknowns: a power of the size, fitted between known sizes; beyond, the dimension's.
  [[nodiscard]] double unknowns(const Rung& rung) const;
  [[nodiscard]] double seconds(const Rung& rung) const;

  /// Corrects the predictions by the measured seconds of a rung: all of them by the same factor.
  void learn(const Rung& rung, double seconds);

private:
  [[nodiscard]] const DegreeCost& of(const Rung& rung) const;
  [[nodiscard]] double priced(const Rung& rung) const;
  std::vector<DegreeCost> known_;
  double steps_by_width_;
  double expected_ = 0, found_ = 0; ///< predicted and measured seconds of the rungs that have run
};

/// Predicts the costs of a ladder from runs of few steps, for each degree on its coarsest mesh and on one of
/// some thousand unknowns. A run makes as many steps as take half as long as the set-up. Steps that the
/// motion chooses are priced like equally many of one length; their number is measured with the largest
/// tolerance on the coarsest mesh. `estimate`: whether a run includes the estimate of J's error. Collective.
/// Throws UserError, SolverFailure, Interrupted.
RungCosts price(MPI_Comm comm, const scene::Scene& scene, const std::vector<Rung>& rungs,
                const Samples& samples, const std::vector<Quantity>& wanted, bool estimate);

} // namespace signorini::accuracy
