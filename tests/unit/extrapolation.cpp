// SPDX-License-Identifier: GPL-3.0-or-later
// The first guess of conjugate gradients.
#include "trajectory/extrapolation.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <cmath>
#include <fmt/format.h>

using namespace signorini;
using petsc::check;

TEST_CASE("after steps of two lengths the next state is guessed by a parabola", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"solver.linear=iterative"}),
      direct("tests/data/block.toml", {"solver.linear=direct"});
  const fem::Space& space = ready.problem.space;
  const petsc::Vector a = test::smooth(space, 1), b = test::smooth(space, 2), c = test::smooth(space, 3);
  const auto time = [](int k) { return 0.1 * k + 0.04 * (k % 2); }; // no two equal steps in a row
  const auto at = [&](int k, double linear, double square) {
    petsc::Vector x = petsc::copy(a);
    check(VecAXPY(x, linear * time(k), b));
    check(VecAXPY(x, square * time(k) * time(k), c));
    return x;
  };
  trajectory::Extrapolation guesses(ready.problem.stepper), copy(ready.problem.stepper),
      none(direct.problem.stepper);
  petsc::Vector out = petsc::copy(c);
  guesses.guess(time(0), out);
  CHECK(test::difference(out, c) == 0); // nothing is known
  for (const auto& [linear, square] :
       {std::pair{0.0, 0.0}, {1.0, 0.0}, {-0.3, 0.2}}) { // one, two, three are known
    guesses.forget();
    const int known = 1 + (linear != 0) + (square != 0);
    for (int k = 0; k < known; ++k)
      guesses.remember(time(k), at(k, linear, square));
    guesses.guess(time(known), out);
    CHECK(test::difference(out, at(known, linear, square)) < 1e-14);
    copy.take(guesses);
    check(VecZeroEntries(out));
    copy.guess(time(known), out);
    CHECK(test::difference(out, at(known, linear, square)) < 1e-14);
  }
  for (int k = 3; k < 6; ++k) { // the last three, and no more
    guesses.guess(time(k), out);
    CHECK(test::difference(out, at(k, -0.3, 0.2)) < 1e-14);
    guesses.remember(time(k), at(k, -0.3, 0.2));
    guesses.remember(time(k), c); // known already
  }
  copy.forget();
  check(VecCopy(c, out));
  copy.guess(time(1), out);
  CHECK(test::difference(out, c) == 0);
  none.remember(time(0), a);
  none.guess(time(1), out);
  CHECK(test::difference(out, c) == 0); // which a direct solver does not need
  CHECK(trajectory::Extrapolation::vectors(ready.problem.stepper) == 8);
  CHECK(trajectory::Extrapolation::vectors(direct.problem.stepper) == 0);
}

namespace {

/// Oscillations of two shapes each, whose parabolas have errors that satisfy a linear recurrence with two
/// terms for each frequency.
class Oscillations {
public:
  Oscillations(const fem::Space& space, double step, std::vector<double> frequencies)
      : space_(space), step_(step), frequencies_(std::move(frequencies)) {}

  [[nodiscard]] double time(int k) const { return step_ * k; }
  [[nodiscard]] petsc::Vector at(int k) const {
    petsc::Vector x = space_.vector();
    int shape = 0;
    for (const double frequency : frequencies_)
      for (const double shift : {0.0, 1.0})
        check(VecAXPY(x, std::cos(frequency * time(k) + shift), waves(++shape)));
    return x;
  }
  /// Value at t_k of the parabola through the three states before.
  [[nodiscard]] petsc::Vector parabola(int k) const {
    petsc::Vector x = at(k - 3);
    check(VecAXPBYPCZ(x, 3, -3, 1, at(k - 1), at(k - 2)));
    return x;
  }

private:
  /// Shape number `count`, linearly independent of the others.
  [[nodiscard]] petsc::Vector waves(int count) const {
    petsc::Vector x = space_.vector();
    space_.interpolate(
        {{fmt::format("sin({}*(x + 0.6*y))", count), fmt::format("cos({}*(x - y))", count)}, "test", false},
        0, x);
    return x;
  }

  const fem::Space& space_;
  double step_;
  std::vector<double> frequencies_;
};

} // namespace

