// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/text.h"
#include "mesh/gmsh_cells.h"
#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <gmsh.h>
#include <sstream>
#include <string_view>

namespace signorini::mesh {
namespace {

struct PhysicalGroup {
  int dim, tag;
  std::vector<int> entities;
};

/// Adds the physical groups of gmsh's current model to a mesh of its cells.
class Grouping {
public:
  Grouping(const GmshCells& cells, const MshFile::GroupNames& names)
      : cells_(cells), names_(names), raw_(cells.raw()) {}

  RawMesh run() {
    collect_groups();
    name_untagged();
    return std::move(raw_);
  }

private:
  [[nodiscard]] std::vector<PhysicalGroup> physical_groups() const {
    std::vector<PhysicalGroup> groups;
    for (const auto& [group, entities] : cells_.entities_of())
      groups.push_back({group.first, group.second, entities});
    if (cells_.entities_are_groups())
      return groups;
    gmsh::vectorpair found;
    gmsh::model::getPhysicalGroups(found);
    for (const auto& [dim, tag] : found) {
      PhysicalGroup& group = groups.emplace_back();
      group.dim = dim, group.tag = tag;
      gmsh::model::getEntitiesForPhysicalGroup(dim, tag, group.entities);
    }
    return groups;
  }

  /// Name of a group, and whether this name is only the group's number.
  [[nodiscard]] std::pair<std::string, bool> name_of(int dim, int tag) const {
    std::string name;
    if (const auto found = names_.find({dim, tag}); found != names_.end())
      name = found->second;
    else
      gmsh::model::getPhysicalName(dim, tag, name);
    return name.empty() ? std::pair{std::to_string(tag), true} : std::pair{name, false};
  }

  void collect_groups() {
    std::map<std::pair<int, std::string>, bool> numbers; // whether a name is the number of a group without
    for (const PhysicalGroup& group : physical_groups()) {
      const auto [name, number] = name_of(group.dim, group.tag);
      if (numbers.try_emplace({group.dim, name}, number).first->second != number)
        raw_.unusable[group.dim][name] =
            "cannot be distinguished from the unnamed group with this number; give the unnamed group a name";
      if (group.dim == raw_.dim)
        add_part(name, group);
      else if (group.dim == raw_.dim - 1)
        add_facets(name, group);
      else
        raw_.other_groups[name] = group.dim;
    }
    find_incomplete_groups();
    for (auto& [name, cells] : part_rows_)
      raw_.parts[name] = ranges(cells);
    for (const auto& [name, reason] : raw_.unusable[raw_.dim])
      raw_.parts.erase(name);
    for (const auto& [name, reason] : raw_.unusable[raw_.dim - 1])
      raw_.facets.erase(name);
  }

  /// Marks groups as unusable whose entities gmsh has skipped: entities that the .geo never draws, or that a
  /// boolean operation has removed.
  void find_incomplete_groups() {
    std::vector<std::string> log;
    gmsh::logger::get(log);
    constexpr std::string_view skipping = "Skipping unknown ";
    for (const std::string& line : log) {
      const std::size_t at = line.find(skipping);
      if (at == std::string::npos) // curve 9 in physical curve 2
        continue;
      std::istringstream words(line.substr(at + skipping.size()));
      std::string what, in, physical, group;
      int entity = 0, tag = 0;
      words >> what >> entity >> in >> physical >> group >> tag;
      for (int dim = raw_.dim - 1; words && dim <= raw_.dim; ++dim)
        if (group == entity_kind(dim))
          raw_.unusable[dim][name_of(dim, tag).first] = fmt::format(
              "lists {} {}, which does not exist, or no longer after boolean operations; correct the list",
              what, entity);
    }
  }

  void add_part(const std::string& name, const PhysicalGroup& group) {
    std::vector<std::int64_t>& cells = part_rows_[name];
    for (int entity : group.entities) {
      const std::span<const std::int64_t> rows = cells_.rows_of_entity(entity);
      cells.insert(cells.end(), rows.begin(), rows.end());
    }
  }

  /// Sorts `rows` and returns its runs of consecutive rows: for each run the first row and the last row + 1.
  static std::vector<std::int64_t> ranges(std::vector<std::int64_t>& rows) {
    std::ranges::sort(rows);
    std::vector<std::int64_t> found;
    for (const std::int64_t row : rows)
      if (!found.empty() && row <= found.back())
        found.back() = row + 1;
      else
        found.insert(found.end(), {row, row + 1});
    return found;
  }

