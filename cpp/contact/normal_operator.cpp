// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/normal_operator.h"
#include "contact/node_basis.h"
#include <algorithm>
#include <array>
#include <numeric>

namespace signorini::contact {

NormalOperator::NormalOperator(const ContactPairs& pairs)
    : pairs_(pairs), dim_(pairs.dim()), local_(pairs.local_dofs()), normals_(pairs.normals()),
      directions_(pairs.directions()) {}

void NormalOperator::normal_components(Vec x, std::span<double> out) const {
  components_along(normals_, x, out);
}

void NormalOperator::components_along(const std::vector<double>& directions, Vec x,
                                      std::span<double> out) const {
  std::ranges::fill(out, 0);
  {
    const petsc::ReadArray values(x);
    for (int i = 0; i < pairs_.count(); ++i)
      for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
        out[i] += directions[i * dim_ + c] * values[local_[i] + c];
  }
  // Every entry comes from one rank alone, so the sum is exact and the same on every rank.
  MPI_Allreduce(MPI_IN_PLACE, out.data(), pairs_.count(), MPI_DOUBLE, MPI_SUM, pairs_.comm());
}

void NormalOperator::gap(std::span<const double> psi, Vec y, std::span<double> out) const {
  normal_components(y, out);
  for (int i = 0; i < pairs_.count(); ++i)
    out[i] = psi[i] - out[i];
}

void NormalOperator::add(double scale, std::span<const double> lambda, Vec x) const {
  add_along(scale, lambda, pairs_.directions(), x);
}

void NormalOperator::add_whole(double scale, std::span<const double> lambda, Vec x) const {
  add_along(scale, lambda, pairs_.normals(), x);
}

void NormalOperator::add_along(double scale, std::span<const double> lambda,
                               const std::vector<double>& directions, Vec x) const {
  const petsc::WriteArray values(x);
  for (int i = 0; i < pairs_.count(); ++i)
    for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
      values[local_[i] + c] += scale * lambda[i] * directions[i * dim_ + c];
}

void NormalOperator::forces(const ActiveSet& set, Vec x, std::span<double> lambda) const {
  std::ranges::fill(lambda, 0);
  {
    const petsc::ReadArray values(x);
    const std::span<const double> all = values;
    NodeBasis basis(dim_);
    std::array<int, 3> members{};
    for (auto at = set.begin(); at != set.end();) {
      const ContactPairs::Node& here = pairs_.node(*at);
      basis.clear();
      for (; at != set.end() && *at < here.last; ++at)
        if (basis.add(pairs_.direction(*at)))
          members[basis.size() - 1] = *at;
      if (local_[here.first] < 0)
        continue;
      std::array<double, 3> b{};
      for (std::size_t k = 0; k < basis.size(); ++k)
        b[k] = basis.along(k, &all[local_[here.first]]);
      basis.combine(b);
      for (std::size_t k = 0; k < basis.size(); ++k)
        lambda[members[k]] = b[k];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, lambda.data(), pairs_.count(), MPI_DOUBLE, MPI_SUM,
                pairs_.comm()); // exact, as above
}

void NormalOperator::set_normal(std::span<const int> set, std::span<const double> value, Vec x) const {
  const petsc::WriteArray values(x);
  const std::span<double> all = values;
  NodeBasis basis(dim_);
  for (auto at = set.begin(); at != set.end();) {
    const ContactPairs::Node& here = pairs_.node(*at);
    if (local_[here.first] < 0) {
      at = std::find_if(at, set.end(), [&](int i) { return i >= here.last; });
      continue;
    }
    double* at_node = &all[local_[here.first]];
    basis.clear();
    std::array<double, 3> change{};
    for (; at != set.end() && *at < here.last; ++at)
      if (basis.add(pairs_.direction(*at))) {
        const double* nu = &normals_[*at * dim_];
        change[basis.size() - 1] = value[*at] - std::inner_product(nu, nu + dim_, at_node, 0.0);
      }
    basis.shortest(change);
    basis.add_to(at_node, change);
  }
}

void NormalOperator::hold(Vec diagonal, Vec r, Vec y) const {
  if (!pairs_.held())
    return;
  const petsc::ReadArray d(diagonal), force(r);
  const petsc::WriteArray values(y);
  for (int i = 0; i < pairs_.count(); ++i)
    for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
      if (directions_[i * dim_ + c] != normals_[i * dim_ + c])
        values[local_[i] + c] = force[local_[i] + c] / d[local_[i] + c];
}

double NormalOperator::held_normal(int i, std::span<const double> y) const {
  double sum = 0;
  for (int c = 0; c < dim_; ++c)
    sum += (normals_[i * dim_ + c] - directions_[i * dim_ + c]) * y[local_[i] + c];
  return sum;
}

} // namespace signorini::contact
