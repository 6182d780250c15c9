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

/// Options for meshing a file, beside the scene's.
struct Meshing {
  const SizeField* sizes = nullptr; ///< replaces mesh.size, or refines a .msh; read on rank 0
  std::filesystem::path keep{};     ///< path to write the mesh to as a .msh, in the file's unit; empty: none
};

/// A distributed mesh of straight simplices with named groups of cells (parts of the body) and of facets
/// (surfaces).
class Mesh {
public:
  /// Reads a .geo or .msh on rank 0 and distributes it. Collective. Throws UserError, or Interrupted if a
  /// rank was asked to stop meanwhile, on every rank alike.
  Mesh(MPI_Comm comm, const scene::Mesh& mesh, const Meshing& meshing = {});

  /// Space dimension.
  [[nodiscard]] int dim() const { return dim_; }

  /// Sides of the bounding box, m.
  [[nodiscard]] const std::array<double, 3>& extent() const { return extent_; }
  /// Diagonal of the bounding box, m: the reference length of tolerances for gaps.
  [[nodiscard]] double diameter() const { return std::hypot(extent_[0], extent_[1], extent_[2]); }

  /// Number of cells on all ranks.
  [[nodiscard]] std::int64_t cells() const { return cells_; }

  /// Cells that this rank owns, local indices ascending.
  [[nodiscard]] std::vector<std::int32_t> owned_cells() const;

  /// This rank's facets of a boundary group, local indices. Throws UserError, naming the scene's `key`, if
  /// there is no such group or it is empty; the same on every rank.
  [[nodiscard]] const std::vector<std::int32_t>& facets(const std::string& group,
                                                        const std::string& key) const;

  /// The cells of a part of the body that this rank owns, local indices ascending. Throws UserError like
  /// facets().
  [[nodiscard]] const std::vector<std::int32_t>& cells(const std::string& group,
                                                       const std::string& key) const;

  /// Dimension of a group: dim() of a part of the body, dim() − 1 of a boundary group. Throws UserError,
  /// naming the scene's `key`, if no such group has elements or if both kinds have one of that name; the same
  /// on every rank.
  [[nodiscard]] int group_dimension(const std::string& group, const std::string& key) const;

  /// Digest of points, cells and groups as read, which identifies the mesh; empty on ranks other than 0.
  [[nodiscard]] const std::string& digest() const { return digest_; }

  /// Notes on how ambiguities of the file were resolved, a sentence each; empty on ranks other than 0.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

  [[nodiscard]] std::shared_ptr<dolfinx::mesh::Mesh<double>> dolfinx() const { return mesh_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  MPI_Comm comm_;
  std::string file_, digest_;
  std::vector<std::string> notes_;
  int dim_ = 0;
  std::array<double, 3> extent_{};
  std::int64_t cells_ = 0;
  std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh_;
  struct Group {
    std::vector<std::int32_t> entities; ///< on this rank; empty for groups of neither cells nor facets
    bool empty = true;                  ///< whether it has no elements in the file
    std::string unusable{};             ///< why it is unusable, if it is
  };
  using Groups = std::map<std::string, Group>;
  std::array<Groups, 4> groups_; ///< by dimension

  [[nodiscard]] int find(const std::string& group, const std::string& key,
                         const std::vector<int>& dims) const;
};

} // namespace signorini::mesh
