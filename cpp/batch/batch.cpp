// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch.h"
#include "accuracy/fingerprint.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/error.h"
#include "base/signals.h"
#include "batch/blocks.h"
#include <algorithm>
#include <fmt/format.h>
#include <sstream>

namespace signorini::batch {
namespace {

/// Reads the table of the cases on rank 0, for all ranks.
scene::CaseTable read_table(MPI_Comm comm, const std::filesystem::path& file) {
  std::string text;
  on_root(comm, [&] { text = scene::read_file(file); });
  text = broadcast(comm, text);
  try {
    return scene::read_cases(text);
  } catch (const UserError& error) {
    throw UserError(fmt::format("--cases: {}: {}", file.string(), error.what()));
  }
}

/// Throws UserError if a scene needs what no case has: a size or an end that a single run would choose.
void require_fixed(const scene::Scene& scene) {
  if (scene.mesh.automatic())
    throw UserError("mesh.size: batch does not accept \"auto\"; give a size in m");
  if (scene.time.until_bounce)
    throw UserError("time.end: batch does not accept \"auto\"; give the end in s");
}

/// Reads the scenes of the cases. Throws UserError if none is valid. Collective.
std::vector<Case> read_all(const scene::CaseTable& table, const scene::Scene& own, const ParseScene& parse) {
  std::vector<Case> cases(table.rows.size());
  for (std::size_t i = 0; i < cases.size(); ++i)
    try {
      scene::Scene scene = parse(table.overrides(i));
      require_fixed(scene);
      if (std::ranges::find(table.keys, "solver.memory") == table.keys.end())
        scene.solver.memory = own.solver.memory; // its default is the machine's
      cases[i].scene = std::move(scene);
    } catch (const UserError& error) {
      cases[i].reason = error.what();
    }
  if (std::ranges::none_of(cases, [](const Case& one) { return one.scene.has_value(); }))
    throw UserError(fmt::format("--cases: line {}: {}", table.rows.front().line, cases.front().reason));
  return cases;
}

/// Digest of all that determines an outcome besides its row in the table. Rank 0, before the first solver.
std::string origin(const scene::Scene& scene, const scene::CaseTable& table, const Options& options) {
  constexpr int space = 3;
  Digest digest;
  digest.add(scene::echo(scene, space));
  for (const auto& [name, value] : accuracy::inputs(scene))
    digest.add(name + "\n" + value + "\n");
  digest.add(options.folders ? "folders\n" : "");
  for (const std::vector<std::string>& names : {table.keys, options.quantities})
    for (const std::string& name : names)
      digest.add(name + "\n");
  return digest.text();
}

/// Folders of the cases in `out`, by their names. Throws UserError if a name is none of a folder, or if steps
/// vary in length, whose errors only a single run records.
std::vector<std::filesystem::path> folders_of(const scene::CaseTable& table, const scene::Scene& scene,
                                              const std::filesystem::path& out) {
  if (scene.time.automatic())
    throw UserError("--folders: found time.step = \"auto\"; give a length, or simulate the case alone");
  std::vector<std::filesystem::path> folders;
  for (const scene::CaseRow& row : table.rows) {
    if (row.name.starts_with('.') || row.name.find('/') != std::string::npos)
      throw UserError(fmt::format("--folders: line {} of the table: found the name \"{}\"; names of folders "
                                  "have no / and begin without a dot",
                                  row.line, row.name));
    folders.push_back(out / row.name);
  }
  return folders;
}

/// Numbers of the cases of a shard, which are neighbours, so that they share as much as they can.
std::pair<std::size_t, std::size_t> range(std::size_t cases, const std::optional<Shard>& shard) {
  if (!shard)
    return {0, cases};
  const auto start = [&](int index) {
    return cases * static_cast<std::size_t>(index) / static_cast<std::size_t>(shard->count);
  };
  return {start(shard->index - 1), start(shard->index)};
}

} // namespace

int run_batch(MPI_Comm comm, const scene::Scene& scene, const ParseScene& parse,
              const std::filesystem::path& given_out, const Options& options, const Console& console) {
  const Elapsed elapsed(comm);
  require_fixed(scene);
  (void)case_quantities(scene, options.quantities, 2); // reports a wrong name before any mesh is read
  const scene::CaseTable table = read_table(comm, options.cases);
  const std::vector<Case> cases = read_all(table, scene, parse);
  const std::filesystem::path out =
      options.shard ? given_out / fmt::format("shard-{}-of-{}", options.shard->index, options.shard->count)
                    : given_out;
  std::vector<std::filesystem::path> folders;
  if (options.folders)
    folders = folders_of(table, scene, out);
  if (const auto [first, end] = range(cases.size(), options.shard); first == end) {
    console.line("this part of the table has no cases: nothing is written");
    return exit_status::done;
  }
  std::optional<Results> results; // on rank 0
  std::vector<char> wanted(cases.size(), 0);
  on_root(comm, [&] {
    results.emplace(out, scene, table, origin(scene, table, options), options.shard);
    if (const std::size_t kept = options.resume ? results->resume() : 0; kept > 0)
      console.line(fmt::format("{} of {} cases have their outcome already", kept, cases.size()));
    const auto [first, end] = range(cases.size(), options.shard);
    for (std::size_t i = first; i < end; ++i)
      if (!results->has(i)) {
        if (cases[i].scene)
          wanted[i] = 1;
        else
          results->set(i, {.reason = cases[i].reason});
      }
  });
  wanted = broadcast(comm, wanted);
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i])
      numbers.push_back(i);

  const std::vector<Block> all = blocks(cases, numbers, static_cast<std::size_t>(options.together));
  BlockRunner runner(cases, options.quantities, std::move(folders));
  std::vector<std::size_t> sizes;
  bool stopped = false;
  {
    Progress progress(console, "cases", cases.size(), cases.size() - numbers.size());
    const auto at_once = static_cast<std::size_t>(ranks(comm));
    for (std::size_t first = 0; first < all.size() && !stopped; first += at_once) {
      std::vector<std::pair<std::size_t, Outcome>> ended;
      if (const std::size_t mine = first + static_cast<std::size_t>(rank(comm)); mine < all.size()) {
        const std::vector<Outcome> outcomes = runner.run(all[mine]);
        for (std::size_t i = 0; i < outcomes.size(); ++i)
          ended.emplace_back(all[mine][i], outcomes[i]);
      }
      const std::string text = packed(ended) + "\n";
      const std::vector<char> together = gather(comm, std::vector<char>(text.begin(), text.end()));
      const double seconds = elapsed.seconds();
      stopped = stop_requested(comm);
      on_root(comm, [&] {
        std::istringstream lines(std::string(together.begin(), together.end()));
        for (std::string line; std::getline(lines, line);)
          for (auto& [number, outcome] : unpacked(line))
            if (!outcome.interrupted)
              results->set(number, std::move(outcome));
        for (std::size_t i = first; i < std::min(first + at_once, all.size()); ++i)
          sizes.push_back(all[i].size());
        results->set(runner.known());
        if (runner.dim())
          results->set_dim(*runner.dim());
        results->write(seconds, sizes);
        progress.update(results->ended());
      });
    }
  }
  int ended = 0;
  on_root(comm, [&] { ended = static_cast<int>(results->ended()); });
  MPI_Bcast(&ended, 1, MPI_INT, 0, comm);
  if (ended == 0)
    throw Interrupted();
  int status = exit_status::done;
  const double seconds = elapsed.seconds();
  on_root(comm, [&] {
    results->write(seconds, sizes);
    const std::size_t failed = results->failed();
    console.line(fmt::format("{} of {} cases have ended, {} of them failed; {:.3g} s, {} blocks", ended,
                             cases.size(), failed, seconds, sizes.size()));
    constexpr std::size_t most = 5;
    for (const std::string& line : results->trouble_lines(most))
      console.line(line);
    console.line(fmt::format("results in {}", out.string()));
    if (static_cast<int>(failed) == ended)
      status = exit_status::solver_failed;
  });
  if (stopped)
    status = exit_status::interrupted;
  MPI_Bcast(&status, 1, MPI_INT, 0, comm);
  return status;
}

} // namespace signorini::batch
