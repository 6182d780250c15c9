// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/lane_kernels.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <limits>
#include <vector>

using namespace signorini;

namespace {

/// Limits the width of the registers as long as this object lives.
struct Registers {
  explicit Registers(int width) : supported(limit_lane_registers(width) == width) {}
  ~Registers() { limit_lane_registers(std::numeric_limits<int>::max()); }
  Registers(const Registers&) = delete;
  Registers& operator=(const Registers&) = delete;
  bool supported;
};

/// Numbers between -1 and 1 that look random.
std::vector<double> numbers(std::size_t count, double first) {
  std::vector<double> all(count);
  for (std::size_t i = 0; i < count; ++i)
    all[i] = std::sin(first + 1.7 * static_cast<double>(i * i % 101));
  return all;
}

/// Copies of a vector in all lanes, with another one in the lane `odd`.
std::vector<double> in_lanes(const std::vector<double>& x, std::ptrdiff_t lanes, std::ptrdiff_t odd) {
  std::vector<double> all;
  for (const double value : x)
    for (std::ptrdiff_t lane = 0; lane < lanes; ++lane)
      all.push_back(lane == odd ? 0.5 - value : value);
  return all;
}

/// The vector of the first lane that is not `odd`; all of these must have the same bits.
std::vector<double> from_lanes(const std::vector<double>& all, std::ptrdiff_t lanes, std::ptrdiff_t odd) {
  std::vector<double> x;
  for (std::size_t i = 0; i < all.size(); i += static_cast<std::size_t>(lanes)) {
    x.push_back(all[i + (odd == 0)]);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(lanes); ++lane)
      if (static_cast<std::ptrdiff_t>(lane) != odd)
        REQUIRE(all[i + lane] == x.back());
  }
  return x;
}

void check_close(const std::vector<double>& found, const std::vector<double>& exact, double size) {
  REQUIRE(found.size() == exact.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    CHECK(std::abs(found[i] - exact[i]) < 1e-14 * size);
}

} // namespace

TEST_CASE("kernels for every width of registers agree with loops, in every lane", "[lockstep]") {
  const int width = GENERATE(2, 4, 8);
  const std::ptrdiff_t lanes = GENERATE(narrow_lanes, wide_lanes);
  const int rows = GENERATE(1, 2, 7, 13, 24), columns = GENERATE(1, 3, 6, 8, 17);
  const Registers registers(width);
  if (!registers.supported)
    SKIP("the machine has no registers of " << width << " numbers");
  const std::ptrdiff_t odd = width + 1;
  const auto n = static_cast<std::size_t>(columns), m = static_cast<std::size_t>(rows);
  const std::size_t stride = m + n + 2;

  std::vector<double> T = numbers(n * stride, 0.1);
  for (std::size_t j = 0; j < n; ++j)
    T[j * stride + j] = 2 + static_cast<double>(j % 3);
  const FactorBlock triangle{T.data(), columns, columns, static_cast<std::ptrdiff_t>(stride)};
  const FactorBlock below{T.data() + columns, rows, columns, static_cast<std::ptrdiff_t>(stride)};
  const std::vector<double> x = numbers(n, 2.3), y = numbers(2 * m, 4.1);
  std::vector<int> rows_at(m); // every second row, backwards
  for (std::size_t i = 0; i < m; ++i)
    rows_at[i] = static_cast<int>(2 * (m - 1 - i));
  const bool spread = columns != 3;
  const auto at = [&](std::size_t i) { return spread ? static_cast<std::size_t>(rows_at[i]) : i; };

  std::vector<double> own = in_lanes(x, lanes, odd), to = in_lanes(y, lanes, odd);
  solve_lanes(triangle, lanes, own.data());
  std::vector<double> z = x;
  double size = 1;
  for (std::size_t j = 0; j < n; ++j) {
    z[j] /= T[j * stride + j];
    size = std::fmax(size, std::abs(z[j]));
    for (std::size_t i = j + 1; i < n; ++i)
      z[i] -= T[j * stride + i] * z[j];
  }
  check_close(from_lanes(own, lanes, odd), z, 100 * size);

  subtract_lanes(below, lanes, own.data(), spread ? rows_at.data() : nullptr, to.data());
  std::vector<double> left = y;
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < m; ++i)
      left[at(i)] -= T[j * stride + n + i] * z[j];
  check_close(from_lanes(to, lanes, odd), left, 1000 * size);

  subtract_lanes_transposed(below, lanes, to.data(), spread ? rows_at.data() : nullptr, own.data());
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < m; ++i)
      z[j] -= T[j * stride + n + i] * left[at(i)];
  for (const double value : left)
    size = std::fmax(size, std::abs(value));
  check_close(from_lanes(own, lanes, odd), z, 10000 * size);

  solve_lanes_transposed(triangle, lanes, own.data());
  for (std::size_t j = n; j-- > 0;) {
    for (std::size_t i = j + 1; i < n; ++i)
      z[j] -= T[j * stride + i] * z[i];
    z[j] /= T[j * stride + j];
    size = std::fmax(size, std::abs(z[j]));
  }
  check_close(from_lanes(own, lanes, odd), z, 100000 * size);
}

TEST_CASE("products in lanes agree with loops for every width of registers", "[lockstep]") {
  const int width = GENERATE(2, 4, 8), size = GENERATE(2, 3);
  const std::ptrdiff_t lanes = GENERATE(narrow_lanes, wide_lanes);
  const Registers registers(width);
  if (!registers.supported)
    SKIP("the machine has no registers of " << width << " numbers");
  constexpr int rows = 5;
  const std::vector<int> begin{0, 2, 3, 3, 6, 8}, column{0, 4, 1, 0, 2, 3, 3, 1};
  const auto blocks = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  const std::vector<double> values = numbers(column.size() * blocks, 0.7),
                            factors = numbers(column.size(), 1.9);
  const std::size_t n = rows * static_cast<std::size_t>(size);
  const std::vector<double> x = numbers(n, 0.3), w = numbers(n, 5.1);
  const std::ptrdiff_t odd = 3;
  const std::vector<double> in_x = in_lanes(x, lanes, odd), in_w = in_lanes(w, lanes, odd);
  std::vector<double> r(n * static_cast<std::size_t>(lanes), 7.0);
  multiply_lanes({begin.data(), column.data(), values.data(), static_cast<int>(blocks)},
                 {begin.data(), column.data(), factors.data(), 1}, size, 1, rows, lanes, in_x.data(),
                 in_w.data(), r.data());
  std::vector<double> exact(n, 0.0);
  std::fill_n(exact.begin(), size, 7.0); // row 0 is not asked for
  for (int row = 1; row < rows; ++row)
    for (int e = begin[static_cast<std::size_t>(row)]; e < begin[static_cast<std::size_t>(row) + 1]; ++e)
      for (int i = 0; i < size; ++i) {
        const auto k = static_cast<std::size_t>(e), to = static_cast<std::size_t>(row * size + i);
        exact[to] += factors[k] * w[static_cast<std::size_t>(column[k] * size + i)];
        for (int j = 0; j < size; ++j)
          exact[to] += values[k * blocks + static_cast<std::size_t>(i * size + j)] *
                       x[static_cast<std::size_t>(column[k] * size + j)];
      }
  check_close(from_lanes(r, lanes, odd), exact, 10);
}
