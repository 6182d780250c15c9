#pragma once
#include "contact/contact_state.h"
#include "contact/dual_active_set.h"
#include "contact/obstacle.h"
#include "fem/operators.h"
#include <span>

namespace signorini::contact {

/// The linearised nonpenetration constraints g_i(y) = ψ_i − ν_i·y_i ≥ 0 of the m contact candidates
/// (docs/method.md section 2): one for each obstacle and each node of its contact boundary that can move against
/// it. A node may have several. Candidates are numbered by their nodes' coordinates, then by obstacle, so
/// that the numbering does not depend on the number of ranks; all arrays over candidates are the same on
/// every rank.
class Constraints {
public:
  /// Collective. Throws UserError if a group is missing or holds only clamped nodes, if an obstacle has no
  /// normal at a node, or if obstacles leave a node no room.
  Constraints(const fem::Space& space, const fem::Clamped& clamped,
              const std::vector<scene::Contact>& contacts);

  /// m, on all ranks.
  [[nodiscard]] int count() const { return static_cast<int>(psi_.size()); }
  /// Coordinates (m × 3), m.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// ν_i (m × dim), unit vectors from the body to the obstacle.
  [[nodiscard]] const std::vector<double>& normals() const { return normals_; }
  /// Columns of N (m × dim), the directions of the contact forces: ν_i, but zero in components that a clamp
  /// holds.
  [[nodiscard]] const std::vector<double>& directions() const { return directions_; }
  /// ψ_i at t = 0 (m), gaps of the undeformed body, m.
  [[nodiscard]] std::span<const double> psi() const { return psi_; }
  /// ψ_i at time t (m), m; evaluated anew only where obstacles move, and valid until the next call. Throws
  /// UserError if obstacles leave a node no room.
  [[nodiscard]] std::span<const double> psi(double t) const;
  /// Whether any obstacle moves.
  [[nodiscard]] bool moving() const { return !moving_.empty(); }
  /// The obstacle of candidate i.
  [[nodiscard]] const Obstacle& obstacle(int i) const {
    return shapes_[static_cast<std::size_t>(obstacles_[static_cast<std::size_t>(i)])];
  }
  /// Numbers of the first dofs, ascending, of the nodes on the boundary of an obstacle of the scene that clamps
  /// hold against it, and which are no candidates for that.
  [[nodiscard]] const std::vector<PetscInt>& clamped_dofs(int obstacle) const {
    return clamped_dofs_[static_cast<std::size_t>(obstacle)];
  }
  /// First global dof of each candidate's node (m).
  [[nodiscard]] const std::vector<PetscInt>& first_dofs() const { return first_dofs_; }
  /// Number of each candidate's node among the nodes that have candidates, ascending (m).
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  /// Obstacles of the scene.
  [[nodiscard]] int obstacle_count() const { return static_cast<int>(keys_.size()); }
  /// Number of each candidate's obstacle in the scene (m).
  [[nodiscard]] const std::vector<int>& obstacles() const { return obstacles_; }
  /// Of the body, m.
  [[nodiscard]] double diameter() const { return diameter_; }
  /// No penetration may be above this length: 1e-10 of the diameter, m.
  [[nodiscard]] double gap_tolerance() const { return gap_tolerance_; }
  [[nodiscard]] int dim() const { return dim_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

  /// Nᵀx: the ν-components of a vector at the candidates (m), held components included. Collective.
  void normal_components(Vec x, std::span<double> out) const;

  /// The displacement of a candidate's node, of the entries of y that this rank owns; null where another owns it.
  [[nodiscard]] const double* displacement(int i, std::span<const double> y) const {
    const int first = local_[static_cast<std::size_t>(i)];
    return first < 0 ? nullptr : &y[static_cast<std::size_t>(first)];
  }

  /// g(y) (m) for the ψ in force (m), m. Collective.
  void gap(std::span<const double> psi, Vec y, std::span<double> out) const;

  /// x += scale · Nλ.
  void add_normal(double scale, std::span<const double> lambda, Vec x) const;

  /// x += scale · Σ_i λ_i ν_i, held components included.
  void add_whole(double scale, std::span<const double> lambda, Vec x) const;

  /// λ (m) with Nλ = x at the nodes of a set and λ zero elsewhere, for an x that the set's forces can make.
  /// Collective.
  void forces(const ActiveSet& set, Vec x, std::span<double> lambda) const;

  /// Changes x least, in free components at the candidates of a set, so that x·ν = value (m) there; where
  /// candidates of a node depend on each other, for the first of them.
  void set_normal(std::span<const int> set, std::span<const double> value, Vec x) const;

  /// Whether clamps hold components of some candidate's node along its ν.
  [[nodiscard]] bool held() const { return held_; }

  /// Sets these components of y to what the step's system says, in which they are decoupled: r over the
  /// matrix's diagonal.
  void hold(Vec diagonal, Vec r, Vec y) const;

  /// Their share in ν_i·y for a candidate of this rank and the owned entries of y.
  [[nodiscard]] double held_normal(int i, std::span<const double> y) const;

  /// Whether candidates of some node depend on each other: more obstacles than dimensions, or opposite walls.
  /// The forces of a motion are then not unique, and S is singular.
  [[nodiscard]] bool dependent() const { return dependent_; }

  /// Whether candidate i depends on those of its node in an independent set.
  [[nodiscard]] bool depends(const ActiveSet& set, int i) const;

  /// Leaves out candidates that depend on earlier ones of their node.
  void drop_dependent(ActiveSet& set) const;

  /// The independent set that the solution on an independent `set` calls for: closed candidates that push and
  /// open ones that penetrate. Where one of these depends on others of its node, it takes the place of the
  /// one whose force it would use up first.
  void next_set(const ActiveSet& set, std::span<const double> lambda, std::span<const double> gap,
                ActiveSet& next) const;

  /// Takes what `other` has of the node of candidate i into `set`.
  void take_node(const ActiveSet& other, int i, ActiveSet& set) const;

  /// Moves y to the closest place that all obstacles of a node allow where it starts inside one whose contact
  /// asks for this (contact.initial). Throws UserError naming the deepest candidate inside another.
  /// Collective.
  void place_outside(Vec y) const;

private:
  /// Candidates of one node, from the first to before the last.
  struct Node {
    int first, last;
    bool crowded; ///< they depend on each other
  };

  void add_candidates(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                      const fem::Clamped& clamped);
  void group_by_node();
  /// x += scale · Σ_i λ_i n_i for directions n (m × dim).
  void add(double scale, std::span<const double> lambda, const std::vector<double>& directions, Vec x) const;
  /// Makes the part of a set from `begin` on, which is one node's, independent, as next_set() says.
  void exchange(std::span<const double> lambda, ActiveSet& set, std::size_t begin) const;
  /// Solves 0 ≤ λ ⟂ g + NᵀNλ ≥ 0 at one node, g its gaps: −Nλ moves the node to the closest place that is
  /// allowed. λ is work_.lambda. False if there is no such place.
  [[nodiscard]] bool place(const Node& node, std::span<const double> gap) const;
  void require_room(std::span<const double> psi, double t) const;
  [[nodiscard]] const Node& node(int i) const {
    return per_node_[static_cast<std::size_t>(nodes_[static_cast<std::size_t>(i)])];
  }
  [[nodiscard]] const double* direction(int i) const {
    return &directions_[static_cast<std::size_t>(i * dim_)];
  }
  [[nodiscard]] std::string shown(int i) const;

  int dim_;
  double diameter_, gap_tolerance_;
  MPI_Comm comm_;
  std::vector<std::string> keys_; ///< names of the scene's tables of contact
  std::vector<bool> project_;     ///< contact.initial of each
  std::vector<Obstacle> shapes_;  ///< of each
  std::vector<std::size_t> moving_; ///< numbers of those that move
  std::vector<std::vector<PetscInt>> clamped_dofs_;
  std::vector<double> points_, normals_, directions_, psi_;
  std::vector<PetscInt> first_dofs_;
  std::vector<int> nodes_, obstacles_;
  std::vector<int> local_; ///< first local dof of each candidate's node, −1 on ranks that do not own it (m)
  std::vector<Node> per_node_;
  bool dependent_ = false, held_ = false;

  /// Work of const members: ψ at the last time asked for, how far each obstacle has come by then.
  mutable std::vector<double> now_, advance_;
  /// For one node.
  struct NodeWork {
    DualActiveSet solver{0};
    std::vector<double> gram, lambda;
    ActiveSet set;
  };
  mutable NodeWork work_;
};

} // namespace signorini::contact
