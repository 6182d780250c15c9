// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/output_folder.h"
#include "base/collective.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <ranges>
#include <system_error>
#include <unistd.h>

namespace signorini::io {
namespace fs = std::filesystem;

namespace {

/// Names of a run's files; data files precede the files that refer to them.
constexpr std::array file_names{
    "mesh.msh",         "indicators.csv", "surfaces.h5",      "state.h5",       "control.h5", "adjoint.h5",
    "obstacles.vtkhdf", "state.vtkhdf",   "control.vtkhdf",   "adjoint.vtkhdf", "state.xdmf", "control.xdmf",
    "adjoint.xdmf",     "steps.csv",      "contact.csv",      "obstacles.csv",  "bodies.csv", "probes.csv",
    "history.csv",      "parameters.csv", "measurements.csv", "scenarios.csv",  "scene.toml", "run.json"};

constexpr const char *manifest = file_names.back(), *unfinished = ".unfinished-";

/// Name of a search's checkpoint, which stays in the folder until another checkpoint replaces it.
constexpr const char* checkpoint = "checkpoint.h5";

/// Files that a search writes into the output folder before its end.
const FolderLock::Names early_names{"history.csv", checkpoint};

/// Files that only a search writes, not a simulation.
constexpr std::array of_search{"history.csv",    "parameters.csv", "measurements.csv", "scenarios.csv",
                               "control.h5",     "control.vtkhdf", "control.xdmf",     "adjoint.h5",
                               "adjoint.vtkhdf", "adjoint.xdmf"};

/// Paths, within the folder, of the pages and figures that postprocess/ made of an earlier run.
std::vector<std::string> drawings(const fs::path& folder) {
  std::vector<std::string> found;
  std::error_code none;
  for (const char* page : {"report.html", "comparison.html"})
    if (fs::is_regular_file(folder / page, none) && is_drawn(folder / page))
      found.emplace_back(page);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "figures", none))
    if (entry.is_regular_file(none) && is_drawn(entry.path()))
      found.push_back("figures/" + entry.path().filename().string());
  return found;
}

/// Removes the unfinished files of killed runs from the folder.
void clear_unfinished(const fs::path& folder) {
  std::error_code ignored; // what remains is harmless
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with(unfinished))
      fs::remove_all(entry.path(), ignored);
}

// Publication: renaming the staging folder to `finished` is atomic and makes it certain. Then earlier files
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

/// Makes the remaining moves of a publication and appends them to `done`. Throws
/// std::filesystem::filesystem_error.
void make_moves(const fs::path& folder, std::vector<Move>& done) {
  const fs::path from = folder / finished;
  const auto move = [&](const fs::path& source, const fs::path& target) {
    fs::rename(source, target);
    done.push_back({source, target});
  };
  const std::vector<std::string> replaced = read_list(from / list);
  for (const std::string& name : replaced)
    if (!fs::exists(from / earlier / name) && fs::exists(folder / name))
      move(folder / name, from / earlier / name);
  for (const char* name : file_names)
    if (fs::exists(from / name))
      move(from / name, folder / name);
  synchronise(folder);
  std::error_code not_empty;
  for (const std::string& name : replaced)
    if (const fs::path inner = fs::path(name).parent_path(); !inner.empty())
      fs::remove(folder / inner, not_empty);
}

/// Removes the remains of a publication; a failure to remove them is harmless and ignored.
void clear_finished(const fs::path& folder) {
  std::error_code error;
  fs::remove(folder / finished / list, error);
  if (!error)
    fs::remove_all(folder / finished, error);
}

/// Makes an error for the user. It names the results' file, at its final path, if `error` concerns one; else
/// the folder.
OutputFailure problem(const fs::path& folder, const fs::filesystem_error& error,
                      const std::string& more = {}) {
  const std::string name = error.path1().filename().string();
  const bool of_results = std::ranges::find(file_names, name) != file_names.end();
  return OutputFailure(fmt::format("{}: cannot be replaced ({}){}",
                                   (of_results ? folder / name : folder).string(), error.code().message(),
                                   more));
}

/// Replaces the files of `folder` by those in `staging`, a folder inside it. Removes the `outdated` files of
/// the folder, and folders that this leaves empty. Throws OutputFailure; `folder` is then unchanged. If the
/// process is killed meanwhile, complete_publication() can finish the rest.
void replace_files(const fs::path& folder, const fs::path& staging,
                   const std::vector<std::string>& outdated) {
  std::vector<std::string> replaced;
  std::vector<Move> done;
  try {
    for (const char* name : std::views::reverse(file_names)) // the manifest first: absent while others change
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
    make_moves(folder, done);
  } catch (const fs::filesystem_error& error) {
    try {
      for (const Move& move : std::views::reverse(done))
        fs::rename(move.to, move.from);
    } catch (const fs::filesystem_error&) {
      throw problem(folder, error,
                    fmt::format("; the results are in {}; the next run in this folder moves them into place",
                                (folder / finished).string()));
    }
    throw problem(folder, error);
  }
  clear_finished(folder);
}

/// Finishes the publication of a process that was killed during it. Throws OutputFailure.
void complete_publication(const fs::path& folder) {
  try {
    if (fs::exists(folder / finished / list)) {
      std::vector<Move> done;
      make_moves(folder, done);
    }
  } catch (const fs::filesystem_error& error) {
    throw problem(folder, error);
  }
  clear_finished(folder);
}

} // namespace

bool is_drawn(const fs::path& file) { // by a mark: in a page the generator, in a picture the comment
  std::string start(1 << 16, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(in.gcount()));
  return start.find("signorini report") != std::string::npos;
}

