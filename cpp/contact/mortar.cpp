// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/mortar.h"
#include "base/dolfinx_versions.h"
#include "base/error.h"
#include "base/text.h"
#include "linalg/dense.h"
#include <algorithm>
#include <basix/quadrature.h>
#include <cmath>
#include <dolfinx/geometry/utils.h>
#include <fmt/format.h>
#include <map>
#include <numbers>

namespace signorini::contact {

namespace {

using Point = std::array<double, 3>;
using Plane = std::array<double, 2>; ///< coordinates across ν; in the plane the second one is 0

/// Least cosine between a facet's normal and ν with which they count as facing.
constexpr double least_cosine = 0.05;
/// Part of a facet below which a covered part is left out: its dual functions would be rounding errors.
constexpr double sliver = 1e-6;

/// Facet that is projected along ν.
struct Projected {
  std::array<Plane, 3> corners; ///< dim corners
  std::array<double, 3> level;  ///< their coordinates along ν, m
};

/// Coordinates across and along a direction ν.
class Projection {
public:
  Projection(const Point& nu, int dim) : dim_(static_cast<std::size_t>(dim)), nu_(nu) {
    if (dim == 2) {
      across_ = {Point{-nu[1], nu[0], 0}, Point{}};
      return;
    }
    std::size_t least = 0;
    for (std::size_t c = 1; c < 3; ++c)
      if (std::abs(nu[c]) < std::abs(nu[least]))
        least = c;
    Point first{};
    for (std::size_t c = 0; c < 3; ++c)
      first[c] = (c == least) - nu[least] * nu[c];
    const double length = std::sqrt(dot(first, first));
    for (double& component : first)
      component /= length;
    across_ = {first, Point{nu[1] * first[2] - nu[2] * first[1], nu[2] * first[0] - nu[0] * first[2],
                            nu[0] * first[1] - nu[1] * first[0]}};
  }

