// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/deformation.h"
#include "fem/forms.h"
#include <memory>
#include <span>
#include <vector>

namespace signorini::fem {

/// Fields of forms/viscoelasticity.py, by their names in that file; docs/method.md section 1.
enum class CellField { strain, stress, von_mises };

/// Returns the von Mises stress (Pa) of a stress tensor (Pa), given row by row.
double von_mises(std::span<const double, 9> stress);

/// Cellwise constant fields of a state of motion: the mean of strain or stress over each cell, and the von
/// Mises stress of the mean stress.
class CellFields {
public:
  /// Sets up the fields for the parts of the body, which have one material each. Collective. Throws
  /// std::runtime_error if a field has a coefficient or constant that the program does not provide.
  CellFields(const Space& space, const std::vector<Part>& parts);
  ~CellFields();
  CellFields(const CellFields&) = delete;
  CellFields& operator=(const CellFields&) = delete;

  /// Shape of a field's value in one cell: (3, 3) for a tensor, also in the plane; empty for the von Mises
  /// stress.
  [[nodiscard]] static Shape shape(CellField field);

  /// Sets the displacement y (m), the velocity v (m/s) and the internal displacements q (m) from which the
  /// fields are computed. `q`: one vector for each branch of the materials that relax, part by part in the
  /// order of the materials' prony, which is that of Relaxation::branches(); empty: zero. Collective. Throws
  /// std::logic_error if `q` has another number of vectors.
  void set(Vec y, Vec v, std::span<const petsc::Vector> q = {});

  /// Values of a field (strain, or Pa) for the state last set, for each cell that this rank owns; a tensor
  /// has nine values per cell, row by row. The span is valid until the next call for the same field.
  /// Collective.
  [[nodiscard]] std::span<const double> operator()(CellField field);

  /// Largest von Mises stress (Pa) for the state last set. Collective.
  [[nodiscard]] Largest largest_von_mises();

private:
  struct Expressions;
  std::unique_ptr<Expressions> expressions_;
};

} // namespace signorini::fem
