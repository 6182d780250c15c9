// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/contact_state.h"
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/obstacle.h"
#include "contact/rigid_body.h"
#include "contact/surface_pair.h"
#include "fem/operators.h"
#include <memory>
#include <optional>
#include <span>

namespace signorini::contact {

/// The m contact pairs (candidates), each of a node and an obstacle, with their linearised nonpenetration
/// constraints g_i(y) = ψ_i − ν_i·y_i ≥ 0 (docs/method.md section 2). There is one pair for each obstacle and
/// each node of its contact boundary that can move towards the obstacle; a node may be in several pairs. With
/// contact.against another surface of the body is in the place of the obstacle, and a pair is a slave node
/// with the master nodes opposite it.
/// Pairs are numbered by their nodes' coordinates, then by obstacle, so that the numbering does not depend on
/// the number of ranks. All arrays over pairs are the same on every rank.
class ContactPairs {
public:
  /// Finds the pairs. Curved obstacles that move are sampled at the time steps of `time`, or at a thousand
  /// times if step lengths are automatic. The direction ν of a pair is that at the first time when the
  /// obstacle touches the undeformed node or, if it never does, at the time when it is nearest. Collective.
  /// Throws UserError if a group is missing or has only clamped nodes, if an obstacle has no normal at a
  /// node, or if no position of a node satisfies the constraints of all its obstacles.
  ContactPairs(const fem::Space& space, const fem::DirichletDofs& clamped,
               const std::vector<scene::Contact>& contacts, const scene::Time& time = {});

  /// Number m of pairs on all ranks.
  [[nodiscard]] int count() const { return static_cast<int>(psi_.size()); }
  /// Coordinates of the pairs' nodes (m × 3), in metres.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// Returns the coordinates of a pair's node as text, for messages.
  [[nodiscard]] std::string node_text(int i) const;
  /// ν_i (m × dim), unit vectors from the body to the obstacle.
  [[nodiscard]] const std::vector<double>& normals() const { return normals_; }
  /// Constraint operator H in the gaps ψ − Hᵀy: one row per pair, on the dofs of the pair's node.
  [[nodiscard]] const ConstraintRows& rows() const { return *rows_; }
  /// Gaps ψ_i of the undeformed body at t = 0 (m entries), in metres.
  [[nodiscard]] std::span<const double> psi() const { return psi_; }

  /// Scratch for computations with the pairs of one node, at most `size` pairs.
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

  /// Storage for ψ at one time.
  struct Gaps {
    std::vector<double> psi;            ///< gaps (m entries), in metres; empty if no obstacle moves
    std::vector<Obstacle::Place> place; ///< position and size of each obstacle
    NodeWork node;
  };
  [[nodiscard]] Gaps gaps() const;
  /// Gaps ψ_i of the undeformed body at time t (s), in metres (m entries). If an obstacle moves, the result
  /// is stored in `gaps`, and the span refers to it. Throws UserError if no position of a node satisfies the
  /// constraints of all its obstacles. Collective.
  [[nodiscard]] std::span<const double> psi(double t, Gaps& gaps) const;
  /// Sets `friction` (m entries) as ContactState::friction for a step that ends at time t (s): coefficients
  /// of Coulomb friction, and `impulse` (τ²/2) times the bounds of nodal forces in Tresca friction, which are
  /// tractions times ∫ φ_i. Throws UserError if one is negative or not finite.
  void friction(double t, double impulse, std::vector<double>& friction) const;
  /// Sets `way` (rows) to the ways ds of the obstacles along the tangents from time t0 to t1 (s), m: those of
  /// their motion, and those of their surface velocity in the middle of the step. Normal rows become zero.
  void obstacle_ways(double t0, double t1, std::span<double> way) const;
  /// Adds the ways of the surface velocity `velocity` of an obstacle (number in the scene) from time t0 to t1
  /// (s) to the tangential rows of its pairs in `way` (rows), m.
  void add_surface_ways(int obstacle, const scene::Field& velocity, double t0, double t1,
                        std::span<double> way) const;

  /// Derivatives of the pairs with respect to a parameter of one obstacle; zero for pairs of other obstacles.
  struct Rates {
    std::vector<double> psi;            ///< derivatives of ψ (m entries); rates() sets those at t = 0
    std::optional<ConstraintRows> rows; ///< derivatives of the rows; absent if no normal changes
  };
  [[nodiscard]] Rates rates(int obstacle, const scene::ObstacleRate& rate) const;
  /// Sets rates.psi to the derivatives at time t (s); does nothing if the obstacle does not move.
  void set_time(int obstacle, const scene::ObstacleRate& rate, double t, Rates& rates) const;

