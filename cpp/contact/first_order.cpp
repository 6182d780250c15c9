// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/first_order.h"
#include "contact/friction.h"
#include <cmath>
#include <stdexcept>

namespace signorini::contact {

namespace {

/// Base of laws that LawSolver solves by Newton steps alone.
class PiecewiseLinear : public Law {
public:
  [[nodiscard]] bool symmetric() const override { return false; }
  [[nodiscard]] bool stays_open(std::span<const double>) const override { return false; }
  [[nodiscard]] bool closes(bool, double, double) const override { unused(); }
  [[nodiscard]] bool holds(std::span<const double>, std::span<const double>, double, double,
                           double) const override {
    unused();
  }
  [[nodiscard]] Status status(std::span<const double>, std::span<const double>, double,
                              double) const override {
    unused();
  }
  [[nodiscard]] LawEquation linearised(std::span<const double> rho, std::span<const double> U,
                                       Compliance compliance, double friction, double) const override {
    LawEquation equation;
    (void)newton_equation(rho, U, compliance, friction, equation);
    return equation;
  }
  [[nodiscard]] bool closes_to_first_order(bool, double, double, double, double) const override { unused(); }
  [[nodiscard]] double residual(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                                double friction) const override {
    LawEquation law; // of the piece in which ρ and U are
    double square = 0;
    if (!newton_equation(rho, U, compliance, friction, law))
      return compliance.normal * length(rho);
    const std::size_t k = rho.size();
    for (std::size_t i = 0; i < k; ++i) {
      double row = 0;
      for (std::size_t j = 0; j < k; ++j)
        row += law.E[i * k + j] * U[j] + law.F[i * k + j] * rho[j];
      square += row * row;
    }
    return std::sqrt(square);
  }

private:
  [[noreturn]] static void unused() { throw std::logic_error("a law to first order has Newton steps only"); }
};

/// Stays open: δρ = 0.
class Open final : public PiecewiseLinear {
public:
  [[nodiscard]] bool newton_equation(std::span<const double>, std::span<const double>, Compliance, double,
                                     LawEquation&) const override {
    return false;
  }
};

/// Obeys the linearised law.
class Linear : public PiecewiseLinear {
public:
  explicit Linear(const LawEquation& equation) : equation_(equation) {}
  [[nodiscard]] bool newton_equation(std::span<const double>, std::span<const double>, Compliance, double,
                                     LawEquation& equation) const override {
    equation = equation_;
    return true;
  }

private:
  LawEquation equation_;
};

/// Touches without force and slips: 0 ≤ δλ ⟂ δg ≥ 0, and the linearised law with the slip's direction if
/// closed.
class OpenOrSlip final : public Linear {
public:
  using Linear::Linear;
  [[nodiscard]] bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                     Compliance compliance, double friction,
                                     LawEquation& equation) const override {
    return Linear::newton_equation(rho, U, compliance, friction, equation) &&
           compliance.normal * rho[0] > U[0];
  }
};

/// Sticks with |σ| = μ λ: δg = 0, no slip across d = σ/|σ|, and 0 ≤ d·δw ⟂ μ δλ − d·δσ ≥ 0.
class StickOrSlip : public PiecewiseLinear {
public:
  explicit StickOrSlip(std::span<const double> sigma) {
    const double size = length(sigma);
    for (std::size_t c = 0; c < sigma.size() && size > 0; ++c)
      d_[c] = sigma[c] / size;
  }
  [[nodiscard]] bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                     Compliance compliance, double friction,
                                     LawEquation& equation) const override {
    const std::size_t k = rho.size();
    double beyond = -friction * rho[0]; // d·δσ + d·δw/tangential − μ δλ
    for (std::size_t c = 1; c < k; ++c)
      beyond += d_[c - 1] * (rho[c] - U[c] / compliance.tangential);
    equation = {};
    equation.motion = beyond > 0 ? Motion::slips : Motion::sticks;
    equation.friction = friction;
    equation.E[0] = 1;
    for (std::size_t i = 1; i < k; ++i) {
      if (beyond > 0)
        equation.F[i * k] = -compliance.tangential * friction * d_[i - 1];
      for (std::size_t j = 1; j < k; ++j) {
        const double along = beyond > 0 ? d_[i - 1] * d_[j - 1] : 0;
        equation.E[i * k + j] = (i == j) - along;
        equation.F[i * k + j] = compliance.tangential * along;
      }
    }
    return true;
  }

private:
  std::array<double, 2> d_{};
};

