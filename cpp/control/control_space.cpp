// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/control_space.h"
#include "base/timers.h"
#include "fem/time_profile.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace signorini::control {
using petsc::check;

namespace {

long& spaces = count("control spaces");

std::optional<std::vector<double>> per_component(std::optional<std::vector<double>> bound, int dim,
                                                 const std::vector<int>& components) {
  if (!bound)
    return bound;
  if (bound->size() == 1)
    bound->assign(static_cast<std::size_t>(dim), bound->front());
  std::vector<double> own;
  for (int c : components)
    own.push_back((*bound)[c]);
  return own;
}

std::vector<int> ascending(std::vector<int> numbers) {
  std::ranges::sort(numbers);
  return numbers;
}

step::TimeGrid intervals_of(const scene::Control& scene, const step::TimeGrid& grid) {
  if (scene.constant_in_time)
    return {grid.end(), 1};
  return scene.step ? step::TimeGrid(*scene.step, scene.intervals) : grid;
}

/// Returns the diagonal of the lumped W (HRZ): the diagonal of W, scaled to the total mass. It is positive
/// for every degree; for degree 1 it equals the row sums.
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

ControlSpace::ControlSpace(const fem::Space& space, const fem::Operators& operators, step::TimeGrid grid,
                           const scene::Control& scene)
    : space_(space), grid_(grid), intervals_(intervals_of(scene, grid)),
      stepwise_(!scene.constant_in_time && !scene.step), scale_(scene.scale),
      constant_in_time_(scene.constant_in_time), cellwise_(scene.space == scene::ControlValues::cellwise),
      on_(scene.on), components_(ascending(fem::component_numbers(scene.components, space.dim()))),
      lower_(per_component(scene.lower, space.dim(), components_)),
      upper_(per_component(scene.upper, space.dim(), components_)) {
  ++spaces;
  if (cellwise_)
    take_cells(scene.on);
  else
    take_nodes(operators, scene.on);
}

void ControlSpace::take_cells(const std::optional<std::string>& on) {
  matrix_ = fem::assemble_cellwise(space_, on, "control.on");
  const petsc::Vector one = space_.vector();
  check(VecSet(one, 1));
  const auto volumes = [&] { // the nodal functions are a partition of unity
    petsc::Vector x;
    check(MatCreateVecs(matrix_, x.put(), nullptr));
    check(MatMultTranspose(matrix_, one, x));
    return x;
  };
  field_ = volumes();
  keep_places(field_, space_.midpoints());
  if (!everywhere_) {
    std::vector<int> columns;
    for (std::size_t i = 0; i < places_.size() * components_.size(); ++i)
      columns.push_back(static_cast<int>(field_index(i)));
    matrix_ = fem::columns(matrix_, columns);
  }
  volumes_ = volumes();
  make_work(volumes_);
}

void ControlSpace::take_nodes(const fem::Operators& operators, const std::optional<std::string>& on) {
  petsc::Matrix part = on ? fem::assemble_L2(space_, *on, "control.on") : petsc::Matrix();
  const Mat L2 = on ? Mat(part) : Mat(*operators.W);
  field_ = space_.vector();
  keep_places(fem::diagonal(L2), space_.points());
  if (!everywhere_)
    matrix_ = fem::among_nodes(L2, places_, static_cast<int>(components_.size()));
  else if (on)
    matrix_ = std::move(part);
  mass_ = matrix_ ? Mat(matrix_) : L2;
  make_work(petsc::vector_of(mass_));
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

void ControlSpace::make_work(Vec values) {
  for (petsc::Vector* vector : {&work_, &in_, &out_})
    *vector = petsc::zero_like(values);
  size_ = petsc::ReadArray(work_).size();
}

petsc::Vector ControlSpace::field() const { return petsc::zero_like(field_); }

void ControlSpace::extend(std::span<const double> values, Vec field) const {
  check(VecZeroEntries(field));
  add(1, values, field);
}

void ControlSpace::add(double a, std::span<const double> values, Vec field) const {
  const petsc::WriteArray to(field);
  if (everywhere_) {
    axpy(a, values, to);
    return;
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    to[field_index(i)] += a * values[i];
}

void ControlSpace::restrict(Vec field, std::span<double> values) const {
  const petsc::ReadArray from(field);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = from[everywhere_ ? i : field_index(i)];
}

double ControlSpace::control_bytes() const {
  PetscInt size = 0;
  check(VecGetSize(work_, &size));
  return sizeof(PetscScalar) * static_cast<double>(size) * count();
}

std::pair<int, int> ControlSpace::intervals(double from, double to) const {
  constexpr double rounding = 1e-9; // relative to the time in between
  const double hair = rounding * (to - from);
  return {intervals_.place(from + hair).k, intervals_.place(to - hair).k};
}

double ControlSpace::variation(const Control& u, double from, double to) const {
  std::array<double, 2> most{}; // largest over all values: variation, integral
  for (std::size_t i = 0; i < size_; ++i) {
    double mean = 0, off = 0, whole = 0;
    for_each_interval(from, to, [&](int j, double part) { mean += part * u.at(j)[i]; });
    for_each_interval(from, to, [&](int j, double part) { off += part * std::abs(u.at(j)[i] - mean); });
    for (int j = 1; off > 0 && j <= u.count(); ++j)
      whole += length(j) * std::abs(u.at(j)[i]);
    most = {std::max(most[0], off * (to - from)), std::max(most[1], whole)};
  }
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 2, MPI_DOUBLE, MPI_MAX, space_.comm());
  return most[1] > 0 ? most[0] / most[1] : 0;
}

Control ControlSpace::zero() const { return Control(size_, count()); }

Control ControlSpace::constant(double value) const {
  Control u = zero();
  std::ranges::fill(u.values(), value);
  return u;
}

Control ControlSpace::interpolate(const scene::Components& components, const std::string& key) const {
  const fem::TimeProfile profile(space_.comm(), scene::Field(components, key, !constant_in_time_), points_,
                                 grid_.end());
  profile.require_resolved();
  Control u = zero();
  for (int j = 1; j <= u.count(); ++j)
    if (j > 1 && !profile.field().depends_on_time())
      std::ranges::copy(u.at(1), u.at(j).begin());
    else
      profile.mean(begin(j), begin(j) + length(j), components_, u.at(j));
  return u;
}

void ControlSpace::mass(std::span<const double> u, std::span<double> out) const {
  const petsc::Placed x(in_, u), image(out_, out);
  if (cellwise_)
    check(VecPointwiseMult(image, volumes_, x));
  else
    check(MatMult(mass_, x, image));
}

Control ControlSpace::mass(const Control& u) const {
  Control image = zero();
  for (int j = 1; j <= u.count(); ++j)
    mass(u.at(j), image.at(j));
  return image;
}

double ControlSpace::sum(double mine) const {
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_DOUBLE, MPI_SUM, space_.comm());
  return mine;
}

double ControlSpace::product(const Control& u, const Control& w) const {
  std::vector<double> image(size_); // of one interval: products are frequent, and controls are long
  double mine = 0;
  for (int j = 1; j <= u.count(); ++j) {
    mass(w.at(j), image);
    mine += length(j) * dot(u.at(j), image);
  }
  return sum(mine);
}

double ControlSpace::product_at(int j, const Control& u, const Control& w) const {
  std::vector<double> image(size_);
  mass(w.at(j), image);
  return sum(dot(u.at(j), image));
}

double ControlSpace::norm(const Control& u) const { return std::sqrt(product(u, u)); }

double ControlSpace::inner(const Control& u, const Control& w) const {
  if (!lumped_)
    return product(u, w);
  const petsc::ReadArray weight(lumped_);
  double mine = 0;
  for (int j = 1; j <= u.count(); ++j) {
    const std::span<const double> a = u.at(j), b = w.at(j);
    double here = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      here += a[i] * (weight[i] * b[i]);
    mine += length(j) * here;
  }
  return sum(mine);
}

Control ControlSpace::dual(const Control& u) const {
  Control dual = lumped_ ? u : mass(u);
  if (lumped_) {
    const petsc::ReadArray weight(lumped_);
    for (int j = 1; j <= u.count(); ++j)
      std::ranges::transform(u.at(j), std::span<const double>(weight), dual.at(j).begin(), std::multiplies());
  }
  for (int j = 1; j <= u.count(); ++j)
    signorini::scale(length(j), dual.at(j));
  return dual;
}

Control ControlSpace::diagonal_weights() const {
  const petsc::Vector other = diagonal() ? petsc::Vector() : lump(mass_);
  const petsc::ReadArray weight(cellwise_ ? volumes_ : lumped_ ? lumped_ : other);
  Control all = zero();
  for (int j = 1; j <= all.count(); ++j)
    axpy(length(j), weight, all.at(j));
  return all;
}

std::vector<double> ControlSpace::pairings(std::span<const Control> duals, std::span<const Compact> w) const {
  std::vector<double> sums = dots(duals, w);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, space_.comm());
  return sums;
}

