// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measure.h"
#include <memory>

namespace signorini::accuracy {

/// A size and a step that have been tried, and an estimate of the relative error, in two parts: that of the
/// mesh and that of the steps.
struct Trial {
  Rung rung;
  double space = 0, time = 0;
  double seconds = 0;        ///< of the rung
  std::string said, grounds; ///< what it found, and by what its error is known, in words
  std::string warning;       ///< why it is not verified though its error is small, in words
  [[nodiscard]] double error() const { return space + time; }
  [[nodiscard]] bool meets(double tolerance) const { return error() <= tolerance && warning.empty(); }
};

/// Tries sizes and steps.
class Trials {
public:
  virtual ~Trials() = default;
  /// The order with which the estimates fall, as far as nothing is known of it, and by how much size and step
  /// may change at a time for them to be trusted.
  [[nodiscard]] virtual double order() const = 0;
  [[nodiscard]] virtual double reach() const = 0;
  /// The next finer rung that can be tried, and all that have to run for it.
  [[nodiscard]] virtual Rung nearest(const Rung& rung) const { return rung; }
  [[nodiscard]] virtual std::vector<Rung> runs(const Rung& rung) const { return {rung}; }
  /// Whether degrees may be compared.
  [[nodiscard]] virtual bool any_degree() const { return true; }
  /// What they measure, and whether the error of J is estimated too.
  [[nodiscard]] virtual Quantity quantity() const = 0;
  [[nodiscard]] virtual bool estimates() const { return false; }
  /// Collective. Throws UserError, SolverFailure, Interrupted.
  virtual Trial run(const Rung& rung) = 0;
  /// Compares a trial with one of half its steps, by which its error in time may turn out to be larger, and
  /// gives its warning. Collective. Throws UserError, SolverFailure, Interrupted.
  void verify(Trial& trial);

protected:
  /// The measurements of a trial's own rung, and of others.
  virtual Measured known(const Rung& rung) = 0;
};

/// Of J, by what the adjoint estimates from the run itself. The references must outlive the result.
std::unique_ptr<Trials> adjoint_trials(MPI_Comm comm, const scene::Scene& scene, const Samples& samples);

/// Of any quantity, by the error bar of a rung beside two coarser ones in size and two in step, with twice
/// and four times either; they take about as long as the rung once more. The references must outlive the
/// result.
std::unique_ptr<Trials> ladder_trials(MPI_Comm comm, const scene::Scene& scene, const Samples& samples,
                                      const Quantity& quantity);

} // namespace signorini::accuracy
