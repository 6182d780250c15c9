#include "linalg/simplex_qp.h"
#include "base/petsc.h"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <petscblaslapack.h>
#include <petsctao.h>

namespace signorini {
using petsc::check;

namespace {

/// ½ x·Kx + c·x over x ≥ 0 for a small dense K.
class BoundedQuadratic {
public:
  explicit BoundedQuadratic(petsc::Matrix K)
      : K_(std::move(K)), c_(petsc::vector_of(K_)), lower_(petsc::zero_like(c_)),
        upper_(petsc::zero_like(c_)) {
    check(VecSet(upper_, PETSC_INFINITY));
    check(TaoCreate(PETSC_COMM_SELF, tao_.put()));
    check(TaoSetOptionsPrefix(tao_, "combination_"));
    check(TaoSetType(tao_, TAOTRON));
    check(TaoSetObjectiveAndGradient(tao_, nullptr, value_and_gradient, this));
    check(TaoSetHessian(tao_, K_, K_, constant_hessian, nullptr));
    check(TaoSetVariableBounds(tao_, lower_, upper_));
    // Steps are accepted by comparing values, whose rounding, 1e-16, limits the gradient to about its root.
    check(TaoSetTolerances(tao_, 1e-7, 0, 0));
    check(TaoSetMaximumIterations(tao_, 30));
    KSP ksp = nullptr; // K may be singular
    check(TaoGetKSP(tao_, &ksp));
    check(KSPSetType(ksp, KSPSTCG));
    PC pc = nullptr;
    check(KSPGetPC(ksp, &pc));
    check(PCSetType(pc, PCNONE));
    check(KSPSetTolerances(ksp, 1e-14, 0, PETSC_CURRENT, PETSC_CURRENT));
    check(TaoSetFromOptions(tao_));
  }

  /// The vector c, to be set before minimise().
  [[nodiscard]] Vec linear() const { return c_; }

  /// Replaces the guess `x` by the minimiser, to the accuracy that rounding allows.
  void minimise(Vec x) const {
    check(TaoSetSolution(tao_, x));
    check(TaoSolve(tao_));
  }

private:
  static PetscErrorCode value_and_gradient(Tao, Vec x, PetscReal* value, Vec gradient, void* self) {
    PetscFunctionBeginUser;
    const auto* quadratic = static_cast<const BoundedQuadratic*>(self);
    PetscScalar product = 0, linear = 0;
    PetscCall(MatMult(quadratic->K_, x, gradient));
    PetscCall(VecDot(x, gradient, &product));
    PetscCall(VecDot(x, quadratic->c_, &linear));
    PetscCall(VecAXPY(gradient, 1, quadratic->c_));
    *value = product / 2 + linear;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode constant_hessian(Tao, Vec, Mat, Mat, void*) { return PETSC_SUCCESS; }

  petsc::Matrix K_;
  petsc::Vector c_, lower_, upper_;
  petsc::Handle<Tao, TaoDestroy> tao_;
};

/// Minimiser under Σ w = 1 with weights outside `support` zero, without w ≥ 0: the weights of the support,
/// and the common value of (Gw + e)_i there (the multiplier). Empty if the KKT matrix is singular.
/// `products`: G; `prices`: e.
std::vector<double> best_on(std::span<const double> products, std::span<const double> prices,
                            const std::vector<std::size_t>& support) {
  const std::size_t n = prices.size(), size = support.size();
  const auto order = static_cast<PetscBLASInt>(size + 1), one = PetscBLASInt{1};
  std::vector<double> K(static_cast<std::size_t>(order) * static_cast<std::size_t>(order)),
      b(static_cast<std::size_t>(order), 1.0);
  double largest = 0;
  for (std::size_t i : support)
    largest = std::max(largest, products[i * n + i]);
  if (!(largest > 0))
    return {};
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j)
      K[i * (size + 1) + j] = products[support[i] * n + support[j]] / largest;
    K[i * (size + 1) + size] = K[size * (size + 1) + i] = 1;
    b[i] = -prices[support[i]] / largest;
  }
  std::vector<PetscBLASInt> pivots(static_cast<std::size_t>(order));
  PetscBLASInt info = 0;
  LAPACKgesv_(&order, &one, K.data(), &order, pivots.data(), b.data(), &order, &info);
  if (info != 0)
    return {};
  b[size] *= -largest;
  return b;
}

/// Weights that satisfy the optimality conditions to rounding, by an active-set method from `near`, which
/// nearly satisfy them; `near` itself if the method does not settle.
std::vector<double> polished(std::span<const double> products, std::span<const double> prices,
                             const std::vector<double>& near) {
  const std::size_t n = prices.size();
  constexpr double negligible = 1e-7;
  std::vector<std::size_t> support;
  for (std::size_t i = 0; i < n; ++i)
    if (near[i] > negligible)
      support.push_back(i);
  for (std::size_t change = 0; change < 10 * n; ++change) {
    const std::vector<double> solution = best_on(products, prices, support);
    if (solution.empty()) { // dependent: the minimum is attained without one of them
      if (support.size() == 1)
        return near;
      support.erase(std::ranges::min_element(support, {}, [&](std::size_t i) { return near[i]; }));
      continue;
    }
    const auto least = std::min_element(solution.begin(), solution.end() - 1) - solution.begin();
    if (solution[static_cast<std::size_t>(least)] < 0) {
      support.erase(support.begin() + least);
      continue;
    }
    std::vector<double> weights(n);
    for (std::size_t i = 0; i < support.size(); ++i)
      weights[support[i]] = solution[i];
    std::size_t steepest = n;
    double below = 0;
    for (std::size_t i = 0; i < n; ++i) {
      double slope = prices[i] - solution.back(), size = std::abs(prices[i]);
      for (std::size_t j : support) {
        slope += products[i * n + j] * weights[j];
        size += std::abs(products[i * n + j] * weights[j]);
      }
      constexpr double rounding = 1e-13;
      if (slope < -rounding * size && slope < below && weights[i] == 0) {
        steepest = i;
        below = slope;
      }
    }
    if (steepest == n)
      return weights;
    support.insert(std::ranges::lower_bound(support, steepest), steepest);
  }
  return near;
}

} // namespace