TEST_CASE("after equal steps the next state is guessed by a parabola and its predicted error", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"solver.linear=iterative"});
  const step::Stepper& stepper = ready.problem.stepper;
  const double step = GENERATE(0.1, -0.1); // adjoint steps lead back
  const auto frequencies = GENERATE(std::vector{5.0}, std::vector{4.0, 9.0}, std::vector{2.0, 3.0, 4.0, 5.0});
  CAPTURE(step, frequencies);
  const Oscillations motion(ready.problem.space, step, frequencies);
  const int terms = 2 * static_cast<int>(frequencies.size());
  trajectory::Extrapolation guesses(stepper);
  petsc::Vector out = ready.problem.space.vector();
  constexpr int steps = 20;
  for (int k = 0; k < steps; ++k) {
    CAPTURE(k);
    const petsc::Vector next = motion.at(k);
    guesses.guess(motion.time(k), out);
    const double off = test::difference(out, next);
    if (k == 3 || k == 4) // at most one error is known: none that it could follow from
      CHECK(test::difference(out, motion.parabola(k)) < 1e-14);
    if (k > 3) {
      const double parabola = test::difference(motion.parabola(k), next);
      REQUIRE(parabola > 1e-3);
      // `terms` weights and the errors that they are fitted to come from the first 3 + terms + 1 states.
      if (terms <= 4 && k >= 4 + terms)
        CHECK(off < 1e-8 * parabola); // normal equations lose half of the digits
      else if (terms > 4 && k >= 8)   // more frequencies than weights
        CHECK(off < 0.1 * parabola);
    }
    guesses.remember(motion.time(k), next);
  }
  // Only a step of the same length is guessed by it.
  const double time = motion.time(steps) + 0.3 * step;
  guesses.guess(time, out);
  petsc::Vector parabola = motion.at(steps - 1); // by Lagrange's polynomials for 1.3 steps
  check(VecAXPBYPCZ(parabola, -1.3 * 3.3, 0.5 * 1.3 * 2.3, 0.5 * 2.3 * 3.3, motion.at(steps - 2),
                    motion.at(steps - 3)));
  CHECK(test::difference(out, parabola) < 1e-13);
}

TEST_CASE("a copy of an extrapolation guesses the same to the last bit", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"solver.linear=iterative"});
  const Oscillations motion(ready.problem.space, 0.1, {3.0, 5.0, 8.0});
  trajectory::Extrapolation guesses(ready.problem.stepper), copy(ready.problem.stepper);
  petsc::Vector out = ready.problem.space.vector(), copied = petsc::copy(out);
  const int copied_at = GENERATE(range(1, 12));
  CAPTURE(copied_at);
  for (int k = 0; k < 3; ++k) // data that must not remain
    copy.remember(motion.time(k), motion.at(7 * k));
  for (int k = 0; k < 20; ++k) {
    CAPTURE(k);
    if (k == copied_at)
      copy.take(guesses);
    if (k >= copied_at) {
      guesses.guess(motion.time(k), out);
      copy.guess(motion.time(k), copied);
      CHECK(test::difference(out, copied) == 0);
      copy.remember(motion.time(k), motion.at(k));
    }
    guesses.remember(motion.time(k), motion.at(k));
  }
}

TEST_CASE("a step of another length begins a new series of errors", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"solver.linear=iterative"});
  const Oscillations motion(ready.problem.space, 0.1, {5.0});
  trajectory::Extrapolation guesses(ready.problem.stepper), fresh(ready.problem.stepper);
  petsc::Vector out = ready.problem.space.vector(), wanted = petsc::copy(out);
  for (int k = 0; k < 9; ++k) // twice as long steps, then those of the motion
    guesses.remember(motion.time(2 * k), motion.at(2 * k));
  fresh.remember(motion.time(16), motion.at(16));
  for (int k = 17; k < 30; ++k) {
    CAPTURE(k);
    guesses.guess(motion.time(k), out);
    fresh.guess(motion.time(k), wanted);
    if (k > 18) // from three equal times on
      CHECK(test::difference(out, wanted) < 1e-13);
    guesses.remember(motion.time(k), motion.at(k));
    fresh.remember(motion.time(k), motion.at(k));
  }
}
