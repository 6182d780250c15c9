// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "contact/law.h"
#include <array>
#include <span>

namespace signorini::contact {

/// The constraint operator H, N of docs/method.md section 2: a sparse matrix with a row for each multiplier,
/// over the dofs that any of them constrains. Hᵀy are the motions that enter the gaps, Hλ the nodal forces of
/// multipliers. Clamped dofs, whose values are prescribed, count in motions and receive no force.
///
/// Rows come in groups, each with a law: without friction the normal row alone, with friction the tangents
/// too. Row i < groups() is the first row of group i; the others follow after all first rows, group by
/// group. First rows that share dofs form a cluster and are numbered consecutively: those of one node or,
/// with a rigid body, all that act on it. The matrix is the same on every rank. Arrays over rows have count()
/// entries; arrays over first rows alone, as over candidates, have groups() entries.
class ConstraintRows {
public:
  struct Entry {
    PetscInt dof; ///< global
    double coefficient;
    bool clamped;
  };
  struct Group {
    std::vector<Entry> entries{};             ///< entries of the first row
    std::vector<std::vector<Entry>> others{}; ///< entries of at most two other rows, at dofs of the first one
    const Law* law = &unilateral;             ///< law of the group; must outlive the rows
  };
  struct Cluster {
    int first, last; ///< groups [first, last)
    int begin, end;  ///< range [begin, end) of the constrained dofs
    bool dependent;  ///< whether its rows are linearly dependent
    bool here;       ///< whether all of its dofs are on this rank
    [[nodiscard]] std::size_t width() const { return static_cast<std::size_t>(end - begin); }
  };

  /// Sets up the rows of `groups`, the same on every rank. This rank owns the dofs [first, end).
  ConstraintRows(MPI_Comm comm, const std::vector<Group>& groups, PetscInt first, PetscInt end);

  [[nodiscard]] int count() const { return static_cast<int>(row_begin_.size()) - 1; }
  [[nodiscard]] int groups() const { return static_cast<int>(laws_.size()); }
  /// Number of rows of a group, k.
  [[nodiscard]] std::size_t size(int group) const {
    return static_cast<std::size_t>(1 + others_[static_cast<std::size_t>(group) + 1] - others_[group]);
  }
  /// Number of a group's row c < k.
  [[nodiscard]] std::size_t row(int group, std::size_t c) const {
    return c == 0 ? static_cast<std::size_t>(group) : static_cast<std::size_t>(others_[group]) + c - 1;
  }
  /// The entries of an array over rows that belong to a group; beyond its k rows, zero.
  [[nodiscard]] std::array<double, 3> of_group(int group, std::span<const double> values) const {
    std::array<double, 3> part{};
    for (std::size_t c = 0; c < size(group); ++c)
      part[c] = values[row(group, c)];
    return part;
  }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }
  /// The global dofs that are constrained, cluster by cluster.
  [[nodiscard]] const std::vector<PetscInt>& dofs() const { return dofs_; }
  [[nodiscard]] const std::vector<Cluster>& clusters() const { return clusters_; }
  [[nodiscard]] const Cluster& cluster(int group) const { return clusters_[cluster_of_[group]]; }
  /// Whether the first rows of some cluster are linearly dependent: multipliers are then not unique.
  [[nodiscard]] bool dependent() const { return dependent_; }
  /// Whether any of the dofs is clamped.
  [[nodiscard]] bool clamped() const { return any_clamped_; }
  /// Rows with the same dofs and other coefficients, one for each entry, row by row.
  [[nodiscard]] ConstraintRows with(std::vector<double> coefficients) const;

  [[nodiscard]] const Law& law(int group) const { return *laws_[group]; }
  /// Whether all laws are symmetric.
  [[nodiscard]] bool symmetric() const { return symmetric_; }

  /// Coefficients of a row at its unclamped dofs, zero at clamped ones: the nodal force of a unit
  /// multiplier.
  [[nodiscard]] std::span<const double> force(int row) const { return part(forces_, row); }
  /// Coefficients of a row at all of its dofs.
  [[nodiscard]] std::span<const double> motion(int row) const { return part(motions_, row); }
  /// Number of each entry's dof among dofs().
  [[nodiscard]] std::span<const int> columns(int row) const {
    return {&columns_[row_begin_[row]], row_begin_[static_cast<std::size_t>(row) + 1] - row_begin_[row]};
  }
  /// Sets `out` to the force coefficients of a group's first row over its cluster's dofs (width).
  void spread(int group, std::span<double> out) const;
  /// Sets `out` to the multipliers of all rows, zero off the active set.
  void spread(const ContactLinearisation& contact, std::span<double> out) const;