std::error_code try_replace_file(const fs::path& file, std::string_view content) {
  fs::path partial = file;
  partial += ".partial";
  errno = 0;
  std::ofstream out(partial, std::ios::binary | std::ios::trunc);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  std::error_code error;
  if (out)
    fs::rename(partial, file, error);
  else
    error.assign(errno != 0 ? errno : EIO, std::generic_category());
  if (error) {
    std::error_code ignored;
    fs::remove(partial, ignored);
  }
  return error;
}

void replace_file(const fs::path& file, std::string_view content) {
  if (try_replace_file(file, content))
    throw OutputFailure(fmt::format("--out: {} cannot be written; choose another folder", file.string()));
}

void synchronise(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = file >= 0 && fsync(file) == 0;
  const std::error_code error(errno, std::generic_category());
  if (file >= 0)
    close(file);
  if (!done)
    throw fs::filesystem_error("", path, error);
}

bool OutputFolder::writes(std::string_view name) {
  return std::ranges::find(file_names, name) != file_names.end() || name == checkpoint ||
         name.starts_with(unfinished);
}

OutputFolder::OutputFolder(MPI_Comm comm, const fs::path& folder, std::string_view given)
    : comm_(comm), folder_(fs::absolute(folder)) {
  std::string staging;
  on_root(comm, [&] {
    lock_.emplace(folder);
    complete_publication(folder_);
    clear_unfinished(folder_);
    std::error_code error;
    for (const char* name : file_names)
      if (fs::is_directory(folder_ / name, error))
        throw UserError(fmt::format(
            "--out: {} is a folder, but this run writes a file of that name; move the folder, or choose "
            "another folder",
            (folder / name).string()));
    FolderLock::Names names(file_names.begin(), file_names.end());
    names.insert(names.end(), early_names.begin(), early_names.end());
    std::erase(names, given);
    lock_->claim(manifest, names, early_names);
    staging = (folder_ / (std::string(unfinished) + "XXXXXX")).string();
    if (!mkdtemp(staging.data())) {
      staging.clear();
      throw OutputFailure(fmt::format("--out: {} cannot be written ({}); choose another folder",
                                      folder.string(), std::generic_category().message(errno)));
    }
  });
  staging_ = broadcast(comm, staging);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored; // the run is ending, and what remains is harmless
  if (rank(comm_) == 0)
    fs::remove_all(staging_, ignored);
}

FolderLock::Names OutputFolder::files() const {
  FolderLock::Names found{manifest};
  std::error_code none;
  for (const char* name : file_names)
    if (name != manifest && fs::exists(staged(name), none))
      found.emplace_back(name);
  if (fs::exists(folder_ / checkpoint, none))
    found.emplace_back(checkpoint);
  return found;
}

double OutputFolder::bytes() const {
  double sum = 0;
  std::error_code none;
  for (const char* name : file_names)
    if (const auto size = fs::file_size(staged(name), none); rank(comm_) == 0 && !none)
      sum += static_cast<double>(size);
  return sum;
}

void OutputFolder::write(const std::string& name, const std::string& text) const {
  TextFile file(*this, name);
  file.append(text);
  file.close();
}

TextFile::TextFile(const OutputFolder& folder, const std::string& name) : folder_(folder), name_(name) {
  if (rank(folder.comm()) == 0)
    out_.open(folder.staged(name), std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
  error_ = out_ ? 0 : errno;
}

void TextFile::append(std::string_view text) {
  if (rank(folder_.comm()) != 0 || error_ != 0)
    return;
  errno = 0;
  size_ += static_cast<std::streamoff>(text.size());
  if (!(out_ << text))
    error_ = errno;
}

void TextFile::insert(std::streamoff at, std::string_view text) {
  if (rank(folder_.comm()) != 0 || error_ != 0)
    return;
  errno = 0;
  constexpr std::streamoff most = 1 << 20; // bytes moved at once, the last ones first
  const auto length = static_cast<std::streamoff>(text.size());
  std::string block;
  for (std::streamoff end = size_; out_ && end > at;) {
    const std::streamoff begin = std::max(at, end - most);
    block.resize(static_cast<std::size_t>(end - begin));
    out_.seekg(begin).read(block.data(), end - begin);
    out_.seekp(begin + length) << block;
    end = begin;
  }
  out_.seekp(at) << text;
  out_.seekp(0, std::ios::end);
  size_ += length;
  if (!out_)
    error_ = errno != 0 ? errno : EIO;
}

void TextFile::close() {
  on_root(folder_.comm(), [&] {
    errno = 0;
    out_.close();
    if (!out_)
      throw OutputFailure(fmt::format("{}: cannot be written ({})", (folder_.path() / name_).string(),
                                      std::generic_category().message(error_ != 0 ? error_ : errno)));
  });
}

void OutputFolder::require_no_search(const fs::path& given) const {
  on_root(comm_, [&] {
    std::error_code none;
    if (std::ranges::any_of(of_search, [&](const char* name) { return fs::exists(folder_ / name, none); }))
      throw UserError(
          fmt::format("--out: {0} has an optimum, whose history, control and adjoint this run would remove; "
                      "add --replace, or use another folder, such as --out {0}-simulate",
                      given.string()));
  });
}

std::vector<std::string> OutputFolder::publish() {
  MPI_Barrier(comm_); // all ranks have closed their files
  std::vector<std::string> outdated;
  on_root(comm_, [&] {
    outdated = drawings(folder_);
    replace_files(folder_, staging_, outdated);
  });
  return outdated;
}

} // namespace signorini::io
