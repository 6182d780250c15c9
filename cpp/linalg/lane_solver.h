// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "linalg/lockstep.h"
#include "linalg/side_by_side.h"
#include "linalg/supernodal.h"
#include <memory>
#include <span>
#include <vector>

namespace signorini {

/// Forward solutions of tasks, side by side.
struct KeptSolutions {
  SideBySide values;
  std::vector<bool> used; ///< which of them
};

/// The place of a forward solution among KeptSolutions, free again when this object is destroyed.
class KeptPlace {
public:
  KeptPlace() = default;
  ~KeptPlace() { leave(); }
  KeptPlace(const KeptPlace&) = delete;
  KeptPlace& operator=(const KeptPlace&) = delete;

private:
  friend class LaneSolver;
  void leave() {
    if (kept_)
      kept_->used[number_] = false;
  }
  std::shared_ptr<KeptSolutions> kept_;
  std::size_t number_ = 0;
};

/// Makes the halves of solves that the tasks of a Lockstep ask for together, on a supernodal factor
/// P A Pᵀ = L Lᵀ. Forward solutions stay side by side; of each only its trailing part is copied.
class LaneSolver {
public:
  /// `L` must outlive this object; the last `trailing` unknowns are passed between the halves.
  LaneSolver(const cholmod_factor& L, std::size_t trailing);

  /// Called by a task of `lockstep`: z = L⁻¹ P b, which is kept at `place`; sets `trailing` to its last
  /// values.
  void forward(Lockstep& lockstep, Vec b, KeptPlace& place, std::span<double> trailing);
  /// Called by a task of `lockstep`: x = Pᵀ L⁻ᵀ z, where `trailing` replaces the last values of z, the
  /// solution kept at `place`, which stays.
  void backward(Lockstep& lockstep, const KeptPlace& place, std::span<const double> trailing, Vec x);

  /// Memory in addition to the factor, bytes.
  [[nodiscard]] std::size_t bytes() const;

private:
  class Half;
  [[nodiscard]] static std::size_t number(const KeptPlace& place) { return place.number_; }
  void forward(std::span<SharedSolve* const> all);
  void backward(std::span<SharedSolve* const> all);
  /// Whether the places are those of all forward solutions that are kept, in their order.
  [[nodiscard]] bool whole(std::span<SharedSolve* const> all) const;

  const int* order_; ///< P: number of the unknown that is eliminated as the i-th
  std::size_t n_, trailing_;
  TriangularSolves solves_;
  std::shared_ptr<KeptSolutions> kept_ = std::make_shared<KeptSolutions>();
  SideBySide work_;
};

} // namespace signorini
