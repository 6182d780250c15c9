// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/fingerprint.h"
#include "base/digest.h"
#include "fem/forms.h"
#include "io/field_reader.h"
#include "io/manifest.h"
#include "scene/compatibility.h"
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace signorini::accuracy {
namespace {

/// Version of the measurements of a run; increase with every change of the measurements.
constexpr int measurement = 4;

constexpr const char *scene_part = "scene", *program = "program", *ranks_part = "number of ranks",
                     *options = "list of PETSc options", *mesh_file = "mesh file",
                     *desired_run = "run that objective.desired.run names",
                     *series = "content of a time series",
                     *first_guess = "run that control.initial.run names", *forms = "set of compiled forms",
                     *search_method = "method of the search",
                     *sample_points = "set of points where fields are compared";

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Digest of a file. Reads the file in blocks, since a stored run may be larger than the memory.
std::string digest(const std::filesystem::path& file) {
  constexpr std::size_t size = 1 << 20;
  std::ifstream in(file, std::ios::binary);
  Digest digest;
  for (std::string piece(size, '\0'); in.read(piece.data(), size) || in.gcount() > 0;)
    digest.add(std::string_view(piece).substr(0, static_cast<std::size_t>(in.gcount())));
  return digest.text();
}

/// Adds a .geo file and, recursively, all existing files that it names in quotes, as Include and Merge do.
void add_with_included(const std::filesystem::path& file, std::set<std::filesystem::path>& seen,
                       Digest& digest) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) ||
      !seen.insert(std::filesystem::weakly_canonical(file, error)).second)
    return;
  const std::string text = content(file);
  digest.add(text);
  if (scene::mesh_format(file).value_or(scene::MeshFormat::script) != scene::MeshFormat::script)
    return;
  constexpr std::size_t longest = 1024; // of a name; unmatched quotes are mostly further apart
  for (std::size_t open = text.find('"'); open != std::string::npos;) {
    const std::size_t close = text.find('"', open + 1);
    if (close == std::string::npos)
      return;
    const std::string name = text.substr(open + 1, std::min(close - open - 1, longest));
    if (!name.empty() && name.find_first_of(std::string_view("\n\0", 2)) == std::string::npos)
      add_with_included(file.parent_path() / name, seen, digest);
    open = text.find('"', name.find('\n') == std::string::npos ? close + 1 : close);
  }
}

std::string mesh_digest(const std::filesystem::path& file) {
  Digest digest;
  std::set<std::filesystem::path> seen;
  add_with_included(file, seen, digest);
  add_with_included(file.string() + ".opt", seen, digest); // gmsh reads it if it exists
  return digest.text();
}

/// All PETSc options, from the command line, PETSC_OPTIONS and .petscrc.
std::string petsc_options() {
  char* all = nullptr;
  petsc::check(PetscOptionsGetAll(nullptr, &all));
  std::string text = all;
  petsc::check(PetscFree(all));
  constexpr std::string_view own = "-options_left 0"; // set by main()
  if (const std::size_t at = text.find(own); at != std::string::npos)
    text.erase(at, own.size());
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

} // namespace

Fingerprint inputs(const scene::Scene& scene) {
  Fingerprint all;
  all[program] = fmt::format("{} with measurement {}", io::versions().dump(), measurement);
  all[options] = petsc_options();
  all[mesh_file] = mesh_digest(scene.mesh.file);
  if (!scene.digest_of_series.empty())
    all[series] = scene.digest_of_series;
  if (scene.control && scene.control->stored)
    all[first_guess] = digest(scene.control->stored->folder / "checkpoint.h5") +
                       digest(io::fields_file(scene.control->stored->folder, "control"));
  if (scene.objective)
    if (const auto* run = std::get_if<scene::DesiredRun>(&scene.objective->desired))
      all[desired_run] = digest(io::fields_file(run->folder, "state"));
  return all;
}

Origin::Origin(const scene::Scene& scene, const SamplePoints& samples, int ranks)
    : scene_(scene), dim_(samples.dim), common_(inputs(scene)) {
  common_[ranks_part] = std::to_string(ranks); // for seconds and memory
  common_[sample_points] = samples.digest;
}

Fingerprint Origin::of(const Rung& rung) const {
  Fingerprint all = common_;
  all[scene_part] = scene::echo(on_rung(scene_, rung), dim_);
  if (rung.graded)
    all[mesh_file] = mesh_digest(scene_.mesh.graded);
  all[forms] =
      fem::forms_digest(dim_, rung.degree, scene_.mesh.model.value_or(scene::PlaneModel::plane_strain));
  return all;
}

Fingerprint Origin::of_search() const {
  Fingerprint all = of(own_rung(scene_));
  const scene::Optimizer& search = scene_.optimizer;
  all[search_method] = fmt::format("{} from {}, {} iterations, {} bytes", scene::name(search.method),
                                   scene::name(*search.start), search.max_iterations, search.memory);
  return all;
}

std::string difference(const Fingerprint& kept, const Fingerprint& now) {
  const auto part = [](const Fingerprint& all, const std::string& name) {
    const auto found = all.find(name);
    return found == all.end() ? "" : found->second;
  };
  for (const Fingerprint* all : {&now, &kept})
    for (const auto& [name, value] : *all) {
      const std::string before = part(kept, name), after = part(now, name);
      if (before == after)
        continue;
      if (name == scene_part) {
        if (const auto [had, has] = scene::difference(before, after, scene::Part::measurement); had != has)
          return fmt::format("the scene had {}, and now has {}", had, has);
        continue;
      }
      if (name == program || name == ranks_part || name == options)
        return fmt::format("the {} was \"{}\", and now is \"{}\"", name, before, after);
      return fmt::format("the {} has changed", name);
    }
  return {};
}

} // namespace signorini::accuracy
