// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/stress_recovery.h"
#include "base/collective.h"
#include <map>

namespace signorini::fem {
namespace {

constexpr std::size_t components = 9;

/// For each cell that this rank owns, the number of its part.
std::vector<double> part_numbers(const mesh::Mesh& mesh, const std::vector<Part>& parts) {
  std::vector<double> numbers(mesh.owned_cells().size());
  for (std::size_t part = 0; part < parts.size(); ++part)
    for (const std::int32_t cell : parts[part].cells)
      numbers.at(static_cast<std::size_t>(cell)) = static_cast<double>(part);
  return numbers;
}

} // namespace

StressRecovery::StressRecovery(const Space& space, const std::vector<Part>& parts)
    : space_(space), fields_(space, parts), rest_(space.vector()) {
  std::vector<double> part;
  cells_ = mesh::gathered(space.mesh(), part_numbers(space.mesh(), parts), part);
  const std::size_t corners = static_cast<std::size_t>(cells_.dim) + 1;
  std::map<std::pair<std::int64_t, double>, std::size_t> rows;
  for (std::size_t i = 0; i < cells_.cells.size(); ++i)
    rows_.push_back(rows.try_emplace({cells_.cells[i], part[i / corners]}, rows.size()).first->second);
  volumes_ = mesh::volumes(cells_);
  sums_.assign(volumes_.size(), 0.0);
}

std::vector<double> StressRecovery::tensors(CellField field) {
  const std::span<const double> values = fields_(field);
  return gather(space_.mesh().comm(), std::vector<double>(values.begin(), values.end()));
}

void StressRecovery::add(Vec y, double weight) {
  fields_.set(y, rest_);
  const std::vector<double> stress = tensors(CellField::stress), strain = tensors(CellField::strain);
  const std::size_t corners = static_cast<std::size_t>(cells_.dim) + 1, count = volumes_.size();
  const std::size_t nodes = rows_.empty() ? 0 : std::ranges::max(rows_) + 1;
  std::vector<double> touching(nodes), of_stress(nodes * components), of_strain(nodes * components);
  for (std::size_t cell = 0; cell < count; ++cell)
    for (std::size_t i = 0; i < corners; ++i) {
      const std::size_t node = rows_[cell * corners + i];
      touching[node] += volumes_[cell];
      for (std::size_t c = 0; c < components; ++c) {
        of_stress[node * components + c] += volumes_[cell] * stress[cell * components + c];
        of_strain[node * components + c] += volumes_[cell] * strain[cell * components + c];
      }
    }
  // ∫ of a product of functions linear on a simplex K: |K| / ((d+1)(d+2)) (Σ a_i Σ b_j + Σ a_i b_i).
  const double share = 1.0 / static_cast<double>(corners * (corners + 1));
  for (std::size_t cell = 0; cell < count; ++cell) {
    double energy = 0;
    for (std::size_t c = 0; c < components; ++c) {
      double all_a = 0, all_b = 0;
      for (std::size_t i = 0; i < corners; ++i) {
        const std::size_t node = rows_[cell * corners + i];
        const double a = of_stress[node * components + c] / touching[node] - stress[cell * components + c],
                     b = of_strain[node * components + c] / touching[node] - strain[cell * components + c];
        all_a += a, all_b += b;
        energy += a * b;
      }
      energy += all_a * all_b;
    }
    sums_[cell] += weight / 2 * volumes_[cell] * share * std::max(0.0, energy);
  }
}

} // namespace signorini::fem