  [[nodiscard]] Projected operator()(const fem::SurfaceMesh& surface,
                                     const fem::SurfaceMesh::Facet& facet) const {
    Projected made{};
    for (std::size_t corner = 0; corner < dim_; ++corner) {
      const Point& x = surface.vertices[static_cast<std::size_t>(facet.vertices[corner])].x;
      made.corners[corner] = {dot(x, across_[0]), dot(x, across_[1])};
      made.level[corner] = dot(x, nu_);
    }
    return made;
  }

private:
  std::size_t dim_;
  Point nu_;
  std::array<Point, 2> across_{};
};

double orientation(const Plane& a, const Plane& b, const Plane& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Length or area of a projected simplex; negative if its corners are clockwise.
double measure(const std::array<Plane, 3>& corners, int dim) {
  return dim == 2 ? corners[1][0] - corners[0][0] : orientation(corners[0], corners[1], corners[2]) / 2;
}

/// Barycentric coordinates of x in a projected facet.
std::array<double, 3> barycentric(const std::array<Plane, 3>& corners, const Plane& x, int dim) {
  if (dim == 2) {
    const double s = (x[0] - corners[0][0]) / (corners[1][0] - corners[0][0]);
    return {1 - s, s, 0};
  }
  const double whole = orientation(corners[0], corners[1], corners[2]),
               second = orientation(corners[0], x, corners[2]) / whole,
               third = orientation(corners[0], corners[1], x) / whole;
  return {1 - second - third, second, third};
}

/// Intersection of two projected facets, as simplices of positive measure.
std::vector<std::array<Plane, 3>> intersection(std::array<Plane, 3> a, std::array<Plane, 3> b, int dim) {
  for (std::array<Plane, 3>* facet : {&a, &b})
    if (measure(*facet, dim) < 0)
      std::swap((*facet)[0], (*facet)[1]);
  if (dim == 2) {
    const double begin = std::max(a[0][0], b[0][0]), end = std::min(a[1][0], b[1][0]);
    if (end > begin)
      return {{Plane{begin, 0}, Plane{end, 0}, Plane{}}};
    return {};
  }
  std::vector<Plane> polygon(a.begin(), a.end()), cut; // by Sutherland and Hodgman
  for (std::size_t edge = 0; edge < 3 && !polygon.empty(); ++edge) {
    const Plane &from = b[edge], &to = b[(edge + 1) % 3];
    cut.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Plane &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
      const double side = orientation(from, to, here), next_side = orientation(from, to, next);
      if (side >= 0)
        cut.push_back(here);
      if (side * next_side < 0) {
        const double s = side / (side - next_side);
        cut.push_back({here[0] + s * (next[0] - here[0]), here[1] + s * (next[1] - here[1])});
      }
    }
    std::swap(polygon, cut);
  }
  std::vector<std::array<Plane, 3>> parts;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    if (const std::array<Plane, 3> part{polygon[0], polygon[i - 1], polygon[i]}; measure(part, dim) > 0)
      parts.push_back(part);
  return parts;
}

/// Quadrature on a simplex of dimension dim − 1, exact for polynomials of degree 3: reference points (points
/// × (dim − 1)) and weights whose sum is 1.
struct Rule {
  std::vector<double> points, weights;
};

Rule rule(int dim) {
  constexpr int degree = 3; // products of two hat functions and the radius
  auto [points, weights] = basix::quadrature::make_quadrature<double>(
      basix::quadrature::type::Default, dim == 2 ? basix::cell::type::interval : basix::cell::type::triangle,
      basix::polyset::type::standard, degree);
  double sum = 0;
  for (const double weight : weights)
    sum += weight;
  for (double& weight : weights)
    weight /= sum;
  return {std::move(points), std::move(weights)};
}

/// Point of the covered part of a slave facet, with hat functions of both sides.
struct Sample {
  double weight;                        ///< of the integral over the slave facet, m or m²
  std::array<double, 3> slave;          ///< hat functions of the slave facet
  std::array<double, 3> master;         ///< hat functions of the master facet
  const fem::SurfaceMesh::Facet* facet; ///< master facet
};

/// Values of the dual function of corner `own` at the samples of a facet, and ∫ φ_own over them.
struct Dual {
  std::vector<double> values;
  double area = 0;
};

/// Orthogonalises φ_own to the other hat functions, and scales it so that ∫ ψ φ_own = ∫ φ_own.
Dual dual_function(const std::vector<Sample>& samples, std::size_t own, std::size_t corners) {
  const auto product = [&](const std::vector<double>& f, const std::vector<double>& g) {
    double sum = 0;
    for (std::size_t q = 0; q < samples.size(); ++q)
      sum += samples[q].weight * f[q] * g[q];
    return sum;
  };
  const auto hat = [&](std::size_t corner) {
    std::vector<double> values;
    for (const Sample& sample : samples)
      values.push_back(sample.slave[corner]);
    return values;
  };
  const auto subtract = [](std::vector<double>& f, double factor, const std::vector<double>& g) {
    for (std::size_t q = 0; q < f.size(); ++q)
      f[q] -= factor * g[q];
  };
  std::vector<std::vector<double>> others;
  for (std::size_t corner = 0; corner < corners; ++corner) {
    if (corner == own)
      continue;
    std::vector<double> other = hat(corner);
    for (int pass = 0; pass < 2; ++pass) // Gram and Schmidt
      for (const std::vector<double>& before : others)
        subtract(other, product(before, other), before);
    const double size = std::sqrt(product(other, other));
    for (double& value : other)
      value /= size;
    others.push_back(std::move(other));
  }
  Dual dual{.values = hat(own)};
  for (std::size_t q = 0; q < samples.size(); ++q)
    dual.area += samples[q].weight * samples[q].slave[own];
  for (int pass = 0; pass < 2; ++pass)
    for (const std::vector<double>& other : others)
      subtract(dual.values, product(other, dual.values), other);
  const double scale = dual.area / product(dual.values, hat(own));
  for (double& value : dual.values)
    value *= scale;
  return dual;
}

/// Bounding box by its lower and upper corner, m.
struct Bounds {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
            std::numeric_limits<double>::infinity()},
      high{-low[0], -low[1], -low[2]};

