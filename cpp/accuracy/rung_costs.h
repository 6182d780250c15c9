// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"

namespace signorini::accuracy {

/// Model of the run time of rungs of one degree: the time of the set-up plus a time for each step. Both have
/// the form a + b n^p in the number n of unknowns, with p = step_power(). On coarse meshes a dominates.
class CostModel {
public:
  /// Measured times of a run.
  struct Timed {
    double unknowns, setup, step; ///< number of unknowns; seconds of the set-up and of one step
  };

  /// Fits the model to the times on a coarse and a finer mesh. If there is only one mesh, a is taken as zero.
  CostModel(const std::vector<Timed>& timed, int dim);

  /// Predicted seconds of a run with the given numbers of unknowns and steps.
  [[nodiscard]] double seconds(double unknowns, double steps) const;

private:
  struct Power {
    double constant = 0, factor = 0;
  };
  double exponent_;
  Power setup_, step_;
};

/// Predicts the number of unknowns and the seconds of rungs.
class RungCosts {
public:
  /// Data for the rungs of one degree.
  struct DegreeCost {
    int degree;
    int dim;
    std::map<double, double> unknowns; ///< number of unknowns by element size, for one or more meshes
    CostModel cost;
  };
  /// `known`: data for each degree. `steps_by_width`: product of the number of steps and Rung::step_width()
  /// for steps of varying length, assumed to be the same for any tolerance.
  RungCosts(std::vector<DegreeCost> known, double steps_by_width)
      : known_(std::move(known)), steps_by_width_(steps_by_width) {}

  /// Predicted number of unknowns, a power of the element size. The exponent is fitted between known sizes;
  /// beyond these sizes it is minus the dimension.
  [[nodiscard]] double unknowns(const Rung& rung) const;
  /// Predicted seconds of a rung.
  [[nodiscard]] double seconds(const Rung& rung) const;

  /// Corrects all predicted seconds by one factor, from the measured seconds of a rung.
  void learn(const Rung& rung, double seconds);

private:
  [[nodiscard]] const DegreeCost& of(const Rung& rung) const;
  [[nodiscard]] double predicted(const Rung& rung) const;
  std::vector<DegreeCost> known_;
  double steps_by_width_;
  double expected_ = 0, found_ = 0; ///< predicted and measured seconds of the rungs that have run
};

/// Predicts the costs of a ladder from runs of few steps: for each degree on the ladder's coarsest mesh, and
/// on a mesh with a few thousand unknowns. Each run computes enough steps to take half as long as the set-up,
/// but at most a second or two.
/// Steps of varying length are assumed to cost as much as steps of one length; their number is measured with
/// the largest tolerance on the coarsest mesh. `estimate`: whether rungs include the error estimate of J.
/// Throws UserError, SolverFailure, Interrupted. Collective.
RungCosts predict_costs(MPI_Comm comm, const scene::Scene& scene, const std::vector<Rung>& rungs,
                        const SamplePoints& samples, const std::vector<Quantity>& wanted, bool estimate);

} // namespace signorini::accuracy
