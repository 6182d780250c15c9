// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene.h"
#include "base/error.h"
#include "mutate.h"
#include <csignal>
#include <cstdio>
#include <fmt/format.h>
#include <optional>
#include <sys/time.h>

/// Scenes with something wrong: each must be taken, and then its echo must read back to the same echo, or be
/// refused by one sentence. An input that does neither stays behind as a file.
///
/// usage: signorini-fuzz-scene SEED COUNT SOURCE_DIR FOLDER

namespace {

using namespace signorini;

constexpr double most_seconds = 1;

/// What an input stands for: its first lines may be options --set behind a mark.
struct Input {
  std::vector<std::string> overrides;
  std::string scene;
};

const std::string mark = "#--set ";

Input input(std::string text) {
  Input in;
  while (text.starts_with(mark)) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    in.overrides.push_back(text.substr(mark.size(), end - mark.size()));
    text.erase(0, end + 1);
  }
  in.scene = std::move(text);
  return in;
}

std::optional<int> dimension(const scene::Scene& scene) {
  for (int dim : {2, 3})
    try {
      scene::require_dimension(scene, dim);
      return dim;
    } catch (const UserError&) {
    }
  return std::nullopt;
}

/// Stands for every file of a time series.
std::string table(const std::filesystem::path&) { return "time,linear\n0,0\n9,1\n"; }

/// Whether the scene is taken.
bool accepted(const Input& in, const std::filesystem::path& file) {
  std::optional<scene::Scene> scene;
  try {
    scene = scene::parse(in.scene, file, in.overrides, table);
  } catch (const UserError&) {
    return false;
  }
  const std::optional<int> dim = dimension(*scene);
  if (!dim)
    return false;
  const std::string echo = scene::echo(*scene, *dim);
  if (scene::echo(scene::parse(echo, file, {}, table), *dim) != echo)
    throw std::logic_error("the echo reads back to another one");
  return true;
}

/// Ends an input that takes too long; what it was is on disk.
void limit_time(int seconds) {
  const itimerval time{.it_interval = {}, .it_value = {.tv_sec = seconds, .tv_usec = 0}};
  setitimer(ITIMER_VIRTUAL, &time, nullptr);
}

/// Texts that may become options --set.
std::string assignment(fuzz::Mutator& mutator) {
  std::string text = mutator.next();
  std::erase(text, '\n');
  return mark + text + "\n";
}

class Run {
public:
  explicit Run(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void take(const std::string& text) {
    ++inputs;
    // It is there before it is tried, and so also after a crash.
    fuzz::write(folder_ / "last.toml", text);
    limit_time(static_cast<int>(2 * most_seconds));
    const double start = fuzz::processor_seconds();
    try {
      accepted(input(text), folder_ / "scene.toml") ? ++taken : ++refused;
      const double seconds = fuzz::processor_seconds() - start;
      if (seconds > most_seconds)
        throw std::logic_error(fmt::format("it takes {:.2g} s", seconds));
    } catch (const std::exception& error) {
      const auto kept = folder_ / fmt::format("scene-{}.toml", inputs);
      fuzz::write(kept, text);
      fmt::print("FAILED {}: {}\n", kept.string(), error.what());
      ++failed;
    }
    limit_time(0);
  }

  int inputs = 0, taken = 0, refused = 0, failed = 0;

private:
  std::filesystem::path folder_;
};

} // namespace

int main(int argc, char** argv) {
  const std::optional<fuzz::Task> task = fuzz::task(argc, argv);
  if (!task)
    return 2;
  const auto& [seed, count, source, folder] = *task;
  const fuzz::Stopwatch clock;
  Run run(folder);
  const int replayed = fuzz::replay(run, *task, ".toml");
  fuzz::Pieces scenes;
  for (const char* place : {"scenes", "tests/data", "tests/fuzz"})
    for (const auto& file : fuzz::files(source / place, ".toml"))
      scenes.push_back(fuzz::read(file));
  fuzz::Mutator mutator(seed, scenes, {"sin(",       "sqrt(",    "min(",
                                       "sum()",      "rnd",      "?",
                                       ":",          "==",       "!=",
                                       "<=",         "&&",       "||",
                                       "^",          "_e",       "x",
                                       "y",          "z",        "t",
                                       "pi",         "e",        "(",
                                       ")",          "cylinder", "cellwise",
                                       "stabilized", "run",      "{file=\"a\",column=\"linear\"}"});
  fuzz::Mutator options(seed + 1,
                        {"mesh.size=0.25", "material.0.young=1e8", "load.body=[\"0\", \"t\"]",
                         "contact.obstacle.point=[0, \"t\"]", "clamp.0.value=[\"0\", \"0\"]",
                         "mesh.file=a.geo", "control.initial=[1, 2]", "contact.on=bottom"},
                        {"=", ".", "a.b=", "..", "clamp.9", "contact.0.on="});
  for (long i = 0; i < count; ++i) {
    std::string text = mutator.next();
    if (mutator.below(8) == 0)
      text = assignment(options) + text;
    run.take(text);
  }
  std::filesystem::remove(folder / "last.toml");
  fmt::print(
      "scenes: {} inputs of seed {} and {} found before in {:.1f} s: {} accepted, {} rejected, {} failed\n",
      run.inputs - replayed, seed, replayed, clock.seconds(), run.taken, run.refused, run.failed);
  return run.failed == 0 ? 0 : 1;
}
