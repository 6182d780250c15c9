// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "contact/law.h"
#include <array>
#include <optional>
#include <span>

namespace signorini::contact {

/// The constraint operator H (N in docs/method.md section 2): a sparse matrix with one row for each
/// multiplier and one column for each constrained dof. Hᵀy is the motion that enters the gaps; Hλ are the
/// nodal forces of the multipliers λ. Clamped dofs, whose values are prescribed, contribute to Hᵀy and
/// receive no force.
///
/// Rows form groups, each with one contact law: a group has one normal row without friction, and tangential
/// rows too with friction. Row i < groups() is the first row of group i; the other rows follow after all
/// first rows, group by group. First rows that have dofs of the mesh in common form a cluster and have
/// consecutive numbers: those of one node. Dofs of virtual nodes and of other surfaces are shared: rows of
/// many clusters have them. The lift of a row is a change of dofs by which its motion Hᵀy changes: along the
/// row itself or, where rows of several clusters have these dofs, a change that other rows do not see. The
/// matrix is the same on every rank. Arrays over rows have count() entries; arrays over first rows only, such
/// as those over candidates, have groups() entries.
class ConstraintRows {
public:
  struct Entry {
    PetscInt dof; ///< global number of the dof
    double coefficient;
    bool clamped;
    bool shared = false; ///< whether rows of other clusters may have the dof too
    /// Coefficient of the dof in the row's lift; by default `coefficient`, or 0 if the dof is shared.
    std::optional<double> lift{};
  };
  struct Group {
    std::vector<Entry> entries{};             ///< entries of the group's first row, shared dofs last
    std::vector<std::vector<Entry>> others{}; ///< at most two further rows, at dofs of the first row
    const Law* law = &unilateral;             ///< contact law of the group; must outlive the rows
  };
  struct Cluster {
    int first, last; ///< range [first, last) of groups
    int begin, end;  ///< range [begin, end) of positions in dofs()
    bool dependent;  ///< whether the cluster's first rows are linearly dependent
    bool here;       ///< whether this rank owns all dofs of the cluster
    [[nodiscard]] std::size_t width() const { return static_cast<std::size_t>(end - begin); }
  };

  /// Sets up the rows of `groups`, which are the same on every rank. This rank owns the dofs [first, end).
  /// Collective.
  ConstraintRows(MPI_Comm comm, const std::vector<Group>& groups, PetscInt first, PetscInt end);

  [[nodiscard]] int count() const { return static_cast<int>(row_begin_.size()) - 1; }
  [[nodiscard]] int groups() const { return static_cast<int>(laws_.size()); }
  /// Number of rows of a group.
  [[nodiscard]] std::size_t size(int group) const {
    return static_cast<std::size_t>(1 + others_[static_cast<std::size_t>(group) + 1] - others_[group]);
  }
  /// Number of a group's row c, 0 ≤ c < size(group), among all rows.
  [[nodiscard]] std::size_t row(int group, std::size_t c) const {
    return c == 0 ? static_cast<std::size_t>(group) : static_cast<std::size_t>(others_[group]) + c - 1;
  }
  /// Selects the entries of a group from an array over rows; entries from size(group) on are zero.
  [[nodiscard]] std::array<double, 3> of_group(int group, std::span<const double> values) const {
    std::array<double, 3> part{};
    for (std::size_t c = 0; c < size(group); ++c)
      part[c] = values[row(group, c)];
    return part;
  }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }
  /// Global numbers of the constrained dofs, cluster by cluster, shared dofs last.
  [[nodiscard]] const std::vector<PetscInt>& dofs() const { return dofs_; }
  [[nodiscard]] const std::vector<Cluster>& clusters() const { return clusters_; }
  [[nodiscard]] const Cluster& cluster(int group) const { return clusters_[cluster_of_[group]]; }
  /// Whether the first rows of some cluster are linearly dependent, so that multipliers are not unique.
  [[nodiscard]] bool dependent() const { return dependent_; }
  /// Whether any constrained dof is clamped.
  [[nodiscard]] bool clamped() const { return any_clamped_; }
  /// Whether `other` has the same dofs, coefficients and laws, to the last bit. Not collective; the same on
  /// every rank.
  [[nodiscard]] bool equals(const ConstraintRows& other) const;
  /// Returns rows with the same dofs and laws but with other coefficients, one for each entry, row by row.
  [[nodiscard]] ConstraintRows with(std::vector<double> coefficients) const;