void ControlSpace::to_inner(Control& gradient) const {
  if (!lumped_)
    return;
  std::vector<double> image(size_);
  const petsc::ReadArray weight(lumped_);
  for (int j = 1; j <= gradient.count(); ++j) {
    mass(gradient.at(j), image);
    std::ranges::transform(image, std::span<const double>(weight), gradient.at(j).begin(), std::divides());
  }
}

void ControlSpace::project(Control& u) const {
  if (!bounded())
    return;
  const std::size_t n = components_.size();
  const std::span<double> values = u.values(); // place by place in every step
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (lower_)
      values[i] = std::max(values[i], (*lower_)[i % n]);
    if (upper_)
      values[i] = std::min(values[i], (*upper_)[i % n]);
  }
}

void ControlSpace::zero_blocked(Control& w, const Control& u, const Control& d) const {
  if (!bounded())
    return;
  const std::size_t n = components_.size();
  const std::span<const double> at = u.values(), direction = d.values();
  const std::span<double> values = w.values();
  for (std::size_t i = 0; i < values.size(); ++i)
    if ((lower_ && at[i] <= (*lower_)[i % n] && direction[i] < 0) ||
        (upper_ && at[i] >= (*upper_)[i % n] && direction[i] > 0))
      values[i] = 0;
}