  void include(const Point& x) {
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], x[c]);
      high[c] = std::max(high[c], x[c]);
    }
  }
  [[nodiscard]] double diagonal() const {
    return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  }
  [[nodiscard]] Point corner(int number) const {
    return {number & 1 ? high[0] : low[0], number & 2 ? high[1] : low[1], number & 4 ? high[2] : low[2]};
  }
};

Bounds bounds_of(const fem::SurfaceMesh& surface) {
  Bounds bounds;
  for (const fem::SurfaceMesh::Vertex& vertex : surface.vertices)
    bounds.include(vertex.x);
  return bounds;
}

/// Tree of bounding boxes. dolfinx makes trees of the cells of a mesh: here of the boxes' diagonals, which
/// further cells join to one line, since dolfinx orders a mesh of many parts in quadratic time.
class Boxes {
public:
  explicit Boxes(const std::vector<Bounds>& all) : diagonals_(mesh_of(all)) {
    const auto& numbers = diagonals_.topology()->original_cell_index;
    if constexpr (requires { numbers[0][0]; })
      number_.assign(numbers.front().begin(), numbers.front().end());
    else
      number_.assign(numbers.begin(), numbers.end());
    std::vector<std::int32_t> cells;
    for (std::size_t i = 0; i < number_.size(); ++i)
      if (number_[i] < static_cast<std::int64_t>(all.size()))
        cells.push_back(static_cast<std::int32_t>(i));
    tree_.emplace(dolfinx_versions::bounding_boxes(diagonals_, 1, std::span<const std::int32_t>(cells)));
  }

  /// Returns for each of these boxes the numbers of the other boxes that it overlaps, ascending.
  [[nodiscard]] std::vector<std::vector<std::size_t>> overlaps(const Boxes& others) const {
    std::vector<std::vector<std::size_t>> found((number_.size() + 1) / 2);
    const std::vector<std::int32_t> pairs = dolfinx::geometry::compute_collisions(*tree_, *others.tree_);
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2)
      found[number(pairs[i])].push_back(others.number(pairs[i + 1]));
    for (std::vector<std::size_t>& each : found)
      std::ranges::sort(each);
    return found;
  }

private:
  static dolfinx::mesh::Mesh<double> mesh_of(const std::vector<Bounds>& all) {
    std::vector<double> x;
    std::vector<std::int64_t> cells;
    for (const Bounds& one : all)
      for (const Point& end : {one.low, one.high}) {
        x.insert(x.end(), end.begin(), end.end());
        cells.push_back(static_cast<std::int64_t>(cells.size()));
      }
    for (std::int64_t end = 1; end + 1 < static_cast<std::int64_t>(2 * all.size()); end += 2)
      cells.insert(cells.end(), {end, end + 1});
    const dolfinx::fem::CoordinateElement<double> element(dolfinx::mesh::CellType::interval, 1);
    return dolfinx_versions::create_mesh(MPI_COMM_SELF, MPI_COMM_SELF, std::span<const std::int64_t>(cells),
                                         element, x, {2 * all.size(), 3}, false);
  }
  [[nodiscard]] std::size_t number(std::int32_t cell) const {
    return static_cast<std::size_t>(number_[static_cast<std::size_t>(cell)]);
  }

  dolfinx::mesh::Mesh<double> diagonals_;
  std::vector<std::int64_t>
      number_; ///< number of each cell's box; larger ones are of cells between two boxes
  std::optional<dolfinx::geometry::BoundingBoxTree<double>> tree_;
};

