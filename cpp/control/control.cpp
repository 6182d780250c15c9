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

std::optional<std::vector<double>> per_component(std::optional<std::vector<double>> bound, int dim,
                                                 const std::vector<int>& components) {
  if (!bound)
    return bound;
  if (bound->size() == 1)
    bound->assign(static_cast<std::size_t>(dim), bound->front());
  std::vector<double> own;
  for (int c : components)
    own.push_back((*bound)[static_cast<std::size_t>(c)]);
  return own;
}

std::vector<int> ascending(std::vector<int> numbers) {
  std::ranges::sort(numbers);
  return numbers;
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
    : space_(space), scheme_(scheme), steps_(steps), scale_(scene.scale),
      constant_in_time_(scene.constant_in_time), cellwise_(scene.space == "P0"), whole_(!scene.on),
      components_(ascending(fem::component_numbers(scene.components, space.dim()))),
      lower_(per_component(scene.lower, space.dim(), components_)),
      upper_(per_component(scene.upper, space.dim(), components_)) {
  ++spaces;
  if (cellwise_)
    take_cells(scene.on);
  else
    take_nodes(operators, scene.on);
}

void ControlSpace::take_cells(const std::optional<std::string>& on) {
  own_ = fem::assemble_cellwise(space_, on, "control.on");
  const petsc::Vector one = space_.vector();
  check(VecSet(one, 1));
  const auto volumes = [&] { // nodal functions add up to one
    petsc::Vector x;
    check(MatCreateVecs(own_, x.put(), nullptr));
    check(MatMultTranspose(own_, one, x));
    return x;
  };
  field_ = volumes();
  keep_places(field_, space_.midpoints());
  if (!everywhere_) {
    std::vector<int> columns;
    for (std::size_t i = 0; i < places_.size() * components_.size(); ++i)
      columns.push_back(static_cast<int>(entry(i)));
    own_ = fem::columns(own_, columns);
  }
  volumes_ = volumes();
  work_ = petsc::zero_like(volumes_);
}

void ControlSpace::take_nodes(const fem::Operators& operators, const std::optional<std::string>& on) {
  petsc::Matrix part = on ? fem::assemble_L2(space_, *on, "control.on") : petsc::Matrix();
  const Mat L2 = on ? Mat(part) : Mat(*operators.W);
  field_ = space_.vector();
  keep_places(fem::diagonal(L2), space_.points());
  if (!everywhere_)
    own_ = fem::among_nodes(L2, places_, static_cast<int>(components_.size()));
  else if (on)
    own_ = std::move(part);
  mass_ = own_ ? Mat(own_) : L2;
  work_ = petsc::vector_of(mass_);
  if (bounded())
    lumped_ = lump(mass_);
}

void ControlSpace::keep_places(Vec weights, const std::vector<double>& points) {
  const auto dim = static_cast<std::size_t>(space_.dim());
  const petsc::ReadArray weight(weights);
  for (std::size_t place = 0; place < weight.size() / dim; ++place)
    if (weight[place * dim] != 0) {
      places_.push_back(static_cast<int>(place));
      points_.insert(points_.end(), &points[3 * place], &points[3 * place] + 3);
    }
  everywhere_ = components_.size() == dim && places_.size() * dim == weight.size();
  MPI_Allreduce(MPI_IN_PLACE, &everywhere_, 1, MPI_CXX_BOOL, MPI_LAND, space_.comm());
}

petsc::Vector ControlSpace::field() const { return petsc::zero_like(field_); }

void ControlSpace::extend(Vec values, Vec field) const {
  check(VecZeroEntries(field));
  add(1, values, field);
}

void ControlSpace::add(double a, Vec values, Vec field) const {
  if (everywhere_) {
    check(VecAXPY(field, a, values));
    return;
  }
  const petsc::ReadArray from(values);
  const petsc::WriteArray to(field);
  for (std::size_t i = 0; i < from.size(); ++i)
    to[entry(i)] += a * from[i];
}

void ControlSpace::restrict(Vec field, Vec values) const {
  if (everywhere_) {
    check(VecCopy(field, values));
    return;
  }
  const petsc::ReadArray from(field);
  const petsc::WriteArray to(values);
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = from[entry(i)];
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
  return u;
}

Control ControlSpace::interpolate(const scene::Components& components, const std::string& key) const {
  const scene::Field field(components, key, !constant_in_time_);
  Control u = unset();
  for (int k = 1; k <= u.count(); ++k)
    if (k > 1 && !field.depends_on_time())
      check(VecCopy(u.at(1), u.at(k)));
    else
      fem::interpolate(space_.comm(), field, constant_in_time_ ? 0 : scheme_.load_time(k), points_, components_,
                       u.at(k));
  return u;
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
    check(VecPointwiseDivide(gradient.at(k), work_, lumped_));
  }
}

void ControlSpace::project(Control& u) const {
  if (!bounded())
    return;
  const std::size_t n = components_.size();
  for (int k = 1; k <= u.count(); ++k) {
    const petsc::WriteArray values(u.at(k));
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (lower_)
        values[i] = std::max(values[i], (*lower_)[i % n]);
      if (upper_)
        values[i] = std::min(values[i], (*upper_)[i % n]);
    }
  }
}

void ControlSpace::hold(Control& w, const Control& u, const Control& d) const {
  if (!bounded())
    return;
  const std::size_t n = components_.size();
  for (int k = 1; k <= w.count(); ++k) {
    const petsc::WriteArray values(w.at(k));
    const petsc::ReadArray at(u.at(k)), direction(d.at(k));
    for (std::size_t i = 0; i < values.size(); ++i)
      if ((lower_ && at[i] <= (*lower_)[i % n] && direction[i] < 0) ||
          (upper_ && at[i] >= (*upper_)[i % n] && direction[i] > 0))
        values[i] = 0;
  }
}

forward::Load ControlSpace::load(const Control& u) const {
  return load([&u](int k) { return u.at(k); });
}

forward::Load ControlSpace::load(std::function<Vec(int k)> u) const {
  forward::Load load;
  if (cellwise_)
    load.force = [this, u](int k, Vec out) {
      check(VecAXPBY(work_, scale_, 0, u(k)));
      check(MatMultAdd(own_, work_, out, out));
    };
  else if (whole_)
    load.density = [this, u](int k, Vec out) { add(scale_, u(k), out); };
  else
    load.force = [this, u](int k, Vec out) { // on no other nodes: there the functions of these vanish
      check(MatMult(mass_, u(k), work_));
      add(scale_, work_, out);
    };
  return load;
}

void ControlSpace::add_riesz(int k, Vec p, Control& g) const {
  const double weight = scheme_.impulse() / duration() * scale_; // duration() of the product is divided out
  if (cellwise_) { // the mean of p over each cell
    check(MatMultTranspose(own_, p, work_));
    check(VecPointwiseDivide(work_, work_, volumes_));
  } else if (!everywhere_) {
    restrict(p, work_);
  }
  check(VecAXPY(g.at(k), weight, everywhere_ && !cellwise_ ? p : Vec(work_)));
}

} // namespace signorini::control
