// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include "optimize_problems.h"

/// Searches by each of the methods, with a record of their iterations.
namespace signorini::test {

/// Writes no checkpoints.
struct NoCheckpointer {
  static bool restore(auto&) { return false; }
  static bool due(const optimize::Iteration&) { return false; }
  static void store(auto&) {}
  static void restored(double, double) {}
  static void mark() {}
  static void certified(const auto&) {}
};

struct Record {
  std::vector<optimize::Iteration> rows;
  void operator()(const optimize::Iteration& row) { rows.push_back(row); }
};

inline const Point start{{0, 0, 0, 5}};

enum class Method { projected_gradient, lbfgs, newton_cg };
constexpr Method methods[] = {Method::projected_gradient, Method::lbfgs, Method::newton_cg};

template <class P, class Checkpointer = NoCheckpointer>
optimize::Result<Point> search(Method method, P& problem, const Point& from, const optimize::Options& options,
                               Record& record, const Checkpointer& checkpointer = {}) {
  switch (method) {
  case Method::lbfgs:
    return optimize::minimize<optimize::Lbfgs>(problem, from, options, record, checkpointer);
  case Method::newton_cg:
    return optimize::minimize<optimize::NewtonCg>(problem, from, options, record, checkpointer);
  default:
    return optimize::minimize<optimize::ProjectedGradient>(problem, from, options, record, checkpointer);
  }
}

template <class P>
optimize::Stop minimise(Method method, P& problem, const Point& from, const optimize::Options& options,
                        Record& record) {
  return search(method, problem, from, options, record).stop;
}

} // namespace signorini::test
