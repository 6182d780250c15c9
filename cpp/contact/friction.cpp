// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/friction.h"
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace signorini::contact {

namespace {

double product(std::span<const double> x, std::span<const double> y) {
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

/// Tangential multipliers that exceed the bound by the slip, σ − U_t/tangential; entries from the number of
/// tangents on are zero.
std::array<double, 2> beyond_bound(std::span<const double> rho, std::span<const double> U,
                                   double tangential) {
  std::array<double, 2> sigma{};
  for (std::size_t c = 1; c < rho.size(); ++c)
    sigma[c - 1] = rho[c] - U[c] / tangential;
  return sigma;
}

/// The tangential rows of a law's equation at multipliers σ̂ that exceed the bound s by the slip. A group
/// sticks if `slips` is false. Otherwise σ = s d + ζ P (σ − U_t/compliance) with ζ = s/|σ̂|, d = σ̂/|σ̂| and
/// P = I − d dᵀ. Here s = `bound` at σ̂, and in the equation s = coefficient λ + constant. Rows are in m.
struct Tangential {
  double bound, coefficient, constant;
  std::span<const double> sigma;
  double compliance; ///< tangential
  bool slips;

  [[nodiscard]] LawEquation equation() const {
    LawEquation law;
    const std::size_t k = sigma.size() + 1;
    const double size = length(sigma);
    law.E[0] = 1;
    if (k > 1)
      law.motion = slips ? Motion::slips : Motion::sticks;
    for (std::size_t i = 1; i < k; ++i) {
      if (!slips) {
        law.E[i * k + i] = 1;
        continue;
      }
      const double toward = size > 0 ? sigma[i - 1] / size : 0;
      law.F[i * k] = -compliance * coefficient * toward;
      law.constant[i] = compliance * constant * toward;
      for (std::size_t j = 1; j < k; ++j) {
        const double across = (i == j) - (size > 0 ? toward * sigma[j - 1] / size : 0);
        const double zeta_P = size > 0 ? bound / size * across : 0;
        law.E[i * k + j] = zeta_P;
        law.F[i * k + j] = compliance * ((i == j) - zeta_P);
      }
    }
    return law;
  }
};

} // namespace

bool Friction::closes(bool, double, double) const {
  throw std::logic_error("friction has no primal-dual steps");
}

bool Friction::closes_to_first_order(bool, double, double, double, double) const {
  throw std::logic_error("friction has no primal-dual steps");
}

bool Friction::holds(std::span<const double> rho, std::span<const double> U, double friction, double force,
                     double gap) const {
  const std::span<const double> sigma = rho.subspan(1), slip = U.subspan(1);
  const double size = length(sigma), slack = bound(friction, rho[0]) - size;
  // σ and the slip −U_t have one direction: |σ| |U_t| + σ·U_t = 0, or σ is the bound times that of the slip.
  const double way = length(slip), across = size * way + product(sigma, slip);
  std::array<double, 2> defect{};
  for (std::size_t c = 0; c < sigma.size() && way > 0; ++c)
    defect[c] = sigma[c] + bound(friction, rho[0]) * slip[c] / way;
  const bool aligned = across <= gap * size || length(defect) <= force;
  return unilateral.holds(rho, U, friction, force, gap) && slack >= -force &&
         (way <= gap || (slack <= force && (size <= force || aligned)));
}

bool Friction::newton_equation(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                               double friction, LawEquation& equation) const {
  const std::array<double, 2> beyond = beyond_bound(rho, U, compliance.tangential);
  const std::span<const double> sigma(beyond.data(), rho.size() - 1);
  const double lambda = rho[0] - U[0] / compliance.normal, closed = std::max(lambda, 0.0),
               rate = bound_rate(friction), s = bound(friction, closed);
  const bool slips = friction == 0 || length(sigma) > s;
  equation = Tangential{s, rate, s - rate * closed, sigma, compliance.tangential, slips}.equation();
  equation.friction = friction;
  if (lambda > 0)
    return true;
  equation.open(compliance.normal);
  return acts_open();
}

LawEquation Friction::linearised(std::span<const double> rho, std::span<const double> U,
                                 Compliance compliance, double friction, double gap) const {
  constexpr double rounding = 1e-9;
  const double s = bound(friction, std::max(rho[0], 0.0));
  const bool on_bound = length(rho.subspan(1)) >= (1 - rounding) * bound(friction, rho[0]),
             slips = on_bound && (length(U.subspan(1)) > gap || friction == 0);
  const std::array<double, 2> beyond = beyond_bound(rho, U, compliance.tangential);
  const std::span<const double> sigma(beyond.data(), rho.size() - 1);
  LawEquation law = Tangential{s, bound_rate(friction), 0, sigma, compliance.tangential, slips}.equation();
  law.friction = friction;
  law.limit = on_bound && !slips && s > 0 && rho.size() > 1;
  return law;
}

double Coulomb::residual(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                         double friction) const {
  // c |ρ − P(ρ − (U + μ |U_t| e_n)/c)| with the projection P on the cone and the mean compliance c
  const auto k = static_cast<double>(rho.size());
  const double mean = (compliance.normal + (k - 1) * compliance.tangential) / k,
               lambda = rho[0] - (U[0] + friction * length(U.subspan(1))) / mean;
  const std::array<double, 2> sigma = beyond_bound(rho, U, mean);
  const double size = length(sigma);
  double normal = lambda, shrink = 1; // of the projection
  if (lambda < 0 || size > friction * lambda) {
    normal = std::max(0.0, (lambda + friction * size) / (1 + friction * friction));
    shrink = size > 0 ? friction * normal / size : 0;
  }
  double square = (rho[0] - normal) * (rho[0] - normal);
  for (std::size_t c = 1; c < rho.size(); ++c)
    square += (rho[c] - shrink * sigma[c - 1]) * (rho[c] - shrink * sigma[c - 1]);
  return mean * std::sqrt(square);
}

double Tresca::residual(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                        double friction) const {
  // |c (ρ − P(ρ − U/c))| with the projection P on λ ≥ 0, |σ| ≤ s
  const std::array<double, 2> sigma = beyond_bound(rho, U, compliance.tangential);
  const double size = length(sigma), shrink = size > friction ? friction / size : 1;
  std::array<double, 3> defect{std::min(compliance.normal * rho[0], U[0])};
  for (std::size_t c = 1; c < rho.size(); ++c)
    defect[c] = compliance.tangential * (rho[c] - shrink * sigma[c - 1]);
  return length(defect);
}

} // namespace signorini::contact
