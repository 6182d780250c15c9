// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/options.h"
#include "optimize/report.h"
#include "optimize/unknowns.h"
#include <span>

namespace signorini::optimize {

/// Units in which a search measures: L is a length of controls, and s is a factor that turns a gradient into
/// a step of a control. The unit of J is then L²/s, the unit of gradients L/s.
struct SearchUnits {
  double length = 1; ///< L, a length of controls
  double step = 1;   ///< s, factor that turns a gradient into a step

  /// Returns the unit of J, L²/s.
  [[nodiscard]] double objective() const { return length * length / step; }
  /// Returns the unit of gradients, L/s.
  [[nodiscard]] double gradient() const { return length / step; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive("units/length", length);
    archive("units/step", step);
  }
};

/// Returns the units of the problem at its current point u, where J = `objective` and the gradient is g.
/// Makes one Hessian product. Let d be −g without the values that bounds block. Cauchy's step is the
/// minimiser of J's quadratic model along d, projected onto the bounds; L is its length, and s = L/‖d‖. Both
/// depend on u, J and the bounds but not on the mesh, and scale with the units of u and J. Adding a constant
/// to all controls and bounds changes nothing. If u is stationary, both are 1.
///
/// The Hessian may be singular. But with frozen active sets J is a sum of squares, which has curvature along
/// its gradient, so that Cauchy's step is at most 2 J/‖g‖² times the gradient. This bound is used if no
/// curvature is found.
template <TwiceDifferentiable P>
[[nodiscard]] SearchUnits measured(P& problem, const typename P::Vector& u, double objective,
                                   const typename P::Vector& g) {
  const typename P::Vector d = tangential(problem, u, negative(g));
  const double squared = problem.inner(d, d);
  if (squared == 0)
    return {}; // stationary: units do not matter
  const double curvature = problem.inner(d, problem.hessian_product(d));
  typename P::Vector step = u;
  step.add(curvature > 0 ? squared / curvature : 2 * std::abs(objective) / squared, d);
  const double length = norm(problem, difference(projected(problem, std::move(step)), u));
  // Otherwise J is linear and zero, and defines no units.
  return std::isfinite(length) && length > 0 ? SearchUnits{length, length / std::sqrt(squared)}
                                             : SearchUnits();
}

/// Problem in dimensionless form, so that no method depends on the units of u and J. Controls and their
/// bounds are unchanged, but inner products are divided by L², so that a control of length L has length 1. J
/// is divided by L²/s, and gradients are multiplied by s, which gives them the length of a step. A curvature
/// of 1/s becomes 1.
template <TwiceDifferentiable P>
class Dimensionless {
public:
  using Vector = typename P::Vector;
  using Compact = typename P::Compact;

  explicit Dimensionless(P& problem) : problem_(problem) {}

  /// Sets the units in which the problem is measured.
  void measure_in(const SearchUnits& units) { units_ = units; }
  [[nodiscard]] const SearchUnits& units() const { return units_; }

  double value(const Vector& u) { return problem_.value(u) / units_.objective(); }
  Vector trial_gradient() { return stepped(problem_.trial_gradient()); }
  Vector hessian_product(const Vector& d) { return stepped(problem_.hessian_product(d)); }
  void accept() { problem_.accept(); }
  [[nodiscard]] double inner(const Vector& u, const Vector& w) const {
    return problem_.inner(u, w) / squared_length();
  }
  [[nodiscard]] Vector dual(const Vector& u) const { return problem_.dual(u); }
  [[nodiscard]] std::vector<double> pairings(std::span<const Vector> duals,
                                             std::span<const Compact> w) const {
    std::vector<double> products = problem_.pairings(duals, w);
    for (double& product : products)
      product /= squared_length();
    return products;
  }
  [[nodiscard]] bool bounded() const { return problem_.bounded(); }
  void project(Vector& u) const { problem_.project(u); }
  void zero_blocked(Vector& w, const Vector& u, const Vector& d) const { problem_.zero_blocked(w, u, d); }

