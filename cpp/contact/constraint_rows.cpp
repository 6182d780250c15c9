// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/constraint_rows.h"
#include "base/collective.h"
#include "contact/row_basis.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace signorini::contact {
using petsc::check;

ConstraintRows::ConstraintRows(MPI_Comm comm, const std::vector<Group>& groups, PetscInt first, PetscInt end)
    : comm_(comm), row_begin_{0} {
  std::size_t of_cluster = 0;   // begin of the present cluster's dofs
  std::vector<PetscInt> shared; // in the order of their first entries
  std::map<PetscInt, int> shared_place;
  const auto place_of = [&](const Entry& entry) { // negative: a shared dof, whose place is not known yet
    if (entry.shared) {
      const auto [at, first_entry] = shared_place.try_emplace(entry.dof, static_cast<int>(shared.size()));
      if (first_entry)
        shared.push_back(entry.dof);
      return -1 - at->second;
    }
    const auto from = dofs_.begin() + static_cast<std::ptrdiff_t>(of_cluster);
    const auto at = static_cast<int>(std::find(from, dofs_.end(), entry.dof) - dofs_.begin());
    if (at == std::ssize(dofs_))
      dofs_.push_back(entry.dof);
    return at;
  };
  const auto known = [&](const Entry& entry) {
    return std::find(dofs_.begin() + static_cast<std::ptrdiff_t>(of_cluster), dofs_.end(), entry.dof) !=
           dofs_.end();
  };
  const auto add_row = [&](const std::vector<Entry>& row) {
    own_entries_.push_back(static_cast<std::size_t>(std::ranges::count(row, false, &Entry::shared)));
    lifted_.push_back(std::ranges::any_of(
        row, [](const Entry& entry) { return entry.shared && entry.lift.value_or(0) != 0; }));
    for (const Entry& entry : row) {
      columns_.push_back(place_of(entry));
      motions_.push_back(entry.coefficient);
      forces_.push_back(entry.clamped ? 0 : entry.coefficient);
      lifts_.push_back(entry.lift.value_or(entry.shared ? 0 : entry.coefficient));
      clamped_.push_back(entry.clamped);
      any_clamped_ = any_clamped_ || entry.clamped;
    }
    row_begin_.push_back(columns_.size());
  };
  for (const Group& group : groups) {
    if (std::ranges::none_of(group.entries, known))
      of_cluster = dofs_.size();
    add_row(group.entries);
    laws_.push_back(group.law);
    symmetric_ = symmetric_ && group.law->symmetric();
    act_open_ = act_open_ || group.law->acts_open();
  }
  of_cluster = 0;
  const std::size_t constrained = dofs_.size();
  others_.push_back(this->groups());
  for (const Group& group : groups) {
    for (const std::vector<Entry>& row : group.others)
      add_row(row);
    others_.push_back(count());
  }
  if (dofs_.size() > constrained)
    throw std::logic_error("a further row of a group has a dof that the group's first row lacks");
  own_ = dofs_.size();
  std::map<PetscInt, int> own_place;
  for (std::size_t i = 0; i < own_ && !shared.empty(); ++i)
    own_place[dofs_[i]] = static_cast<int>(i);
  std::vector<int> place; // of each shared dof
  for (const PetscInt dof : shared)
    if (const auto found = own_place.find(dof); found != own_place.end()) {
      place.push_back(found->second);
    } else {
      place.push_back(static_cast<int>(dofs_.size()));
      dofs_.push_back(dof);
    }
  for (int& column : columns_)
    if (column < 0)
      column = place[static_cast<std::size_t>(-1 - column)];
  for (const PetscInt dof : dofs_)
    local_.push_back(dof >= first && dof < end ? static_cast<int>(dof - first) : -1);
  find_clusters();
}

void ConstraintRows::find_clusters() {
  for (int group = 0; group < groups(); ++group) {
    const auto [least, most] = std::ranges::minmax(own_columns(group));
    if (clusters_.empty() || least >= clusters_.back().end)
      clusters_.push_back({group, group, least, least, false, false});
    Cluster& here = clusters_.back();
    here.last = group + 1;
    here.end = std::max(here.end, most + 1);
    cluster_of_.push_back(static_cast<int>(clusters_.size()) - 1);
  }
  int on_ranks = 0; // clusters, summed over the ranks that have all of them
  RowBasis basis(*this);
  for (Cluster& here : clusters_) {
    basis.clear();
    for (int row = here.first; row < here.last; ++row)
      here.dependent = !basis.add(row) || here.dependent;
    dependent_ = dependent_ || here.dependent;
    here.here = std::all_of(local_.begin() + here.begin, local_.begin() + here.end,
                            [](int local) { return local >= 0; });
    on_ranks += here.here;
  }
  MPI_Allreduce(MPI_IN_PLACE, &on_ranks, 1, MPI_INT, MPI_SUM, comm_);
  across_ranks_ = on_ranks < static_cast<int>(clusters_.size()) || (share() && ranks(comm_) > 1);
}