/// Law with a bound that does not depend on the normal force. Touches without force if `equation` is weak:
/// 0 ≤ δλ ⟂ δg ≥ 0. Sticks at the bound if it is at the limit: 0 ≤ d·δw ⟂ −d·δσ ≥ 0.
class OfTresca final : public StickOrSlip {
public:
  OfTresca(const LawEquation& equation, std::span<const double> sigma)
      : StickOrSlip(sigma), equation_(equation) {}
  [[nodiscard]] bool acts_open() const override { return true; }
  [[nodiscard]] bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                     Compliance compliance, double friction,
                                     LawEquation& equation) const override {
    constexpr double fixed = 0; // change of the bound per unit of λ
    equation = equation_;
    if (equation_.limit) {
      (void)StickOrSlip::newton_equation(rho, U, compliance, fixed, equation);
      equation.friction = friction;
      if (!equation_.closed)
        equation.open(compliance.normal);
    }
    if (equation_.weak && !(compliance.normal * rho[0] > U[0]))
      equation.open(compliance.normal);
    equation.weak = equation.limit = false; // of the piece that is selected
    return true;
  }

private:
  LawEquation equation_;
};

} // namespace

FirstOrderLaws::FirstOrderLaws(const ConstraintRows& rows, const ContactLinearisation& contact)
    : rows_(rows), laws_(static_cast<std::size_t>(rows.groups())), friction_(laws_.size()) {
  own_.push_back(std::make_unique<Open>());
  std::ranges::fill(laws_, own_.front().get());
  std::size_t at = 0;
  for (std::size_t j = 0; j < contact.active.size(); ++j) {
    const int i = contact.active[j];
    const std::size_t k = rows.size(i);
    const LawEquation& equation = contact.equations[j];
    const std::span<const double> rho(&contact.forces[at], k);
    at += k;
    friction_[i] = equation.friction;
    if (!std::ranges::binary_search(contact.weak, i))
      own_.push_back(std::make_unique<Linear>(equation));
    else if (rows.law(i).acts_open())
      own_.push_back(std::make_unique<OfTresca>(equation, rho.subspan(1)));
    else if (equation.limit)
      own_.push_back(std::make_unique<StickOrSlip>(rho.subspan(1)));
    else if (equation.motion == Motion::sticks) {
      laws_[i] = &coulomb;
      continue;
    } else
      own_.push_back(std::make_unique<OpenOrSlip>(equation));
    laws_[i] = own_.back().get();
  }
}

void FirstOrderLaws::select(const ContactState& change, const Complementarity& scales,
                            ContactLinearisation& contact) const {
  ActiveSet active;
  std::vector<double> forces;
  std::vector<LawEquation> equations;
  auto force = contact.forces.begin();
  for (std::size_t j = 0; j < contact.active.size(); ++j) {
    const int i = contact.active[j];
    const std::size_t k = rows_.size(i);
    const std::array<double, 3> rho = rows_.of_group(i, change.lambda), U = rows_.of_group(i, change.gap);
    const auto next = force + static_cast<std::ptrdiff_t>(k);
    const bool may_open =
        std::ranges::binary_search(contact.weak, i) && contact.equations[j].weak && !laws_[i]->acts_open();
    if (!may_open || rho[0] != 0) {
      active.push_back(i);
      forces.insert(forces.end(), force, next);
      equations.push_back(
          laws_[i]->linearised({rho.data(), k}, {U.data(), k}, scales.compliance(i), friction_[i], 0));
    }
    force = next;
  }
  contact.active = std::move(active);
  contact.forces = std::move(forces);
  contact.equations = std::move(equations);
}

} // namespace signorini::contact
