// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/operators.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/text.h"
#include "fem/foundations.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace signorini::fem {
using petsc::check;

std::vector<int> component_numbers(const std::optional<std::vector<scene::Component>>& given, int dim) {
  std::vector<int> numbers;
  for (scene::Component component : given.value_or(scene::components(dim)))
    numbers.push_back(static_cast<int>(component));
  return numbers;
}

DirichletDofs::DirichletDofs(const Space& space, const std::vector<scene::Clamp>& clamps)
    : dim_(space.dim()), first_dof_(space.first_dof()) {
  std::map<int, std::pair<std::string, std::size_t>> motion; // motion of each dof, and its first clamp
  for (std::size_t i = 0; i < clamps.size(); ++i) {
    const scene::Clamp& clamp = clamps[i];
    const auto key = [&](std::size_t j, const char* name) {
      return fmt::format("{}.{}", scene::clamp_key(clamps, j), name);
    };
    const std::vector<int> components = component_numbers(clamp.components, dim_);
    const std::vector<int> nodes = space.nodes_on(clamp.on, key(i, "on"));
    on_all_ranks(space.comm(), [&] {
      for (int node : nodes)
        for (std::size_t c = 0; c < components.size(); ++c) {
          const std::string value =
              clamp.value && !scene::vanishes({clamp.value->at(c)}) ? clamp.value->at(c).text : "0";
          if (components[c] == 0 && space.on_axis(node) && value != "0")
            throw UserError(fmt::format(
                "{}: found \"{}\" for x of the node at {}; the node is on the axis, where the "
                "radial displacement is 0. End the group before the axis",
                key(i, "value"), value, point_text(&space.points()[3 * static_cast<std::size_t>(node)])));
          const auto [held, first] = motion.try_emplace(node * dim_ + components[c], value, i);
          if (const auto& [other, by] = held->second; !first && other != value)
            throw UserError(fmt::format("{}: found \"{}\", but {} prescribes {} of the node at {} as \"{}\"; "
                                        "clamps that share a node must prescribe the same motion",
                                        key(i, "value"), value, key(by, "value"), "xyz"[components[c]],
                                        point_text(&space.points()[3 * static_cast<std::size_t>(node)]),
                                        other));
        }
    });
  }
  for (int node = 0; node < space.owned_nodes(); ++node)
    if (space.on_axis(node))
      motion.try_emplace(node * dim_, "0", clamps.size());
  for (const auto& [dof, held] : motion)
    dofs_.push_back(dof);
  if (const Layout& layout = space.layout(); layout.owns_virtual_nodes())
    for (std::size_t node = 0; node < layout.virtual_nodes().size(); ++node)
      for (int c = 0; c < dim_; ++c)
        if (layout.virtual_nodes()[node].clamped[static_cast<std::size_t>(c)])
          dofs_.push_back((layout.mesh_nodes() + static_cast<int>(node)) * dim_ + c);
}

bool DirichletDofs::contains(int node, int component) const {
  return std::ranges::binary_search(dofs_, node * dim_ + component);
}

void DirichletDofs::clear(Vec x) const {
  const petsc::WriteArray values(x);
  for (int dof : dofs_)
    values[static_cast<std::size_t>(dof)] = 0;
}

double DirichletDofs::decouple(Mat matrix) const {
  const petsc::Vector diagonal = fem::diagonal(matrix);
  PetscReal largest = 0; // keeps the condition number of the free part, in any units
  check(VecMax(diagonal, nullptr, &largest));
  std::vector<PetscInt> rows;
  for (int dof : dofs_)
    rows.push_back(first_dof_ + dof);
  check(
      MatZeroRowsColumns(matrix, static_cast<PetscInt>(rows.size()), rows.data(), largest, nullptr, nullptr));
  return largest;
}

