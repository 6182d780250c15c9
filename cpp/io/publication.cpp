// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/publication.h"
#include "io/output_failure.h"
#include "io/sync.h"
#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <fstream>
#include <ranges>
#include <string>
#include <vector>

namespace signorini::io {
namespace fs = std::filesystem;

namespace {

using Names = std::span<const char* const>;

// Renaming the staging folder to `finished` is atomic and makes the publication certain: then earlier files
// move to a folder inside it, and the new ones into place; a later run can complete this from any state in
// between. The list of earlier files is removed at the end: without it nothing is left to do.
constexpr const char *finished = ".finished", *list = "replaced", *earlier = "earlier";

struct Move {
  fs::path from, to;
};

[[noreturn]] void fail(const fs::path& path, int error) {
  throw fs::filesystem_error("", path, std::error_code(error != 0 ? error : EIO, std::generic_category()));
}

void write_list(const fs::path& file, const std::vector<std::string>& replaced) {
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  for (const std::string& name : replaced)
    out << name << '\n';
  out.close();
  if (!out)
    fail(file, errno);
}

std::vector<std::string> read_list(const fs::path& file) {
  std::vector<std::string> replaced;
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  for (std::string name; std::getline(in, name);)
    replaced.push_back(name);
  if (!in.eof())
    fail(file, errno);
  return replaced;
}

/// Makes the moves that are left and appends them to `done`. Throws std::filesystem::filesystem_error.
void go_on(const fs::path& folder, Names names, std::vector<Move>& done) {
  const fs::path from = folder / finished;
  const auto move = [&](const fs::path& source, const fs::path& target) {
    fs::rename(source, target);
    done.push_back({source, target});
  };
  const std::vector<std::string> replaced = read_list(from / list);
  for (const std::string& name : replaced)
    if (!fs::exists(from / earlier / name) && fs::exists(folder / name))
      move(folder / name, from / earlier / name);
  for (const char* name : names)
    if (fs::exists(from / name))
      move(from / name, folder / name);
  synchronise(folder);
  std::error_code not_empty;
  for (const std::string& name : replaced)
    if (const fs::path inner = fs::path(name).parent_path(); !inner.empty())
      fs::remove(folder / inner, not_empty);
}

/// Removes the remains of a publication, which are harmless if this fails.
void clear(const fs::path& folder) {
  std::error_code error;
  fs::remove(folder / finished / list, error);
  if (!error)
    fs::remove_all(folder / finished, error);
}

/// The error as the user sees it: of the results' file, wherever it was at that moment, else of the folder.
OutputFailure problem(const fs::path& folder, Names names, const fs::filesystem_error& error,
                      const std::string& more = {}) {
  const std::string name = error.path1().filename().string();
  const bool of_results = std::ranges::find(names, name) != names.end();
  return OutputFailure(fmt::format("{}: cannot be replaced ({}){}",
                                   (of_results ? folder / name : folder).string(), error.code().message(),
                                   more));
}

} // namespace

void publish(const fs::path& folder, const fs::path& staging, Names names,
             const std::vector<std::string>& outdated) {
  std::vector<std::string> replaced;
  std::vector<Move> done;
  try {
    for (const char* name : std::views::reverse(names))
      if (fs::exists(folder / name))
        replaced.emplace_back(name);
    replaced.insert(replaced.end(), outdated.begin(), outdated.end());
    write_list(staging / list, replaced);
    fs::create_directory(staging / earlier);
    for (const std::string& name : replaced)
      fs::create_directories((staging / earlier / name).parent_path());
    for (const auto& entry : fs::directory_iterator(staging))
      synchronise(entry.path());
    synchronise(staging);
    fs::rename(staging, folder / finished);
    done.push_back({staging, folder / finished});
    go_on(folder, names, done);
  } catch (const fs::filesystem_error& error) {
    try {
      for (const Move& move : std::views::reverse(done))
        fs::rename(move.to, move.from);
    } catch (const fs::filesystem_error&) {
      throw problem(folder, names, error,
                    fmt::format("; the results wait in {}, from where the next run there puts them in place",
                                (folder / finished).string()));
    }
    throw problem(folder, names, error);
  }
  clear(folder);
}

void complete_publication(const fs::path& folder, Names names) {
  try {
    if (fs::exists(folder / finished / list)) {
      std::vector<Move> done;
      go_on(folder, names, done);
    }
  } catch (const fs::filesystem_error& error) {
    throw problem(folder, names, error);
  }
  clear(folder);
}

} // namespace signorini::io