double facet_measure(const fem::SurfaceMesh& surface, const fem::SurfaceMesh::Facet& facet, int dim) {
  const auto corner = [&](std::size_t i) {
    return surface.vertices[static_cast<std::size_t>(facet.vertices[i])].x;
  };
  const auto edge = [&](std::size_t i) {
    Point made = corner(i);
    for (std::size_t c = 0; c < 3; ++c)
      made[c] -= corner(0)[c];
    return made;
  };
  const Point a = edge(1);
  if (dim == 2)
    return std::sqrt(dot(a, a));
  const Point b = edge(2);
  return std::sqrt(std::max(0.0, dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b))) / 2;
}

/// Computes the row of one slave node after the other.
class Mortar {
public:
  /// `nu`: direction of each slave node; zero if it has none.
  Mortar(const fem::SurfaceMesh& slave, const fem::SurfaceMesh& master, std::vector<Point> nu, int dim,
         bool axisymmetric, const std::string& key)
      : slave_(slave), master_(master), dim_(dim), axisymmetric_(axisymmetric), key_(key), rule_(rule(dim)),
        facets_(slave.vertices.size()), nu_(std::move(nu)) {
    for (const fem::SurfaceMesh::Facet& facet : slave.facets)
      for (std::size_t corner = 0; corner < corners(); ++corner)
        facets_[static_cast<std::size_t>(facet.vertices[corner])].push_back(&facet);
    const Bounds of_slave = bounds_of(slave), of_master = bounds_of(master);
    // Bodies that start deeper inside each other are not found to face each other.
    constexpr double part = 0.25;
    deepest_ = part * std::min(of_slave.diagonal(), of_master.diagonal());
    std::vector<Bounds> swept, targets;
    for (std::size_t vertex = 0; vertex < nu_.size(); ++vertex)
      swept.push_back(sweep(vertex, of_master));
    for (const fem::SurfaceMesh::Facet& facet : master.facets) {
      Bounds& box = targets.emplace_back();
      for (std::size_t corner = 0; corner < corners(); ++corner)
        box.include(master.vertices[static_cast<std::size_t>(facet.vertices[corner])].x);
    }
    near_ = Boxes(swept).overlaps(Boxes(targets));
  }

  /// Mean normal of the master surface opposite a slave node, of arbitrary length; zero if there is none.
  [[nodiscard]] Point opposite_normal(std::size_t vertex) const {
    Point normal{};
    const Projection project(nu_[vertex], dim_);
    for (const fem::SurfaceMesh::Facet* facet : facets_[vertex])
      for (const Sample& sample : covered(*facet, vertex, project))
        for (std::size_t c = 0; c < 3; ++c)
          normal[c] += sample.weight * sample.slave[corner_of(*facet, vertex)] * sample.facet->normal[c];
    return normal;
  }

  [[nodiscard]] std::optional<MortarRow> row(std::size_t vertex) const {
    const Projection project(nu_[vertex], dim_);
    MortarRow row{.vertex = static_cast<int>(vertex), .nu = nu_[vertex], .area = 0, .gap = 0, .master = {}};
    std::map<int, double> weights;
    for (const fem::SurfaceMesh::Facet* facet : facets_[vertex]) {
      const std::vector<Sample> samples = covered(*facet, vertex, project);
      if (samples.empty())
        continue;
      const Dual dual = dual_function(samples, corner_of(*facet, vertex), corners());
      row.area += dual.area;
      for (std::size_t q = 0; q < samples.size(); ++q)
        for (std::size_t corner = 0; corner < corners(); ++corner)
          weights[samples[q].facet->vertices[corner]] +=
              samples[q].weight * dual.values[q] * samples[q].master[corner];
    }
    if (weights.empty())
      return std::nullopt;
    // The sum of the weights is the area up to rounding.
    double sum = 0;
    for (const auto& [node, weight] : weights)
      sum += weight;
    row.gap = -dot(slave_.vertices[vertex].x, row.nu);
    for (const auto& [node, weight] : weights) {
      row.gap += weight / sum * dot(master_.vertices[static_cast<std::size_t>(node)].x, row.nu);
      row.master.emplace_back(node, weight / sum);
    }
    return row;
  }

private:
  [[nodiscard]] std::size_t corners() const { return static_cast<std::size_t>(dim_); }
  /// Number of a vertex among those of its facet.
  static std::size_t corner_of(const fem::SurfaceMesh::Facet& facet, std::size_t vertex) {
    return static_cast<std::size_t>(std::ranges::find(facet.vertices, static_cast<int>(vertex)) -
                                    facet.vertices.begin());
  }