bool ConstraintRows::equals(const ConstraintRows& other) const {
  return row_begin_ == other.row_begin_ && others_ == other.others_ && laws_ == other.laws_ &&
         dofs_ == other.dofs_ && columns_ == other.columns_ && motions_ == other.motions_ &&
         forces_ == other.forces_ && lifts_ == other.lifts_;
}

ConstraintRows ConstraintRows::with(std::vector<double> coefficients) const {
  ConstraintRows other = *this;
  for (std::size_t i = 0; i < coefficients.size(); ++i)
    other.forces_[i] = clamped_[i] ? 0 : coefficients[i];
  for (std::size_t row = 0; row < rows_count(); ++row)
    for (std::size_t j = row_begin_[row]; j < row_begin_[row + 1]; ++j)
      other.lifts_[j] = j < row_begin_[row] + own_entries_[row] ? coefficients[j] : 0;
  other.lifted_.assign(rows_count(), false);
  other.motions_ = std::move(coefficients);
  return other;
}

void ConstraintRows::spread(int group, std::span<double> out) const {
  std::ranges::fill(out, 0);
  const std::span<const int> at = own_columns(group);
  const std::span<const double> values = lift(group);
  for (std::size_t j = 0; j < at.size(); ++j)
    out[at[j] - cluster(group).begin] = clamped_[row_begin_[group] + j] ? 0 : values[j];
}

void ConstraintRows::spread(const ContactLinearisation& contact, std::span<double> out) const {
  std::ranges::fill(out, 0);
  auto force = contact.forces.begin();
  for (const int group : contact.active)
    for (std::size_t c = 0; c < size(group); ++c)
      out[row(group, c)] = *force++;
}

template <class Visit>
void ConstraintRows::for_each(const std::vector<double>& coefficients, std::size_t first, std::size_t end,
                              Visit&& visit) const {
  for (std::size_t row = first; row < end; ++row)
    for (std::size_t entry = row_begin_[row]; entry < row_begin_[row + 1]; ++entry)
      visit(row, static_cast<std::size_t>(columns_[entry]), coefficients[entry]);
}

template <class Visit>
void ConstraintRows::for_each_here(const std::vector<double>& coefficients, std::size_t rows,
                                   Visit&& visit) const {
  for_each(coefficients, 0, rows, [&](std::size_t row, std::size_t column, double h) {
    if (const int local = local_[column]; local >= 0)
      visit(row, static_cast<std::size_t>(local), h);
  });
}

void ConstraintRows::apply_transpose(Vec x, std::span<double> out) const {
  std::ranges::fill(out, 0);
  {
    const petsc::ReadArray values(x);
    for_each_here(motions_, out.size(),
                  [&](std::size_t row, std::size_t dof, double h) { out[row] += h * values[dof]; });
  }
  // An entry whose row is on one rank comes from it alone, so that the sum is exact.
  MPI_Allreduce(MPI_IN_PLACE, out.data(), static_cast<int>(out.size()), MPI_DOUBLE, MPI_SUM, comm_);
}

void ConstraintRows::gap(std::span<const double> psi, Vec y, std::span<double> out) const {
  apply_transpose(y, out);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = (i < psi.size() ? psi[i] : 0) - out[i];
}

void ConstraintRows::add(const std::vector<double>& coefficients, double scale,
                         std::span<const double> lambda, Vec x) const {
  const petsc::WriteArray values(x);
  for_each_here(coefficients, lambda.size(),
                [&](std::size_t row, std::size_t dof, double h) { values[dof] += scale * lambda[row] * h; });
}

void ConstraintRows::apply_transpose(std::span<const double> x, std::span<double> out) const {
  std::ranges::fill(out.first(rows_count()), 0);
  for_each(motions_, 0, rows_count(),
           [&](std::size_t row, std::size_t column, double h) { out[row] += h * x[column]; });
}

