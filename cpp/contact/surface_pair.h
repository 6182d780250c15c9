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
  /// facet_size() of the slave side, m.
  [[nodiscard]] double facet_size() const { return facet_size_; }
  /// Rows of the slave nodes. The gaps include contact.height.
  [[nodiscard]] const std::vector<MortarRow>& rows() const { return rows_; }
  /// Slave node of a row.
  [[nodiscard]] const fem::SurfaceMesh::Vertex& node(const MortarRow& row) const {
    return slave_.vertices[static_cast<std::size_t>(row.vertex)];
  }
  /// Integral of the hat function of the slave node of a row over all of its facets, m or m².
  [[nodiscard]] double slave_area(const MortarRow& row) const {
    return slave_areas_[static_cast<std::size_t>(row.vertex)];
  }
  /// contact.height, m.
  [[nodiscard]] double height() const { return height_; }
  /// Whether the slave side is the one with the larger facets, since clamps hold nodes of the other one.
  [[nodiscard]] bool exchanged() const { return exchanged_; }
  /// Calls visit(vertex, weight, area) for the integrals with hat functions of the master surface in a row,
  /// whose sum is 1, with the integral of the hat function over all of its facets. A hat function of degree 2
  /// is that of its vertex and half of those of the midpoints around.
  template <class Visit>
  void for_each_master_hat(const MortarRow& row, Visit&& visit) const {
    for (const auto& [node, weight] : row.master)
      if (const auto number = static_cast<std::size_t>(node); number < master_.vertices.size())
        visit(master_.vertices[number], weight, master_areas_[number]);
      else
        for (const int end : master_.midpoints[number - master_.vertices.size()].ends)
          visit(master_.vertices[static_cast<std::size_t>(end)], weight / 2,
                master_areas_[static_cast<std::size_t>(end)]);
  }
  /// Unclamped components of the slave node of a row, one bit for each.
  [[nodiscard]] int free_components(const MortarRow& row) const {
    return slave_free_[static_cast<std::size_t>(row.vertex)];
  }
  /// Derivative of a row's gap by contact.height.
  [[nodiscard]] double height_rate(const MortarRow& row) const;

  /// Completes a row that has the direction e (dim) at the slave node: scales these entries by B_ii, and
  /// appends B_ij e at other slave nodes and −C_ij e at master nodes.
  void append(const MortarRow& of, std::span<const double> direction,
              std::vector<ConstraintRows::Entry>& row) const;
  /// First global dofs, ascending, of the master nodes in the rows.
  [[nodiscard]] std::vector<PetscInt> master_dofs() const;

private:
  scene::ContactSide side_ = scene::ContactSide::on;
  fem::SurfaceMesh slave_, master_;
  std::vector<int> slave_free_, master_free_; ///< unclamped components of the nodes
  std::vector<MortarRow> rows_;
  std::vector<double> slave_areas_, master_areas_; ///< hat_areas()
  double facet_size_ = 0, height_ = 0;
  bool exchanged_ = false;
  std::array<double, 3> towards_{}; ///< mean of ν_i over the covered surface, a unit vector
};

} // namespace signorini::contact