std::optional<std::vector<double>> simplex_qp(std::span<const double> products,
                                              std::span<const double> prices) {
  const std::size_t n = prices.size();
  const auto finite = [](double x) { return std::isfinite(x); };
  if (n == 0 || !std::ranges::all_of(products, finite) || !std::ranges::all_of(prices, finite))
    return std::nullopt;
  std::vector<double> weights(n, 1 / static_cast<double>(n));
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i)
    largest = std::max({largest, products[i * n + i], std::abs(prices[i])});
  if (n == 1 || largest == 0)
    return weights;
  petsc::Matrix K; // G plus the penalty ½ (Σ w − 1)² of the augmented Lagrangian
  const auto size = static_cast<PetscInt>(n);
  check(MatCreateSeqDense(PETSC_COMM_SELF, size, size, nullptr, K.put()));
  for (PetscInt i = 0; i < size; ++i)
    for (PetscInt j = 0; j < size; ++j)
      check(MatSetValue(K, i, j,
                        products[static_cast<std::size_t>(i) * n + static_cast<std::size_t>(j)] / largest + 1,
                        INSERT_VALUES));
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  const BoundedQuadratic quadratic(std::move(K));
  petsc::Vector x = petsc::copy(quadratic.linear());
  check(VecSet(x, 1 / static_cast<double>(n)));
  // Augmented Lagrangian in the constraint Σ w = 1. For e = 0 the first minimiser is already a multiple of
  // the solution.
  const bool priced = std::ranges::any_of(prices, [](double e) { return e != 0; });
  double multiplier = 1, sum = 0;
  constexpr int most = 10;
  for (int iteration = 0; iteration < most; ++iteration) {
    {
      const petsc::WriteArray c(quadratic.linear());
      for (std::size_t i = 0; i < n; ++i)
        c[i] = prices[i] / largest - multiplier;
    }
    quadratic.minimise(x);
    const petsc::ReadArray found(x);
    for (std::size_t i = 0; i < n; ++i)
      weights[i] = std::max(0.0, found[i]);
    sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    constexpr double near = 1e-6;
    if (sum > 0 && (!priced || std::abs(sum - 1) < near))
      break;
    multiplier += 1 - sum;
  }
  if (!(sum > 0))
    return std::nullopt;
  for (double& w : weights)
    w /= sum;
  return polished(products, prices, weights);
}

} // namespace signorini
