// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/control.h"
#include <algorithm>
#include <cmath>

namespace signorini::control {

namespace {

/// Number of entries in a block of an operation on many vectors, so that the block of the common vector stays
/// in the cache.
constexpr std::size_t block = 4096;
/// Least number of blocks (about 3 µs each) for which such an operation is divided among threads.
constexpr std::size_t worth_threads = 64;

/// Returns the least power of two above `largest`; 1 if there is none.
double power_above(double largest) {
  return largest > 0 && std::isfinite(largest) ? std::ldexp(1, std::ilogb(largest) + 1) : 1;
}

/// Returns pointers to the values of each control from entry `first` on.
std::vector<const float*> beginnings(std::span<const CompactControl> x, std::size_t first) {
  std::vector<const float*> all;
  for (const CompactControl& one : x)
    all.push_back(one.values().data() + first);
  return all;
}

} // namespace

CompactControl::CompactControl(const Control& u) : count_(u.count()) {
  double largest = 0;
  for (double x : u.values())
    largest = std::max(largest, std::abs(x));
  scale_ = power_above(largest);
  std::vector<float> values;
  values.reserve(u.values().size());
  for (double x : u.values())
    values.push_back(static_cast<float>(x / scale_));
  values_ = SharedArray(std::move(values));
}

void CompactControl::combine(std::vector<CompactControl>& x,
                             const std::vector<std::vector<double>>& factors) {
  const std::size_t n = x.size(), m = factors.size();
  std::vector<double> scales, scaled(n * m); // column by column
  for (std::size_t j = 0; j < m; ++j) {
    double largest = 0; // bound of the combined values
    for (std::size_t i = 0; i < n; ++i)
      largest += std::abs(factors[j][i]) * x[i].scale_;
    scales.push_back(power_above(largest));
    for (std::size_t i = 0; i < n; ++i)
      scaled[j * n + i] = factors[j][i] * x[i].scale_ / scales[j];
  }
  std::vector<std::span<float>> results;
  for (std::size_t j = 0; j < m; ++j) {
    results.push_back(x[j].values_.write());
    x[j].scale_ = scales[j];
  }
  constexpr std::size_t rows = 512; // some of all controls, in double precision, fit into the cache
  const std::size_t values = x.empty() ? 0 : x.front().values().size(), parts = (values + rows - 1) / rows;
#pragma omp parallel for schedule(static) if (parts * n >= worth_threads)
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * rows, size = std::min(rows, values - first);
    const std::vector<const float*> before = beginnings(x, first);
    std::vector<double> after(size * m);
    // Not by BLAS: concurrent products share a buffer in builds for one thread, as Debian's.
    for (std::size_t j = 0; j < m; ++j)
      signorini::add(std::span(scaled).subspan(j * n, n), before, std::span(after).subspan(j * size, size));
    for (std::size_t j = 0; j < m; ++j)
      std::copy_n(&after[j * size], size, results[j].begin() + static_cast<std::ptrdiff_t>(first));
  }
  x.resize(m);
}

Control::Control(const CompactControl& u)
    : values_(std::vector<double>(u.values().begin(), u.values().end())),
      size_(u.values().size() / static_cast<std::size_t>(u.count())), count_(u.count()) {
  scale(u.scale());
}

void Control::add(std::span<const double> a, std::span<const CompactControl> x) {
  std::vector<double> factors(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    factors[i] = a[i] * x[i].scale();
  const std::span<double> sum = values();
  const std::size_t blocks = (sum.size() + block - 1) / block;
#pragma omp parallel for schedule(static) if (blocks * x.size() >= worth_threads)
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = b * block, size = std::min(block, sum.size() - first);
    signorini::add(factors, beginnings(x, first), sum.subspan(first, size));
  }
}

std::vector<double> dots(std::span<const Control> u, std::span<const CompactControl> w) {
  const std::size_t values = u.empty() ? 0 : u.front().values().size(), blocks = (values + block - 1) / block,
                    each = u.size() * w.size();
  std::vector<double> parts(blocks * each); // added in their order, whatever the number of threads
#pragma omp parallel for schedule(static) if (blocks * each >= worth_threads)
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = b * block, size = std::min(block, values - first);
    const std::vector<const float*> arrays = beginnings(w, first);
    for (std::size_t i = 0; i < u.size(); ++i)
      signorini::dots(arrays, u[i].values().subspan(first, size),
                      std::span(parts).subspan(b * each + i * w.size(), w.size()));
  }
  std::vector<double> sums(each);
  for (std::size_t b = 0; b < blocks; ++b)
    axpy(1, std::span(parts).subspan(b * each, each), sums);
  for (std::size_t i = 0; i < each; ++i)
    sums[i] *= w[i % w.size()].scale();
  return sums;
}

Variables::Variables(const CompactVariables& compact) : u(compact.u), x(compact.x) {}

void Variables::add(std::span<const double> a, std::span<const CompactVariables> v) {
  u.add(a, controls_of(v));
  for (std::size_t i = 0; i < v.size(); ++i)
    axpy(a[i], v[i].x, x);
}

void CompactVariables::combine(std::vector<CompactVariables>& v,
                               const std::vector<std::vector<double>>& factors) {
  std::vector<CompactControl> controls; // moved, so that none is copied when it is overwritten
  for (CompactVariables& one : v)
    controls.push_back(std::move(one.u));
  CompactControl::combine(controls, factors);
  std::vector<CompactVariables> combined(factors.size());
  for (std::size_t j = 0; j < factors.size(); ++j) {
    combined[j].u = std::move(controls[j]);
    combined[j].x.assign(v.empty() ? 0 : v.front().x.size(), 0.0);
    for (std::size_t i = 0; i < v.size(); ++i)
      axpy(factors[j][i], v[i].x, combined[j].x);
  }
  v = std::move(combined);
}

std::vector<CompactControl> controls_of(std::span<const CompactVariables> v) {
  std::vector<CompactControl> controls;
  for (const CompactVariables& one : v)
    controls.push_back(one.u);
  return controls;
}

} // namespace signorini::control