void ConstraintRows::apply(std::span<const double> lambda, std::span<double> x) const {
  std::ranges::fill(x, 0);
  for_each(forces_, 0, rows_count(),
           [&](std::size_t row, std::size_t column, double h) { x[column] += h * lambda[row]; });
}

std::vector<double> ConstraintRows::dense() const {
  std::vector<double> H(dofs_.size() * rows_count());
  for_each(forces_, 0, rows_count(),
           [&](std::size_t row, std::size_t column, double h) { H[row * dofs_.size() + column] = h; });
  return H;
}

void ConstraintRows::gram(const Cluster& cluster, std::vector<double>& out) const {
  SmallArray<double, 3> one(cluster.width()), other(cluster.width());
  out.clear();
  for (int i = cluster.first; i < cluster.last; ++i)
    for (int j = cluster.first; j < cluster.last; ++j) {
      spread(i, one);
      spread(j, other);
      out.push_back(std::inner_product(one.begin(), one.end(), other.begin(), 0.0));
    }
}

petsc::Matrix ConstraintRows::rows(int first, int count, Vec layout) const {
  const bool mine = rank(comm_) == 0;
  PetscInt n = 0;
  check(VecGetSize(layout, &n));
  std::size_t most = 0;
  for (int i = first; i < first + count; ++i)
    most = std::max(most, columns(i).size());
  petsc::Matrix made;
  check(MatCreateAIJ(comm_, mine ? count : 0, mine ? n : 0, count, n, static_cast<PetscInt>(most), nullptr, 0,
                     nullptr, made.put()));
  const auto begin = static_cast<std::size_t>(first);
  for_each(forces_, begin, mine ? begin + static_cast<std::size_t>(count) : begin,
           [&](std::size_t row, std::size_t column, double h) {
             check(MatSetValue(made, static_cast<PetscInt>(row - begin), dofs_[column], h, INSERT_VALUES));
           });
  check(MatAssemblyBegin(made, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(made, MAT_FINAL_ASSEMBLY));
  return made;
}

std::vector<double> ConstraintRows::weighted_squares(Vec diagonal) const {
  std::vector<double> sums(rows_count());
  {
    const petsc::ReadArray d(diagonal);
    for (std::size_t row = 0; row < sums.size(); ++row)
      for (std::size_t j = row_begin_[row]; j < row_begin_[row + 1]; ++j)
        if (const int local = local_[columns_[j]]; local >= 0 && !clamped_[j])
          sums[row] += lifts_[j] * lifts_[j] * d[local];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), count(), MPI_DOUBLE, MPI_SUM, comm_);
  return sums;
}

std::vector<double> ConstraintRows::gathered(Vec x) const {
  std::vector<double> all;
  if (!across_ranks_)
    return all;
  all.resize(dofs_.size());
  {
    const petsc::ReadArray values(x);
    for (std::size_t i = 0; i < all.size(); ++i)
      all[i] = local_[i] >= 0 ? values[local_[i]] : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, comm_);
  return all;
}

void ConstraintRows::take(const Cluster& cluster, std::span<const double> x, std::span<const double> gathered,
                          std::span<double> out) const {
  for (std::size_t j = 0; j < cluster.width(); ++j) {
    const std::size_t dof = static_cast<std::size_t>(cluster.begin) + j;
    out[j] = gathered.empty() ? x[local_[dof]] : gathered[dof];
  }
}

