// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/mesh_info.h"
#include "app/scene_file.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/text.h"
#include "mesh/gmsh_process.h"
#include "mesh/statistics.h"
#include "scene/mesh_format.h"
#include <algorithm>
#include <fmt/format.h>
#include <string_view>

namespace signorini::app {

namespace {

/// The scene with nothing but a mesh that the keys mesh.* of `overrides` change.
scene::Mesh mesh_of(MPI_Comm comm, const std::filesystem::path& file,
                    const std::vector<std::string>& overrides) {
  bool sized = false;
  for (const std::string& one : overrides) {
    if (!one.starts_with("mesh."))
      throw UserError(fmt::format("--set: found \"{}\"; info of a mesh accepts keys of [mesh], such as "
                                  "mesh.unit=\"mm\"",
                                  one));
    sized |= one.starts_with("mesh.size");
  }
  const bool shape = scene::mesh_format(file) == scene::MeshFormat::shape;
  const std::string text = fmt::format("[mesh]\nfile = '''{}'''\n{}"
                                       "[time]\nend = 1.0\nstep = 1.0\n"
                                       "[material]\ndensity = 1.0\nyoung = 1.0\npoisson = 0.3\n",
                                       std::filesystem::absolute(file).string(), shape ? "size = 1.0\n" : "");
  scene::Mesh mesh = parse_scene(comm, text, file, overrides).mesh;
  if (shape && !sized)
    mesh.size = 0; // chosen from the size of the body
  return mesh;
}

void print_groups(const std::vector<mesh::Statistics::Group>& groups, const char* kind, const char* elements,
                  const char* measure, int dim, const char* unit, const Console& console) {
  std::size_t width = 0;
  for (const auto& group : groups)
    width = std::max(width, group.name.size());
  for (const auto& [name, count, size, centre, inside] : groups)
    console.line(count == 0 ? fmt::format("  {} group {:{}}  no elements", kind, name, width)
                            : fmt::format("  {} group {:{}}  {} {}{}, {} {:.4g} {}, centre {} m", kind, name,
                                          width, count, elements,
                                          inside == 0 ? "" : fmt::format(" ({} inside the body)", inside),
                                          measure, size, unit, point_text(centre.data(), dim)));
}

void print(const std::filesystem::path& file, const mesh::RawMesh& raw, const Console& console) {
  const mesh::Statistics all = mesh::statistics(raw);
  const bool plane = raw.dim == 2;
  const std::size_t cells = raw.cells.size() / static_cast<std::size_t>(raw.dim + 1);
  const char* word = plane ? "triangles" : "tetrahedra";
  console.line(fmt::format("{}: {} nodes, {} {}, in the box from {} to {} m", file.string(),
                           raw.points.size() / 3, cells, word, point_text(all.low.data(), raw.dim),
                           point_text(all.high.data(), raw.dim)));
  console.line(fmt::format("connected parts: {}", all.connected));
  console.line(fmt::format("edges: {:.4g} to {:.4g} m", all.shortest, all.longest));
  console.line(fmt::format("quality (ratio of the inscribed to the circumscribed radius, 1 for regular {}): "
                           "mean {:.2f}, least {:.2g}, {} below {}",
                           word, all.quality, all.least_quality, all.poor, mesh::Statistics::poor_quality));
  console.line("groups, for the keys \"on\" of a scene:");
  print_groups(all.cells, plane ? "surface" : "volume", word, plane ? "area" : "volume", raw.dim,
               plane ? "m²" : "m³", console);
  print_groups(all.facets, plane ? "curve" : "surface", plane ? "edges" : "triangles",
               plane ? "length" : "area", raw.dim, plane ? "m" : "m²", console);
  for (const auto& [dim, groups] : raw.unusable)
    for (const auto& [name, why] : groups)
      console.line(fmt::format("  the group {} cannot be used: it {}", name, why));
  for (const auto& [name, dim] : raw.other_groups)
    console.line(fmt::format("  the group {} cannot be used: its dimension is {}", name, dim));
  for (const std::string& note : raw.notes)
    console.line("note: " + note);
}

} // namespace

bool is_mesh(const std::filesystem::path& file) { return scene::mesh_format(file).has_value(); }

void print_mesh_info(MPI_Comm comm, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides, const Console& console) {
  const scene::Mesh mesh = mesh_of(comm, file, overrides);
  on_root(comm, [&] { print(file, mesh::read_gmsh(mesh), console); });
}

} // namespace signorini::app
