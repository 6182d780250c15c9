// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/mortar.h"
#include "fem/operators.h"
#include "scene/scene.h"

namespace signorini::contact {

/// The two surfaces of contact between parts of the body, with the constraints of the slave nodes.
class SurfacePair {
public:
  /// Finds the rows. Without contact.slave the slave side is that with the smaller facets, or the other one
  /// if clamps hold nodes of the first one along ν. `key`: of the contact in messages. Collective. Throws
  /// UserError if the groups have common nodes, if no nodes face each other, or if clamps hold slave nodes.
  SurfacePair(const fem::Space& space, const fem::DirichletDofs& clamped, const scene::Contact& contact,
              const std::string& key);

  [[nodiscard]] scene::ContactSide slave_side() const { return side_; }
  /// Rows of the slave nodes. The gaps include contact.height.
  [[nodiscard]] const std::vector<MortarRow>& rows() const { return rows_; }
  /// Slave node of a row.
  [[nodiscard]] const fem::SurfaceMesh::Vertex& node(const MortarRow& row) const {
    return slave_.vertices[static_cast<std::size_t>(row.vertex)];
  }
  /// Vertex of the master surface with this number.
  [[nodiscard]] const fem::SurfaceMesh::Vertex& master_node(int vertex) const {
    return master_.vertices[static_cast<std::size_t>(vertex)];
  }
  /// Unclamped components of the slave node of a row, one bit for each.
  [[nodiscard]] int free_components(const MortarRow& row) const {
    return slave_free_[static_cast<std::size_t>(row.vertex)];
  }
  /// Derivative of a row's gap by contact.height.
  [[nodiscard]] double height_rate(const MortarRow& row) const;

  /// Appends to a row with the direction e (dim) at the slave node the entries −C_ij e at the master nodes.
  void append(const MortarRow& of, std::span<const double> direction,
              std::vector<ConstraintRows::Entry>& row) const;
  /// First global dofs, ascending, of the master nodes that rows contain.
  [[nodiscard]] std::vector<PetscInt> master_dofs() const;

private:
  scene::ContactSide side_ = scene::ContactSide::on;
  fem::SurfaceMesh slave_, master_;
  std::vector<int> slave_free_, master_free_; ///< unclamped components of the vertices
  std::vector<MortarRow> rows_;
  std::array<double, 3> towards_{}; ///< mean of ν_i over the covered surface, a unit vector
};

} // namespace signorini::contact