void ConstraintRows::multipliers(std::span<const int> set, Vec x, std::span<double> lambda) const {
  std::ranges::fill(lambda, 0);
  const std::vector<double> all = gathered(x);
  {
    const petsc::ReadArray values(x);
    RowBasis basis(*this);
    for (auto at = set.begin(); at != set.end();) {
      const Cluster& cluster = this->cluster(*at);
      basis.clear();
      for (; at != set.end() && *at < cluster.last; ++at)
        basis.add(*at);
      if (all.empty() ? !cluster.here : rank(comm_) > 0)
        continue;
      if (lifted(cluster.first)) {
        for (std::size_t k = 0; k < basis.size(); ++k) {
          const std::size_t row = basis.member(k);
          for (std::size_t j = row_begin_[row]; j < row_begin_[row + 1]; ++j)
            lambda[row] += clamped_[j]   ? 0
                           : all.empty() ? lifts_[j] * values[local_[columns_[j]]]
                                         : lifts_[j] * all[columns_[j]];
        }
        continue;
      }
      SmallArray<double, 3> here(cluster.width());
      take(cluster, values, all, here);
      RowBasis::Coordinates b = basis.coordinates();
      for (std::size_t k = 0; k < basis.size(); ++k)
        b[k] = basis.along(k, here);
      basis.combine(b);
      for (std::size_t k = 0; k < basis.size(); ++k)
        lambda[basis.member(k)] = b[k];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, lambda.data(), static_cast<int>(lambda.size()), MPI_DOUBLE, MPI_SUM,
                comm_); // exact, as above
}

void ConstraintRows::prescribe_by_lifts(std::span<const int> set, std::span<const double> value,
                                        Vec x) const {
  std::vector<double> all = gathered(x);
  const petsc::WriteArray values(x);
  if (all.empty())
    for (const int local : local_)
      all.push_back(values[local]);
  double size = 0;
  for (const int row : set)
    size = std::max(size, std::abs(value[row]));
  for (const double one : all)
    size = std::max(size, std::abs(one));
  // One sweep suffices, unless clamps hold dofs of lifts.
  constexpr int sweeps = 50;
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * size;
  double worst = 0;
  for (int sweep = 0; sweep == 0 || (sweep < sweeps && worst > rounding); ++sweep) {
    worst = 0;
    for (const int row : set) {
      if (!lifted(row))
        continue;
      double left = value[row], per_lift = 0;
      for (std::size_t j = row_begin_[row]; j < row_begin_[static_cast<std::size_t>(row) + 1]; ++j) {
        left -= motions_[j] * all[columns_[j]];
        per_lift += clamped_[j] ? 0 : motions_[j] * lifts_[j];
      }
      worst = std::max(worst, std::abs(left));
      for (std::size_t j = row_begin_[row]; j < row_begin_[static_cast<std::size_t>(row) + 1]; ++j)
        if (!clamped_[j])
          all[columns_[j]] += lifts_[j] * left / per_lift;
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (local_[i] >= 0)
      values[local_[i]] = all[i];
}

void ConstraintRows::prescribe(std::span<const int> set, std::span<const double> value, Vec x) const {
  if (std::ranges::any_of(set, [this](int row) { return lifted(row); }))
    prescribe_by_lifts(set, value, x);
  const std::vector<double> all = gathered(x);
  const petsc::WriteArray values(x);
  RowBasis basis(*this);
  for (auto at = set.begin(); at != set.end();) {
    const Cluster& cluster = this->cluster(*at);
    if ((all.empty() && !cluster.here) || lifted(*at)) {
      at = std::find_if(at, set.end(), [&](int i) { return i >= cluster.last; });
      continue;
    }
    SmallArray<double, 3> here(cluster.width());
    take(cluster, std::span<double>(values), all, here);
    basis.clear();
    RowBasis::Coordinates change = basis.coordinates();
    for (; at != set.end() && *at < cluster.last; ++at)
      if (basis.add(*at)) {
        const std::span<const int> columns = this->columns(*at);
        const std::span<const double> row = motion(*at);
        double moved = 0;
        for (std::size_t j = 0; j < row.size(); ++j) {
          const int column = columns[j];
          moved += row[j] * (column >= cluster.begin && column < cluster.end ? here[column - cluster.begin]
                             : all.empty()                                   ? values[local_[column]]
                                                                             : all[column]);
        }
        change[basis.size() - 1] = value[*at] - moved;
      }
    basis.shortest(change);
    basis.add_to(here, change);
    for (std::size_t j = 0; j < cluster.width(); ++j)
      if (const int local = local_[static_cast<std::size_t>(cluster.begin) + j]; local >= 0)
        values[local] = here[j];
  }
}

void ConstraintRows::set_clamped(Vec diagonal, Vec r, Vec y) const {
  if (!clamped())
    return;
  const petsc::ReadArray d(diagonal), force(r);
  const petsc::WriteArray values(y);
  for (std::size_t entry = 0; entry < columns_.size(); ++entry)
    if (const int at = local_[columns_[entry]]; at >= 0 && forces_[entry] != motions_[entry])
      values[at] = force[at] / d[at];
}

double ConstraintRows::clamped_part(int row, std::span<const double> y) const {
  const std::span<const int> at = columns(row);
  double sum = 0;
  for (std::size_t j = 0; j < at.size(); ++j)
    sum += (motion(row)[j] - force(row)[j]) * y[local_[at[j]]];
  return sum;
}

} // namespace signorini::contact
