// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/enriched_body.h"
#include "base/dolfinx_versions.h"
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include "fem/function.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <utility>

namespace signorini::adjoint {
using petsc::check, petsc::dot;

EnrichedBody::EnrichedBody(const fem::Space& linear, const contact::ContactPairs* pairs,
                           const scene::Scene& scene)
    : linear_(linear), space_(linear.mesh(), 2),
      operators_(fem::assemble_operators(space_, scene.materials, true, scene.foundations)),
      clamped_(space_, scene.clamps), embed_(fem::embedding(linear, space_)) {
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
        values[node * dim + c] = 0;
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

Duals::Duals(const step::Stepper& stepper, const step::TimeGrid& grid)
    : stepper_(stepper), grid_(grid), work_(stepper.space().vector()) {
  for (petsc::Vector* x : {&p, &p_later, &velocity, &velocity_later})
    *x = stepper.space().vector();
  if (stepper.predictor())
    predictor_ = stepper.predictor()->workspace();
}

void Duals::move(int k, Vec p_k, const contact::ContactLinearisation* later) {
  Vec jump = nullptr;
  const double tau = later ? grid_.length(k + 1) : 0;
  if (const step::PredictorProjection* predictor = stepper_.predictor(); predictor && later) {
    check(VecWAXPY(work_, -2 / tau, velocity, p));
    jump = predictor->linearised_jump(later->predictor, work_, *predictor_);
  }
  std::swap(velocity, velocity_later);
  petsc::combine(velocity, tau, p, -1, velocity_later);
  if (jump)
    check(VecAXPY(velocity, tau, jump));
  std::swap(p, p_later);
  check(VecCopy(p_k, p));
}

DualBubbles::DualBubbles(const EnrichedBody& body, const step::DualAtStep& derivative,
                         const step::TimeGrid& grid)
    : body_(body), derivative_(derivative), grid_(grid), of_A_(fem::diagonal(body.operators().A)) {
  for (petsc::Vector* x : {&b_, &left_, &z_, &direction_, &image_, &work_, &diagonal_})
    *x = body.space().vector();
  if (body.operators().B)
    of_B_ = fem::diagonal(*body.operators().B);
}

void DualBubbles::set_length(double mean) {
  if (std::exchange(mean_, mean) == mean)
    return;
  check(VecAXPBY(diagonal_, mean, 0, of_A_));
  if (of_B_)
    check(VecAXPY(diagonal_, 1, of_B_));
}

void DualBubbles::add(Mat matrix, double factor) {
  body_.embed(coarse_, z_);
  check(MatMult(matrix, z_, work_));
  check(VecAXPY(left_, factor, work_));
}

void DualBubbles::residual(int k, const Duals& duals) {
  if (!coarse_)
    coarse_ = petsc::zero_like(duals.p);
  const fem::Operators& operators = body_.operators();
  const step::Scheme now = grid_.scheme(k), later = grid_.scheme(k + 1);
  step::assemble(derivative_.at(grid_.step(k)), operators, left_);
  petsc::combine(coarse_, 1 / later.tau + 2 / now.tau, duals.velocity, -1 / later.tau, duals.velocity_later);
  check(VecAXPY(coarse_, -1, duals.p));
  add(operators.M, 1);
  if (operators.B) {
    petsc::combine(coarse_, later.tau / 2, duals.p_later, -now.tau / 2, duals.p);
    add(*operators.B, 1);
    check(MatMult(*operators.B, b_, work_));
    check(VecAXPY(left_, 1, work_));
  }
  petsc::combine(coarse_, now.stiffness(), duals.p, later.stiffness(), duals.p_later);
  add(operators.A, -1);
}

void DualBubbles::apply(Vec x, const contact::ActiveSet& active, Vec out) {
  const fem::Operators& operators = body_.operators();
  check(MatMult(operators.A, x, out));
  check(VecScale(out, mean_));
  if (operators.B) {
    check(MatMult(*operators.B, x, work_));
    check(VecAXPY(out, 1, work_));
  }
  body_.keep_bubbles(active, out);
}

double DualBubbles::apply_preconditioner(const contact::ActiveSet& active) {
  check(VecPointwiseDivide(z_, left_, diagonal_));
  body_.keep_bubbles(active, z_);
  return dot(z_, left_);
}

Vec DualBubbles::next(int k, const Duals& duals, const contact::ActiveSet& active) {
  set_length((grid_.length(k) + grid_.length(k + 1)) / 2);
  residual(k, duals);
  body_.keep_bubbles(active, left_);
  const double size = apply_preconditioner(active);
  body_.keep_bubbles(active, b_);
  apply(b_, active, image_);
  check(VecAXPY(left_, -1, image_));
  double product = apply_preconditioner(active);
  check(VecCopy(z_, direction_));
  // Bound of a squared norm: 1 % in the bubbles' energy norm, below the error that the estimate neglects.
  constexpr double tolerance = 1e-4;
  constexpr int most = 1000;
  const double enough = tolerance * std::max(size, product);
  for (int iteration = 0; product > enough; ++iteration) {
    if (iteration == most)
      throw SolverFailure(fmt::format(
          "the error estimate at step {}: no convergence in {} iterations, relative residual {:.2e}", k, most,
          product / std::max(size, product)));
    apply(direction_, active, image_);
    const double length = product / dot(direction_, image_);
    check(VecAXPY(b_, length, direction_));
    check(VecAXPY(left_, -length, image_));
    const double last = std::exchange(product, apply_preconditioner(active));
    check(VecAYPX(direction_, product / last, z_));
  }
  return b_;
}

} // namespace signorini::adjoint