  /// Adds a group of facets. If the group has elements that are not facets of cells, for example a drawn
  /// floor, it is marked as unusable, which is an error only if the scene names the group.
  void add_facets(const std::string& name, const PhysicalGroup& group) {
    const Words& word = words(raw_.dim);
    std::vector<std::int64_t>& facets = raw_.facets[name];
    for (int entity : group.entities) {
      const auto [tags, refused] = cells_.read_facets(entity);
      if (!refused.empty()) {
        raw_.unusable[group.dim][name] =
            fmt::format("has elements of type \"{}\", not {}; set mesh.split = true, which divides them",
                        refused, word.straight_facets);
        return;
      }
      std::ranges::for_each(tags, [&](std::int64_t tag) { cells_.require_node(tag); });
      for (std::size_t i = 0; i < tags.size(); i += raw_.dim) {
        const std::span own(&tags[i], raw_.dim);
        if (!std::ranges::all_of(own, [&](std::int64_t tag) { return cells_.has(tag); }) ||
            !is_facet(cells_.rows_of({own.begin(), own.end()}))) {
          raw_.unusable[group.dim][name] = fmt::format(
              "contains the {} at {}, which belongs to no {}; choose a group in which all {} belong to {}",
              word.facet, point_text(cells_.coordinates(own[0]).data(), raw_.dim), word.cell, word.facets,
              word.cells);
          return;
        }
      }
      const std::vector<std::int64_t> rows = cells_.rows_of(tags);
      facets.insert(facets.end(), rows.begin(), rows.end());
    }
    bounded_ |= !facets.empty();
  }

  [[nodiscard]] bool is_facet(const std::vector<std::int64_t>& nodes) const {
    return std::ranges::binary_search(cells_.facets(), sorted_nodes(nodes), {}, &Facet::nodes);
  }

  /// Adds the group "body" of all cells if no cell is in a group, and "boundary" if no facet of the body is.
  /// Throws UserError if some cells, but not all, are in a group.
  void name_untagged() {
    const std::size_t count = raw_.cells.size() / (raw_.dim + 1);
    std::vector<bool> grouped(count);
    for (const auto& [name, rows] : part_rows_)
      for (const std::int64_t row : rows)
        grouped[row] = true;
    const auto tagged = static_cast<std::size_t>(std::ranges::count(grouped, true));
    if (0 < tagged && tagged < count)
      fail_ungrouped(grouped);
    const auto taken = [&](const char* name) {
      return raw_.parts.contains(name) || raw_.facets.contains(name);
    };
    if (tagged == 0 && !taken("body")) {
      raw_.parts["body"] = {0, static_cast<std::int64_t>(count)};
      raw_.notes.push_back(fmt::format("no {} of the mesh is in a physical group; all are the group \"body\"",
                                       words(raw_.dim).cell));
    }
    if (!bounded_ && !taken("boundary")) {
      std::vector<std::int64_t>& nodes = raw_.facets["boundary"];
      for (const Facet& facet : outer_facets(cells_.facets()))
        nodes.insert(nodes.end(), facet.nodes.begin(), facet.nodes.begin() + raw_.dim);
      raw_.notes.push_back(fmt::format(
          "no {} of the body is in a physical group; its whole boundary is the group \"boundary\"",
          words(raw_.dim).facet));
    }
  }

  [[noreturn]] void fail_ungrouped(const std::vector<bool>& grouped) const {
    const Words& word = words(raw_.dim);
    for (const int entity : cells_.entities()) {
      const auto bare = std::ranges::count_if(cells_.rows_of_entity(entity),
                                              [&](std::int64_t row) { return !grouped[row]; });
      if (bare == 0)
        continue;
      std::vector<int> numbers{entity};
      if (cells_.entities_are_groups()) // then this is its number, or the first of several entities'
        gmsh::model::getPhysicalGroupsForEntity(raw_.dim, entity, numbers);
      const int number = numbers.empty() ? entity : numbers.front();
      cells_.fail(fmt::format("{0} {1} has {2} {3} in no physical group, although other {5} are in one. Add "
                              "the {0} to a group, as by Physical {4}(\"body\") = {{{1}}};, or delete it",
                              entity_kind(raw_.dim), number, bare, bare == 1 ? word.cell : word.cells,
                              word.body_kind, word.cells));
    }
    std::abort(); // some range has that cell
  }

  const GmshCells& cells_;
  const MshFile::GroupNames& names_;
  RawMesh raw_;
  std::map<std::string, std::vector<std::int64_t>> part_rows_;
  bool bounded_ = false; ///< whether some group contains facets of cells
};

} // namespace

RawMesh with_groups(const GmshCells& cells, const MshFile::GroupNames& names) {
  return Grouping(cells, names).run();
}

} // namespace signorini::mesh
