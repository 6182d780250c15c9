// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize_search.h"
#include <catch2/catch_test_macros.hpp>
#include <map>
#include <string>

using namespace signorini;
using namespace signorini::test;

namespace {

/// What a search stored: numbers, lists of numbers and vectors by name.
struct Archive {
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, Point> vectors;
};

struct Writer {
  Archive& archive;
  void operator()(const std::string& name, double value) { archive.numbers[name] = {value}; }
  void operator()(const std::string& name, const std::vector<double>& values) {
    archive.numbers[name] = values;
  }
  void operator()(const std::string& name, const optimize::Shared<Point>& u) { archive.vectors[name] = *u; }
  void operator()(const std::string& name, const Point& u) { archive.vectors[name] = u; }
};

struct Reader {
  const Archive& archive;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  void operator()(const std::string& name, Number& value) {
    value = static_cast<Number>(archive.numbers.at(name).at(0));
  }
  void operator()(const std::string& name, std::vector<double>& values) { values = archive.numbers.at(name); }
  void operator()(const std::string& name, optimize::Shared<Point>& u) {
    u = optimize::share(archive.vectors.at(name));
  }
  void operator()(const std::string& name, Point& u) { u = archive.vectors.at(name); }
};

/// Stores a search at one iteration, or goes on from where one was stored.
struct StoredAt {
  Archive& archive;
  int iteration;
  bool going_on = false;
  bool restore(auto& state) const {
    if (going_on) {
      Reader reader{archive};
      state.serialize(reader);
    }
    return going_on;
  }
  bool due(const optimize::Iteration& at) const { return !going_on && at.number == iteration; }
  void store(auto& state) const {
    if (!due(state.iteration))
      return;
    Writer writer{archive};
    state.serialize(writer);
  }
  static void restored(double stored, double found) {
    CHECK(std::abs(stored / found - 1) < 1e-15);
  } // in other units
  static void mark() {}
  static void certified(const auto&) {}
};

} // namespace

TEST_CASE("a search that was stored anywhere goes on to the last bit", "[optimize]") {
  const optimize::Options options{.max_iterations = 28, .tolerance = 1e-7};
  const Point from{std::vector<double>(10, 0.3)};
  for (Method method : methods)
    for (const double bound : {1e300, 0.35}) {
      Pieces problem(3, bound);
      Record whole;
      const auto ending = search(method, problem, from, options, whole);
      const int last = whole.rows.back().number;
      REQUIRE(last > 20); // among the kinks
      for (int stored : {0, 1, 4, 11, 20}) {
        INFO("method " << static_cast<int>(method) << ", bound " << bound << ", stored at " << stored
                       << " of " << last);
        Archive archive;
        Record before, after;
        Pieces one(3, bound), other(3, bound);
        (void)search(method, one, from, options, before, StoredAt{archive, stored});
        REQUIRE(!archive.vectors.empty());
        const auto end = search(method, other, Point{std::vector<double>(10, -0.2)}, options, after,
                                StoredAt{archive, stored, true});
        CHECK(other.current.x == problem.current.x);
        CHECK(end.stop == ending.stop);
        REQUIRE(after.rows.size() == static_cast<std::size_t>(last - stored));
        for (std::size_t i = 0; i < after.rows.size(); ++i) {
          const optimize::Iteration &here = after.rows[i],
                                    &there = whole.rows[static_cast<std::size_t>(stored) + 1 + i];
          REQUIRE(here.number == there.number);
          REQUIRE(here.objective == there.objective);
          REQUIRE(here.gradient_norm == there.gradient_norm);
          REQUIRE(here.step_length == there.step_length);
        }
        REQUIRE(end.certificate.has_value() == ending.certificate.has_value());
        if (end.certificate)
          CHECK(end.certificate->length == ending.certificate->length);
      }
    }
}
