// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/search_costs.h"
#include "base/collective.h"
#include "base/error.h"
#include "drivers/methods.h"
#include "drivers/search.h"
#include "drivers/search_level.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

template <template <optimize::TwiceDifferentiable> class Method>
SearchCost search_by(MPI_Comm comm, const scene::Scene& scene) {
  drivers::SearchLevel<Method> level(comm, scene, {}, nullptr, problem::search_needs(scene));
  const Elapsed elapsed(comm);
  const optimize::Options options =
      drivers::search_options(level.control_problem().controls, scene.optimizer);
  std::vector<io::CoarseLevel> coarse;
  level.search(drivers::search_start<Method>(level.problem(), level.control_problem(), options,
                                             Console(false, false), coarse),
               options, [](const optimize::Iteration&) {});
  const io::CoarseLevel found = level.record();
  return {.tolerance = *scene.optimizer.tolerance,
          .objective = found.objective,
          .iterations = found.iterations,
          .forward_sweeps = found.forward_sweeps,
          .adjoint_sweeps = found.adjoint_sweeps,
          .seconds = elapsed.seconds(),
          .stop_reason = found.stop_reason};
}

} // namespace

void require_searches(const scene::Scene& scene, const std::vector<double>& tolerances) {
  if (!scene.objective || !scene.unknowns.empty())
    throw UserError(fmt::format("--search-tolerances: {} has {}; this option needs a control and an "
                                "objective, and no [[unknown]]",
                                scene.file.string(),
                                scene.objective ? "parameters to fit" : "no [objective]"));
  for (auto it = tolerances.begin(); it != tolerances.end(); ++it)
    if (std::find(tolerances.begin(), it, *it) != it)
      throw UserError(fmt::format("--search-tolerances: found {} twice; give each tolerance once", *it));
  for (const double tolerance : tolerances)
    if (!(tolerance > 0 && tolerance <= 1))
      throw UserError(fmt::format(
          "--search-tolerances: found {}; expected numbers above 0 and at most 1, relative to the norm of "
          "the first gradient",
          tolerance));
}

SearchCost search_to(MPI_Comm comm, const scene::Scene& given, double tolerance) {
  scene::Scene scene = given;
  scene.optimizer.tolerance = tolerance;
  return drivers::with_method(scene.optimizer.method,
                              [&]<template <optimize::TwiceDifferentiable> class Method>() {
                                return search_by<Method>(comm, scene);
                              });
}

std::vector<double> above_least(const std::vector<SearchCost>& searches) {
  std::vector<double> above;
  if (searches.empty())
    return above;
  const double least = std::ranges::min(searches, {}, &SearchCost::objective).objective;
  for (const SearchCost& search : searches)
    above.push_back(least != 0 ? (search.objective - least) / std::abs(least)
                               : std::numeric_limits<double>::quiet_NaN());
  return above;
}

std::string csv(const std::vector<SearchCost>& searches) {
  std::string text =
      "tolerance,J,J_above_least,iterations,forward_sweeps,adjoint_sweeps,seconds,stop_reason\n";
  const std::vector<double> above = above_least(searches);
  for (std::size_t i = 0; i < searches.size(); ++i) {
    const SearchCost& one = searches[i];
    text += fmt::format("{},{:.17g},{},{},{},{},{:.6g},\"{}\"\n", one.tolerance, one.objective,
                        std::isfinite(above[i]) ? fmt::format("{:.17g}", above[i]) : "", one.iterations,
                        one.forward_sweeps, one.adjoint_sweeps, one.seconds, one.stop_reason);
  }
  return text;
}

std::string table(const std::vector<SearchCost>& searches) {
  std::string text = fmt::format("{:>9} {:>13} {:>8} {:>14} {:>11}  {}", "tolerance", "sweeps", "seconds",
                                 "J", "above least", "ends");
  const std::vector<double> above = above_least(searches);
  for (std::size_t i = 0; i < searches.size(); ++i) {
    const SearchCost& one = searches[i];
    text += fmt::format("\n{:>9.3g} {:>13} {:>8.3g} {:>14.7e} {:>11}  {}", one.tolerance,
                        fmt::format("{} + {}", one.forward_sweeps, one.adjoint_sweeps), one.seconds,
                        one.objective, std::isfinite(above[i]) ? fmt::format("{:.1e}", above[i]) : "-",
                        one.stop_reason);
  }
  return text;
}

std::string sentence(const std::vector<SearchCost>& searches, double error) {
  constexpr double small = 0.1;
  const std::vector<double> above = above_least(searches);
  const SearchCost* cheapest = nullptr;
  for (std::size_t i = 0; i < searches.size(); ++i)
    if (above[i] <= small * error && (!cheapest || searches[i].seconds < cheapest->seconds))
      cheapest = &searches[i];
  if (!cheapest)
    return "no recommendation for optimizer.tolerance: the least J of all searches is 0, so that relative "
           "errors are undefined";
  return fmt::format(
      "size and step cause an error of {:.2g} % in J. A search with optimizer.tolerance = {:.3g} adds less "
      "than a tenth of this error, with {} forward + {} adjoint sweeps in {:.2g} s",
      100 * error, cheapest->tolerance, cheapest->forward_sweeps, cheapest->adjoint_sweeps,
      cheapest->seconds);
}

} // namespace signorini::accuracy