void ControlSpace::add_force(std::span<const double> u, step::NodalForce sum, double weight) const {
  const double factor = weight * scale_;
  if (acts_by_density()) {
    add(factor, u, sum.density);
    return;
  }
  const petsc::Placed values(in_, u);
  if (cellwise_) {
    check(VecAXPBY(work_, factor, 0, values));
    check(MatMultAdd(matrix_, work_, sum.vector, sum.vector));
  } else { // other basis functions vanish where the control acts
    check(MatMult(mass_, values, work_));
    add(factor, petsc::ReadArray(work_), sum.vector);
  }
}

void ControlSpace::add_riesz(int k, Vec p, Control& g) const {
  const step::TimeStep step = grid_.step(k);
  const double factor = step.scheme().impulse() * scale_;
  const auto weight = [&](int j, double part) { return part * factor / length(j); }; // length: of product()
  if (cellwise_) { // the mean of p over each cell
    check(MatMultTranspose(matrix_, p, work_));
    check(VecPointwiseDivide(work_, work_, volumes_));
    for_each_interval(step,
                      [&](int j, double part) { axpy(weight(j, part), petsc::ReadArray(work_), g.at(j)); });
    return;
  }
  const petsc::ReadArray states(p);
  for_each_interval(step, [&](int j, double part) {
    if (everywhere_)
      return axpy(weight(j, part), states, g.at(j));
    const std::span<double> values = g.at(j);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] += weight(j, part) * states[field_index(i)];
  });
}

SampledForce::SampledForce(const ControlSpace& controls, const scene::Components& components,
                           const std::string& key, bool within)
    : controls_(controls),
      profile_(controls.space().comm(), scene::Field(components, key, !controls.constant_in_time()),
               controls.points(), controls.grid().end()),
      within_(within), values_(controls.size(), 1) {
  profile_.require_resolved();
}

void SampledForce::add(const step::TimeStep& step, step::NodalForce sum) const {
  controls_.for_each_interval(step, [&](int j, double part) {
    const bool own = !controls_.stepwise(); // steps may still be unknown to `controls_`
    const double begin = own ? controls_.begin(j) : step.begin;
    const std::pair of(begin, begin + (own ? controls_.length(j) : step.tau));
    const bool first = of_.second == 0;
    if (first || (profile_.field().depends_on_time() && of_ != of)) {
      profile_.mean(of.first, of.second, controls_.components(), values_.at(1));
      if (within_)
        controls_.project(values_);
      of_ = of;
    }
    controls_.add_force(values_.at(1), sum, part);
  });
}

} // namespace signorini::control
