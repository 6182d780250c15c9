// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include <array>
#include <span>
#include <vector>

namespace signorini::contact {

/// Array of `size` values, initially zero; does not allocate memory if `size` is at most `few`.
template <class T, std::size_t few>
class SmallArray {
public:
  explicit SmallArray(std::size_t size) : many_(size > few ? size : 0), size_(size) {}
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T* begin() { return many_.empty() ? few_.data() : many_.data(); }
  [[nodiscard]] T* end() { return begin() + size_; }
  [[nodiscard]] const T* begin() const { return many_.empty() ? few_.data() : many_.data(); }
  [[nodiscard]] const T* end() const { return begin() + size_; }
  T& operator[](std::size_t i) { return begin()[i]; }
  const T& operator[](std::size_t i) const { return begin()[i]; }

private:
  std::array<T, few> few_{};
  std::vector<T> many_;
  std::size_t size_;
};

/// Orthonormal basis q of the force directions of some rows of one cluster, the members, by Gram–Schmidt: h_j
/// = Σ_k R_jk q_k for the force direction h_j of member j. Allocates nothing for clusters of one node.
class RowBasis {
public:
  /// Limit of linear dependence: a row counts as dependent if orthogonalisation leaves at most this fraction
  /// of its norm. Closer to dependence, the distribution of the force among the rows would be accurate to
  /// fewer than four digits.
  static constexpr double dependence_limit = 1e-6;
  using Coordinates = SmallArray<double, 3>;

  /// Reserves memory for any cluster of `rows`, which must outlive this object.
  explicit RowBasis(const ConstraintRows& rows);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] int member(std::size_t k) const { return members_[k]; }
  void clear() { size_ = 0; }

  /// Adds a row, which must be in the same cluster as the members. Returns false and adds nothing if the row
  /// depends linearly on the members.
  bool add(int row);
  /// Replaces member k by a row, and removes members that then depend linearly on earlier ones.
  void replace(std::size_t k, int row);
  /// Returns q_k·x for the values x at the cluster's dofs.
  [[nodiscard]] double along(std::size_t k, std::span<const double> x) const;
  /// Computes the coefficients of the members in the force direction of a row that depends linearly on them.
  void coefficients(int row, Coordinates& out) const;
  /// x += Σ_k b_k q_k, for the values x at the cluster's dofs.
  void add_to(std::span<double> x, const Coordinates& b) const;
  /// Replaces b by R⁻¹ b: the coordinates in the basis q of the shortest vector x with h_j·x = b_j.
  void shortest(Coordinates& b) const;
  /// Replaces the coefficients b of a vector Σ_k b_k q_k by its coefficients a = R⁻ᵀ b in the force
  /// directions of the members, Σ_j a_j h_j.
  void combine(Coordinates& b) const;
  [[nodiscard]] Coordinates coordinates() const { return Coordinates(capacity_); }

private:
  [[nodiscard]] static std::size_t widest(const ConstraintRows& rows);

  const ConstraintRows& rows_;
  std::size_t capacity_, width_ = 0, size_ = 0;
  SmallArray<double, 9> q_, R_; ///< (capacity × capacity), row by row
  SmallArray<int, 3> members_;
};

} // namespace signorini::contact
