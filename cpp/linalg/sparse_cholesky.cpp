// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/sparse_cholesky.h"
#include "base/error.h"
#include "linalg/lane_solver.h"
#include "linalg/supernodal.h"
#include <algorithm>
#include <array>
#include <cholmod.h>
#include <fmt/format.h>
#include <optional>

namespace signorini {
using petsc::check;

namespace {

/// Number of entries of L below which a simplicial factor solves faster than a supernodal one, because L fits
/// into the processor's cache. Measured for sizes on both sides of this value by `./dev bench`, which reports
/// the time of a solve.
constexpr double small_factor = 1e6;

/// Access to a sequential BAIJ matrix: compressed rows of blocks. The values are stored block by block, each
/// block column by column.
class Blocks {
public:
  explicit Blocks(Mat matrix) : matrix_(matrix) {
    check(MatGetBlockSize(matrix, &size));
    PetscBool done = PETSC_FALSE;
    check(MatGetRowIJ(matrix_, 0, PETSC_FALSE, PETSC_TRUE, &count, &row, &column, &done));
    if (!done)
      throw SolverFailure("the step operator D is not in block format");
    check(MatSeqBAIJGetArray(matrix_, &values_));
  }
  ~Blocks() {
    PetscBool done = PETSC_FALSE;
    (void)MatSeqBAIJRestoreArray(matrix_, &values_);
    (void)MatRestoreRowIJ(matrix_, 0, PETSC_FALSE, PETSC_TRUE, &count, &row, &column, &done);
  }
  Blocks(const Blocks&) = delete;
  Blocks& operator=(const Blocks&) = delete;

  [[nodiscard]] double value(PetscInt entry, int i, int j) const {
    return values_[(static_cast<std::size_t>(entry) * size + j) * size + i];
  }

  PetscInt size = 0, count = 0;
  const PetscInt *row = nullptr, *column = nullptr;

private:
  Mat matrix_;
  PetscScalar* values_ = nullptr;
};

} // namespace

struct SparseCholesky::Cholmod {
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  cholmod_dense *work_y = nullptr, *work_e = nullptr;
  Forward z;                              ///< scratch of solves
  std::vector<double> x;                  ///< scratch of solves (n)
  std::vector<double> b;                  ///< right-hand side for a simplicial factor, else empty
  std::optional<TriangularSolves> solves; ///< present if the factor is supernodal
  Lockstep* lockstep = nullptr;           ///< whose tasks share solves
  cholmod_factor* supernodal = nullptr;   ///< for these, if `factor` is simplicial
  std::optional<LaneSolver> together;     ///< their solves

