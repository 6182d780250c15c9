#pragma once
#include "contact/contact_state.h"
#include "contact/dual_active_set.h"
#include "contact/obstacle.h"
#include "fem/operators.h"
#include <span>

namespace signorini::contact {

/// The linearised nonpenetration constraints g_i(y) = ψ_i − ν_i·y_i ≥ 0 of the m contact candidates
/// (docs/method.md section 2): one for each obstacle and each node of its contact boundary that can move
/// towards it. A node may have several. Candidates are numbered by their nodes' coordinates, then by
/// obstacle, so that the numbering does not depend on the number of ranks; all arrays over candidates are the
/// same on every rank.
class Constraints {
public:
  /// Collective. Throws UserError if a group is missing or holds only clamped nodes, if an obstacle has no
  /// normal at a node, or if no position of a node satisfies the constraints of all its obstacles.
  Constraints(const fem::Space& space, const fem::DirichletDofs& clamped,
              const std::vector<scene::Contact>& contacts);

  /// m, on all ranks.
  [[nodiscard]] int count() const { return static_cast<int>(psi_.size()); }
  /// Coordinates of the candidates' nodes (m × 3), in metres.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// ν_i (m × dim), unit vectors from the body to the obstacle.
  [[nodiscard]] const std::vector<double>& normals() const { return normals_; }
  /// Columns of N (m × dim), the directions of the contact forces: ν_i, but zero in components that a clamp
  /// holds.
  [[nodiscard]] const std::vector<double>& directions() const { return directions_; }
  /// ψ_i at t = 0 (m), the gaps of the undeformed body, in metres.
  [[nodiscard]] std::span<const double> psi() const { return psi_; }
  /// ψ_i at time t (m), in metres; evaluated anew only where obstacles move, and valid until the next call.
  /// Throws UserError if no position of a node satisfies the constraints of all its obstacles. Collective.
  [[nodiscard]] std::span<const double> psi(double t) const;
  /// Whether any obstacle moves.
  [[nodiscard]] bool moving() const { return !moving_.empty(); }
  /// The obstacle of candidate i.
  [[nodiscard]] const Obstacle& obstacle(int i) const {
    return shapes_[static_cast<std::size_t>(obstacles_[static_cast<std::size_t>(i)])];
  }
  /// First global dofs, ascending, of the nodes on the contact boundary of an obstacle (number in the scene)
  /// that clamps keep from moving towards it, and which are therefore no candidates.
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
  /// Diameter of the body, in metres.
  [[nodiscard]] double diameter() const { return diameter_; }
  /// Largest penetration allowed, in metres: 1e-10 of the diameter.
  [[nodiscard]] double gap_tolerance() const { return gap_tolerance_; }
  [[nodiscard]] int dim() const { return dim_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

  /// ν_i·x of a vector at the candidates (m), including components that clamps hold. Collective.
  void normal_components(Vec x, std::span<double> out) const;

  /// The displacement (dim) of candidate i's node among the entries of y that this rank owns; null if another
  /// rank owns the node.
  [[nodiscard]] const double* displacement(int i, std::span<const double> y) const {
    const int first = local_[static_cast<std::size_t>(i)];
    return first < 0 ? nullptr : &y[static_cast<std::size_t>(first)];
  }

  /// g(y) (m), in metres, for the given ψ (m). Collective.
  void gap(std::span<const double> psi, Vec y, std::span<double> out) const;

  /// x += scale · Nλ, for λ (m).
  void add_normal(double scale, std::span<const double> lambda, Vec x) const;

  /// x += scale · Σ_i λ_i ν_i, for λ (m), including components that clamps hold.
  void add_whole(double scale, std::span<const double> lambda, Vec x) const;

  /// λ (m) with Nλ = x at the nodes of `set` and zero elsewhere, for an x in the range of the set's columns
  /// of N; of candidates of a node that are linearly dependent, the first ones carry the force. Collective.
  void forces(const ActiveSet& set, Vec x, std::span<double> lambda) const;

  /// Makes x·ν = value (m) at the candidates of `set` by the smallest change of the components that no clamp
  /// holds; of candidates of a node that are linearly dependent, for the first ones.
  void set_normal(std::span<const int> set, std::span<const double> value, Vec x) const;

  /// Whether clamps hold components of some candidate's node.
  [[nodiscard]] bool held() const { return held_; }

  /// Sets these components of y, where they contribute to ν·y, to their values in the step's system, in which
  /// they are decoupled: r divided by the matrix's diagonal.
  void hold(Vec diagonal, Vec r, Vec y) const;

  /// What the held components contribute to ν_i·y, for a candidate whose node this rank owns and the owned
  /// entries of y.
  [[nodiscard]] double held_normal(int i, std::span<const double> y) const;

  /// Whether the directions of some node's candidates are linearly dependent: more obstacles than dimensions,
  /// or opposite walls. Contact forces are then not unique, and S is singular.
  [[nodiscard]] bool dependent() const { return dependent_; }

  /// Whether the direction of candidate i depends linearly on those of its node in an independent set.
  [[nodiscard]] bool depends(const ActiveSet& set, int i) const;

  /// Removes candidates that depend on earlier ones of their node.
  void drop_dependent(ActiveSet& set) const;

  /// The next set of a primal-dual step, independent, from the solution on an independent `set`: closed
  /// candidates with λ > 0 and open ones with g < 0. A candidate that depends on others of its node replaces
  /// the one whose force falls to zero first as its own grows (ratio test).
  void next_set(const ActiveSet& set, std::span<const double> lambda, std::span<const double> gap,
                ActiveSet& next) const;

  /// Replaces the candidates of candidate i's node in `set` by those in `other`.
  void take_node(const ActiveSet& other, int i, ActiveSet& set) const;

  /// Moves nodes that start inside an obstacle for which contact.initial asks for it to the closest position
  /// that all obstacles of the node allow. Throws UserError naming the deepest candidate inside any other
  /// obstacle, or a node that has no such position. Collective.
  void place_outside(Vec y) const;

private:
  /// Candidates of one node: [first, last).
  struct Node {
    int first, last;
    bool crowded; ///< their directions are linearly dependent
  };

  void add_candidates(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                      const fem::DirichletDofs& clamped);
  void group_by_node();
  /// x += scale · Σ_i λ_i n_i for directions n (m × dim).
  void add(double scale, std::span<const double> lambda, const std::vector<double>& directions, Vec x) const;
  /// Makes the candidates of one node, those of `set` from `begin` on, independent by the ratio test of
  /// next_set().
  void exchange(std::span<const double> lambda, ActiveSet& set, std::size_t begin) const;
  /// Solves 0 ≤ λ ⟂ g + NᵀNλ ≥ 0 at one node with the gaps g: −Nλ moves the node to the closest position
  /// allowed. λ is in work_.lambda. False if there is no such position.
  [[nodiscard]] bool place(const Node& node, std::span<const double> gap) const;
  /// Throws UserError if no position of some node satisfies the constraints of all its obstacles. Collective.
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
  std::vector<std::string> keys_;   ///< names of the scene's contact tables
  std::vector<bool> project_;       ///< whether contact.initial is "project", for each table
  std::vector<Obstacle> shapes_;    ///< obstacle of each
  std::vector<std::size_t> moving_; ///< numbers of the obstacles that move
  std::vector<std::vector<PetscInt>> clamped_dofs_;
  std::vector<double> points_, normals_, directions_, psi_;
  std::vector<PetscInt> first_dofs_;
  std::vector<int> nodes_, obstacles_;
  std::vector<int> local_; ///< first local dof of each candidate's node, −1 on ranks that do not own it (m)
  std::vector<Node> per_node_;
  bool dependent_ = false, held_ = false;

  /// Scratch of const members: ψ at the last time asked for, and the advance of each obstacle by then (m).
  mutable std::vector<double> now_, advance_;
  /// Scratch of place() for one node.
  struct NodeWork {
    DualActiveSet solver{0};
    std::vector<double> gram, lambda;
    ActiveSet set;
  };
  mutable NodeWork work_;
};

} // namespace signorini::contact
