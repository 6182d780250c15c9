#pragma once
#include "optimize/units.h"

namespace signorini::optimize {

/// A point with what is known there.
template <BoundedProblem P>
struct Iterate {
  typename P::Vector u;
  double objective;
  typename P::Vector g;
};

/// Where a search stands between two iterations: all that the next ones depend on. But for u it is without
/// dimension.
template <BoundedProblem P, class Memory>
struct State {
  Iterate<P> current;
  Units units; ///< of the problem at the first guess
  Iteration iteration;
  double first_norm; ///< ‖u − P(u − g)‖ at the first guess
  Memory memory;     ///< of the method

  /// Without what can be evaluated anew: J's gradient at u.
  template <class Archive>
  void exchange(Archive& archive) {
    Shared<typename P::Vector> u = share(current.u);
    archive("u", u);
    current.u = *u;
    units.exchange(archive);
    iteration.exchange(archive);
    archive("first_norm", first_norm);
    memory.exchange(archive);
  }
};

/// Keeps nothing of a search.
struct NoKeeper {
  static bool restore(auto&) { return false; }
  static bool due(const Iteration&) { return false; }
  static void store(auto&) {}
  static void restored(double, double) {}
};

/// The iterations of a method from the first guess, or from where `keeper` says that it stood, until they
/// end. The method sees a problem in its own units: none of what follows depends on those in which u and J are given,
/// and `report`, `keeper` and the caller are told in those.
///
/// `memory.advance(problem, state)` makes one iteration: it moves state.current, state.iteration and the
/// problem's current point, or says how the search ends. `report(iteration)` is told of the first guess and
/// of each iterate that this call accepts. keeper.restore(state) reads a state and returns whether there was
/// one, and keeper.restored(stored, found) is told of J there, as it was stored and as it is;
/// keeper.store(state) is called where keeper.due(iteration) asks for it and when the search ends.
/// Interrupted from the problem ends it with the last accepted iterate. Throws SolverFailure if the objective
/// or its gradient is not finite.
template <TwiceDifferentiable P, class Memory, class Report, class Keeper>
[[nodiscard]] Ending<typename P::Vector> search(P& given, typename P::Vector guess, const Options& options,
                                                Memory memory, Report&& report, Keeper&& keeper) {
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
    std::optional<Ending<typename P::Vector>> end;
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
