// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <map>
#include <memory>
#include <mpi.h>
#include <string>
#include <vector>

namespace dolfinx::mesh {
template <std::floating_point T>
class Mesh;
}

namespace signorini::mesh {

struct SizeField;

/// Options for meshing a file that are not in the scene.
struct Meshing {
  /// Element sizes: a .geo is meshed with them instead of mesh.size; a .msh is refined to them if `keep` is
  /// given. Used on rank 0 only; null: none.
  const SizeField* sizes = nullptr;
  std::filesystem::path keep{}; ///< .msh file to write the mesh to, in the unit mesh.unit; none if empty
};

/// Distributed mesh of straight simplices, with named groups of cells (parts of the body) and of facets
/// (surfaces).
class Mesh {
public:
  /// Reads a .msh file or meshes a .geo file on rank 0 and distributes the result. Collective. Throws
  /// UserError, or Interrupted if a stop of any rank is requested meanwhile; every rank throws the same
  /// exception.
  Mesh(MPI_Comm comm, const scene::Mesh& mesh, const Meshing& meshing = {});

  /// Space dimension.
  [[nodiscard]] int dim() const { return dim_; }

  /// Model of a body in the plane; without meaning in space.
  [[nodiscard]] scene::PlaneModel model() const { return model_; }
  /// Whether the mesh is the half section of a body of revolution, x ≥ 0. The axis is x = 0.
  [[nodiscard]] bool axisymmetric() const { return model_ == scene::PlaneModel::axisymmetric; }
  /// scene::per_depth() of the body.
  [[nodiscard]] const char* per_depth() const { return scene::per_depth(dim_, model_); }

  /// Sides of the bounding box, m.
  [[nodiscard]] const std::array<double, 3>& extent() const { return extent_; }
  /// Diagonal of the bounding box, m: the reference length for tolerances of gaps.
  [[nodiscard]] double diameter() const { return std::hypot(extent_[0], extent_[1], extent_[2]); }

  /// Number of cells on all ranks.
  [[nodiscard]] std::int64_t cells() const { return cells_; }

  /// Local indices of the cells that this rank owns, ascending.
  [[nodiscard]] std::vector<std::int32_t> owned_cells() const;

  /// Local indices of this rank's facets in a boundary group, ascending. Throws UserError, which names the
  /// scene's `key`, on every rank if the group is missing, empty or unusable.
  [[nodiscard]] const std::vector<std::int32_t>& facets(const std::string& group,
                                                        const std::string& key) const;

  /// Local indices of the cells that this rank owns in a part of the body (a group of cells), ascending.
  /// Throws UserError, which names the scene's `key`, on every rank if the group is missing, empty or
  /// unusable.
  [[nodiscard]] const std::vector<std::int32_t>& cells(const std::string& group,
                                                       const std::string& key) const;

  /// Dimension of a group: dim() for a part of the body, dim() − 1 for a boundary group. Throws UserError,
  /// which names the scene's `key`, on every rank: if the group is missing, empty or unusable, or if there
  /// are groups of both dimensions with this name.
  [[nodiscard]] int group_dimension(const std::string& group, const std::string& key) const;

  /// Names of the usable groups of cells (parts of the body), in alphabetical order.
  [[nodiscard]] std::vector<std::string> cell_groups() const;

  /// Digest of the points, cells and groups, which identifies the mesh; empty on ranks other than 0.
  [[nodiscard]] const std::string& digest() const { return digest_; }

  /// Notes on how ambiguities of the mesh file were resolved, one sentence each; empty on ranks other than 0.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

  [[nodiscard]] std::shared_ptr<dolfinx::mesh::Mesh<double>> dolfinx() const { return mesh_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  MPI_Comm comm_;
  std::string file_, digest_;
  std::vector<std::string> notes_;
  int dim_ = 0;
  scene::PlaneModel model_;
  std::array<double, 3> extent_{};
  std::int64_t cells_ = 0;
  std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh_;
  struct Group {
    std::vector<std::int32_t> entities; ///< local indices; empty for groups of lower dimensions
    bool empty = true;                  ///< whether the group has no elements in the file
    std::string unusable{};             ///< reason why the group is unusable; empty if it is usable
  };
  using Groups = std::map<std::string, Group>;
  std::array<Groups, 4> groups_; ///< groups of each dimension 0 … 3

  [[nodiscard]] int find(const std::string& group, const std::string& key,
                         const std::vector<int>& dims) const;
};

} // namespace signorini::mesh
