#pragma once
#include "optimize/units.h"

namespace signorini::optimize {

/// An iterate with J and its gradient there.
template <BoundedProblem P>
struct Iterate {
  typename P::Vector u;
  double objective;
  typename P::Vector g;
};

/// The state of a search between two iterations, on which all further ones depend. Dimensionless except for
/// u.
template <BoundedProblem P, class Memory>
struct State {
  Iterate<P> current;
  Units units; ///< of the problem at the first guess
  Iteration iteration;
  double first_norm; ///< ‖u − P(u − g)‖ at the first guess
  Memory memory;     ///< of the method

  /// Omits J and its gradient at u, which are evaluated anew.
  template <class Archive>
  void serialize(Archive& archive) {
    Shared<typename P::Vector> u = share(current.u);
    archive("u", u);
    current.u = *u;
    units.serialize(archive);
    iteration.serialize(archive);
    archive("first_norm", first_norm);
    memory.serialize(archive);
  }
};

/// Writes no checkpoints.
struct NoCheckpointer {
  static bool restore(auto&) { return false; }
  static bool due(const Iteration&) { return false; }
  static void store(auto&) {}
  static void restored(double, double) {}
};

/// Runs the iterations of a method from the first guess, or from the checkpoint that `keeper` restores, to a
/// stopping reason. The method works on the dimensionless problem and thus does not depend on the units of u
/// and J; `report`, keeper.restored() and the result are in the units given.
///
/// `memory.advance(problem, state, options)` makes one iteration: it moves state.current, state.iteration and
/// the problem's current point, or returns how the search ends. `report(iteration)` is called for the first
/// guess and for each iterate that this call accepts. keeper.restore(state) reads a state and returns whether
/// there was one; keeper.restored(stored, found) receives J there, as stored and as evaluated;
/// keeper.store(state) is called where keeper.due(iteration) asks for it and when the search ends.
/// Interrupted from the problem ends the search with the last accepted iterate. Throws SolverFailure if the
/// objective or its gradient is not finite. Collective if the problem is.
template <TwiceDifferentiable P, class Memory, class Report, class Checkpointer>
[[nodiscard]] Result<typename P::Vector> minimize(P& given, typename P::Vector guess, const Options& options,
                                                  Memory memory, Report&& report, Checkpointer&& keeper) {
  given.project(guess);
  Dimensionless<P> problem(given);
  State<Dimensionless<P>, Memory> state{{guess, 0, std::move(guess)}, {}, {}, 0, std::move(memory)};
  const auto tell = [&] {
    Iteration told = state.iteration;
    told.objective *= state.units.objective();
    told.gradient_norm *= state.units.gradient();
    report(told);
  };
  try {
    const bool restored = keeper.restore(state);
    auto& current = state.current;
    const double value = given.value(current.u);
    typename P::Vector g = given.trial_gradient();
    given.accept();
    if (!restored) {
      require_finite({0, value, norm(given, g), 0});
      state.units = measured(given, current.u, value, g);
    }
    problem.measure_in(state.units);
    current.objective = value / state.units.objective();
    current.g = problem.stepped(std::move(g));
    if (!restored) {
      state.first_norm = stationarity(problem, current.u, current.g);
      state.iteration = {0, current.objective, state.first_norm, 0};
      tell();
    } else {
      keeper.restored(state.iteration.objective * state.units.objective(), value);
    }
  } catch (const Interrupted&) {
    return {Stop::interrupted};
  }
  for (;;) {
    if (const auto end = ended(state.iteration, options.tolerance * state.first_norm, options)) {
      keeper.store(state);
      return {*end};
    }
    if (keeper.due(state.iteration))
      keeper.store(state);
    Memory before = state.memory;
    std::optional<Result<typename P::Vector>> end;
    try {
      end = state.memory.advance(problem, state, options);
    } catch (const Interrupted&) {
      end.emplace(Stop::interrupted);
    }
    if (end) {
      state.memory = std::move(before);
      keeper.store(state);
      if (end->certificate) {
        end->certificate->length *= state.units.gradient();
        end->certificate->radius *= state.units.length;
      }
      return std::move(*end);
    }
    require_finite(state.iteration);
    tell();
  }
}

} // namespace signorini::optimize
