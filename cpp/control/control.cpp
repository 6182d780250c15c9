#include "control/control.h"
#include "base/counters.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::control {
using petsc::check;

namespace {
long& spaces = count("control spaces");
}

Control::Control(const Control& other) : steps_(other.steps_) {
  for (const petsc::Vector& value : other.values_)
    values_.push_back(petsc::copy(value));
}

Control& Control::operator=(const Control& other) {
  if (this != &other)
    for (std::size_t k = 0; k < values_.size(); ++k)
      check(VecCopy(other.values_[k], values_[k]));
  return *this;
}

void Control::add(double a, const Control& x) {
  for (std::size_t k = 0; k < values_.size(); ++k)
    check(VecAXPY(values_[k], a, x.values_[k]));
}

void Control::scale(double a) {
  for (const petsc::Vector& value : values_)
    check(VecScale(value, a));
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

/// One where `support` is not zero and the component is among `components`; null if that is everywhere.
petsc::Vector make_mask(Vec support, int dim, const std::vector<int>& components) {
  petsc::Vector mask = petsc::zero_like(support);
  bool all = true;
  {
    const petsc::ReadArray weight(support);
    const petsc::WriteArray values(mask);
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] =
          weight[i] != 0 && std::ranges::find(components, static_cast<int>(i) % dim) != components.end();
      all = all && values[i] != 0;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_CXX_BOOL, MPI_LAND, petsc::comm(support));
  return all ? petsc::Vector() : std::move(mask);
}

} // namespace

ControlSpace::ControlSpace(const fem::Space& space, const fem::Operators& operators, forward::Scheme scheme,
                           int steps, const scene::Control& scene)
    : space_(space), scheme_(scheme), steps_(steps), scale_(scene.scale),
      constant_in_time_(scene.constant_in_time), cellwise_(scene.space == "P0"), whole_(!scene.on),
      components_(fem::component_numbers(scene.components, space.dim())),
      lower_(per_component(scene.lower, space.dim())), upper_(per_component(scene.upper, space.dim())) {
  ++spaces;
  if (cellwise_) {
    own_ = fem::assemble_cellwise(space, scene.on, "control.on");
    points_ = space.midpoints();
    petsc::Vector one;
    check(MatCreateVecs(own_, volumes_.put(), one.put()));
    check(VecSet(one, 1));
    check(MatMultTranspose(own_, one, volumes_)); // nodal functions add up to one
    mask_ = make_mask(volumes_, space.dim(), components_);
    work_ = petsc::zero_like(volumes_);
    return;
  }
  if (!whole_)
    own_ = fem::assemble_L2(space, *scene.on, "control.on");
  mass_ = whole_ ? *operators.W : own_;
  points_ = space.points();
  work_ = space.vector();
  mask_ = make_mask(fem::diagonal(mass_), space.dim(), components_);
  if (bounded())
    lumped_ = lump(mass_);
}

Control ControlSpace::unset() const {
  petsc::Series values(vectors());
  for (petsc::Vector& value : values)
    check(VecDuplicate(work_, value.put()));
  return Control(std::move(values), steps_);
}

double ControlSpace::control_bytes() const {
  PetscInt size = 0;
  check(VecGetSize(work_, &size));
  return sizeof(PetscScalar) * static_cast<double>(size) * static_cast<double>(vectors());
}

Control ControlSpace::zero() const { return constant(0); }

Control ControlSpace::constant(double value) const {
  Control u = unset();
  for (int k = 1; k <= u.count(); ++k)
    check(VecSet(u.at(k), value));
  restrict(u);
  return u;
}

Control ControlSpace::interpolate(const scene::Components& components, const std::string& key) const {
  const scene::Field field(components, key, !constant_in_time_);
  Control u = unset();
  for (int k = 1; k <= u.count(); ++k) {
    if (k > 1 && !field.depends_on_time())
      check(VecCopy(u.at(1), u.at(k)));
    else
      fem::interpolate(space_.comm(), field, constant_in_time_ ? 0 : scheme_.load_time(k), points_, u.at(k));
  }
  restrict(u);
  return u;
}

void ControlSpace::restrict(Control& u) const {
  for (int k = 1; mask_ && k <= u.count(); ++k)
    check(VecPointwiseMult(u.at(k), u.at(k), mask_));
}

