// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/field_reader.h"
#include "base/collective.h"
#include "base/hdf5.h"
#include "io/point_match.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

namespace signorini::io {
using petsc::check;

namespace {

/// Reads all values of a dataset, row by row; empty if the dataset cannot be read.
template <class T>
std::vector<T> values(hid_t dataset) {
  std::vector<T> all;
  if (!read_whole(dataset, all))
    all.clear();
  return all;
}

/// Names of a group's members, ascending. Stops at the first name that cannot be read.
std::vector<std::string> names_of(hid_t group) {
  H5G_info_t info{};
  std::vector<std::string> names;
  for (hsize_t i = 0; H5Gget_info(group, &info) >= 0 && i < info.nlinks; ++i) {
    std::array<char, 64> name{};
    if (H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT) <
        0)
      break;
    names.emplace_back(name.data());
  }
  return names;
}

bool finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
}

/// Times (s, ascending) and names of the datasets of a field; empty if the file is not in the format of a
/// run.
std::vector<std::pair<double, std::string>> times_of(hid_t file, hid_t group) {
  const std::vector<std::string> names = names_of(group);
  const Hdf5Handle list(H5Dopen(file, "/times", H5P_DEFAULT), H5Dclose);
  const std::vector<double> listed = list ? values<double>(list) : std::vector<double>();
  if (listed.size() != names.size() || !finite(listed) || !std::ranges::is_sorted(listed))
    return {};
  std::vector<std::pair<double, std::string>> times;
  for (std::size_t i = 0; i < names.size(); ++i)
    times.emplace_back(listed[i], names[i]);
  return times;
}

} // namespace

std::filesystem::path fields_file(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path data = folder / (name + ".h5"), whole = folder / (name + ".vtkhdf");
  std::error_code none;
  return !std::filesystem::exists(data, none) && std::filesystem::exists(whole, none) ? whole : data;
}

StoredField::StoredField(const fem::Space& space, const std::filesystem::path& file, const std::string& field,
                         const std::string& key, double end, bool at_start)
    : space_(space), file_(file), field_(field), key_(key),
      nodes_(static_cast<std::size_t>(space.dofs() / space.dim()) - space.layout().virtual_nodes().size()) {
  if (space.degree() > 1)
    fail(fmt::format("found mesh.degree = {}; set it to 1, since fields are stored at the mesh's own nodes",
                     space.degree()));
  std::vector<double> points;
  on_root(space.comm(), [&] { look(end, at_start, points); });
  times_ = broadcast(space.comm(), times_);
  rows_ = match_points(space, broadcast(space.comm(), points), distinct_points(space),
                       [this](const std::string& problem) { fail(problem); });
}

void StoredField::fail(const std::string& problem) const {
  throw UserError(fmt::format("{}: {}: {}", key_, file_.string(), problem));
}

void StoredField::look(double end, bool at_start, std::vector<double>& points) {
  if (!std::filesystem::is_regular_file(file_))
    fail(fmt::format("no such file; name the folder of an earlier run that stored \"{}\"", field_));
  const std::string damaged = "the file is damaged, or was not written by a run; use an undamaged file";
  const Hdf5Handle file = open_hdf5(file_);
  if (!file)
    fail(damaged);
  const Hdf5Handle geometry(H5Dopen(file, "/Mesh/mesh/geometry", H5P_DEFAULT), H5Dclose);
  if (!geometry)
    fail(damaged);
  const auto [rows, columns] = shape(geometry);
  if (rows != nodes_ || columns != static_cast<hsize_t>(space_.dim()))
    fail(fmt::format(
        "found a mesh of {} nodes in {} dimensions; expected the mesh of this scene, of {} nodes in {}", rows,
        columns, nodes_, space_.dim()));
  points = values<double>(geometry);
  if (points.empty() || !finite(points))
    fail(damaged);
  const Hdf5Handle topology(H5Dopen(file, "/Mesh/mesh/topology", H5P_DEFAULT), H5Dclose);
  if (!separate(points, topology ? values<std::int64_t>(topology) : std::vector<std::int64_t>(), space_))
    fail(damaged);
  const Hdf5Handle group(H5Gopen(file, ("/Function/" + field_).c_str(), H5P_DEFAULT), H5Gclose);
  if (!group)
    fail(fmt::format("found no field \"{}\"; use a run whose output.fields contains this field", field_));
  for (const auto& [time, name] : times_of(file, group)) {
    times_.push_back(time);
    names_.push_back(name);
  }
  if (times_.empty())
    fail(damaged);
  constexpr double rounding = 1e-9;
  if ((at_start && times_.front() > rounding * end) || times_.back() < (1 - rounding) * end)
    fail(fmt::format(
        "found \"{}\" from {:.6g} to {:.6g} s; use a run that covers this one, from 0 to {:.6g} s", field_,
        times_.front(), times_.back(), end));
}

Vec StoredField::stored(std::size_t number) {
  if (const auto known = std::ranges::find(kept_, number, &Stored::number); known != kept_.end()) {
    std::rotate(known, known + 1, kept_.end()); // the first of two equally distant ones is replaced
    return kept_.back().values;
  }
  constexpr std::size_t padded = 3; // vectors in an XDMF file have three components
  std::vector<double> all;
  on_root(space_.comm(), [&] {
    const Hdf5Handle file = open_hdf5(file_);
    const Hdf5Handle dataset(
        file ? H5Dopen(file, ("/Function/" + field_ + "/" + names_[number]).c_str(), H5P_DEFAULT)
             : H5I_INVALID_HID,
        H5Dclose);
    if (dataset && shape(dataset) == std::array<hsize_t, 2>{nodes_, padded})
      all = values<double>(dataset);
    if (all.empty() || !finite(all))
      fail(fmt::format("\"{}\" at {:.6g} s is damaged; expected {} finite vectors", field_, times_[number],
                       nodes_));
  });
  all = broadcast(space_.comm(), all);
  if (kept_.size() == 2) { // replace the farther one, for times in either direction
    const auto distance = [number](const Stored& one) {
      return one.number > number ? one.number - number : number - one.number;
    };
    kept_.erase(std::ranges::max_element(kept_, {}, distance));
  }
  kept_.push_back({number, space_.vector()});
  const petsc::WriteArray out(kept_.back().values);
  const auto dim = static_cast<std::size_t>(space_.dim());
  for (std::size_t node = 0; node < rows_.size(); ++node)
    for (std::size_t c = 0; c < dim; ++c)
      out[node * dim + c] = all[rows_[node] * padded + c];
  return kept_.back().values;
}

void StoredField::at(double t, Vec out) {
  if (times_.size() == 1) { // stored for a single step
    check(VecCopy(stored(0), out));
    return;
  }
  const auto above = static_cast<std::size_t>(std::ranges::lower_bound(times_, t) - times_.begin());
  const std::size_t second = std::clamp<std::size_t>(above, 1, times_.size() - 1), first = second - 1;
  const double weight = (t - times_[first]) / (times_[second] - times_[first]);
  constexpr double rounding = 1e-7; // relative; this near, the stored field is returned as it is
  if (weight < rounding) {
    check(VecCopy(stored(first), out));
  } else if (weight > 1 - rounding) {
    check(VecCopy(stored(second), out));
  } else {
    const Vec from = stored(first), to = stored(second);
    petsc::combine(out, 1 - weight, from, weight, to);
  }
}

} // namespace signorini::io