namespace {

/// Returns c with `matrix` = c `other` up to rounding, or nothing if no such c exists; tested with a random
/// vector. Collective.
std::optional<double> ratio(Mat matrix, Mat other) {
  petsc::Vector x = petsc::vector_of(matrix), y = petsc::zero_like(x), z = petsc::zero_like(x);
  check(VecSetRandom(x, nullptr));
  check(MatMult(matrix, x, y));
  check(MatMult(other, x, z));
  const double c = petsc::dot(y, z) / petsc::dot(z, z);
  PetscReal size = 0, difference = 0;
  check(VecNorm(y, NORM_INFINITY, &size));
  check(VecAXPY(z, -1 / c, y));
  check(VecNorm(z, NORM_INFINITY, &difference));
  constexpr double rounding = 1e-13;
  if (!(difference * c <= rounding * size))
    return std::nullopt;
  return std::abs(c - 1) <= rounding ? 1 : c;
}

/// Extracts the rows and columns of the first component from an AIJ matrix with blocks. Collective.
petsc::Matrix first_component(Mat rows) {
  PetscInt dim = 1, begin = 0, end = 0;
  check(MatGetBlockSize(rows, &dim));
  check(MatGetOwnershipRange(rows, &begin, &end));
  petsc::IndexSet first;
  check(ISCreateStride(petsc::comm(rows), (end - begin) / dim, begin, dim, first.put()));
  petsc::Matrix component;
  check(MatCreateSubMatrix(rows, first, first, MAT_INITIAL_MATRIX, component.put()));
  return component;
}

/// Returns the MAIJ matrix that applies the first component of an AIJ matrix to all components. Collective.
petsc::Matrix one_for_all(Mat rows) {
  PetscInt dim = 1;
  check(MatGetBlockSize(rows, &dim));
  petsc::Matrix all;
  check(MatCreateMAIJ(first_component(rows), dim, all.put()));
  thread_products(all);
  return all;
}

/// Stores a matrix in the most compact way: returns one_for_all() if it is the same operator, else the upper
/// half in blocks (SBAIJ). Collective.
petsc::Matrix compress(petsc::Matrix rows) {
  petsc::Matrix all = one_for_all(rows);
  if (ratio(rows, all) == 1)
    return all;
  petsc::Matrix blocks;
  check(MatConvert(rows, MATBAIJ, MAT_INITIAL_MATRIX, blocks.put()));
  return symmetric_half(blocks);
}

/// Index set of the global numbers `first` + i, for local numbers i. Collective.
petsc::IndexSet numbers(MPI_Comm comm, PetscInt first, const std::vector<int>& local) {
  std::vector<PetscInt> global;
  for (int i : local)
    global.push_back(first + i);
  petsc::IndexSet set;
  check(ISCreateGeneral(comm, static_cast<PetscInt>(global.size()), global.data(), PETSC_COPY_VALUES,
                        set.put()));
  return set;
}

} // namespace

petsc::Vector diagonal(Mat matrix) {
  petsc::Vector diagonal = petsc::vector_of(matrix);
  const Mat component = petsc::component(matrix);
  if (!component) {
    check(MatGetDiagonal(matrix, diagonal));
    return diagonal;
  }
  petsc::Vector one = petsc::vector_of(component);
  check(MatGetDiagonal(component, one));
  const petsc::ReadArray from(one);
  const petsc::WriteArray to(diagonal);
  const std::size_t dim = to.size() / std::max<std::size_t>(from.size(), 1);
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = from[i / dim];
  return diagonal;
}

namespace {

constexpr double no_tau = 0; // for forms without a time step

/// Assembles Σ α M over the materials (BAIJ); null if no material has mass-proportional damping. Collective.
petsc::Matrix assemble_drag(const Space& space, std::vector<Part> body) {
  if (std::ranges::none_of(body, [](const Part& part) { return part.material.dragged(); }))
    return {};
  for (Part& part : body)
    part.material.density *= part.material.mass_damping();
  return assemble(space, Form::m, body, no_tau, MATBAIJ);
}

/// Adds c · `part` to `sum`, of whose nonzero pattern that of `part` is a part; nothing if `part` is null.
void add_part(Mat sum, double c, Mat part) {
  if (part)
    check(MatAXPY(sum, c, part, SUBSET_NONZERO_PATTERN));
}

} // namespace

Operators assemble_operators(const Space& space, const std::vector<scene::Material>& materials,
                             bool densities, const std::vector<scene::Foundation>& foundations) {
  const std::vector<Part> body = parts(space.mesh(), materials);
  Operators operators;
  operators.foundation_A = assemble_springs(space, foundations);
  operators.foundation_B = assemble_dashpots(space, foundations, materials);
  operators.drag = assemble_drag(space, body);
  operators.M = compress(assemble(space, Form::m, body, no_tau, MATAIJ));
  const petsc::Matrix A = assemble(space, Form::a, body, no_tau, MATBAIJ);
  add_part(A, 1, operators.foundation_A);
  operators.A = symmetric_half(A);
  operators.viscous = std::ranges::any_of(materials, &scene::Material::viscous);
  const auto damped = [](const VirtualNode& node) { return node.damping != std::array<double, 3>{}; };
  if (operators.viscous || operators.foundation_B || operators.drag ||
      std::ranges::any_of(space.layout().virtual_nodes(), damped)) {
    const petsc::Matrix B = assemble(space, Form::b, body, no_tau, MATBAIJ);
    add_part(B, 1, operators.foundation_B);
    add_part(B, 1, operators.drag);
    operators.B = symmetric_half(B);
  }
  if (std::ranges::any_of(materials, &scene::Material::relaxes))
    operators.relaxation.emplace(space, materials);
  if (densities) {
    operators.W = one_for_all(assemble(space, Form::L2, body, no_tau, MATAIJ));
    operators.uniform_density = ratio(operators.M, *operators.W);
  }
  return operators;
}

