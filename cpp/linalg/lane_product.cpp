// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/lane_product.h"
#include "base/machine.h"
#include <algorithm>
#include <deque>

namespace signorini {
using petsc::check;

namespace {

bool is(Mat matrix, const char* type) {
  PetscBool same = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), type, &same));
  return same;
}

} // namespace

/// The product that a task waits for.
class LaneProduct::Asked final : public SharedSolve {
public:
  Asked(LaneProduct& product, Vec x, Vec w, Vec r) : x(x), w(w), r(r), product_(product) {}
  void make(std::span<SharedSolve* const> all) override { product_.make(all); }
  [[nodiscard]] const void* kind() const override { return &product_; }

  Vec x, w, r;

private:
  LaneProduct& product_;
};

LaneProduct::Copy LaneProduct::copy(Mat matrix) {
  const bool multiples = is(matrix, MATSEQMAIJ);
  const Mat stored = multiples ? petsc::component(matrix) : matrix;
  PetscInt size = 1, count = 0;
  check(MatGetBlockSize(matrix, &size));
  const PetscInt *begin = nullptr, *column = nullptr;
  PetscBool done = PETSC_FALSE;
  check(MatGetRowIJ(stored, 0, PETSC_FALSE, PETSC_TRUE, &count, &begin, &column, &done));
  PetscScalar* values = nullptr;
  check(multiples ? MatSeqAIJGetArray(stored, &values) : MatSeqSBAIJGetArray(stored, &values));
  Copy made;
  made.numbers = multiples ? 1 : size * size;
  made.begin.assign(static_cast<std::size_t>(count) + 1, 0);
  const auto for_entries = [&](auto&& visit) { // in both halves; of each row by ascending columns
    for (PetscInt i = 0; i < count; ++i)
      for (PetscInt e = begin[i]; e < begin[i + 1]; ++e) {
        visit(i, column[e], e, false);
        if (!multiples && column[e] != i)
          visit(column[e], i, e, true);
      }
  };
  for_entries([&](PetscInt i, PetscInt, PetscInt, bool) { ++made.begin[i + 1]; });
  for (PetscInt i = 0; i < count; ++i)
    made.begin[i + 1] += made.begin[i];
  const auto entries = static_cast<std::size_t>(made.begin[count]);
  made.column.resize(entries);
  made.values.resize(entries * static_cast<std::size_t>(made.numbers));
  std::vector<int> next(made.begin.begin(), made.begin.end() - 1);
  for_entries([&](PetscInt i, PetscInt j, PetscInt e, bool transposed) {
    const int at = next[i]++;
    made.column[at] = j;
    double* const to = &made.values[static_cast<std::size_t>(at) * static_cast<std::size_t>(made.numbers)];
    const double* const from = values + static_cast<std::ptrdiff_t>(e) * made.numbers; // by columns
    if (made.numbers == 1)
      *to = *from;
    else
      for (PetscInt r = 0; r < size; ++r)
        for (PetscInt c = 0; c < size; ++c)
          to[r * size + c] = transposed ? from[r * size + c] : from[c * size + r];
  });
  check(multiples ? MatSeqAIJRestoreArray(stored, &values) : MatSeqSBAIJRestoreArray(stored, &values));
  check(MatRestoreRowIJ(stored, 0, PETSC_FALSE, PETSC_TRUE, &count, &begin, &column, &done));
  return made;
}

void LaneProduct::unite(Lockstep* lockstep) {
  const Mat R = *R_;
  if (lockstep && size_ == 0 && is(R, MATSEQSBAIJ) && (is(M_, MATSEQSBAIJ) || is(M_, MATSEQMAIJ))) {
    PetscInt size = 1;
    check(MatGetBlockSize(R, &size));
    whole_R_ = copy(R);
    whole_M_ = copy(M_);
    size_ = size;
  }
  lockstep_ = size_ > 0 ? lockstep : nullptr;
}

void LaneProduct::multiply(Mat R, Vec x, Vec w, Vec r) {
  if (R == *R_ && lockstep_ && lockstep_->inside()) {
    Asked asked(*this, x, w, r);
    lockstep_->wait(asked);
    return;
  }
  check(MatMult(M_, w, r));
  check(MatMultAdd(R, x, r, r));
}

void LaneProduct::make(std::span<SharedSolve* const> all) {
  const std::size_t n = (whole_R_.begin.size() - 1) * static_cast<std::size_t>(size_);
  std::deque<petsc::ReadArray> from;
  const auto gather = [&](Vec Asked::* which, SideBySide& to) {
    std::vector<const double*> values;
    for (SharedSolve* const one : all)
      values.push_back(std::span<const double>(from.emplace_back(static_cast<Asked*>(one)->*which)).data());
    to.resize(n, all.size());
    to.gather(values, nullptr);
  };
  gather(&Asked::x, x_);
  gather(&Asked::w, w_);
  r_.resize(n, all.size());
  constexpr int piece = 64;
  const int rows = static_cast<int>(whole_R_.begin.size()) - 1;
#pragma omp parallel for schedule(static) num_threads(threads())
  for (int first = 0; first < rows; first += piece)
    for (std::size_t g = 0; g < r_.groups().size(); ++g)
      multiply_lanes(whole_R_.rows(), whole_M_.rows(), size_, first, std::min(first + piece, rows),
                     r_.groups()[g].lanes, x_.groups()[g].values, w_.groups()[g].values,
                     r_.groups()[g].values);
  std::deque<petsc::WriteArray> arrays;
  std::vector<double*> to;
  for (SharedSolve* const one : all)
    to.push_back(std::span<double>(arrays.emplace_back(static_cast<Asked*>(one)->r)).data());
  r_.scatter(nullptr, to);
}

std::size_t LaneProduct::bytes() const {
  std::size_t sum = x_.bytes() + w_.bytes() + r_.bytes();
  for (const Copy* one : {&whole_R_, &whole_M_})
    sum += (one->begin.capacity() + one->column.capacity()) * sizeof(int) +
           one->values.capacity() * sizeof(double);
  return sum;
}

} // namespace signorini
