#include "io/output_folder.h"
#include "base/collective.h"
#include <array>
#include <fmt/format.h>

namespace signorini::io {
namespace fs = std::filesystem;

namespace {

/// The fixed names of a run's files, data before the files that refer to them.
constexpr std::array file_names{"state.h5",     "control.h5",   "adjoint.h5", "state.xdmf",
                                "control.xdmf", "adjoint.xdmf", "steps.csv",  "contact.csv",
                                "history.csv",  "scene.toml",   "run.json"};

constexpr const char* unfinished = ".unfinished-";

} // namespace

OutputFolder::OutputFolder(MPI_Comm comm, const fs::path& folder)
    : comm_(comm), folder_(fs::absolute(folder)) {
  std::string staging;
  on_root(comm, [&] {
    std::error_code error;
    for (fs::path missing = folder_; !fs::exists(missing, error) && missing.has_relative_path();
         missing = missing.parent_path())
      made_.push_back(missing);
    for (const char* name : file_names)
      if (fs::is_directory(folder_ / name, error))
        throw UserError(
            fmt::format("--out: {} is a folder and in the way of a file of this run, allowed is a folder "
                        "without it",
                        (folder / name).string()));
    fs::create_directories(folder_, error);
    staging = (folder_ / (std::string(unfinished) + "XXXXXX")).string();
    if (error || !mkdtemp(staging.data()))
      throw UserError(fmt::format("--out: {} cannot be written ({}), allowed is a folder that can",
                                  folder.string(),
                                  error ? error.message() : std::generic_category().message(errno)));
  });
  staging_ = broadcast(comm, staging);
}

OutputFolder::~OutputFolder() {
  if (rank(comm_) == 0)
    discard();
}

void OutputFolder::clear_unfinished() const {
  if (rank(comm_) != 0)
    return;
  std::error_code ignored; // they are in nobody's way
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored))
    if (entry.path().filename().string().starts_with(unfinished) && entry.path() != staging_)
      fs::remove_all(entry.path(), ignored);
}

void OutputFolder::discard() const {
  std::error_code ignored; // the run ends anyhow, and has nobody to tell
  fs::remove_all(staging_, ignored);
  for (const fs::path& folder : made_) // goes through only where nothing was published
    fs::remove(folder, ignored);
}

void OutputFolder::write(const std::string& name, const std::string& text) const {
  TextFile file(*this, name);
  file.append(text);
  file.close();
}

TextFile::TextFile(const OutputFolder& folder, const std::string& name) : folder_(folder), name_(name) {
  if (rank(folder.comm()) == 0)
    out_.open(folder.staged(name), std::ios::binary);
  error_ = out_ ? 0 : errno;
}

void TextFile::append(std::string_view text) {
  if (rank(folder_.comm()) != 0 || error_ != 0)
    return;
  errno = 0;
  if (!(out_ << text))
    error_ = errno;
}

void TextFile::close() {
  on_root(folder_.comm(), [&] {
    errno = 0;
    out_.close();
    if (!out_)
      throw UserError(fmt::format("{}: cannot be written ({})", (folder_.path() / name_).string(),
                                  std::generic_category().message(error_ != 0 ? error_ : errno)));
  });
}

void OutputFolder::publish() {
  MPI_Barrier(comm_); // all ranks have closed their files
  on_root(comm_, [&] {
    for (const char* name : file_names) {
      std::error_code error;
      if (fs::exists(staged(name)))
        fs::rename(staged(name), folder_ / name, error);
      else
        fs::remove(folder_ / name, error);
      if (error)
        throw UserError(
            fmt::format("{}: cannot be replaced ({})", (folder_ / name).string(), error.message()));
    }
  });
}

} // namespace signorini::io
