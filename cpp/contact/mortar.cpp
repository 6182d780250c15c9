// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/mortar.h"
#include "base/error.h"
#include "base/text.h"
#include "contact/box_search.h"
#include "contact/facet_projection.h"
#include "linalg/dense.h"
#include <algorithm>
#include <basix/quadrature.h>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>

namespace signorini::contact {

namespace {

/// Least cosine between a facet's normal and ν with which they count as facing.
constexpr double least_cosine = 0.05;
/// Part of a facet below which a covered part is left out: its dual functions would be rounding errors.
constexpr double sliver = 1e-6;

/// Quadrature on a simplex of dimension dim − 1, exact for products of a hat function, a function of
/// displacements and the radius: reference points (points × (dim − 1)) and weights whose sum is 1.
struct Rule {
  std::vector<double> points, weights;
};

Rule rule(int dim, bool quadratic) {
  const int degree = quadratic ? 4 : 3;
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

/// Calls visit(node, value) for the displacements' functions of a facet at a point with the hat functions
/// `hats` of its corners.
template <class Visit>
void for_each_function(const fem::SurfaceMesh& surface, const fem::SurfaceMesh::Facet& facet,
                       const std::array<double, 3>& hats, std::size_t corners, Visit&& visit) {
  const bool quadratic = !surface.midpoints.empty();
  for (std::size_t corner = 0; corner < corners; ++corner)
    visit(facet.vertices[corner], quadratic ? hats[corner] * (2 * hats[corner] - 1) : hats[corner]);
  for (std::size_t edge = 0; quadratic && edge < corners * (corners - 1) / 2; ++edge)
    visit(facet.midpoints[edge], 4 * hats[edge] * hats[(edge + 1) % corners]);
}

Box box_of(const fem::SurfaceMesh& surface) {
  Box box = Box::empty(3);
  for (const fem::SurfaceMesh::Vertex& vertex : surface.vertices)
    box.include(vertex.x);
  return box;
}

/// Corner 0 … 7 of a box.
Point corner_of(const Box& box, int number) {
  return {number & 1 ? box.high[0] : box.low[0], number & 2 ? box.high[1] : box.low[1],
          number & 4 ? box.high[2] : box.low[2]};
}

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
      : slave_(slave), master_(master), dim_(dim), axisymmetric_(axisymmetric), key_(key),
        rule_(rule(dim, !slave.midpoints.empty())), facets_(slave.vertices.size()), nu_(std::move(nu)) {
    for (const fem::SurfaceMesh::Facet& facet : slave.facets)
      for (std::size_t corner = 0; corner < corners(); ++corner)
        facets_[static_cast<std::size_t>(facet.vertices[corner])].push_back(&facet);
    const Box of_slave = box_of(slave), of_master = box_of(master);
    // Bodies that start deeper inside each other are not found to face each other.
    constexpr double part = 0.25;
    deepest_ = part * std::min(of_slave.diagonal(), of_master.diagonal());
    std::vector<Box> swept, targets;
    for (std::size_t vertex = 0; vertex < nu_.size(); ++vertex)
      swept.push_back(sweep(vertex, of_master));
    for (const fem::SurfaceMesh::Facet& facet : master.facets) {
      Box& box = targets.emplace_back(Box::empty(3));
      for (std::size_t corner = 0; corner < corners(); ++corner)
        box.include(master.vertices[static_cast<std::size_t>(facet.vertices[corner])].x);
    }
    near_ = overlaps(swept, targets);
  }

  /// Mean normal of the master surface opposite a slave node, of arbitrary length; zero if there is none.
  [[nodiscard]] Point opposite_normal(std::size_t vertex) const {
    Point normal{};
    const Projection project(nu_[vertex], dim_);
    for (const fem::SurfaceMesh::Facet* facet : facets_[vertex])
      for (const Sample& sample : covered(*facet, vertex, project))
        for (std::size_t c = 0; c < 3; ++c)
          normal[c] += sample.weight * sample.slave[place_in(*facet, vertex)] * sample.facet->normal[c];
    return normal;
  }

  [[nodiscard]] std::optional<MortarRow> row(std::size_t vertex) const {
    const Projection project(nu_[vertex], dim_);
    MortarRow row{.vertex = static_cast<int>(vertex), .nu = nu_[vertex], .area = 0, .gap = 0, .master = {}};
    std::map<int, double> weights, of_slave;
    for (const fem::SurfaceMesh::Facet* facet : facets_[vertex]) {
      if (!slave_.midpoints.empty()) // the hat function of the node has all of them
        for_each_function(slave_, *facet, {}, corners(), [&](int node, double) { of_slave[node] += 0; });
      const std::vector<Sample> samples = covered(*facet, vertex, project);
      if (samples.empty())
        continue;
      const Dual dual = dual_function(samples, place_in(*facet, vertex), corners());
      row.area += dual.area;
      for (std::size_t q = 0; q < samples.size(); ++q) {
        const Sample& sample = samples[q];
        const double weight = sample.weight * dual.values[q];
        for_each_function(master_, *sample.facet, sample.master, corners(),
                          [&](int node, double value) { weights[node] += weight * value; });
        if (!slave_.midpoints.empty())
          for_each_function(slave_, *facet, sample.slave, corners(),
                            [&](int node, double value) { of_slave[node] += weight * value; });
      }
    }
    if (weights.empty())
      return std::nullopt;
    // The sum of the weights is the area up to rounding.
    double sum = 0;
    for (const auto& [node, weight] : weights)
      sum += weight;
    row.gap = -dot(slave_.vertices[vertex].x, row.nu);
    for (const auto& [node, weight] : weights) {
      row.gap += weight / sum * dot(master_.node(node).x, row.nu);
      row.master.emplace_back(node, weight / sum);
    }
    for (const auto& [node, weight] : of_slave)
      if (node == row.vertex)
        row.own = weight / sum;
      else
        row.slave.emplace_back(node, weight / sum);
    return row;
  }

private:
  [[nodiscard]] std::size_t corners() const { return static_cast<std::size_t>(dim_); }
  /// Number of a vertex among those of its facet.
  static std::size_t place_in(const fem::SurfaceMesh::Facet& facet, std::size_t vertex) {
    return static_cast<std::size_t>(std::ranges::find(facet.vertices, static_cast<int>(vertex)) -
                                    facet.vertices.begin());
  }

  /// Box of the facets around a slave node, moved along ν as far as the master surface extends.
  [[nodiscard]] Box sweep(std::size_t vertex, const Box& of_master) const {
    Box box = Box::empty(3);
    for (const fem::SurfaceMesh::Facet* facet : facets_[vertex])
      for (std::size_t corner = 0; corner < corners(); ++corner) {
        const Point& x = slave_.vertices[static_cast<std::size_t>(facet->vertices[corner])].x;
        double reach = -deepest_;
        for (int number = 0; number < 8; ++number)
          reach = std::max(reach, dot(corner_of(of_master, number), nu_[vertex]) - dot(x, nu_[vertex]));
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

std::vector<double> hat_areas(const fem::SurfaceMesh& surface, int dim, bool axisymmetric) {
  std::vector<double> areas(surface.vertices.size());
  const auto corners = static_cast<std::size_t>(dim);
  for (const fem::SurfaceMesh::Facet& facet : surface.facets) {
    const double size = facet_measure(surface, facet, dim);
    const auto radius = [&](std::size_t corner) {
      return surface.vertices[static_cast<std::size_t>(facet.vertices[corner])].x[0];
    };
    for (std::size_t corner = 0; corner < corners; ++corner)
      areas[static_cast<std::size_t>(facet.vertices[corner])] +=
          axisymmetric ? 2 * std::numbers::pi * size * (2 * radius(corner) + radius(1 - corner)) / 6
                       : size / dim;
  }
  return areas;
}

double facet_size(const fem::SurfaceMesh& surface, int dim) {
  double sum = 0;
  for (const fem::SurfaceMesh::Facet& facet : surface.facets)
    sum += facet_measure(surface, facet, dim);
  const double mean = sum / static_cast<double>(surface.facets.size());
  return dim == 2 ? mean : std::sqrt(mean);
}

} // namespace signorini::contact
