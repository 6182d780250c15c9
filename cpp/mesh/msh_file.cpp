// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/msh_file.h"
#include "base/error.h"
#include "base/subprocess.h"
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>
#include <unistd.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace signorini::mesh {
namespace {

constexpr std::string_view blank = " \t\r";

std::string_view without_end_of_line(std::string_view line) {
  return line.substr(0, line.find_last_not_of(blank) + 1);
}

/// Throws UserError unless the file begins with $MeshFormat or with $Comments, which gmsh accepts before it.
void require_beginning(const std::string& file, std::string_view text) {
  constexpr std::array beginnings{std::string_view("$MeshFormat"), std::string_view("$Comments")};
  const std::string_view line = without_end_of_line(text.substr(0, text.find('\n')));
  if (std::ranges::find(beginnings, line) != beginnings.end())
    return;
  constexpr std::size_t shown = 40;
  std::string found;
  for (char c : line.substr(0, shown))
    found += ' ' <= c && c <= '~' ? c : '?';
  throw UserError(fmt::format("{}: not a .msh file of gmsh: {}; its first line must be $MeshFormat (convert "
                              "other files with gmsh or meshio)",
                              file,
                              text.empty() ? "found an empty file"
                                           : fmt::format("found \"{}{}\" on its first line", found,
                                                         line.size() > shown ? "..." : "")));
}

/// Throws UserError unless the last section of the file has its end, since gmsh may read a truncated file
/// without an error. Binary data may lack the final line end, and text may follow the last section.
void require_end(const std::string& file, std::string_view text) {
  const std::size_t end = text.rfind("$End");
  std::size_t begin = text.rfind("\n$");
  while (begin != std::string_view::npos && begin > 0 && begin + 2 < text.size() &&
         std::isalpha(static_cast<unsigned char>(text[begin + 2])) == 0) // no section's name, but data
    begin = text.rfind("\n$", begin - 1);
  if (end != std::string_view::npos && (begin == std::string_view::npos || begin < end))
    return;
  throw UserError(fmt::format(
      "{}: incomplete .msh file: the end of a section ($End...) is missing; write the file again", file));
}

/// Text that follows a heading such as $MeshFormat, at the place where a number is expected.
std::string behind(std::string_view heading, std::string_view text) {
  constexpr std::size_t longest = 20;
  const std::size_t at = text.find(heading);
  return at == std::string_view::npos ? "" : std::string(text.substr(at + heading.size(), longest));
}

MshFile::GroupNames names_in(std::string_view text) {
  MshFile::GroupNames names;
  const std::size_t begin = text.find("\n$PhysicalNames"), end = text.find("\n$EndPhysicalNames");
  if (begin == std::string_view::npos || end == std::string_view::npos || end < begin)
    return names;
  std::istringstream lines{std::string(text.substr(begin + 1, end - begin))};
  for (std::string line; std::getline(lines, line);) { // such as: 1 2 "bottom"
    const std::size_t first = line.find('"'), last = line.rfind('"');
    std::istringstream numbers(line.substr(0, first));
    int dim = 0, tag = 0;
    if (first != std::string::npos && first + 1 < last && numbers >> dim >> tag)
      names[{dim, tag}] = line.substr(first + 1, last - first - 1);
  }
  return names;
}

#ifdef __linux__
constexpr char descriptors[] = "/proc/self/fd";
int nameless_file() { return memfd_create("signorini-mesh", MFD_CLOEXEC); }
#else
constexpr char descriptors[] = "/dev/fd";
int nameless_file() {
  std::FILE* const file = std::tmpfile();
  const int copy = file ? dup(fileno(file)) : -1;
  if (file)
    std::fclose(file);
  return copy;
}
#endif

} // namespace

namespace {

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad())
    throw UserError(
        fmt::format("mesh.file: {} cannot be read; give the path of a mesh or a geometry", file.string()));
  return text;
}

} // namespace

MshFile::MshFile(const std::filesystem::path& file) : MshFile(file.string(), content(file)) {}

MshFile::MshFile(const std::string& name, const std::string& text) {
  require_beginning(name, text);
  require_end(name, text);
  version_ = std::strtod(behind("$MeshFormat", text).c_str(), nullptr);
  group_names_ = names_in(text);
  if (version_ < 3)
    elements_ = std::strtoull(behind("\n$Elements", text).c_str(), nullptr, 10);
  copy_ = nameless_file();
  if (copy_ < 0 || !write_all(copy_, text)) {
    const std::string reason = std::generic_category().message(errno);
    if (copy_ >= 0)
      close(copy_);
    throw UserError(fmt::format("{}: cannot be copied into memory ({}); use a smaller mesh", name, reason));
  }
  lseek(copy_, 0, SEEK_SET); // where opening a descriptor anew does not
  path_ = fmt::format("{}/{}", descriptors, copy_);
}

MshFile::~MshFile() { close(copy_); }

} // namespace signorini::mesh