void ControlSpace::mass(Vec x, Vec out) const {
  if (cellwise_)
    check(VecPointwiseMult(out, volumes_, x));
  else
    check(MatMult(mass_, x, out));
}

template <class Mass>
double ControlSpace::product(const Control& u, const Control& w, Mass&& mass) const {
  double sum = 0;
  for (int k = 1; k <= u.count(); ++k) {
    mass(w.at(k), work_);
    sum += petsc::dot(u.at(k), work_);
  }
  return duration() * sum;
}

double ControlSpace::product(const Control& u, const Control& w) const {
  return product(u, w, [this](Vec x, Vec out) { mass(x, out); });
}

double ControlSpace::product_at(int k, const Control& u, const Control& w) const {
  mass(w.at(k), work_);
  return petsc::dot(u.at(k), work_);
}

double ControlSpace::norm(const Control& u) const { return std::sqrt(product(u, u)); }

double ControlSpace::metric(const Control& u, const Control& w) const {
  if (!lumped_)
    return product(u, w);
  return product(u, w, [this](Vec x, Vec out) { check(VecPointwiseMult(out, lumped_, x)); });
}

Control ControlSpace::dual(const Control& u) const {
  Control dual = unset();
  for (int k = 1; k <= u.count(); ++k) {
    if (lumped_)
      check(VecPointwiseMult(dual.at(k), lumped_, u.at(k)));
    else
      mass(u.at(k), dual.at(k));
  }
  return dual;
}

double ControlSpace::pairing(const Control& dual, const Control& w) const {
  double sum = 0;
  for (int k = 1; k <= w.count(); ++k)
    sum += petsc::dot(dual.at(k), w.at(k));
  return duration() * sum;
}

void ControlSpace::to_metric(Control& gradient) const {
  for (int k = 1; lumped_ && k <= gradient.count(); ++k) {
    check(MatMult(mass_, gradient.at(k), work_));
    check(VecPointwiseDivide(gradient.at(k), work_, lumped_)); // PETSc: zero where both are
  }
  restrict(gradient);
}

void ControlSpace::project(Control& u) const {
  if (!bounded())
    return;
  const auto dim = static_cast<std::size_t>(space_.dim());
  for (int k = 1; k <= u.count(); ++k) {
    const petsc::WriteArray values(u.at(k));
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (lower_)
        values[i] = std::max(values[i], (*lower_)[i % dim]);
      if (upper_)
        values[i] = std::min(values[i], (*upper_)[i % dim]);
    }
  }
  restrict(u);
}

void ControlSpace::hold(Control& w, const Control& u, const Control& d) const {
  if (!bounded())
    return;
  const auto dim = static_cast<std::size_t>(space_.dim());
  for (int k = 1; k <= w.count(); ++k) {
    const petsc::WriteArray values(w.at(k));
    const petsc::ReadArray at(u.at(k)), direction(d.at(k));
    for (std::size_t i = 0; i < values.size(); ++i)
      if ((lower_ && at[i] <= (*lower_)[i % dim] && direction[i] < 0) ||
          (upper_ && at[i] >= (*upper_)[i % dim] && direction[i] > 0))
        values[i] = 0;
  }
}

forward::Load ControlSpace::load(const Control& u) const {
  forward::Load load;
  if (whole_ && !cellwise_)
    load.density = [this, &u](int k, Vec out) { check(VecAXPY(out, scale_, u.at(k))); };
  else
    load.force = [this, &u](int k, Vec out) {
      check(VecCopy(u.at(k), work_));
      check(VecScale(work_, scale_));
      check(MatMultAdd(cellwise_ ? own_ : mass_, work_, out, out));
    };
  return load;
}

void ControlSpace::add_riesz(int k, Vec p, Control& g) const {
  const double weight = scheme_.impulse() / duration() * scale_; // duration() of the product is divided out
  Vec own = p;
  if (cellwise_) { // the mean of p over each cell
    check(MatMultTranspose(own_, p, work_));
    check(VecPointwiseDivide(work_, work_, volumes_));
    own = work_;
  }
  if (mask_) {
    check(VecPointwiseMult(work_, own, mask_));
    own = work_;
  }
  check(VecAXPY(g.at(k), weight, own));
}

} // namespace signorini::control