  /// Converts a gradient or Hessian product of the given problem to dimensionless form.
  [[nodiscard]] Vector stepped(Vector g) const {
    g.scale(units_.step);
    return g;
  }

private:
  [[nodiscard]] double squared_length() const { return units_.length * units_.length; }

  P& problem_;
  SearchUnits units_;
};

/// State of a search between two iterations, on which all further iterations depend. Dimensionless except for
/// u.
template <Unknowns U, class Memory>
struct State {
  Iterate<U> current;
  SearchUnits units; ///< units of the problem at the first guess
  Iteration iteration;
  double first_norm; ///< ‖u − P(u − g)‖ at the first guess
  Memory memory;     ///< the method, with its state
  /// Length of the certificate that ended the search; infinite if none did.
  double certified = std::numeric_limits<double>::infinity();

  /// Writes or reads the state, except for J and its gradient at u, which are evaluated again.
  template <class Archive>
  void serialize(Archive& archive) {
    Shared<typename U::Vector> u = share(current.u);
    archive("u", u);
    current.u = *u;
    units.serialize(archive);
    iteration.serialize(archive);
    archive("first_norm", first_norm);
    archive("certified", certified);
    memory.serialize(archive);
  }
};

/// Warm start for a search with the same unknowns on another problem, such as a finer mesh. The search takes
/// over units and first norm, so that its tolerance does not depend on its starting point.
template <class Memory>
struct Inheritance {
  SearchUnits units;
  double first_norm;
  Memory memory;
};

/// Throws SolverFailure if J or its gradient is not finite.
inline void require_finite(const Iteration& iteration) {
  if (!std::isfinite(iteration.objective) || !std::isfinite(iteration.gradient_norm))
    throw SolverFailure("the objective or its gradient is not finite at iteration " +
                        std::to_string(iteration.number));
}

/// Returns the stopping reason at the present iterate, if there is one.
template <Unknowns U, class Memory>
std::optional<Stop> ended(const State<U, Memory>& state, const Options& options) {
  const Iteration& iteration = state.iteration;
  if (!(iteration.gradient_norm > options.tolerance * state.first_norm))
    return Stop::gradient_tolerance;
  if (state.certified <= options.tolerance * state.first_norm)
    return Stop::kink;
  if (iteration.number >= options.max_iterations)
    return Stop::iteration_limit;
  return std::nullopt;
}

/// Evaluates J and its gradient at state.current.u, where the search starts or, with `restored`, continues.
/// `inherited`: whether units and first norm of the state come from another search. Returns J in the units of
/// the given problem. Throws SolverFailure, Interrupted.
template <TwiceDifferentiable P, class Memory>
double start(P& given, Dimensionless<P>& problem, State<Dimensionless<P>, Memory>& state, bool restored,
             bool inherited) {
  auto& current = state.current;
  const double value = given.value(current.u);
  typename P::Vector g = given.trial_gradient();
  given.accept();
  if (!restored)
    require_finite({0, value, norm(given, g), 0});
  if (!restored && !inherited)
    state.units = measured(given, current.u, value, g);
  problem.measure_in(state.units);
  current.objective = value / state.units.objective();
  current.g = problem.stepped(std::move(g));
  if (!restored) {
    state.iteration = {0, current.objective, stationarity(problem, current.u, current.g), 0};
    if (!inherited)
      state.first_norm = state.iteration.gradient_norm;
  }
  return value;
}

/// Minimises J by the iterations of a method, from the first guess or from the checkpoint that `checkpointer`
/// restores, until there is a stopping reason. The method works on the dimensionless problem and thus does
/// not depend on the units of u and J. `report`, checkpointer.restored() and the result are in the units of
/// the given problem.
///
/// Method(options).advance(problem, state) makes one iteration, or one round of an iteration. If it finds a
/// new iterate, it moves state.current, state.iteration and the problem's current point. It returns a result
/// only if the search ends. make_room() is called before each advance() and may drop stored vectors.
/// `report(iteration)` is called for the first guess and for each iterate that this call accepts. If `report`
/// returns a bool, false ends the search.
///
/// checkpointer.restore(state) reads a state and returns whether there was one. checkpointer.restored(stored,
/// found) receives J at the restored point, as stored and as evaluated. checkpointer.mark() is called at
/// the start of each round: a state that is stored before the next mark is the state at this mark.
/// checkpointer.store(state) is called if checkpointer.due(iteration) is true and when the search ends. If a
/// certificate ends the search, checkpointer.certified(certificate) receives it, and the state that is stored
/// at the end does not contain the method's state. A search restored from this state ends at once, without a
/// certificate, unless its tolerance is smaller.
///
/// `inherited`: units, first norm and method with which another search ended, used if there is no checkpoint.
/// If the problem throws Interrupted, the search ends with the last accepted iterate. Throws SolverFailure if
/// J or its gradient is not finite. Collective if the problem is.
template <template <TwiceDifferentiable> class Method, TwiceDifferentiable P, class Report,
          class Checkpointer>
[[nodiscard]] Result<typename P::Vector>
minimize(P& given, typename P::Vector guess, const Options& options, Report&& report,
         Checkpointer&& checkpointer,
         std::optional<Inheritance<Method<Dimensionless<P>>>> inherited = std::nullopt) {
  using Memory = Method<Dimensionless<P>>;
  given.project(guess);
  Dimensionless<P> problem(given);
  State<Dimensionless<P>, Memory> state{{guess, 0, std::move(guess)}, {}, {}, 0, Memory(options)};
  if (inherited) {
    state.units = inherited->units;
    state.first_norm = inherited->first_norm;
    state.memory = std::move(inherited->memory);
  }
  bool enough = false;
  const auto show = [&] {
    Iteration shown = state.iteration;
    shown.objective *= state.units.objective();
    shown.gradient_norm *= state.units.gradient();
    shown.predicted_decrease *= state.units.objective();
    if constexpr (std::is_same_v<std::invoke_result_t<Report&, const Iteration&>, bool>)
      enough = !report(shown);
    else
      report(shown);
  };
  const auto first_norm = [&] { return state.first_norm * state.units.gradient(); };
  try {
    const bool restored = checkpointer.restore(state);
    const double value = start(given, problem, state, restored, inherited.has_value());
    if (restored)
      checkpointer.restored(state.iteration.objective * state.units.objective(), value);
    else
      show();
  } catch (const Interrupted&) {
    return {Stop::interrupted};
  }
  for (;;) {
    checkpointer.mark();
    if (const auto end = enough ? Stop::enough : ended(state, options)) {
      checkpointer.store(state);
      return {.stop = *end, .first_norm = first_norm()};
    }
    if (checkpointer.due(state.iteration))
      checkpointer.store(state);
    state.memory.make_room();
    Memory before = state.memory;
    const int number = state.iteration.number;
    std::optional<Result<typename P::Vector>> end;
    try {
      end = state.memory.advance(problem, state);
    } catch (const Interrupted&) {
      end.emplace(Stop::interrupted);
    }
    if (!end) {
      if (state.iteration.number != number) {
        require_finite(state.iteration);
        show();
      }
      continue;
    }
    if (auto& certificate = end->certificate) {
      const double length = certificate->length;
      certificate->length *= state.units.gradient();
      certificate->radius *= state.units.length;
      try {
        checkpointer.certified(*certificate);
        state.certified = length;
        before = Memory(options);
      } catch (const Interrupted&) {
        end.emplace(Stop::interrupted);
      }
    }
    state.memory = std::move(before);
    checkpointer.store(state);
    end->first_norm = first_norm();
    return std::move(*end);
  }
}

} // namespace signorini::optimize
