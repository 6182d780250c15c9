// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/verb_options.h"
#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace signorini::app {
namespace {

/// Replaces a text such as 90, 90s, 10min or 2h by the number of seconds. Returns an error message; empty if
/// the text is valid.
std::string to_seconds(std::string& text) {
  constexpr std::pair<std::string_view, double> units[] = {{"min", 60}, {"h", 3600}, {"s", 1}};
  std::string_view number = text;
  double unit = 1;
  for (const auto& [name, factor] : units)
    if (number.ends_with(name)) {
      number.remove_suffix(name.size());
      unit = factor;
      break;
    }
  double value = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc() || end != number.data() + number.size() || !(value > 0) || !std::isfinite(value))
    return fmt::format("found {}; expected a time above 0, such as 90s, 10min or 2h", text);
  text = fmt::format("{}", value * unit);
  return {};
}

/// Sets `shard` from a text i/n with 1 ≤ i ≤ n. Returns an error message; empty if the text is valid.
std::string to_shard(const std::string& text, std::optional<batch::Shard>& shard) {
  int index = 0, count = 0;
  const char *begin = text.data(), *end = begin + text.size();
  const auto [slash, first] = std::from_chars(begin, end, index);
  const bool divided = first == std::errc() && slash != end && *slash == '/';
  const auto [rest, second] =
      divided ? std::from_chars(slash + 1, end, count) : std::from_chars_result{begin, first};
  if (!divided || second != std::errc() || rest != end || index < 1 || count < index)
    return fmt::format("found {}; expected i/n with 1 <= i <= n, such as 2/8", text);
  shard = {index, count};
  return {};
}

} // namespace

void add_study_options(CLI::App& app, Request& request) {
  const auto list = [&](const char* name, auto& values, const char* text) {
    app.add_option(name, values, text)
        ->delimiter(',')
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  list("--sizes", request.study.choice.sizes,
       "element sizes, m, such as 1,0.5 (default: 1, 2 and 4 times the scene's size)");
  list("--steps", request.study.choice.steps, "time steps, s (default: 1, 2 and 4 times the scene's step)");
  list("--tolerances", request.study.choice.tolerances,
       "tolerances of steps of varying length (time.step = \"auto\"), beside or in place of --steps "
       "(default: 1, 4 and 16 times time.tolerance if the scene's steps vary, else none)");
  app.add_flag(
      "--graded", request.study.choice.graded,
      "repeat all rungs on graded meshes, with as many elements as the uniform ones and sizes that follow "
      "the error");
  list("--degrees", request.study.choice.degrees,
       "degrees of the displacement, such as 1,2 (default: the scene's)");
  list("--schemes", request.study.choice.schemes,
       "contact schemes, from contact-implicit,contact-stabilized,massless (default: the scene's)");
  list("--quantity", request.study.quantities,
       "quantities to compare, such as J,displacement,gradient,impulse (default: all but the gradient)");
  list("--search-tolerances", request.study.search_tolerances,
       "also search for the scene's optimum with "
       "these values of optimizer.tolerance, such as 1e-3,1e-4,1e-5");
  app.add_option("--budget", request.study.budget,
                 "time limit, such as 90s, 10min or 2h; a rung that would end later is not started (default: "
                 "none; with --suggest 10min)")
      ->transform(CLI::Validator(to_seconds, "TIME"));
  app.add_flag("--dry-run", request.study.dry_run, "predict the time of each rung; run none");
  app.add_option("--suggest", request.suggest,
                 "in place of a study: suggest a size and a step for this relative error of --quantity or J, "
                 "such as 1e-2; stores nothing")
      ->check(CLI::Range(1e-12, 1.0))
      ->excludes("--search-tolerances")
      ->excludes("--out");
}

void add_batch_options(CLI::App& app, Request& request) {
  app.add_option("--cases", request.batch.cases,
                 "table of the cases (CSV): a row for each, a column for each key that changes, such as "
                 "material.young; a column `name` is optional")
      ->required();
  app.add_option("--quantity", request.study.quantities,
                 "numbers to tabulate, such as J,impulse,peak_force (default: all but energy_loss and the "
                 "stress)")
      ->delimiter(',')
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_flag("--resume", request.resume, "keep the outcomes in the folder and its shards");
  app.add_flag("--folders", request.batch.folders,
               "store all results of each case, as simulate does, in a folder of its name");
  app.add_option_function<std::string>(
         "--shard", [](const std::string&) {},
         "compute part i of n of the cases, as i/n, in a folder of its own")
      ->check(CLI::Validator([&request](std::string& text) { return to_shard(text, request.batch.shard); },
                             "i/n"));
  app.add_option("--together", request.batch.together,
                 "largest number of motions whose solves are made together (default 16)")
      ->check(CLI::Range(1, 1024));
}

CLI::Option* add_accuracy_options(CLI::App& app, Request& request, const std::string& quantity) {
  CLI::Option* const accuracy = app.add_option("--accuracy", request.accuracy,
                                               "choose sizes and steps until the relative error of " +
                                                   quantity + " is below this number, such as 1e-2")
                                    ->check(CLI::Range(1e-12, 1.0));
  app.add_option("--budget", request.study.budget,
                 "time limit, such as 90s, 10min or 2h; "
                 "the best result until then is written (default: none)")
      ->transform(CLI::Validator(to_seconds, "TIME"))
      ->needs(accuracy);
  return accuracy;
}

} // namespace signorini::app