  /// out ← Hᵀx, including clamped dofs. Collective.
  void apply_transpose(Vec x, std::span<double> out) const;
  /// out ← g(y) = ψ − Hᵀy, m, for ψ in metres; ψ = 0 beyond its entries. Collective.
  void gap(std::span<const double> psi, Vec y, std::span<double> out) const;
  /// x += scale · Hλ.
  void apply(double scale, std::span<const double> lambda, Vec x) const { add(forces_, scale, lambda, x); }
  /// x += scale · Hλ, clamped dofs included.
  void apply_whole(double scale, std::span<const double> lambda, Vec x) const {
    add(motions_, scale, lambda, x);
  }

  /// out ← Hᵀx for the values x of the constrained dofs.
  void apply_transpose(std::span<const double> x, std::span<double> out) const;
  /// x ← Hλ, the values at the constrained dofs.
  void apply(std::span<const double> lambda, std::span<double> x) const;
  /// H as a dense matrix (dofs × rows), column by column.
  [[nodiscard]] std::vector<double> dense() const;
  /// Sets `out` to HᵀH of a cluster's first rows, over unclamped dofs.
  void gram(const Cluster& cluster, std::vector<double>& out) const;
  /// Rows [first, first + count) of Hᵀ, on rank 0. Collective.
  [[nodiscard]] petsc::Matrix rows(int first, int count, Vec layout) const;
  /// Σ_j h_j² d_j of each row, for a diagonal d. Collective.
  [[nodiscard]] std::vector<double> weighted_squares(Vec diagonal) const;

  /// Computes λ of first rows with Hλ = x at the clusters of `set` and zero elsewhere, for an x in the range
  /// of these columns of H. Among linearly dependent rows the first ones carry the force. Collective.
  void multipliers(std::span<const int> set, Vec x, std::span<double> lambda) const;
  /// Makes Hᵀx = value on `set` by the smallest change of the unclamped dofs; among linearly dependent rows,
  /// for the first ones. Collective.
  void prescribe(std::span<const int> set, std::span<const double> value, Vec x) const;

  /// Sets the clamped dofs of y to their values in the step's system, in which they are decoupled: r divided
  /// by the matrix's diagonal.
  void set_clamped(Vec diagonal, Vec r, Vec y) const;
  /// Contribution of clamped dofs to (Hᵀy)_row, from the owned entries of y, for a row whose dofs are all on
  /// this rank.
  [[nodiscard]] double clamped_part(int row, std::span<const double> y) const;

private:
  [[nodiscard]] std::span<const double> part(const std::vector<double>& all, int row) const {
    return {&all[row_begin_[row]], columns(row).size()};
  }
  [[nodiscard]] std::size_t rows_count() const { return row_begin_.size() - 1; }
  /// Calls visit(row, column, coefficient) for the entries of the rows [first, end), row by row.
  template <class Visit>
  void for_each(const std::vector<double>& coefficients, std::size_t first, std::size_t end,
                Visit&& visit) const;
  /// Calls visit(row, local dof, coefficient) for entries of the first `rows` rows at owned dofs.
  template <class Visit>
  void for_each_here(const std::vector<double>& coefficients, std::size_t rows, Visit&& visit) const;
  void add(const std::vector<double>& coefficients, double scale, std::span<const double> lambda,
           Vec x) const;
  void find_clusters();
  /// Copies the values of a cluster's dofs to `out`: from `gathered` (over dofs()), or from x if it is empty.
  void take(const Cluster& cluster, std::span<const double> x, std::span<const double> gathered,
            std::span<double> out) const;
  /// Values of dofs(), the same on every rank; empty if every cluster is on one rank. Collective.
  [[nodiscard]] std::vector<double> gathered(Vec x) const;

  MPI_Comm comm_;
  std::vector<std::size_t> row_begin_; ///< begin of each row's entries, and the end of the last row's
  std::vector<int> others_;            ///< number of each group's second row, and the end
  std::vector<const Law*> laws_;       ///< law of each group
  std::vector<int> columns_;           ///< dof of each entry, a number among dofs_
  std::vector<double> motions_, forces_;
  std::vector<bool> clamped_; ///< whether each entry's dof is clamped
  std::vector<PetscInt> dofs_;
  std::vector<int> local_; ///< local numbers of dofs_, −1 if another rank owns them
  std::vector<Cluster> clusters_;
  std::vector<int> cluster_of_; ///< cluster of each group
  bool dependent_ = false, any_clamped_ = false, symmetric_ = true;
  bool across_ranks_ = false; ///< whether a cluster's dofs are on several ranks
};

} // namespace signorini::contact
