#include "control/control.h"
#include "base/counters.h"
#include <algorithm>
#include <cmath>

namespace signorini::control {
using petsc::check;

namespace {
long& spaces = count("control spaces");
}

Control::Control(const Control& other) {
  for (const petsc::Vector& step : other.steps_)
    steps_.push_back(petsc::copy(step));
}

Control& Control::operator=(const Control& other) {
  if (this != &other)
    for (std::size_t k = 0; k < steps_.size(); ++k)
      check(VecCopy(other.steps_[k], steps_[k]));
  return *this;
}

void Control::add(double a, const Control& x) {
  for (std::size_t k = 0; k < steps_.size(); ++k)
    check(VecAXPY(steps_[k], a, x.steps_[k]));
}

void Control::scale(double a) {
  for (const petsc::Vector& step : steps_)
    check(VecScale(step, a));
}

namespace {

std::optional<std::vector<double>> per_component(std::optional<std::vector<double>> bound, int dim) {
  if (bound && bound->size() == 1)
    bound->assign(static_cast<std::size_t>(dim), bound->front());
  return bound;
}

/// HRZ lumping: the diagonal of W, scaled to the whole mass; positive for every degree. For degree 1 the row
/// sums.
petsc::Vector lump(Mat W) {
  petsc::Vector diagonal = fem::diagonal(W), one = petsc::zero_like(diagonal),
                mass = petsc::zero_like(diagonal);
  check(VecSet(one, 1));
  check(MatMult(W, one, mass));
  PetscScalar whole = 0, trace = 0;
  check(VecSum(mass, &whole));
  check(VecSum(diagonal, &trace));
  check(VecScale(diagonal, whole / trace));
  return diagonal;
}

} // namespace

ControlSpace::ControlSpace(const fem::Space& space, const fem::Operators& operators, forward::Scheme scheme,
                           int steps, const scene::Control& scene)
    : space_(space), W_(operators.W), scheme_(scheme), steps_(steps), scale_(scene.scale),
      lower_(per_component(scene.lower, space.dim())), upper_(per_component(scene.upper, space.dim())),
      work_(space.vector()) {
  ++spaces;
  if (bounded())
    lumped_ = lump(W_);
}

Control ControlSpace::zero() const {
  return Control(petsc::zero_series(work_, static_cast<std::size_t>(steps_)));
}

Control ControlSpace::unset() const {
  petsc::Series steps(static_cast<std::size_t>(steps_));
  for (petsc::Vector& step : steps)
    check(VecDuplicate(work_, step.put()));
  return Control(std::move(steps));
}

Control ControlSpace::interpolate(const scene::Components& components, const std::string& key) const {
  const scene::Field field(components, key, true);
  Control u = zero();
  for (int k = 1; k <= steps_; ++k) {
    if (k > 1 && !field.depends_on_time())
      check(VecCopy(u.at(1), u.at(k)));
    else
      space_.interpolate(field, scheme_.load_time(k), u.at(k));
  }
  return u;
}

double ControlSpace::dot(Vec x, Vec y) const {
  check(MatMult(W_, y, work_));
  return petsc::dot(x, work_);
}

double ControlSpace::product(const Control& u, const Control& w) const {
  double sum = 0;
  for (int k = 1; k <= steps_; ++k)
    sum += dot(u.at(k), w.at(k));
  return scheme_.tau * sum;
}

double ControlSpace::norm(const Control& u) const { return std::sqrt(product(u, u)); }

double ControlSpace::metric(const Control& u, const Control& w) const {
  if (!bounded())
    return product(u, w);
  double sum = 0;
  for (int k = 1; k <= steps_; ++k) {
    check(VecPointwiseMult(work_, lumped_, w.at(k)));
    sum += petsc::dot(u.at(k), work_);
  }
  return scheme_.tau * sum;
}

void ControlSpace::to_metric(Control& gradient) const {
  if (!bounded())
    return;
  for (int k = 1; k <= steps_; ++k) {
    check(MatMult(W_, gradient.at(k), work_));
    check(VecPointwiseDivide(gradient.at(k), work_, lumped_));
  }
}

void ControlSpace::project(Control& u) const {
  if (!bounded())
    return;
  const auto dim = static_cast<std::size_t>(space_.dim());
  for (int k = 1; k <= steps_; ++k) {
    const petsc::WriteArray values(u.at(k));
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (lower_)
        values[i] = std::max(values[i], (*lower_)[i % dim]);
      if (upper_)
        values[i] = std::min(values[i], (*upper_)[i % dim]);
    }
  }
}

void ControlSpace::add_load(const Control& u, int k, Vec density) const {
  check(VecAXPY(density, scale_, u.at(k)));
}

forward::AddLoad ControlSpace::with(forward::AddLoad load, const Control& u) const {
  return [this, load = std::move(load), &u](int k, Vec out) {
    load(k, out);
    add_load(u, k, out);
  };
}

} // namespace signorini::control