  /// Box of the facets around a slave node, moved along ν as far as the master surface extends.
  [[nodiscard]] Bounds sweep(std::size_t vertex, const Bounds& of_master) const {
    Bounds box;
    for (const fem::SurfaceMesh::Facet* facet : facets_[vertex])
      for (std::size_t corner = 0; corner < corners(); ++corner) {
        const Point& x = slave_.vertices[static_cast<std::size_t>(facet->vertices[corner])].x;
        double reach = -deepest_;
        for (int number = 0; number < 8; ++number)
          reach = std::max(reach, dot(of_master.corner(number), nu_[vertex]) - dot(x, nu_[vertex]));
        for (const double way : {-deepest_, reach}) {
          Point moved = x;
          for (std::size_t c = 0; c < 3; ++c)
            moved[c] += way * nu_[vertex][c];
          box.include(moved);
        }
      }
    return box;
  }

  /// Samples of the part of a slave facet that the master surface covers along ν of a node. Throws UserError
  /// if parts of the master surface cover each other.
  [[nodiscard]] std::vector<Sample> covered(const fem::SurfaceMesh::Facet& facet, std::size_t vertex,
                                            const Projection& project) const {
    std::vector<Sample> samples;
    const double cosine = dot(facet.normal, nu_[vertex]);
    if (cosine < least_cosine)
      return samples;
    const Projected here = project(slave_, facet);
    double whole = 0;
    for (const std::size_t number : near_[vertex]) {
      const fem::SurfaceMesh::Facet& other = master_.facets[number];
      if (dot(other.normal, nu_[vertex]) > -least_cosine)
        continue;
      const Projected there = project(master_, other);
      for (const std::array<Plane, 3>& part : intersection(here.corners, there.corners, dim_))
        whole += add(facet, here, cosine, other, there, part, samples);
    }
    const double size = std::abs(measure(here.corners, dim_)) / cosine;
    constexpr double rounding = 1e-6;
    if (whole > (1 + rounding) * size)
      throw UserError(fmt::format(
          "{}: seen from the node at {}, parts of the other surface are behind each other; choose a group of "
          "the nearest surface",
          key_, point_text(slave_.vertices[vertex].x.data())));
    if (whole < sliver * size)
      samples.clear();
    return samples;
  }

  /// Adds the samples of one simplex of an intersection, unless the master facet is too deep behind. Returns
  /// the covered length or area of the slave facet.
  double add(const fem::SurfaceMesh::Facet& facet, const Projected& here, double cosine,
             const fem::SurfaceMesh::Facet& other, const Projected& there, const std::array<Plane, 3>& part,
             std::vector<Sample>& samples) const {
    const double size = measure(part, dim_) / cosine;
    std::vector<Sample> added;
    double distance = 0;
    for (std::size_t q = 0; q < rule_.weights.size(); ++q) {
      Plane x = part[0];
      for (std::size_t c = 0; c + 1 < corners(); ++c)
        for (std::size_t direction = 0; direction < 2; ++direction)
          x[direction] +=
              rule_.points[q * (corners() - 1) + c] * (part[c + 1][direction] - part[0][direction]);
      Sample sample{.weight = rule_.weights[q] * size,
                    .slave = barycentric(here.corners, x, dim_),
                    .master = barycentric(there.corners, x, dim_),
                    .facet = &other};
      for (std::size_t corner = 0; corner < corners(); ++corner)
        distance += rule_.weights[q] *
                    (sample.master[corner] * there.level[corner] - sample.slave[corner] * here.level[corner]);
      double radius = 0;
      for (std::size_t corner = 0; corner < corners(); ++corner)
        radius +=
            sample.slave[corner] * slave_.vertices[static_cast<std::size_t>(facet.vertices[corner])].x[0];
      if (axisymmetric_)
        sample.weight *= 2 * std::numbers::pi * radius;
      added.push_back(sample);
    }
    if (distance < -deepest_)
      return 0;
    samples.insert(samples.end(), added.begin(), added.end());
    return size;
  }

