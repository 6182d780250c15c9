// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "mesh/gmsh_model.h"
#include "mutate.h"
#include <csignal>
#include <cstdio>
#include <cstring>
#include <execinfo.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gmsh.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

/// Meshes with something wrong: each must be read, to numbers that fit each other, or be refused by one
/// sentence. Each is read by a process of its own, for gmsh may damage its own memory. An input that does
/// neither stays behind as a file.
///
/// usage: signorini-fuzz-mesh SEED COUNT SOURCE_DIR FOLDER

namespace {

using namespace signorini;

constexpr int taken = 0, refused = 1, wrong = 3, slow = 4, stopped_by_sanitizer = 99;

/// Where the time went, for whoever reads the log.
void out_of_time(int) {
  std::array<void*, 100> frames{};
  backtrace_symbols_fd(frames.data(), backtrace(frames.data(), static_cast<int>(frames.size())),
                       STDERR_FILENO);
  _exit(slow);
}

/// Small meshes of the tests' geometries, in both formats that hold text.
fuzz::Pieces meshes(const std::filesystem::path& data, const std::filesystem::path& folder) {
  fuzz::Pieces texts;
  gmsh::initialize(0, nullptr, false, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::option::setNumber("Mesh.MeshSizeMin", 1);
  for (const auto& file : fuzz::files(data, ".geo")) {
    gmsh::open(file.string());
    gmsh::model::mesh::generate(gmsh::model::getDimension());
    for (double version : {2.2, 4.1}) {
      gmsh::option::setNumber("Mesh.MshFileVersion", version);
      gmsh::write((folder / "whole.msh").string());
      texts.push_back(fuzz::read(folder / "whole.msh"));
    }
    gmsh::clear();
  }
  gmsh::finalize();
  std::filesystem::remove(folder / "whole.msh");
  return texts;
}

void require(bool holds, const char* what) {
  if (!holds)
    throw std::logic_error(what);
}

void require_sound(const mesh::RawMesh& mesh) {
  const auto nodes = static_cast<std::int64_t>(mesh.points.size() / 3);
  const auto fit = [&](const std::vector<std::int64_t>& rows, int corners) {
    return rows.size() % static_cast<std::size_t>(corners) == 0 &&
           std::ranges::all_of(rows, [&](std::int64_t row) { return row >= 0 && row < nodes; });
  };
  require(mesh.dim == 2 || mesh.dim == 3, "the mesh has another dimension");
  require(!mesh.cells.empty() && fit(mesh.cells, mesh.dim + 1), "the cells do not fit the nodes");
  for (const auto& [name, facets] : mesh.facets)
    require(fit(facets, mesh.dim), "the facets do not fit the nodes");
  const auto cells = static_cast<std::int64_t>(mesh.cells.size()) / (mesh.dim + 1);
  for (const auto& [name, ranges] : mesh.parts)
    require(ranges.size() % 2 == 0 &&
                std::ranges::all_of(ranges, [&](std::int64_t row) { return row >= 0 && row <= cells; }),
            "the parts do not fit the cells");
}

/// Reads a mesh and says on stderr what is wrong; a status.
int attempt(const std::filesystem::path& file) {
  try {
    require_sound(mesh::read_gmsh_here({.file = file, .size = {}}));
    return taken;
  } catch (const UserError&) {
    return refused;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return wrong;
  }
}

struct Outcome {
  bool ended = false;
  int status = 0; ///< or the signal
  std::string said;
};

Outcome read_apart(const std::filesystem::path& file, const std::filesystem::path& log) {
  (void)std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    const rlimit no_core{.rlim_cur = 0, .rlim_max = 0};
    setrlimit(RLIMIT_CORE, &no_core);
    const itimerval second{.it_interval = {}, .it_value = {.tv_sec = 1, .tv_usec = 0}};
    std::signal(SIGPROF, out_of_time);
    setitimer(ITIMER_PROF, &second, nullptr);
    _exit(attempt(file)); // gmsh's own leaks are not looked for
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child)
    throw std::runtime_error("a process cannot be started");
  return {WIFEXITED(status), WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status), fuzz::read(log)};
}

class Run {
public:
  explicit Run(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void take(const std::string& text) {
    ++inputs;
    const auto file = folder_ / "last.msh";
    fuzz::write(file, text);
    const Outcome outcome = read_apart(file, folder_ / "last.log");
    if (outcome.ended && outcome.status <= refused) {
      accepted += outcome.status == taken;
      rejected += outcome.status != taken;
      return;
    }
    // A crash, which the program survives (mesh::read_gmsh); under the sanitizers their report says whose it
    // is.
    if (!outcome.ended ||
        (outcome.status == stopped_by_sanitizer && outcome.said.find("libgmsh") != std::string::npos)) {
      ++crashes;
      return;
    }
    if (outcome.ended && outcome.status == slow && outcome.said.find("libgmsh") != std::string::npos) {
      ++unended; // gmsh believes counts that no file could hold
      return;
    }
    const auto kept = folder_ / fmt::format("mesh-{}.msh", inputs);
    fuzz::write(kept, text);
    fmt::print("FAILED {}: {} {}: {}\n", kept.string(), outcome.ended ? "status" : strsignal(outcome.status),
               outcome.status, outcome.said.substr(0, 6000));
    ++failed;
  }

  int inputs = 0, accepted = 0, rejected = 0, crashes = 0, unended = 0, failed = 0;

private:
  std::filesystem::path folder_;
};

} // namespace

// stopped_by_sanitizer
extern "C" const char* __asan_default_options() { return "exitcode=99"; }
extern "C" const char* __ubsan_default_options() { return "exitcode=99"; }

int main(int argc, char** argv) {
  const std::optional<fuzz::Task> task = fuzz::task(argc, argv);
  if (!task)
    return 2;
  const auto& [seed, count, source, folder] = *task;
  const fuzz::Stopwatch clock;
  Run run(folder);
  const int replayed = fuzz::replay(run, *task, ".msh");
  fuzz::Mutator mutator(seed, meshes(source / "tests/data", folder),
                        {"$Nodes", "$EndNodes", "$Elements", "$EndElements", "$PhysicalNames", "$Periodic",
                         "$Comments", "$NodeData", "$ParametricNodes", "$PartitionedEntities",
                         "$GhostElements", "$MeshFormat", "\"body\"", "\"\"", "15", "92", "4.1", "2.2"});
  for (long i = 0; i < count; ++i)
    run.take(mutator.next());
  std::filesystem::remove(folder / "last.msh");
  std::filesystem::remove(folder / "last.log");
  fmt::print("meshes: {} inputs of seed {} and {} found before in {:.1f} s: {} accepted, {} rejected, {} "
             "crashed gmsh, "
             "{} given up after 1 s in gmsh, {} failed\n",
             run.inputs - replayed, seed, replayed, clock.seconds(), run.accepted, run.rejected, run.crashes,
             run.unended, run.failed);
  return run.failed == 0 ? 0 : 1;
}
