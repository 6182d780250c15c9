// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/coulomb.h"
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace signorini::contact {

namespace {

double product(std::span<const double> x, std::span<const double> y) {
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

/// Tangential multipliers that exceed the cone by the slip, σ − U_t/compliance; entries from the number of
/// tangents on are zero.
std::array<double, 2> beyond_cone(std::span<const double> rho, std::span<const double> U, double compliance) {
  std::array<double, 2> sigma{};
  for (std::size_t c = 1; c < rho.size(); ++c)
    sigma[c - 1] = rho[c] - U[c] / compliance;
  return sigma;
}

/// The law's equation at a normal multiplier λ̂ and tangential ones σ̂ that exceed the cone by the slip. A
/// group sticks if `slips` is false. Otherwise σ = μ λ d + ζ P (σ − U_t/compliance) with ζ = μ λ̂/|σ̂|,
/// d = σ̂/|σ̂| and P = I − d dᵀ. The rows are in m.
LawEquation equation_at(double friction, double lambda, std::span<const double> sigma, double compliance,
                        bool slips) {
  LawEquation law;
  const std::size_t k = sigma.size() + 1;
  const double size = length(sigma), bound = friction * std::max(lambda, 0.0);
  law.E[0] = 1;
  law.friction = friction;
  if (k > 1)
    law.motion = slips ? Motion::slips : Motion::sticks;
  for (std::size_t i = 1; i < k; ++i) {
    if (!slips) {
      law.E[i * k + i] = 1;
      continue;
    }
    const double toward = size > 0 ? sigma[i - 1] / size : 0;
    law.F[i * k] = -compliance * friction * toward;
    for (std::size_t j = 1; j < k; ++j) {
      const double across = (i == j) - (size > 0 ? toward * sigma[j - 1] / size : 0);
      const double zeta_P = size > 0 ? bound / size * across : 0;
      law.E[i * k + j] = zeta_P;
      law.F[i * k + j] = compliance * ((i == j) - zeta_P);
    }
  }
  return law;
}

} // namespace

bool Coulomb::closes(bool, double, double) const {
  throw std::logic_error("friction has no primal-dual steps");
}

bool Coulomb::closes_to_first_order(bool, double, double, double, double) const {
  throw std::logic_error("friction has no primal-dual steps");
}

bool Coulomb::newton_equation(std::span<const double> rho, std::span<const double> U, double compliance,
                              double friction, LawEquation& equation) const {
  const std::array<double, 2> beyond = beyond_cone(rho, U, compliance);
  const std::span<const double> sigma(beyond.data(), rho.size() - 1);
  const double lambda = rho[0] - U[0] / compliance;
  equation = equation_at(friction, lambda, sigma, compliance,
                         friction == 0 || length(sigma) > friction * std::max(lambda, 0.0));
  return lambda > 0;
}

double Coulomb::residual(std::span<const double> rho, std::span<const double> U, double compliance,
                         double friction) const {
  // compliance |ρ − P(ρ − (U + μ |U_t| e_n)/compliance)| with the projection P on the cone
  const double lambda = rho[0] - (U[0] + friction * length(U.subspan(1))) / compliance;
  const std::array<double, 2> sigma = beyond_cone(rho, U, compliance);
  const double size = length(sigma);
  double normal = lambda, shrink = 1; // of the projection
  if (lambda < 0 || size > friction * lambda) {
    normal = std::max(0.0, (lambda + friction * size) / (1 + friction * friction));
    shrink = size > 0 ? friction * normal / size : 0;
  }
  double square = (rho[0] - normal) * (rho[0] - normal);
  for (std::size_t c = 1; c < rho.size(); ++c)
    square += (rho[c] - shrink * sigma[c - 1]) * (rho[c] - shrink * sigma[c - 1]);
  return compliance * std::sqrt(square);
}

bool Coulomb::holds(std::span<const double> rho, std::span<const double> U, double friction, double force,
                    double gap) const {
  const std::span<const double> sigma = rho.subspan(1), slip = U.subspan(1);
  const double size = length(sigma), slack = friction * rho[0] - size;
  // σ and the slip −U_t have one direction: |σ| |U_t| + σ·U_t = 0.
  const double across = size * length(slip) + product(sigma, slip);
  return unilateral.holds(rho, U, friction, force, gap) && slack >= -force &&
         (length(slip) <= gap || (slack <= force && (size <= force || across <= gap * size)));
}

LawEquation Coulomb::linearised(std::span<const double> rho, std::span<const double> U, double compliance,
                                double friction, double gap) const {
  constexpr double rounding = 1e-9;
  const bool on_cone = length(rho.subspan(1)) >= (1 - rounding) * friction * rho[0],
             slips = on_cone && (length(U.subspan(1)) > gap || friction == 0);
  const std::array<double, 2> beyond = beyond_cone(rho, U, compliance);
  LawEquation law = equation_at(friction, rho[0], std::span(beyond).first(rho.size() - 1), compliance, slips);
  law.limit = on_cone && !slips && friction * rho[0] > 0 && rho.size() > 1;
  return law;
}

} // namespace signorini::contact
