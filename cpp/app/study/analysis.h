#pragma once
#include "adjoint/weighted_residual.h"
#include "app/study/ladder.h"
#include <optional>

namespace signorini::study {

/// What is measured of a run. A field is compared in its norm, a number by its modulus.
struct Measured {
  long unknowns = 0;
  double seconds = 0;                    ///< of set-up and sweeps
  double memory = 0;                     ///< peak beyond what the program held before, bytes
  std::map<std::string, double> numbers; ///< by quantity
  std::map<std::string, std::vector<double>>
      fields; ///< by quantity: samples, scaled so that their sum of squares is the norm's
  std::optional<adjoint::ErrorParts> estimate; ///< of the error of J, J(exact) − J
};

struct Quantity {
  std::string name, title, unit;
  bool field = false;
  bool absolute = false; ///< already relative: errors are plain differences
};

/// A rung and its measurements; empty if it has not run.
struct Result {
  Rung rung;
  std::optional<Measured> measured;
};

/// The values against which errors are taken, by quantity; an absent quantity is compared with the finest
/// rung.
struct Exact {
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> fields;
  [[nodiscard]] bool knows(const Quantity& quantity) const {
    return quantity.field ? fields.contains(quantity.name) : numbers.contains(quantity.name);
  }
};

/// Errors of one quantity, rung by rung.
struct Errors {
  Quantity quantity;
  bool exact = false;
  std::optional<std::size_t> reference;        ///< the finest rung that has run, without an exact value
  std::vector<std::optional<double>> error;    ///< relative
  std::vector<std::optional<double>> estimate; ///< of the error, from the run and coarser ones alone
  /// Estimate over error; absent unless the reference's own error, by its estimate, is small beside the
  /// error.
  std::vector<std::optional<double>> effectivity;
  std::vector<bool> pareto; ///< no cheaper rung is as accurate
};

/// Observed orders of one degree and scheme.
struct Orders {
  std::string quantity;
  int degree = 1;
  Scheme scheme;
  /// Log-log slope of the differences, and the smallest and largest of neighbouring pairs.
  struct Order {
    double slope = 0, least = 0, largest = 0;
  };
  std::optional<Order> space, time, both;
};

/// Errors, estimates and Pareto front of one quantity.
Errors errors(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact);

/// Observed orders: in space at the shortest step and in time at the smallest size from the differences of
/// neighbouring rungs, in both along rungs that refine both, there from the errors if the exact value is
/// known. Needs three rungs, two with an exact value.
std::vector<Orders> orders(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact);

/// For 10, 1 and 0.1 per cent the cheapest rung that is as accurate, or that there is none, in words.
std::vector<std::string> sentences(const Errors& errors, const std::vector<Result>& results,
                                   const scene::Scene& scene);

} // namespace signorini::study