  [[nodiscard]] const Law& law(int group) const { return *laws_[group]; }
  /// Whether all laws are symmetric.
  [[nodiscard]] bool symmetric() const { return symmetric_; }
  /// Whether some law has forces on groups that are not in contact.
  [[nodiscard]] bool act_open() const { return act_open_; }

  /// Whether any row has shared dofs.
  [[nodiscard]] bool share() const { return dofs_.size() > own_; }

  /// Nodal force of a unit multiplier: the row's coefficients at unclamped dofs, and zero at clamped ones.
  [[nodiscard]] std::span<const double> force(int row) const { return part(forces_, row); }
  /// Coefficients of a row at all of its dofs, clamped ones included.
  [[nodiscard]] std::span<const double> motion(int row) const { return part(motions_, row); }
  /// Coefficients of a row's lift at all of its dofs, clamped ones included. The first ones are those at the
  /// candidate's node: the direction of its motion.
  [[nodiscard]] std::span<const double> lift(int row) const { return part(lifts_, row); }
  /// Position in dofs() of the dof of each entry of a row.
  [[nodiscard]] std::span<const int> columns(int row) const {
    return {&columns_[row_begin_[row]], row_begin_[static_cast<std::size_t>(row) + 1] - row_begin_[row]};
  }
  /// Sets `out` (width of the cluster) to the lift of a group's first row at the dofs of its cluster, with
  /// zero at clamped dofs; shared dofs are left out.
  void spread(int group, std::span<double> out) const;
  /// Sets `out` to the multipliers of all rows, with zero outside the active set.
  void spread(const ContactLinearisation& contact, std::span<double> out) const;

  /// out ← Hᵀx, including the contributions of clamped dofs. Collective.
  void apply_transpose(Vec x, std::span<double> out) const;
  /// out ← g(y) = ψ − Hᵀy (gaps, in m). Rows without an entry in `psi` have ψ = 0. Collective.
  void gap(std::span<const double> psi, Vec y, std::span<double> out) const;
  /// x += scale · Hλ at unclamped dofs.
  void apply(double scale, std::span<const double> lambda, Vec x) const { add(forces_, scale, lambda, x); }
  /// x += scale · Hλ at all dofs, clamped ones included.
  void apply_whole(double scale, std::span<const double> lambda, Vec x) const {
    add(motions_, scale, lambda, x);
  }

  /// out ← Hᵀx, where x contains the values at dofs(). Not collective.
  void apply_transpose(std::span<const double> x, std::span<double> out) const;
  /// x ← Hλ at dofs(), with zero at clamped dofs. Not collective.
  void apply(std::span<const double> lambda, std::span<double> x) const;
  /// Returns H as a dense matrix (dofs × rows), column by column, with zero at clamped dofs.
  [[nodiscard]] std::vector<double> dense() const;
  /// Sets `out` to HᵀH for the first rows of a cluster, restricted to unclamped dofs.
  void gram(const Cluster& cluster, std::vector<double>& out) const;
  /// Returns the rows [first, first + count) of Hᵀ as a sparse matrix, all on rank 0, zero at clamped dofs.
  /// `layout`: any vector of V. Collective.
  [[nodiscard]] petsc::Matrix rows(int first, int count, Vec layout) const;
  /// Returns Σ_j h_j² d_j for each row, where h is its lift at unclamped dofs and d is a diagonal matrix.
  /// Collective.
  [[nodiscard]] std::vector<double> weighted_squares(Vec diagonal) const;