  /// Motion of an obstacle (number in the scene) with mass; null without mass.
  [[nodiscard]] const RigidMotion* rigid(int obstacle) const {
    const auto& motion = rigid_[static_cast<std::size_t>(obstacle)];
    return motion ? &*motion : nullptr;
  }
  /// Sets the velocities v (a vector of V) of the obstacles with mass to those at the start. Not collective.
  void set_rigid_velocities(Vec v) const;
  /// Whether any obstacle moves as the scene prescribes.
  [[nodiscard]] bool moving() const { return !moving_.empty(); }

  /// Obstacle of pair i; null with contact.against.
  [[nodiscard]] const Obstacle* obstacle(int i) const { return shape(obstacles_[i]); }
  /// Obstacle with this number in the scene; null with contact.against.
  [[nodiscard]] const Obstacle* shape(int obstacle) const {
    const std::optional<Obstacle>& shape = shapes_[static_cast<std::size_t>(obstacle)];
    return shape ? &*shape : nullptr;
  }
  /// The two surfaces of a contact (number in the scene) with contact.against; null for an obstacle.
  [[nodiscard]] const SurfacePair* surfaces(int obstacle) const {
    const std::optional<SurfacePair>& pair = surfaces_[static_cast<std::size_t>(obstacle)];
    return pair ? &*pair : nullptr;
  }
  /// Returns the jumps of displacements of the pairs of two surfaces, a row for each pair and axis (pair by
  /// pair); absent without contact.against. Collective.
  [[nodiscard]] std::optional<ConstraintRows> jumps(const fem::Space& space) const;
  /// Row of pair i of two surfaces; null for an obstacle.
  [[nodiscard]] const MortarRow* mortar_row(int i) const { return mortar_[static_cast<std::size_t>(i)]; }
  /// Factor of the forces on a contact's candidates in those on the group `contact.on`: −1 if the candidates
  /// are on the side `against`, else 1.
  [[nodiscard]] double side(int obstacle) const {
    const SurfacePair* pair = surfaces(obstacle);
    return pair && pair->slave_side() == scene::ContactSide::against ? -1 : 1;
  }
  /// Number of obstacles in the scene.
  [[nodiscard]] int obstacle_count() const { return static_cast<int>(keys_.size()); }
  /// For each pair, the number of its obstacle in the scene (m entries).
  [[nodiscard]] const std::vector<int>& obstacles() const { return obstacles_; }
  /// Whether nodes that start inside an obstacle (number in the scene) are to be moved out of it
  /// (contact.initial).
  [[nodiscard]] bool projects(int obstacle) const { return project_[obstacle]; }
  /// Whether nodes on the axis of a body of revolution are no candidates, as in degree 2.
  [[nodiscard]] bool skips_axis() const { return skips_axis_; }
  /// Node on the axis that is no candidate and deepest inside an obstacle.
  struct Depth {
    double depth = 0; ///< m; 0 if no such node is inside
    int obstacle = -1;
    std::array<double, 3> x{}; ///< its undeformed position, m
  };
  /// Returns the deepest of the nodes on the axis that are no candidates, for the displacement y at time t
  /// (s). Collective.
  [[nodiscard]] Depth deepest_on_axis(Vec y, double t) const;
  /// Name of the table of an obstacle (number in the scene) in the scene file.
  [[nodiscard]] const std::string& key(int obstacle) const { return keys_[obstacle]; }
  /// First global dofs, ascending, of the nodes on the contact boundary of an obstacle that have no pair,
  /// because clamps prevent them from moving towards the obstacle. `obstacle`: number in the scene.
  [[nodiscard]] const std::vector<PetscInt>& clamped_dofs(int obstacle) const {
    return clamped_dofs_[obstacle];
  }

  /// For each pair, the first global dof of its node (m entries).
  [[nodiscard]] const std::vector<PetscInt>& first_dofs() const { return first_dofs_; }
  /// For each pair, the first local dof of its node, or −1 on ranks that do not own the node (m entries).
  [[nodiscard]] const std::vector<int>& local_dofs() const { return local_; }
  /// Address of the displacement (dim) of pair i's node in `y`; null if another rank owns the node. `y`:
  /// entries of a vector of V that this rank owns.
  [[nodiscard]] const double* displacement(int i, std::span<const double> y) const {
    const int first = local_[i];
    return first < 0 ? nullptr : &y[first];
  }