  const fem::SurfaceMesh &slave_, &master_;
  int dim_;
  bool axisymmetric_;
  const std::string& key_;
  Rule rule_;
  std::vector<std::vector<const fem::SurfaceMesh::Facet*>> facets_; ///< slave facets at each slave node
  std::vector<Point> nu_;
  double deepest_ = 0;                         ///< largest depth at which surfaces face each other, m
  std::vector<std::vector<std::size_t>> near_; ///< master facets that may be opposite each slave node
};

/// Sums of the normals of the facets at each vertex, weighted with their lengths or areas.
std::vector<Point> vertex_normals(const fem::SurfaceMesh& surface, int dim) {
  std::vector<Point> sums(surface.vertices.size());
  for (const fem::SurfaceMesh::Facet& facet : surface.facets) {
    const double size = facet_measure(surface, facet, dim);
    for (std::size_t corner = 0; corner < static_cast<std::size_t>(dim); ++corner)
      for (std::size_t c = 0; c < 3; ++c)
        sums[static_cast<std::size_t>(facet.vertices[corner])][c] += size * facet.normal[c];
  }
  return sums;
}

} // namespace

std::vector<MortarRow> mortar_rows(const fem::SurfaceMesh& slave, const fem::SurfaceMesh& master, int dim,
                                   bool axisymmetric, const std::string& key) {
  std::vector<Point> nu = vertex_normals(slave, dim);
  const auto set_unit = [&](std::size_t vertex, Point direction) {
    if (axisymmetric && slave.vertices[vertex].x[0] == 0)
      direction[0] = 0; // the tangent plane on the axis is normal to it
    const double length = std::sqrt(dot(direction, direction));
    for (std::size_t c = 0; c < 3; ++c)
      nu[vertex][c] = length > 0 ? direction[c] / length : 0;
  };
  for (std::size_t vertex = 0; vertex < nu.size(); ++vertex)
    set_unit(vertex, nu[vertex]);
  {
    const Mortar along_normals(slave, master, nu, dim, axisymmetric, key);
    for (std::size_t vertex = 0; vertex < nu.size(); ++vertex) {
      const Point opposite = along_normals.opposite_normal(vertex);
      const double length = std::sqrt(dot(opposite, opposite));
      Point mean{};
      for (std::size_t c = 0; c < 3 && length > 0; ++c)
        mean[c] = nu[vertex][c] - opposite[c] / length;
      set_unit(vertex, mean);
    }
  }
  std::vector<MortarRow> rows;
  const Mortar mortar(slave, master, std::move(nu), dim, axisymmetric, key);
  for (std::size_t vertex = 0; vertex < slave.vertices.size(); ++vertex)
    if (std::optional<MortarRow> row = mortar.row(vertex))
      rows.push_back(std::move(*row));
  return rows;
}

double facet_size(const fem::SurfaceMesh& surface, int dim) {
  double sum = 0;
  for (const fem::SurfaceMesh::Facet& facet : surface.facets)
    sum += facet_measure(surface, facet, dim);
  const double mean = sum / static_cast<double>(surface.facets.size());
  return dim == 2 ? mean : std::sqrt(mean);
}

} // namespace signorini::contact
