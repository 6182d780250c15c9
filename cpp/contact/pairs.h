// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/contact_state.h"
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/obstacle.h"
#include "fem/operators.h"
#include <optional>
#include <span>

namespace signorini::contact {

/// The m contact pairs of a node and an obstacle with their linearised nonpenetration constraints g_i(y) =
/// ψ_i − ν_i·y_i ≥ 0 (docs/method.md section 2): one for each obstacle and each node of its contact boundary
/// that can move towards it. A node may be in several pairs, each a candidate of its own. Pairs are numbered
/// by their nodes' coordinates, then by obstacle, so that the numbering does not depend on the number of
/// ranks. All arrays over pairs are the same on every rank.
class ContactPairs {
public:
  /// Finds the pairs. Obstacles that move are sampled in the steps of `time`, or at a thousand times. A
  /// pair's direction is taken when the obstacle first touches the undeformed node or, if it never does, is
  /// nearest to it. Collective. Throws UserError if a group is missing or has only clamped nodes, if an
  /// obstacle has no normal at a node, or if no position of a node satisfies the constraints of all its
  /// obstacles.
  ContactPairs(const fem::Space& space, const fem::DirichletDofs& clamped,
               const std::vector<scene::Contact>& contacts, const scene::Time& time = {});

  /// Number m of pairs, on all ranks.
  [[nodiscard]] int count() const { return static_cast<int>(psi_.size()); }
  /// Coordinates of the nodes (m × 3), in metres.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// ν_i (m × dim), unit vectors from the body to the obstacle.
  [[nodiscard]] const std::vector<double>& normals() const { return normals_; }
  /// The constraints as rows on the dofs of their nodes: H in the gaps ψ − Hᵀy.
  [[nodiscard]] const ConstraintRows& rows() const { return *rows_; }
  /// ψ_i at t = 0 (m), the gaps of the undeformed body, in metres.
  [[nodiscard]] std::span<const double> psi() const { return psi_; }

  /// Scratch for the at most `size` pairs of one node.
  struct NodeWork {
    explicit NodeWork(std::size_t size) : solver(size) {
      gram.reserve(size * size);
      lambda.reserve(size);
      set.reserve(size);
    }
    GoldfarbIdnaniWork solver;
    std::vector<double> gram, lambda;
    ActiveSet set;
  };
  [[nodiscard]] NodeWork node_work() const;

  /// Storage of ψ at one time.
  struct Gaps {
    std::vector<double> psi;            ///< (m), empty where no obstacle moves
    std::vector<Obstacle::Place> place; ///< position and size of each obstacle
    NodeWork node;
  };
  [[nodiscard]] Gaps gaps() const;
  /// ψ_i at time t (m), in metres; computed in `gaps` only if obstacles move. Throws UserError if no
  /// position of a node satisfies the constraints of all its obstacles. Collective.
  [[nodiscard]] std::span<const double> psi(double t, Gaps& gaps) const;
  /// Derivatives of the pairs by a parameter of an obstacle; zero for pairs of other obstacles.
  struct Rates {
    std::vector<double> psi;            ///< derivatives of ψ, from rates() at t = 0 (m)
    std::optional<ConstraintRows> rows; ///< derivatives of the rows; absent if the normals do not change
  };
  [[nodiscard]] Rates rates(int obstacle, const scene::ObstacleRate& rate) const;
  /// Sets the derivatives of ψ to those at time t if the obstacle moves.
  void set_time(int obstacle, const scene::ObstacleRate& rate, double t, Rates& rates) const;

  /// Whether any obstacle moves.
  [[nodiscard]] bool moving() const { return !moving_.empty(); }

  /// The obstacle of pair i.
  [[nodiscard]] const Obstacle& obstacle(int i) const { return shapes_[obstacles_[i]]; }
  /// The obstacle with the given number in the scene.
  [[nodiscard]] const Obstacle& shape(int obstacle) const { return shapes_[obstacle]; }
  /// Number of obstacles in the scene.
  [[nodiscard]] int obstacle_count() const { return static_cast<int>(keys_.size()); }
  /// Number of each pair's obstacle in the scene (m).
  [[nodiscard]] const std::vector<int>& obstacles() const { return obstacles_; }
  /// Whether nodes that start inside an obstacle are to be moved out of it (contact.initial).
  [[nodiscard]] bool projects(int obstacle) const { return project_[obstacle]; }
  /// Name of an obstacle's table in the scene.
  [[nodiscard]] const std::string& key(int obstacle) const { return keys_[obstacle]; }
  /// First global dofs, ascending, of the nodes on the contact boundary of an obstacle (number in the scene)
  /// that cannot move towards it because of clamps, and are therefore in no pair.
  [[nodiscard]] const std::vector<PetscInt>& clamped_dofs(int obstacle) const {
    return clamped_dofs_[obstacle];
  }

  /// First global dof of each pair's node (m).
  [[nodiscard]] const std::vector<PetscInt>& first_dofs() const { return first_dofs_; }
  /// First local dof of each pair's node, −1 on ranks that do not own it (m).
  [[nodiscard]] const std::vector<int>& local_dofs() const { return local_; }
  /// The displacement (dim) of pair i's node among the entries of y that this rank owns; null if another rank
  /// owns the node.
  [[nodiscard]] const double* displacement(int i, std::span<const double> y) const {
    const int first = local_[i];
    return first < 0 ? nullptr : &y[first];
  }

  /// Diameter of the body, in metres.
  [[nodiscard]] double diameter() const { return diameter_; }
  /// Largest penetration allowed, in metres: 1e-10 of the diameter.
  [[nodiscard]] double gap_tolerance() const { return gap_tolerance_; }
  [[nodiscard]] int dim() const { return dim_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  /// A node of the contact boundary of an obstacle, with a bit for each unclamped component.
  struct BoundaryNode {
    std::array<double, 3> x;
    std::int64_t first_dof;
    int obstacle, free_components;
  };
  /// Boundary nodes of all ranks, in the order of the pairs. Collective.
  [[nodiscard]] std::vector<BoundaryNode> boundary_nodes(const std::vector<scene::Contact>& contacts,
                                                         const fem::Space& space,
                                                         const fem::DirichletDofs& clamped) const;
  void add_pairs(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                 const fem::DirichletDofs& clamped, const scene::Time& time);
  /// Time at which the direction of each node's pair is taken, s.
  [[nodiscard]] std::vector<double> times_of_meeting(const std::vector<BoundaryNode>& nodes,
                                                     const scene::Time& time) const;

  int dim_;
  double diameter_, gap_tolerance_;
  MPI_Comm comm_;
  std::vector<std::string> keys_;
  std::vector<bool> project_; ///< whether contact.initial moves nodes out of each obstacle
  std::vector<Obstacle> shapes_;
  std::vector<std::size_t> moving_; ///< numbers of the obstacles that move
  std::vector<std::vector<PetscInt>> clamped_dofs_;
  std::vector<double> points_, normals_, psi_;
  std::vector<PetscInt> first_dofs_;
  std::vector<int> obstacles_, local_;
  std::optional<ConstraintRows> rows_; ///< absent until the pairs are known
};

/// Moves nodes that start inside an obstacle with contact.initial = "project" to the closest position that
/// all obstacles of the node allow. Throws UserError naming the deepest node inside any other obstacle, or a
/// node that has no such position. Collective.
void place_outside(const ContactPairs& pairs, Vec y);

} // namespace signorini::contact