  /// Diameter of the body (diagonal of its bounding box), in metres.
  [[nodiscard]] double diameter() const { return diameter_; }
  /// Largest penetration accepted, in metres: 1e-10 times diameter().
  [[nodiscard]] double gap_tolerance() const { return gap_tolerance_; }
  [[nodiscard]] int dim() const { return dim_; }
  /// Whether the bodies are bodies of revolution.
  [[nodiscard]] bool axisymmetric() const { return axisymmetric_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  /// Node on the contact boundary of an obstacle. `free_components` has one bit for each unclamped component.
  struct BoundaryNode {
    std::array<double, 3> x;
    std::int64_t first_dof;
    int obstacle, free_components;
    const MortarRow* row = nullptr; ///< of a slave node
  };
  /// Normal out of the obstacle and gap of a node's pair at the time when its direction is computed.
  [[nodiscard]] Obstacle::Plane plane_of(const BoundaryNode& node, double meeting) const;
  /// Throws UserError if a node is a candidate or a master node of several contacts in a way that is not
  /// possible.
  void refuse_common_nodes() const;
  /// Boundary nodes of all ranks, in the order in which their pairs are numbered. Collective.
  [[nodiscard]] std::vector<BoundaryNode> boundary_nodes(const std::vector<scene::Contact>& contacts,
                                                         const fem::Space& space,
                                                         const fem::DirichletDofs& clamped);
  /// Appends the motion of an obstacle with mass or of master nodes to the rows of a pair `group`, which has
  /// the entries of the candidate's node alone.
  void append_opposite(const BoundaryNode& node, ConstraintRows::Group& group) const;
  /// Adds the tangential rows of a pair whose normal row `group` has. Components that are clamped as a whole
  /// are left out. Throws UserError if a clamp holds a tangent in part.
  void add_tangents(const BoundaryNode& node, ConstraintRows::Group& group) const;
  /// Sets `values` (m entries) to the coefficients of friction or the bounds of tractions at time t (s), zero
  /// without friction.
  void evaluate_friction(double t, std::span<double> values) const;
  /// Sets tresca_areas_. Collective.
  void set_tresca_areas(const fem::Space& space, const std::vector<scene::Contact>& contacts);
  void add_pairs(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                 const fem::DirichletDofs& clamped, const scene::Time& time);
  /// Time at which the direction of each node's pair is computed, s.
  [[nodiscard]] std::vector<double> times_of_meeting(const std::vector<BoundaryNode>& nodes,
                                                     const scene::Time& time) const;

  int dim_;
  bool axisymmetric_;
  double diameter_, gap_tolerance_;
  MPI_Comm comm_;
  std::vector<std::string> keys_, names_; ///< of each contact
  std::vector<bool> project_; ///< for each obstacle: whether contact.initial moves nodes out of it
  std::vector<std::optional<Obstacle>> shapes_;      ///< of each contact; absent with contact.against
  std::vector<std::optional<SurfacePair>> surfaces_; ///< of each contact; absent with an obstacle
  std::vector<std::optional<RigidMotion>> rigid_;    ///< of each obstacle; absent without mass
  /// Coefficient or bound of friction, and surface velocity, of each obstacle; absent without friction or
  /// motion.
  std::vector<std::optional<scene::Field>> friction_, surface_velocity_;
  std::vector<double>
      friction_at_start_;            ///< evaluate_friction() at t = 0 (m entries); empty without friction
  std::vector<double> tresca_areas_; ///< ∫ φ_i of pairs with Tresca friction, else 0; empty without it
  bool friction_varies_ = false;     ///< whether friction depends on t
  std::vector<std::size_t> moving_;  ///< numbers of the obstacles that move
  std::vector<std::vector<PetscInt>> clamped_dofs_;
  std::vector<double> points_, normals_, psi_;
  std::vector<PetscInt> first_dofs_;
  std::vector<int> obstacles_, local_;
  std::vector<const MortarRow*> mortar_; ///< row of each pair of surfaces, else null (m entries)
  /// Node on the axis that is no candidate, on the rank that owns it.
  struct AxisNode {
    std::array<double, 3> x;
    int local_dof, obstacle;
  };
  std::vector<AxisNode> axis_nodes_;
  bool skips_axis_ = false;
  std::optional<ConstraintRows> rows_; ///< absent until the pairs have been found
};

/// Returns the contacts without their friction: their pairs have normal rows alone.
[[nodiscard]] std::vector<scene::Contact> without_friction(std::vector<scene::Contact> contacts);

} // namespace signorini::contact
