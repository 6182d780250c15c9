// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/mass_redistribution.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/text.h"
#include "contact/row_basis.h"
#include "fem/surface.h"
#include "linalg/dense.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <petscblaslapack.h>
#include <set>

namespace signorini::contact {
using petsc::check;

namespace {

using Point = std::array<double, 3>;

/// Contact node that this rank owns, with the nodes within one, two and three rings of elements around it.
struct Surroundings {
  static constexpr int rings = 3;
  int candidate; ///< the first candidate of the node
  std::array<std::vector<PetscInt>, rings> nodes;
};

/// Requirements on an extrapolation: that it is exact for linear fields or only for constants, and a bound on
/// the sum of absolute weights. This sum is 3 for two nodes in a row behind a surface, 9 behind an edge and
/// 27 behind a corner.
struct Requirement {
  bool linear;
  double cancellation;
};
constexpr Requirement requirements[] = {{true, 10}, {true, 30}, {false, 1 + 1e-9}};

/// Weights with which the nodes `around` extrapolate fields to `x`; nearer nodes have larger weights. Empty
/// if the requirement cannot be met.
std::vector<double> extrapolation(const Point& x, const std::vector<Point>& around, int dim,
                                  Requirement requirement) {
  const auto n = static_cast<std::size_t>(requirement.linear ? dim + 1 : 1);
  double size = 0;
  for (const Point& y : around)
    size = std::max(size, std::hypot(y[0] - x[0], y[1] - x[1], y[2] - x[2]));
  // The least Σ w_j²/V_j, V_j = distance⁻⁴, under Σ w = 1, Σ w (y − x) = 0: w = V Cᵀ (C V Cᵀ)⁻¹ (1, 0).
  std::vector<std::array<double, 4>> C;
  std::vector<double> V;
  std::array<double, 16> normal{};
  for (const Point& y : around) {
    std::array<double, 4> column{1};
    double distance = 0;
    for (int c = 0; c < dim; ++c) {
      column[c + 1] = (y[c] - x[c]) / size;
      distance = std::hypot(distance, column[c + 1]);
    }
    const double weight = 1 / (distance * distance * distance * distance);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        normal[i * n + j] += weight * column[i] * column[j];
    C.push_back(column);
    V.push_back(weight);
  }
  std::array<double, 4> b{1};
  if (factorise_dense(normal, n) != 0)
    return {};
  solve_factorised(normal, n, std::span(b).first(n));
  std::vector<double> w(around.size());
  std::array<double, 4> moments{};
  double absolute = 0;
  for (std::size_t j = 0; j < w.size(); ++j) {
    for (std::size_t i = 0; i < n; ++i)
      w[j] += V[j] * C[j][i] * b[i];
    for (std::size_t i = 0; i < n; ++i)
      moments[i] += w[j] * C[j][i];
    absolute += std::abs(w[j]);
  }
  constexpr double rounding = 1e-12; // nodes on a line do not determine linear fields beside it
  const double defect = std::hypot(std::abs(moments[0] - 1) + std::abs(moments[1]), moments[2], moments[3]);
  if (!(absolute <= requirement.cancellation && defect <= rounding * absolute))
    return {};
  return w;
}

std::vector<Surroundings> surroundings(const ContactPairs& pairs, const std::vector<int>& candidates,
                                       Mat rows) {
  // PETSc requires as many index sets on every rank, so all nodes of a rank share one; the rings of each node
  // are then found in the submatrix of that set.
  const int dim = pairs.dim();
  std::vector<PetscInt> first;
  for (int i : candidates)
    first.push_back(pairs.first_dofs()[i]);
  IS all = nullptr;
  check(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(first.size()), first.data(), PETSC_COPY_VALUES,
                        &all));
  check(MatIncreaseOverlap(rows, 1, &all, Surroundings::rings));
  const petsc::IndexSet spanned(all);
  check(ISSort(spanned));
  Mat* parts = nullptr;
  check(MatCreateSubMatrices(rows, 1, &all, &all, MAT_INITIAL_MATRIX, &parts));
  PetscInt size = 0;
  const PetscInt *dofs = nullptr, *begin = nullptr, *columns = nullptr;
  PetscBool done = PETSC_FALSE;
  check(ISGetIndices(spanned, &dofs));
  check(MatGetRowIJ(parts[0], 0, PETSC_FALSE, PETSC_FALSE, &size, &begin, &columns, &done));
  std::vector<Surroundings> found;
  for (int i : candidates) {
    found.push_back({i, {}});
    std::set<PetscInt> reached{
        static_cast<PetscInt>(std::lower_bound(dofs, dofs + size, pairs.first_dofs()[i]) - dofs)};
    for (std::vector<PetscInt>& ring : found.back().nodes) {
      std::set<PetscInt> next = reached;
      for (PetscInt row : reached)
        next.insert(columns + begin[row], columns + begin[row + 1]);
      reached = std::move(next);
      std::set<PetscInt> nodes;
      for (PetscInt row : reached)
        nodes.insert(dofs[row] / dim);
      ring.assign(nodes.begin(), nodes.end());
    }
  }
  check(MatRestoreRowIJ(parts[0], 0, PETSC_FALSE, PETSC_FALSE, &size, &begin, &columns, &done));
  check(ISRestoreIndices(spanned, &dofs));
  check(MatDestroySubMatrices(1, &parts));
  return found;
}

/// Coordinates of all surrounding nodes, also of those on other ranks, by node number, m. Collective.
std::map<PetscInt, Point> places(const fem::Space& space, const std::vector<Surroundings>& all) {
  const int dim = space.dim();
  std::set<PetscInt> nodes;
  for (const Surroundings& here : all)
    nodes.insert(here.nodes.back().begin(), here.nodes.back().end());
  std::vector<PetscInt> dofs;
  for (PetscInt node : nodes)
    for (int c = 0; c < dim; ++c)
      dofs.push_back(node * dim + c);
  const petsc::Vector x = space.vector();
  {
    const petsc::WriteArray values(x);
    for (std::size_t i = 0; i < static_cast<std::size_t>(dim * space.owned_nodes()); ++i)
      values[i] = space.points()[3 * (i / dim) + i % dim];
  }
  petsc::IndexSet wanted;
  check(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(dofs.size()), dofs.data(), PETSC_COPY_VALUES,
                        wanted.put()));
  petsc::Vector gathered;
  check(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(dofs.size()), gathered.put()));
  VecScatter scatter = nullptr;
  check(VecScatterCreate(x, wanted, gathered, nullptr, &scatter));
  check(VecScatterBegin(scatter, x, gathered, INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterEnd(scatter, x, gathered, INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterDestroy(&scatter));
  std::map<PetscInt, Point> places;
  const petsc::ReadArray values(gathered);
  for (std::size_t i = 0; i < values.size(); ++i)
    places[dofs[i] / dim][dofs[i] % dim] = values[i];
  return places;
}

/// Whether the node of each pair can touch the obstacle: whether a facet of the boundary at the node faces
/// the obstacle. For example, nodes on a plate's upper side never touch a floor, and take the mass of the
/// lower side. True for nodes inside the body, where no facet is known. Collective.
std::vector<bool> facing(const fem::Space& space, const ContactPairs& pairs) {
  const auto dim = static_cast<std::size_t>(pairs.dim()), count = static_cast<std::size_t>(pairs.count());
  std::map<PetscInt, const ConstraintRows::Cluster*> in_pairs; // by the first dof
  for (const ConstraintRows::Cluster& node : pairs.rows().clusters())
    in_pairs[pairs.first_dofs()[node.first]] = &node;
  std::vector<int> seen(2 * count); // on the boundary; facing
  for (const fem::OutwardNormal& here : fem::outward_normals(space)) {
    const auto found = in_pairs.find(here.first_dof);
    if (found == in_pairs.end())
      continue;
    for (auto pair = static_cast<std::size_t>(found->second->first);
         pair < static_cast<std::size_t>(found->second->last); ++pair) {
      const double* towards = &pairs.normals()[pair * dim];
      seen[2 * pair] = 1;
      if (std::inner_product(towards, towards + dim, here.n.begin(), 0.0) > RowBasis::dependence_limit)
        seen[2 * pair + 1] = 1;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, seen.data(), static_cast<int>(seen.size()), MPI_INT, MPI_MAX, space.comm());
  std::vector<bool> faces(count);
  for (std::size_t i = 0; i < count; ++i)
    faces[i] = seen[2 * i] == 0 || seen[2 * i + 1] != 0;
  return faces;
}

using Block = std::array<double, 9>; // dim × dim, row by row

/// Orthogonal projectors (dim × dim) onto the directions in which nodes lose their mass, by node.
using Projectors = std::map<PetscInt, Block>;

/// Orthogonal projector onto the directions of a basis.
Block projector(const RowBasis& basis, int dim) {
  Block onto{};
  for (int c = 0; c < dim; ++c) {
    Point unit{}, column{};
    RowBasis::Coordinates part = basis.coordinates();
    unit[c] = 1;
    for (std::size_t k = 0; k < basis.size(); ++k)
      part[k] = basis.along(k, unit);
    basis.add_to(column, part);
    for (int row = 0; row < dim; ++row)
      onto[row * dim + c] = column[row];
  }
  return onto;
}

/// Orthogonal projector onto the tangents of a pair with friction, which are orthonormal.
Block tangential_projector(const ConstraintRows& rows, int pair, int dim) {
  Block onto{};
  for (std::size_t c = 1; c < rows.size(pair); ++c) {
    const std::span<const double> tangent = rows.motion(static_cast<int>(rows.row(pair, c)));
    for (int i = 0; i < dim * dim; ++i)
      onto[i] += tangent[i / dim] * tangent[i % dim];
  }
  return onto;
}

/// Finds the directions in which nodes lose their mass. Collective.
Projectors directions_without_mass(const fem::Space& space, const ContactPairs& pairs,
                                   const std::vector<scene::Contact>& contacts) {
  const std::vector<bool> faces = facing(space, pairs);
  const auto mass = [&](int i) { return contacts[static_cast<std::size_t>(pairs.obstacles()[i])].mass; };
  std::map<PetscInt, RowBasis> bases;
  Projectors found;
  for (int i = 0; i < pairs.count(); ++i) {
    const PetscInt node = pairs.first_dofs()[i] / pairs.dim();
    if (!faces[i] && !pairs.rows().law(i).acts_open())
      continue;
    if (mass(i) == scene::ContactMass::massless)
      bases.try_emplace(node, pairs.rows()).first->second.add(i);
    else if (mass(i) == scene::ContactMass::massless_tangential && pairs.rows().size(i) > 1)
      found.emplace(node, tangential_projector(pairs.rows(), i, pairs.dim()));
  }
  for (const auto& [node, basis] : bases)
    found.emplace(node, projector(basis, pairs.dim()));
  return found;
}

/// Creates an empty square AIJ matrix with `size` rows on this rank. Collective.
petsc::Matrix empty_square(MPI_Comm comm, PetscInt size, int block_size) {
  petsc::Matrix E;
  check(MatCreate(comm, E.put()));
  check(MatSetSizes(E, size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetBlockSize(E, block_size));
  check(MatSetType(E, MATAIJ));
  check(MatSetUp(E));
  return E;
}

/// Nodes with mass and their weights in the extrapolated velocity of a contact node; empty if no nodes
/// determine it.
struct Combination {
  std::vector<PetscInt> nodes;
  std::vector<double> weights;
};
Combination combination(PetscInt node, const Surroundings& here, const Projectors& massless,
                        const std::map<PetscInt, Point>& place, int dim) {
  Combination found;
  for (const Requirement& requirement : requirements)
    for (int ring = 0; ring < Surroundings::rings && found.weights.empty(); ++ring) {
      found.nodes.clear();
      std::vector<Point> around;
      for (PetscInt other : here.nodes[ring])
        if (!massless.contains(other)) {
          found.nodes.push_back(other);
          around.push_back(place.at(other));
        }
      if (!around.empty())
        found.weights = extrapolation(place.at(node), around, dim, requirement);
    }
  return found;
}

} // namespace

petsc::Matrix velocity_extrapolation(const fem::Space& space, const ContactPairs& pairs,
                                     const std::vector<scene::Contact>& contacts, Mat pattern) {
  const int dim = space.dim();
  petsc::Matrix rows;
  check(MatConvert(pattern, MATAIJ, MAT_INITIAL_MATRIX, rows.put()));
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(rows, &begin, &end));

  const Projectors massless = directions_without_mass(space, pairs, contacts);
  std::vector<int> owned; // the first pair of each of these nodes
  for (const ConstraintRows::Cluster& here : pairs.rows().clusters())
    if (const PetscInt first = pairs.first_dofs()[here.first];
        first >= begin && first < end && massless.contains(first / dim))
      owned.push_back(here.first);

  petsc::Matrix E = empty_square(petsc::comm(rows), end - begin, dim);
  const auto insert = [&](PetscInt row, PetscInt column, const Block& block) {
    check(MatSetValuesBlocked(E, 1, &row, 1, &column, block.data(), INSERT_VALUES)); // whole blocks, for BAIJ
  };
  Block identity{};
  for (int c = 0; c < dim; ++c)
    identity[c * dim + c] = 1;
  for (PetscInt node = begin / dim; node < end / dim; ++node)
    if (!massless.contains(node))
      insert(node, node, identity);

  const std::vector<Surroundings> all = surroundings(pairs, owned, rows);
  const std::map<PetscInt, Point> place = places(space, all);
  on_all_ranks(space.comm(), [&] {
    for (const Surroundings& here : all) {
      const PetscInt node = pairs.first_dofs()[here.candidate] / dim;
      const auto [neighbours, weights] = combination(node, here, massless, place, dim);
      if (weights.empty())
        throw UserError(fmt::format(
            "contact.mass: found \"{}\", but all neighbours of the node at {} are contact nodes, so "
            "none can take its mass. Set mesh.degree = 2, refine the mesh, or choose a smaller group",
            scene::name(contacts[static_cast<std::size_t>(pairs.obstacles()[here.candidate])].mass),
            point_text(&pairs.points()[3 * static_cast<std::size_t>(here.candidate)])));
      const Block& onto = massless.at(node);
      Block block{};
      for (int i = 0; i < dim * dim; ++i)
        block[i] = identity[i] - onto[i];
      insert(node, node, block);
      for (std::size_t j = 0; j < neighbours.size(); ++j) {
        for (int i = 0; i < dim * dim; ++i)
          block[i] = weights[j] * onto[i];
        insert(node, neighbours[j], block);
      }
    }
  });
  check(MatAssemblyBegin(E, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(E, MAT_FINAL_ASSEMBLY));
  return E;
}

petsc::Matrix redistributed_mass(Mat E, Mat M) {
  petsc::Matrix rows, moved, blocks;
  PetscInt dim = 1;
  check(MatGetBlockSize(E, &dim));
  check(MatConvert(M, MATAIJ, MAT_INITIAL_MATRIX, rows.put()));
  check(MatPtAP(rows, E, MAT_INITIAL_MATRIX, PETSC_DETERMINE, moved.put()));
  check(MatSetBlockSize(moved, dim));
  check(MatConvert(moved, MATBAIJ, MAT_INITIAL_MATRIX, blocks.put()));
  return blocks;
}

void add_removed_mass(Mat E, Mat M, Mat blocks) {
  const petsc::Vector diagonal = fem::diagonal(M);
  const petsc::ReadArray masses(diagonal);
  PetscInt begin = 0, end = 0, dim = 1;
  check(MatGetOwnershipRange(E, &begin, &end));
  check(MatGetBlockSize(E, &dim));
  for (PetscInt node = begin / dim; node < end / dim; ++node) {
    std::array<PetscInt, 3> dofs{};
    Block block{}; // E_ii, then the addition
    for (PetscInt c = 0; c < dim; ++c)
      dofs[c] = node * dim + c;
    check(MatGetValues(E, dim, dofs.data(), dim, dofs.data(), block.data()));
    const double mass = masses[static_cast<std::size_t>(node * dim - begin)];
    for (PetscInt c = 0; c < dim; ++c)
      for (PetscInt other = 0; other < dim; ++other)
        block[c * dim + other] = mass * ((c == other) - block[c * dim + other]);
    check(MatSetValuesBlocked(blocks, 1, &node, 1, &node, block.data(), ADD_VALUES));
  }
  check(MatAssemblyBegin(blocks, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(blocks, MAT_FINAL_ASSEMBLY));
}

} // namespace signorini::contact
