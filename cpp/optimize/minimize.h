#pragma once
#include "optimize/options.h"
#include "optimize/report.h"
#include "optimize/units.h"

namespace signorini::optimize {

/// The state of a search between two iterations, on which all further ones depend. Dimensionless except for
/// u.
template <Unknowns U, class Memory>
struct State {
  Iterate<U> current;
  Units units; ///< of the problem at the first guess
  Iteration iteration;
  double first_norm; ///< ‖u − P(u − g)‖ at the first guess
  Memory memory;     ///< of the method

  /// Omits J and its gradient at u, which are evaluated anew.
  template <class Archive>
  void serialize(Archive& archive) {
    Shared<typename U::Vector> u = share(current.u);
    archive("u", u);
    current.u = *u;
    units.serialize(archive);
    iteration.serialize(archive);
    archive("first_norm", first_norm);
    memory.serialize(archive);
  }
};

/// Throws SolverFailure if J or its gradient is not finite.
inline void require_finite(const Iteration& iteration) {
  if (!std::isfinite(iteration.objective) || !std::isfinite(iteration.gradient_norm))
    throw SolverFailure("the objective or its gradient is not finite at iteration " +
                        std::to_string(iteration.number));
}

/// The stopping reason at this iterate, if there is one.
inline std::optional<Stop> ended(const Iteration& iteration, double first_norm, const Options& options) {
  if (!(iteration.gradient_norm > options.tolerance * first_norm))
    return Stop::gradient_tolerance;
  if (iteration.number >= options.max_iterations)
    return Stop::iteration_limit;
  return std::nullopt;
}

/// Evaluates J at the state's point, where the search starts or, with `restored`, goes on. Returns J in the
/// units given. Throws SolverFailure, Interrupted.
template <TwiceDifferentiable P, class Memory>
double start(P& given, Dimensionless<P>& problem, State<Dimensionless<P>, Memory>& state, bool restored) {
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
  }
  return value;
}

/// Runs the iterations of a method from the first guess, or from the checkpoint that `keeper` restores, to a
/// stopping reason. The method works on the dimensionless problem and thus does not depend on the units of u
/// and J; `report`, keeper.restored() and the result are in the units given.
///
/// Method(options).advance(problem, state) makes one iteration: it moves state.current, state.iteration and
/// the problem's current point, or returns how the search ends. `report(iteration)` is called for the first
/// guess and for each iterate that this call accepts. keeper.restore(state) reads a state and returns whether
/// there was one; keeper.restored(stored, found) receives J there, as stored and as evaluated;
/// keeper.store(state) is called where keeper.due(iteration) asks for it and when the search ends.
/// Interrupted from the problem ends the search with the last accepted iterate. Throws SolverFailure if the
/// objective or its gradient is not finite. Collective if the problem is.
template <template <TwiceDifferentiable> class Method, TwiceDifferentiable P, class Report,
          class Checkpointer>
[[nodiscard]] Result<typename P::Vector> minimize(P& given, typename P::Vector guess, const Options& options,
                                                  Report&& report, Checkpointer&& keeper) {
  using Memory = Method<Dimensionless<P>>;
  given.project(guess);
  Dimensionless<P> problem(given);
  State<Dimensionless<P>, Memory> state{{guess, 0, std::move(guess)}, {}, {}, 0, Memory(options)};
  const auto tell = [&] {
    Iteration told = state.iteration;
    told.objective *= state.units.objective();
    told.gradient_norm *= state.units.gradient();
    report(told);
  };
  try {
    const bool restored = keeper.restore(state);
    const double value = start(given, problem, state, restored);
    if (restored)
      keeper.restored(state.iteration.objective * state.units.objective(), value);
    else
      tell();
  } catch (const Interrupted&) {
    return {Stop::interrupted};
  }
  for (;;) {
    if (const auto end = ended(state.iteration, state.first_norm, options)) {
      keeper.store(state);
      return {*end};
    }
    if (keeper.due(state.iteration))
      keeper.store(state);
    Memory before = state.memory;
    std::optional<Result<typename P::Vector>> end;
    try {
      end = state.memory.advance(problem, state);
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
