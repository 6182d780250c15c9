// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/output_folder.h"
#include "io/output_failure.h"
#include "io/publication.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <fmt/format.h>

namespace signorini::io {
namespace fs = std::filesystem;

namespace {

/// The fixed names of a run's files, data before the files that refer to them.
constexpr std::array file_names{
    "mesh.msh",     "indicators.csv", "state.h5",         "control.h5",  "adjoint.h5",    "state.xdmf",
    "control.xdmf", "adjoint.xdmf",   "steps.csv",        "contact.csv", "obstacles.csv", "probes.csv",
    "history.csv",  "parameters.csv", "measurements.csv", "scene.toml",  "run.json"};

constexpr const char *manifest = file_names.back(), *unfinished = ".unfinished-";

/// The checkpoint of a search; it stays until another one replaces it.
constexpr const char* checkpoint = "checkpoint.h5";

/// Files that a search puts in place before its end.
const FolderLock::Names early_names{"history.csv", checkpoint};

/// Files that only a search leaves.
constexpr std::array of_search{"history.csv",  "parameters.csv", "measurements.csv", "control.h5",
                               "control.xdmf", "adjoint.h5",     "adjoint.xdmf"};

/// Whether postprocess/ made a file: it says so near its beginning, a page in
/// <meta name="generator" content="signorini report">, a picture in its comment.
bool drawn(const fs::path& file) {
  std::string start(1 << 16, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(in.gcount()));
  return start.find("signorini report") != std::string::npos;
}

/// The pages and the figures of an earlier run, by their paths within the folder.
std::vector<std::string> drawings(const fs::path& folder) {
  std::vector<std::string> found;
  std::error_code none;
  for (const char* page : {"report.html", "comparison.html"})
    if (fs::is_regular_file(folder / page, none) && drawn(folder / page))
      found.emplace_back(page);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "figures", none))
    if (entry.is_regular_file(none) && drawn(entry.path()))
      found.push_back("figures/" + entry.path().filename().string());
  return found;
}

/// Removes the half-written files of runs that were killed.
void clear_unfinished(const fs::path& folder) {
  std::error_code ignored; // what remains is harmless
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with(unfinished))
      fs::remove_all(entry.path(), ignored);
}

} // namespace

bool OutputFolder::writes(std::string_view name) {
  return std::ranges::find(file_names, name) != file_names.end() || name == checkpoint ||
         name.starts_with(unfinished);
}

OutputFolder::OutputFolder(MPI_Comm comm, const fs::path& folder, std::string_view given)
    : comm_(comm), folder_(fs::absolute(folder)) {
  std::string staging;
  write_on_root(comm, [&] {
    lock_.emplace(folder);
    complete_publication(folder_, file_names);
    clear_unfinished(folder_);
    std::error_code error;
    for (const char* name : file_names)
      if (fs::is_directory(folder_ / name, error))
        throw UserError(
            fmt::format("--out: {} is a folder and in the way of a file of this run, allowed is a folder "
                        "without it",
                        (folder / name).string()));
    FolderLock::Names names(file_names.begin(), file_names.end());
    names.insert(names.end(), early_names.begin(), early_names.end());
    std::erase(names, given);
    lock_->claim(manifest, names, early_names);
    staging = (folder_ / (std::string(unfinished) + "XXXXXX")).string();
    if (!mkdtemp(staging.data())) {
      staging.clear();
      throw OutputFailure(fmt::format("--out: {} cannot be written ({}), allowed is a folder that can",
                                      folder.string(), std::generic_category().message(errno)));
    }
  });
  staging_ = broadcast(comm, staging);
}

OutputFolder::~OutputFolder() {
  if (rank(comm_) == 0)
    discard();
}

void OutputFolder::discard() const {
  std::error_code ignored; // the run is ending, and what remains is harmless
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
  write_on_root(folder_.comm(), [&] {
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
          fmt::format("--out: found an optimum in {0}, whose history, control and adjoint this run would "
                      "remove, allowed are "
                      "--replace, which removes them, and another folder, such as --out {0}-simulate",
                      given.string()));
  });
}

std::vector<std::string> OutputFolder::publish() {
  MPI_Barrier(comm_); // all ranks have closed their files
  std::vector<std::string> outdated;
  write_on_root(comm_, [&] {
    outdated = drawings(folder_);
    io::publish(folder_, staging_, file_names, outdated);
  });
  return outdated;
}

} // namespace signorini::io