void Operators::add_surroundings(Mat D, double tau) const {
  add_part(D, tau * tau / 4, foundation_A);
  add_part(D, tau / 2, foundation_B);
  add_part(D, tau / 2, drag);
}

petsc::Matrix assemble_L2(const Space& space, const std::string& group, const std::string& key) {
  const petsc::Matrix component = first_component(assemble_part(space, group, key));
  // Functions of nodes off the group vanish on it exactly: drop these zeros.
  check(MatEliminateZeros(component, PETSC_FALSE));
  petsc::Matrix all;
  check(MatCreateMAIJ(component, space.dim(), all.put()));
  return all;
}

petsc::Matrix among_nodes(Mat L2, const std::vector<int>& nodes, int components) {
  const Mat component = petsc::component(L2);
  PetscInt begin = 0;
  check(MatGetOwnershipRange(component, &begin, nullptr));
  const petsc::IndexSet kept = numbers(petsc::comm(L2), begin, nodes);
  petsc::Matrix among, all;
  check(MatCreateSubMatrix(component, kept, kept, MAT_INITIAL_MATRIX, among.put()));
  check(MatCreateMAIJ(among, components, all.put()));
  return all;
}

petsc::Matrix columns(Mat matrix, const std::vector<int>& columns) {
  PetscInt first_row = 0, end_row = 0, first = 0;
  check(MatGetOwnershipRange(matrix, &first_row, &end_row));
  check(MatGetOwnershipRangeColumn(matrix, &first, nullptr));
  petsc::IndexSet rows;
  check(ISCreateStride(petsc::comm(matrix), end_row - first_row, first_row, 1, rows.put()));
  petsc::Matrix some;
  check(MatCreateSubMatrix(matrix, rows, numbers(petsc::comm(matrix), first, columns), MAT_INITIAL_MATRIX,
                           some.put()));
  return some;
}

void attach_rigid_motions(Mat matrix, const Space& space) {
  const petsc::Vector points = space.vector();
  const auto dim = static_cast<std::size_t>(space.dim());
  {
    const petsc::WriteArray values(points);
    for (std::size_t i = 0; i < dim * static_cast<std::size_t>(space.owned_nodes()); ++i)
      values[i] = space.points()[3 * (i / dim) + i % dim];
  }
  petsc::NullSpace motions;
  check(VecSetBlockSize(points, space.dim()));
  check(MatNullSpaceCreateRigidBody(points, motions.put()));
  check(MatSetNearNullSpace(matrix, motions));
}

petsc::Matrix assemble_step_operator(const Space& space, const std::vector<scene::Material>& materials,
                                     double tau) {
  return assemble(space, Form::d, parts(space.mesh(), materials), tau, MATBAIJ);
}

petsc::Matrix assemble_mass(const Space& space, const std::vector<scene::Material>& materials) {
  return assemble(space, Form::m, parts(space.mesh(), materials), no_tau, MATBAIJ);
}

petsc::Matrix assemble_rate(const Space& space, const std::vector<scene::Material>& materials,
                            std::size_t material, Form form) {
  return assemble_one(space, form, parts(space.mesh(), materials), material, MATBAIJ);
}

petsc::Matrix shifted(Mat A, Mat D, double c) {
  // In full blocks, since MatAXPY of MPISBAIJ is wrong on several ranks in PETSc 3.22.
  petsc::Matrix blocks, sum;
  check(MatConvert(A, MATBAIJ, MAT_INITIAL_MATRIX, blocks.put()));
  check(MatDuplicate(D, MAT_COPY_VALUES, sum.put()));
  check(MatAXPY(sum, -c, blocks, SUBSET_NONZERO_PATTERN));
  return symmetric_half(sum);
}

} // namespace signorini::fem
