// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/problem.h"
#include "control/measurements.h"
#include "optimize/gauss_newton.h"
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace signorini {

/// The unknowns of a scene as those of a least-squares problem (docs/method.md sections 9 and 10): on their
/// scales, x = θ or log θ; the residuals are the data's, in standard deviations, and the priors'. All members
/// collective.
class FitProblem {
public:
  /// Reads the data. The references must outlive this object. Throws UserError.
  FitProblem(std::shared_ptr<const Discretisation> discretisation, const scene::Scene& scene, Timers& timers);

  [[nodiscard]] std::vector<double> start() const { return on_scales(scene::start_values(scene_)); }
  [[nodiscard]] const optimize::Box& box() const { return box_; }

  /// θ of x, and x of θ.
  [[nodiscard]] std::vector<double> values(std::span<const double> x) const;
  [[nodiscard]] std::vector<double> on_scales(std::span<const double> values) const;
  /// dθ/dx at x.
  [[nodiscard]] std::vector<double> slopes(std::span<const double> x) const;

  /// The scene with the values of x.
  [[nodiscard]] scene::Scene scene_at(std::span<const double> x) const {
    return scene::with_values(scene_, values(x));
  }

  /// A motion with as many linearised ones beside it as there are unknowns, under the scene's given control
  /// or another's force. Throws UserError where the scene at x is none, SolverFailure, Interrupted.
  [[nodiscard]] optimize::LeastSquares evaluate(std::span<const double> x,
                                                const forward::Load* control = nullptr,
                                                forward::Stops stops = forward::Stops::obeyed);

  /// What the problem at any x needs of its solvers: which they are is decided once.
  [[nodiscard]] forward::Stepper::Needs needs() const;

  /// J and its gradient by x, by one motion and one adjoint sweep. Throws as evaluate() does.
  struct Gradient {
    double value;
    std::vector<double> residuals;
    std::vector<double> by_x;                           ///< empty without the adjoint sweep
    std::vector<contact::ContactLinearisation> contact; ///< of the motion
    long weak = 0;                                      ///< candidates in weak contact, over all steps
  };
  [[nodiscard]] Gradient gradient(std::span<const double> x);
  /// All but the gradient.
  [[nodiscard]] Gradient value(std::span<const double> x);

  [[nodiscard]] const std::vector<control::Data>& data() const { return data_; }
  /// Doubts about their tables.
  [[nodiscard]] std::vector<scene::TableDoubt> doubts() const;
  /// Values of all measurements.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Times at which each measurement has values, s.
  [[nodiscard]] std::vector<std::vector<double>> times() const;
  [[nodiscard]] const std::shared_ptr<const Discretisation>& discretisation() const {
    return discretisation_;
  }
  [[nodiscard]] const scene::Scene& scene() const { return scene_; }
  /// Forward sweeps so far; a linearised one counts as one.
  [[nodiscard]] int sweeps() const { return sweeps_; }
  void count_from(int sweeps) { sweeps_ = sweeps; }

  /// Residuals of values that were simulated, and of the priors.
  [[nodiscard]] std::vector<double> residuals(const std::vector<double>& simulated,
                                              std::span<const double> x) const;
  /// ∂J/∂ values of the measurements, from the residuals.
  [[nodiscard]] std::vector<double> by_values(const std::vector<double>& residuals) const;
  /// dJ/dx from dJ/dθ of the data, with the priors'.
  [[nodiscard]] std::vector<double> on_scale_gradient(std::vector<double> by_theta,
                                                      const std::vector<double>& residuals,
                                                      std::span<const double> x) const;

private:
  struct Setup;
  [[nodiscard]] Gradient swept(std::span<const double> x, bool adjoint);

  const scene::Scene& scene_;
  Timers& timers_;
  std::shared_ptr<const Discretisation> discretisation_;
  std::vector<control::Data> data_;
  std::size_t count_ = 0;
  optimize::Box box_;
  void decide(bool iterates);
  int sweeps_ = 0;
  std::optional<bool> iterative_; ///< whether D is not factorised, once that is decided
};

} // namespace signorini
