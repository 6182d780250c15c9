// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/enriched_body.h"
#include "base/dolfinx_versions.h"
#include "contact/lcp/primal_dual.h"
#include "fem/function.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace signorini::adjoint {
using petsc::check;

EnrichedBody::EnrichedBody(const fem::Space& linear, const contact::ContactPairs* pairs,
                           const scene::Scene& scene)
    : linear_(linear), space_(linear.mesh(), 2),
      operators_(fem::assemble_operators(space_, scene.materials, true)), clamped_(space_, scene.clamps),
      embed_(fem::embedding(linear, space_)) {
  find_vertices();
  const auto set = [&](const std::optional<scene::Components>& field, const char* key, petsc::Vector& error) {
    if (!field)
      return;
    error = space_.vector();
    interpolation_error({*field, key, false}, 0, error);
    clamped_.clear(error);
  };
  set(scene.initial.displacement, "initial.displacement", initial_error_.y);
  set(scene.initial.velocity, "initial.velocity", initial_error_.v);
  if (!pairs)
    return;
  pairs_.emplace(space_, clamped_, scene.contacts, scene.time);
  match(*pairs);
  zero_.assign(ends_.size(), 0.0);
}

void EnrichedBody::find_vertices() {
  const Mat one = petsc::component(embed_);
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(one, &begin, &end));
  for (PetscInt node = begin; node < end; ++node) {
    PetscInt count = 0;
    check(MatGetRow(one, node, &count, nullptr, nullptr));
    if (count == 1)
      vertices_.push_back(static_cast<int>(node - begin));
    check(MatRestoreRow(one, node, &count, nullptr, nullptr));
  }
}

void EnrichedBody::match(const contact::ContactPairs& pairs) {
  const int dim = space_.dim();
  std::map<std::pair<PetscInt, int>, int> candidate; // by node and obstacle
  for (int i = 0; i < pairs.count(); ++i)
    candidate[{pairs.first_dofs()[i] / dim, pairs.obstacles()[i]}] = i;
  constexpr int elsewhere = -2; // on another rank; less than −1 for MPI_MAX
  ends_.assign(static_cast<std::size_t>(pairs_->count()), {elsewhere, elsewhere});
  const Mat embed = petsc::component(embed_);
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(embed, &begin, &end));
  for (std::size_t j = 0; j < ends_.size(); ++j) {
    const PetscInt node = pairs_->first_dofs()[j] / dim;
    if (node < begin || node >= end)
      continue;
    PetscInt count = 0;
    const PetscInt* nodes = nullptr;
    check(MatGetRow(embed, node, &count, &nodes, nullptr));
    const auto at = [&](PetscInt n) {
      const auto found = candidate.find({n, pairs_->obstacles()[j]});
      return found == candidate.end() ? -1 : found->second;
    };
    ends_[j] = {at(nodes[0]), at(nodes[count - 1])};
    check(MatRestoreRow(embed, node, &count, &nodes, nullptr));
  }
  MPI_Allreduce(MPI_IN_PLACE, ends_.data(), 2 * pairs_->count(), MPI_INT, MPI_MAX, space_.comm());
}

void EnrichedBody::embed(Vec y, Vec out) const { check(MatMult(embed_, y, out)); }

void EnrichedBody::interpolation_error(const scene::Field& field, double t, Vec out) const {
  const petsc::Vector linear = linear_.vector(), embedded = space_.vector();
  linear_.interpolate(field, t, linear);
  space_.interpolate(field, t, out);
  embed(linear, embedded);
  check(VecAXPY(out, -1, embedded));
}

std::vector<double> EnrichedBody::by_cells(Vec x) const {
  const auto dim = static_cast<std::size_t>(space_.dim());
  const auto V = space_.dolfinx();
  const auto owned = static_cast<std::size_t>(space_.owned_nodes());
  fem::Function sums(V), cells_at(V);
  {
    const petsc::ReadArray values(x);
    const std::span<double> to = dolfinx_versions::entries(*sums.x());
    for (std::size_t node = 0; node < owned; ++node)
      for (std::size_t c = 0; c < dim; ++c)
        to[node * dim] += values[node * dim + c];
  }
  for (int vertex : vertices_)
    dolfinx_versions::entries(*sums.x())[static_cast<std::size_t>(vertex) * dim] = 0;
  sums.x()->scatter_fwd();
  const auto& dofmap = *V->dofmap();
  const std::vector<std::int32_t> cells = linear_.mesh().owned_cells();
  for (const std::int32_t cell : cells)
    for (const std::int32_t node : dofmap.cell_dofs(cell))
      dolfinx_versions::entries(*cells_at.x())[static_cast<std::size_t>(node) * dim] += 1;
  cells_at.x()->scatter_rev(std::plus<>());
  cells_at.x()->scatter_fwd();
  std::vector<double> indicators;
  indicators.reserve(cells.size());
  for (const std::int32_t cell : cells) {
    double sum = 0;
    for (const std::int32_t node : dofmap.cell_dofs(cell)) {
      const std::size_t i = static_cast<std::size_t>(node) * dim;
      sum += std::abs(sums.x()->array()[i]) / cells_at.x()->array()[i];
    }
    indicators.push_back(sum);
  }
  return indicators;
}

void EnrichedBody::keep_bubbles(const contact::ActiveSet& active, Vec x) const {
  {
    const petsc::WriteArray values(x);
    const int dim = space_.dim();
    for (int node : vertices_)
      for (int c = 0; c < dim; ++c)
        values[static_cast<std::size_t>(node * dim + c)] = 0;
  }
  clamped_.clear(x);
  if (!pairs_ || active.empty())
    return;
  contact::ActiveSet between;
  const auto closed = [&](int i) { return std::ranges::binary_search(active, i); };
  for (std::size_t j = 0; j < ends_.size(); ++j)
    if (closed(ends_[j][0]) && closed(ends_[j][1]))
      between.push_back(static_cast<int>(j));
  contact::drop_dependent(pairs_->rows(), between);
  pairs_->rows().prescribe(between, zero_, x);
}

} // namespace signorini::adjoint