  /// Computes the multipliers λ of the first rows of the groups in `set` (ascending), so that Hλ = x at the
  /// dofs of their lifts; all other multipliers become zero. There x must be a combination of these rows'
  /// forces. Other dofs are not regarded. Among linearly dependent rows, those that come first in `set` get
  /// the force. Collective.
  void multipliers(std::span<const int> set, Vec x, std::span<double> lambda) const;
  /// Changes unclamped dofs of x along the lifts of the rows in `set`, as little as possible (Euclidean norm)
  /// at each cluster, so that Hᵀx = `value` on `set`. Among linearly dependent rows, only the first
  /// independent ones are satisfied. Collective.
  void prescribe(std::span<const int> set, std::span<const double> value, Vec x) const;

  /// Sets the clamped entries of y to their solution r_j/d_j in the step's system, in which they are
  /// decoupled; `diagonal`: d, the diagonal of the system's matrix. Not collective.
  void set_clamped(Vec diagonal, Vec r, Vec y) const;
  /// Contribution of clamped dofs to (Hᵀy)_row, for a row whose dofs all are on this rank. `y`: entries that
  /// this rank owns.
  [[nodiscard]] double clamped_part(int row, std::span<const double> y) const;

private:
  [[nodiscard]] std::span<const double> part(const std::vector<double>& all, int row) const {
    return {&all[row_begin_[row]], columns(row).size()};
  }
  [[nodiscard]] std::size_t rows_count() const { return row_begin_.size() - 1; }
  /// columns() without shared dofs.
  [[nodiscard]] std::span<const int> own_columns(int row) const {
    return columns(row).first(own_entries_[static_cast<std::size_t>(row)]);
  }
  /// Whether the lift of a row has shared dofs.
  [[nodiscard]] bool lifted(int row) const { return lifted_[static_cast<std::size_t>(row)]; }
  /// prescribe() for rows with lifts of shared dofs.
  void prescribe_by_lifts(std::span<const int> set, std::span<const double> value, Vec x) const;
  /// Calls visit(row, column, coefficient) for each entry of the rows [first, end), row by row.
  template <class Visit>
  void for_each(const std::vector<double>& coefficients, std::size_t first, std::size_t end,
                Visit&& visit) const;
  /// Calls visit(row, local dof, coefficient) for each entry of the first `rows` rows whose dof this rank
  /// owns.
  template <class Visit>
  void for_each_here(const std::vector<double>& coefficients, std::size_t rows, Visit&& visit) const;
  void add(const std::vector<double>& coefficients, double scale, std::span<const double> lambda,
           Vec x) const;
  void find_clusters();
  /// Copies the values at a cluster's dofs to `out`: from `gathered` (values at dofs()) or, if this is empty,
  /// from x.
  void take(const Cluster& cluster, std::span<const double> x, std::span<const double> gathered,
            std::span<double> out) const;
  /// Values of x at dofs(), the same on every rank; empty if each cluster's dofs are on one rank. Collective.
  [[nodiscard]] std::vector<double> gathered(Vec x) const;

  MPI_Comm comm_;
  std::vector<std::size_t> row_begin_; ///< start of each row's entries, and the end of the last row
  std::vector<int> others_;            ///< number of each group's second row, and the total number of rows
  std::vector<const Law*> laws_;       ///< law of each group
  std::vector<int> columns_;           ///< position in dofs_ of each entry's dof
  std::vector<double> motions_, forces_, lifts_;
  std::vector<bool> clamped_;            ///< whether each entry's dof is clamped
  std::vector<std::size_t> own_entries_; ///< number of each row's entries at dofs that are not shared
  std::vector<bool> lifted_;             ///< of each row
  std::vector<PetscInt> dofs_;
  std::size_t own_ = 0;    ///< number of constrained dofs that are not shared
  std::vector<int> local_; ///< local numbers of dofs_; −1 if another rank owns the dof
  std::vector<Cluster> clusters_;
  std::vector<int> cluster_of_; ///< cluster of each group
  bool dependent_ = false, any_clamped_ = false, symmetric_ = true, act_open_ = false;
  bool across_ranks_ = false; ///< whether the dofs of some cluster are on several ranks
};

} // namespace signorini::contact