  Cholmod() {
    cholmod_start(&common);
    common.print = 0;
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
  }
  ~Cholmod() {
    for (cholmod_dense** dense : {&work_y, &work_e})
      cholmod_free_dense(dense, &common);
    for (cholmod_factor** one : {&factor, &supernodal})
      cholmod_free_factor(one, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  /// Throws SolverFailure unless the last call of CHOLMOD succeeded.
  void require(const char* doing) const {
    if (common.status == CHOLMOD_OK)
      return;
    const char* why = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
                      : common.status == CHOLMOD_TOO_LARGE   ? "the factor is too large for 32-bit indices"
                      : common.status == CHOLMOD_NOT_POSDEF  ? "not positive definite"
                                                             : "internal error";
    throw SolverFailure(fmt::format("{} of the step operator D by CHOLMOD failed: {} (status {})", doing, why,
                                    common.status));
  }

  /// Allocates the lower triangle of a symmetric (n × n) matrix and calls `fill` with its arrays of column
  /// starts, row indices and values.
  template <class Fill>
  cholmod_sparse* lower(std::size_t n, std::size_t entries, bool pattern, Fill&& fill) {
    cholmod_sparse* A =
        cholmod_allocate_sparse(n, n, entries, 1, 1, -1, pattern ? CHOLMOD_PATTERN : CHOLMOD_REAL, &common);
    require("the storage");
    fill(static_cast<int*>(A->p), static_cast<int*>(A->i), static_cast<double*>(A->x));
    return A;
  }

  /// Array into which the right-hand side is written before triangular_solve(…, solution).
  std::span<double> right_hand_side(std::span<double> solution) {
    return factor->is_super ? solution : std::span<double>(b);
  }

  void triangular_solve(int system, std::span<double> solution) {
    if (factor->is_super) {
      system == CHOLMOD_L ? solves->forward(solution) : solves->backward(solution);
      return;
    }
    cholmod_dense from = dense(b), to = dense(solution), *to_there = &to;
    cholmod_solve2(system, factor, &from, nullptr, &to_there, nullptr, &work_y, &work_e, &common);
    require("a solve");
  }

  /// Sets up the solves that tasks share, on a supernodal factor.
  void solve_together(std::size_t trailing) {
    if (!factor->is_super) {
      analyse(supernodal, static_cast<int*>(factor->Perm), CHOLMOD_SUPERNODAL);
      cholmod_factorize(matrix, supernodal, &common);
      require("the factorisation");
    }
    together.emplace(factor->is_super ? *factor : *supernodal, trailing);
  }

  /// Analyses the matrix for a factor in the given elimination order.
  void analyse(cholmod_factor*& to, int* permutation, int format) {
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 0; // the analysis that found the order has postordered
    // Solves are bound by memory bandwidth: keep narrow supernodes rather than merge them and pad with zeros.
    std::ranges::copy(std::array{2, 4, 8}, common.nrelax);
    common.supernodal = format;
    to = cholmod_analyze_p(matrix, permutation, nullptr, 0, &common);
  }

private:
  static cholmod_dense dense(std::span<double> x) {
    cholmod_dense dense{};
    dense.nrow = dense.nzmax = dense.d = x.size();
    dense.ncol = 1;
    dense.x = x.data();
    dense.xtype = CHOLMOD_REAL;
    dense.dtype = CHOLMOD_DOUBLE;
    return dense;
  }
};

namespace {

/// Fills the arrays of the lower triangle of D in compressed columns, from the blocks of D.
void fill_lower(const Blocks& D, int* p, int* i, double* x) {
  int entries = 0;
  for (int node = 0; node < D.count; ++node)
    for (int cj = 0; cj < D.size; ++cj) {
      p[node * D.size + cj] = entries;
      for (PetscInt e = D.row[node]; e < D.row[node + 1]; ++e)
        for (int ci = 0; ci < D.size; ++ci)
          if (D.column[e] * D.size + ci >= node * D.size + cj) {
            i[entries] = D.column[e] * D.size + ci;
            x[entries++] = D.value(e, cj, ci); // by symmetry
          }
    }
  p[D.count * D.size] = entries;
}

/// Computes a fill-reducing elimination order of the nodes outside the trailing block, and puts the trailing
/// block last.
template <class Cholmod>
EliminationOrder order_for_sparsity(Cholmod& c, const Blocks& D, std::span<const int> trailing_block) {
  std::vector<int> number(static_cast<std::size_t>(D.count), 0), node;
  for (int i : trailing_block)
    number[i] = -1;
  for (int i = 0; i < D.count; ++i)
    if (number[i] == 0) {
      number[i] = static_cast<int>(node.size());
      node.push_back(i);
    }
  cholmod_sparse* graph =
      c.lower(node.size(), static_cast<std::size_t>(D.row[D.count]), true, [&](int* p, int* i, double*) {
        int entries = 0;
        for (std::size_t j = 0; j < node.size(); ++j) {
          p[j] = entries;
          for (PetscInt e = D.row[node[j]]; e < D.row[node[j] + 1]; ++e)
            if (const int k = number[D.column[e]]; k >= static_cast<int>(j))
              i[entries++] = k;
        }
        p[node.size()] = entries;
      });
  c.common.nmethods = 2; // CHOLMOD keeps the better of the two
  c.common.method[0].ordering = CHOLMOD_METIS;
  c.common.method[1].ordering = CHOLMOD_AMD;
  c.common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_factor* factor = cholmod_analyze(graph, &c.common);
  cholmod_free_sparse(&graph, &c.common);
  c.require("the ordering");
  EliminationOrder order{{}, c.common.lnz * D.size * D.size};
  for (std::size_t j = 0; j < node.size(); ++j)
    order.nodes.push_back(node[static_cast<int*>(factor->Perm)[j]]);
  cholmod_free_factor(&factor, &c.common);
  order.nodes.insert(order.nodes.end(), trailing_block.begin(), trailing_block.end());
  return order;
}

} // namespace

SparseCholesky::SparseCholesky(Mat matrix, std::span<const int> trailing_block, double most,
                               const EliminationOrder& order)
    : c_(std::make_unique<Cholmod>()) {
  const Blocks D(matrix);
  trailing_size_ = static_cast<int>(trailing_block.size()) * D.size;
  order_ = order.nodes.empty() ? order_for_sparsity(*c_, D, trailing_block) : order;
  const double matrix_entries = static_cast<double>(D.row[D.count]) * D.size * D.size;
  entries_ = order_.entries + static_cast<double>(trailing_size_) * trailing_size_ / 2;
  indexable_ = std::max(entries_, matrix_entries) <= most;
  if (!indexable_)
    return;
  std::vector<int> permutation;
  for (int i : order_.nodes)
    for (int c = 0; c < D.size; ++c)
      permutation.push_back(i * D.size + c);
  c_->matrix = c_->lower(permutation.size(), static_cast<std::size_t>(D.row[D.count]) * D.size * D.size,
                         false, [&](int* p, int* i, double* x) { fill_lower(D, p, i, x); });
  c_->analyse(c_->factor, permutation.data(),
              order_.entries < small_factor ? CHOLMOD_SIMPLICIAL : CHOLMOD_SUPERNODAL);
  indexable_ = c_->common.status != CHOLMOD_TOO_LARGE; // counts the zeros that pad supernodes
  if (indexable_)
    c_->require("the analysis");
}

SparseCholesky::~SparseCholesky() = default;

double SparseCholesky::estimate() const {
  if (!indexable_)
    return entries_ * sizeof(double);
  const cholmod_factor& L = *c_->factor;
  const double trailing_block = static_cast<double>(trailing_size_);
  constexpr double entry = sizeof(double), index = sizeof(int);
  return static_cast<double>(c_->common.memory_inuse) + trailing_block * trailing_block * entry +
         (L.is_super ? static_cast<double>(L.xsize + L.maxcsize) * entry : c_->common.lnz * (entry + index));
}

FactorWork SparseCholesky::work() const {
  const cholmod_factor& L = *c_->factor;
  return {.flops = c_->common.fl, .entries = L.is_super ? static_cast<double>(L.xsize) : c_->common.lnz};
}

void SparseCholesky::factorise() {
  if (!indexable_)
    throw SolverFailure(
        fmt::format("the factorisation of the step operator D by CHOLMOD failed: its {:.3g} entries "
                    "are too many for 32-bit indices",
                    entries_));
  cholmod_factorize(c_->matrix, c_->factor, &c_->common);
  c_->require("the factorisation");
  if (c_->factor->is_super) // else kept for a supernodal factor
    cholmod_free_sparse(&c_->matrix, &c_->common);
  const std::size_t n = c_->factor->n;
  c_->x.resize(n);
  c_->b.resize(c_->factor->is_super ? 0 : n);
  if (c_->factor->is_super)
    c_->solves.emplace(*c_->factor);
}

std::vector<double> SparseCholesky::trailing_factor() const {
  const cholmod_factor& L = *c_->factor;
  const auto c = static_cast<std::size_t>(trailing_size_);
  const int first = static_cast<int>(L.n - c);
  const auto* x = static_cast<const double*>(L.x);
  std::vector<double> block(c * c, 0.0);
  const auto put = [&](int i, int j, double value) {
    if (i >= j && j >= first)
      block[static_cast<std::size_t>(j - first) * c + static_cast<std::size_t>(i - first)] = value;
  };
  if (L.is_super) {
    const auto *super = static_cast<const int*>(L.super), *pi = static_cast<const int*>(L.pi),
               *px = static_cast<const int*>(L.px), *rows = static_cast<const int*>(L.s);
    for (std::size_t s = 0; s < L.nsuper; ++s) {
      const int height = pi[s + 1] - pi[s];
      for (int j = std::max(super[s], first); j < super[s + 1]; ++j)
        for (int k = 0; k < height; ++k)
          put(rows[pi[s] + k], j,
              x[static_cast<std::size_t>(px[s]) + static_cast<std::size_t>(j - super[s]) * height + k]);
    }
  } else {
    const auto *p = static_cast<const int*>(L.p), *i = static_cast<const int*>(L.i),
               *nz = static_cast<const int*>(L.nz);
    for (int j = first; j < static_cast<int>(L.n); ++j)
      for (int e = p[j]; e < p[j] + nz[j]; ++e)
        put(i[e], j, x[e]);
  }
  return block;
}

std::size_t SparseCholesky::size() const { return c_->factor->n; }

bool SparseCholesky::shared() const { return c_->lockstep && c_->lockstep->inside(); }

void SparseCholesky::unite(Lockstep* lockstep) const {
  if (lockstep && !c_->together)
    c_->solve_together(static_cast<std::size_t>(trailing_size_));
  c_->lockstep = lockstep;
}

SparseCholesky::Forward SparseCholesky::storage() const {
  Forward z;
  z.z_.reserve(size()); // which takes no memory as long as z is kept with those of other tasks
  z.trailing_.reserve(static_cast<std::size_t>(trailing_size_));
  return z;
}

void SparseCholesky::forward(Vec b, Forward& z) const {
  z.trailing_.resize(static_cast<std::size_t>(trailing_size_));
  z.among_others_ = shared();
  if (z.among_others_) {
    if (!z.place_)
      z.place_ = std::make_shared<KeptPlace>();
    c_->together->forward(*c_->lockstep, b, *z.place_, z.trailing_);
    return;
  }
  z.z_.resize(size());
  const auto* permutation = static_cast<const int*>(c_->factor->Perm);
  {
    const petsc::ReadArray values(b);
    const std::span<double> ordered = c_->right_hand_side(z.z_);
    for (std::size_t i = 0; i < ordered.size(); ++i)
      ordered[i] = values[permutation[i]];
  }
  c_->triangular_solve(CHOLMOD_L, z.z_);
  std::copy(z.z_.end() - trailing_size_, z.z_.end(), z.trailing_.begin());
}

void SparseCholesky::backward(const Forward& z, std::span<const double> trailing_block, Vec x) const {
  count_solves();
  if (z.among_others_) {
    c_->together->backward(*c_->lockstep, *z.place_, trailing_block, x);
    return;
  }
  const auto* permutation = static_cast<const int*>(c_->factor->Perm);
  const std::span<double> right = c_->right_hand_side(c_->x);
  const std::span<const double> whole = z.z_;
  std::ranges::copy(whole.first(whole.size() - trailing_block.size()), right.begin());
  std::ranges::copy(trailing_block, right.end() - static_cast<std::ptrdiff_t>(trailing_block.size()));
  c_->triangular_solve(CHOLMOD_Lt, c_->x);
  const petsc::WriteArray values(x);
  for (std::size_t i = 0; i < c_->x.size(); ++i)
    values[permutation[i]] = c_->x[i];
}

void SparseCholesky::solve(Vec b, Vec x) const {
  if (shared()) { // other tasks run between the halves
    Forward z;
    forward(b, z);
    backward(z, {}, x);
    return;
  }
  forward(b, c_->z);
  backward(c_->z, {}, x);
}

double SparseCholesky::bytes() const {
  return static_cast<double>(
      c_->common.memory_inuse + (c_->b.size() + c_->x.size() + c_->z.z_.size()) * sizeof(double) +
      (c_->solves ? c_->solves->bytes() : 0) + (c_->together ? c_->together->bytes() : 0));
}

} // namespace signorini
