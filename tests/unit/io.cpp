// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "fixtures.h"
#include "io/checkpoint.h"
#include "io/csv_tables.h"
#include "io/field_reader.h"
#include "io/field_writer.h"
#include "io/manifest.h"
#include "io/point_match.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

namespace {

const std::vector both{scene::FieldFormat::xdmf, scene::FieldFormat::vtkhdf};

/// An empty folder for as long as this object lives, the same on every rank.
struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "signorini-io-XXXXXX").string();
    if (rank(MPI_COMM_WORLD) == 0)
      REQUIRE(mkdtemp(name.data()));
    path = broadcast(MPI_COMM_WORLD, name);
  }
  ~Folder() {
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank(MPI_COMM_WORLD) == 0)
      fs::remove_all(path);
  }
};

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Collective; every rank sees it.
void overwrite(const fs::path& file, const std::string& text) {
  if (rank(MPI_COMM_WORLD) == 0)
    std::ofstream(file, std::ios::binary) << text;
  MPI_Barrier(MPI_COMM_WORLD);
}

/// Lines of a CSV text, split.
std::vector<std::vector<std::string>> cells(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');)
      rows.back().push_back(cell);
  }
  return rows;
}

/// The cell of a row (0 is the first below the names) in the column of a name.
double number(const std::vector<std::vector<std::string>>& rows, std::size_t row, const std::string& name) {
  const auto column = std::ranges::find(rows.front(), name) - rows.front().begin();
  return std::stod(rows.at(row + 1).at(static_cast<std::size_t>(column)));
}

[[noreturn]] void refuse(const std::string& problem) { throw UserError("refused: " + problem); }

} // namespace

TEST_CASE("points are found among the same in another order, and with other last digits", "[io]") {
  const char* scene = GENERATE(as<const char*>{}, "tests/data/block.toml", "tests/data/cube.toml");
  CAPTURE(scene);
  const test::Ready ready(scene);
  const fem::Space& space = ready.problem.space;
  const auto dim = static_cast<std::size_t>(space.dim());
  const std::vector<double> all = gather(space.comm(), space.points());
  std::vector<std::size_t> order(all.size() / 3);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1); // the same on every rank
  for (std::size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[random() % (i + 1)]);
  REQUIRE(!std::ranges::is_sorted(order));
  const double last_digits = 1e-14 * space.mesh().diameter();
  std::vector<double> there;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t c = 0; c < dim; ++c)
      there.push_back(all[3 * order[i] + c] + last_digits * (static_cast<double>(i % 3) - 1));
  const std::vector<std::size_t> found = io::match_points(space, there, space.points(), refuse);
  REQUIRE(found.size() == static_cast<std::size_t>(space.owned_nodes()));
  double off = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t c = 0; c < dim; ++c)
      off = std::max(off, std::abs(there[found[i] * dim + c] - space.points()[3 * i + c]));
  CHECK(off < 2 * last_digits);

  std::vector<double> moved = there, twice = there;
  moved[dim] += 1e-6; // one point, which one rank alone misses: all of them refuse
  CHECK_THROWS_WITH(io::match_points(space, moved, space.points(), refuse),
                    ContainsSubstring("refused: found no point at ("));
  std::copy_n(there.begin(), dim, twice.begin() + static_cast<std::ptrdiff_t>(dim));
  CHECK_THROWS_WITH(io::match_points(space, twice, space.points(), refuse),
                    ContainsSubstring("found two points at ("));
}

TEST_CASE("a field that was stored is read as it was, linear between its times, in any order of them",
          "[io]") {
  const Folder folder;
  const char* scene = GENERATE(as<const char*>{}, "tests/data/block.toml", "tests/data/cube.toml");
  CAPTURE(scene);
  const test::Ready ready(scene);
  const fem::Space& space = ready.problem.space;
  io::OutputFolder output(space.comm(), folder.path);
  const std::vector<double> times{0, 0.3, 1.0 / 3, 1};
  io::FieldWriter file(space, output, "state", {{"displacement", io::Values::nodal}}, times.size(), both);
  for (const std::size_t i : {2U, 0U, 3U, 1U})
    file.write("displacement", i, times[i], test::smooth(space, static_cast<int>(i) + 1));
  file.close();
  MPI_Barrier(space.comm());
  const fs::path stored = output.staged("state.h5");
  io::StoredField field(space, stored, "displacement", "key", 1);
  petsc::Vector read = space.vector();
  for (const std::size_t i : {0U, 1U, 2U, 3U, 2U, 0U, 3U, 1U}) {
    field.at(times[i], read);
    CHECK(test::difference(read, test::smooth(space, static_cast<int>(i) + 1)) == 0);
  }
  field.at(0.6, read);
  petsc::Vector mean = test::smooth(space, 3); // at 1/3, and 0.6 is 2/5 of the way from there to 1
  petsc::check(VecAXPBY(mean, 0.4, 0.6, test::smooth(space, 4)));
  CHECK(test::difference(read, mean) < 1e-14 * test::largest(mean));

  const auto opened = [&](const std::string& name, double end) {
    io::StoredField(space, stored, name, "key", end);
  };
  CHECK_THROWS_WITH(opened("velocity", 1), ContainsSubstring("found no field \"velocity\""));
  CHECK_THROWS_WITH(opened("displacement", 1.1), ContainsSubstring("from 0 to 1 s"));
  const test::Ready other(scene, {"mesh.size=0.2"});
  CHECK_THROWS_WITH(io::StoredField(other.problem.space, stored, "displacement", "key", 1),
                    ContainsSubstring("expected the mesh of this scene"));
  const std::string whole = content(stored);
  MPI_Barrier(space.comm());
  for (const std::size_t length : {std::size_t{0}, whole.size() / 2, whole.size() - 1}) {
    overwrite(stored, whole.substr(0, length));
    CHECK_THROWS_WITH(opened("displacement", 1),
                      ContainsSubstring("key: ") && ContainsSubstring("state.h5: "));
  }
}

namespace {

/// Bytes that this process has written so far.
double bytes_written() {
  std::ifstream in("/proc/self/io");
  for (std::string name, value; in >> name >> value;)
    if (name == "wchar:")
      return std::stod(value);
  throw std::runtime_error("no count of bytes written");
}

} // namespace

TEST_CASE("a stored time costs the same however many came before, and the index comes once", "[io]") {
  const Folder folder;
  const test::Ready ready("tests/data/block.toml");
  const fem::Space& space = ready.problem.space;
  const petsc::Vector values = test::smooth(space, 1);
  std::vector<double> cost, stored;
  for (const std::size_t times : {100U, 200U, 400U}) {
    CAPTURE(times);
    io::OutputFolder output(space.comm(), folder.path);
    const double before = bytes_written();
    io::FieldWriter file(space, output, "state",
                         {{"displacement", io::Values::nodal}, {"velocity", io::Values::nodal}}, times, both);
    for (std::size_t i = 0; i < times; ++i)
      for (const char* field : {"displacement", "velocity"})
        file.write(field, i, 0.125 * static_cast<double>(i), values);
    if (rank(space.comm()) == 0) // who writes it at once when all are through
      CHECK(!fs::exists(output.staged("state.xdmf")));
    file.close();
    MPI_Barrier(space.comm());
    cost.push_back(bytes_written() - before);
    stored.push_back(static_cast<double>(fs::file_size(output.staged("state.h5"))));
    const std::string index = content(output.staged("state.xdmf"));
    REQUIRE(static_cast<double>(index.size()) > 400 * static_cast<double>(times)); // what would be quadratic
    CHECK(index.ends_with("</Xdmf>\n"));
    if (rank(space.comm()) == 0)
      CHECK(cost.back() < 1.3 * (stored.back() + static_cast<double>(index.size())));
    MPI_Barrier(space.comm());
  }
  if (rank(space.comm()) == 0)
    CHECK(cost[2] - cost[1] < 1.2 * 2 * (cost[1] - cost[0]));
  const double data = 2 * 100 * 8 * static_cast<double>(space.dofs() / space.dim() * 3);
  CHECK((stored[2] - stored[1]) / 2 - data < 2 * 100 * 600); // headers and names
}

TEST_CASE("tables have a cell for each column and numbers to the last digit", "[io]") {
  for (const auto& [scene, dim] : {std::pair{"tests/data/block.toml", 2}, {"tests/data/cube.toml", 3}}) {
    CAPTURE(scene, dim);
    const test::Ready ready(scene, {"time.step=0.05"});
    const problem::Problem& problem = ready.problem;
    const contact::ContactPairs& pairs = *problem.stepper.pairs();
    const contact::Pressure pressure(problem.space, pairs, ready.scene.contacts);
    const io::ContactTable contact_table(pairs, pressure, ready.scene.contacts);
    for (const bool tracking : {false, true}) {
      CAPTURE(tracking);
      const io::StepsColumns columns{.tracking = tracking};
      std::string steps = io::steps_header(dim, columns), contact = contact_table.header();
      diagnostics::Invariants invariants(problem.stepper,
                                         diagnostics::body_figures(problem.stepper, problem.scene));
      diagnostics::Balance weigh(problem.stepper);
      std::vector<diagnostics::StepBalance> balance;
      std::vector<contact::ContactState> states;
      trajectory::integrate(problem.stepper, problem.grid, problem.initial, problem.load(),
                            [&](const trajectory::Frame& frame) {
                              balance.push_back(weigh(frame));
                              states.push_back(frame.contact);
                              invariants.observe(frame, balance.back());
                              io::add_steps_row(steps, columns, frame.step.k, frame.step.end, dim,
                                                balance.back(), invariants, frame.contact, 2.5 * frame.step.k,
                                                1.0 / (frame.step.k + 3));
                              contact_table.add_rows(contact, frame.step, frame.contact);
                            });
      const auto rows = cells(steps), candidates = cells(contact);
      const auto m = static_cast<std::size_t>(pairs.count());
      REQUIRE(rows.size() == balance.size() + 1);
      REQUIRE(candidates.size() == m * balance.size() + 1);
      for (const auto* table : {&rows, &candidates})
        for (const auto& row : *table)
          CHECK(row.size() == table->front().size());
      CHECK(rows.front().back() == "load_work");
      CHECK((rows.front()[rows.front().size() - 3] == "tracking_error") == tracking);
      int pushed = 0;
      for (std::size_t k = 0; k < balance.size(); ++k) {
        CHECK(number(rows, k, "step") == static_cast<double>(k));
        CHECK(number(rows, k, "kinetic_energy") == balance[k].kinetic_energy);
        CHECK(number(rows, k, dim == 3 ? "contact_force_z" : "contact_force_y") ==
              balance[k].contact_force[static_cast<std::size_t>(dim) - 1]);
        CHECK(number(rows, k, "active") == static_cast<double>(states[k].active.size()));
        CHECK(number(rows, k, "min_gap") == std::ranges::min(states[k].gap));
        CHECK(number(rows, k, "normal_force") == 2.5 * static_cast<double>(k));
        CHECK(number(rows, k, "load_work") == balance[k].load_work);
        if (tracking)
          CHECK(number(rows, k, "tracking_error") == 1.0 / (static_cast<double>(k) + 3));
        double force = 0, pressed = 0;
        for (std::size_t i = 0; i < m; ++i) {
          const auto cell = [&](const char* name) { return number(candidates, k * m + i, name); };
          force += cell("force") * cell(dim == 3 ? "normal_z" : "normal_y");
          pressed += cell("pressure") * cell("area") - cell("force");
          CHECK(number(candidates, k * m + i, "gap") == states[k].gap[i]);
          CHECK(number(candidates, k * m + i, "force") ==
                states[k].lambda[i] / problem.grid.scheme(1).impulse());
          CHECK(number(candidates, k * m + i, "x") == pairs.points()[3 * i]);
          pushed += states[k].lambda[i] > 0;
        }
        const double up = balance[k].contact_force[static_cast<std::size_t>(dim) - 1];
        CHECK(std::abs(force - up) <= 1e-13 * std::abs(up));
        CHECK(std::abs(pressed) <= 1e-13 * std::abs(up));
      }
      CHECK(pushed > 0);
    }
  }
  io::History history;
  for (const int i : {0, 1})
    history.add({{"iteration", i},
                 {"objective", i ? 1.0 / 3 : 0.1},
                 {"gradient_norm", 1e-300},
                 {"forward_sweeps", 7 * i},
                 {"seconds", 2.0 / 3},
                 {"distance", std::numeric_limits<double>::quiet_NaN()}});
  CHECK(history.last("objective") == 1.0 / 3);
  CHECK(history.at(0, "objective") == 0.1);
  const auto rows = cells(history.table());
  REQUIRE(rows.size() == 3);
  CHECK(io::History::split("iteration,objective") == std::vector<std::string>{"iteration", "objective"});
  CHECK(rows[1].size() == rows[0].size());
  CHECK(number(rows, 1, "objective") == 1.0 / 3);
  CHECK(number(rows, 0, "gradient_norm") == 1e-300);
  CHECK(number(rows, 1, "forward_sweeps") == 7);
  CHECK(number(rows, 1, "seconds") == 0.667);
  CHECK(rows[1].back() == "nan");
}

TEST_CASE("run.json tells what the run was, and nothing that it had not", "[io]") {
  const scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  Timers timers;
  {
    const auto timer = timers.time("forward");
  }
  io::Manifest manifest;
  manifest.verb = "optimize";
  manifest.ranks = 3;
  manifest.unknowns = 50'000'000'000;
  const auto bare = nlohmann::json::parse(io::to_json(manifest, scene, timers));
  CHECK(bare["verb"] == "optimize");
  CHECK(bare["host"]["ranks"] == 3);
  CHECK(bare["unknowns"] == 50'000'000'000);
  CHECK(bare["effects"]["viscosity"] == true);
  CHECK(bare["effects"]["clamp"] == false);
  CHECK(bare["timings"]["forward"]["calls"] == 1);
  for (const char* absent : {"objective", "optimizer", "kink", "invariants", "control_unit"}) {
    CAPTURE(absent);
    CHECK_FALSE(bare.contains(absent));
  }
  manifest.control_unit = "N/m²";
  manifest.objective = control::ObjectiveValue{.tracking = 1.0 / 3, .terminal = 0.1, .control_cost = 1e-20};
  manifest.iterations = 4;
  manifest.kink = io::Kink{1e-9, 1e-4, 12, {{0, 3, 0.25, 7, {0.5, 1.0 / 3}}}};
  const auto full = nlohmann::json::parse(io::to_json(manifest, scene, timers));
  CHECK(full["control_unit"] == "N/m²");
  CHECK(full["objective"]["value"] == manifest.objective->total());
  CHECK(full["objective"]["tracking"] == 1.0 / 3);
  CHECK(full["optimizer"]["metric"] == "L2");
  CHECK(full["kink"]["weak_contact"][0]["node"][1] == 1.0 / 3);
}

namespace {

/// What a checkpoint holds in the following test.
struct Pieces {
  double value = 0.1 + 0.2;
  std::vector<double> numbers{1.0 / 3, -0.0, 1e-308, 1e308}, none;
  std::string text = "Müller\n\"quoted\"";
  std::shared_ptr<const control::Control> u;

  /// Hands the pieces by name to a writer or a reader.
  template <class Archive>
  void through(Archive& archive) {
    archive("value", value);
    archive("some/numbers", numbers);
    archive("none", none);
    archive("text", text);
    archive("control", u);
  }
};

control::Control some(const control::ControlSpace& controls) {
  control::Control u = controls.zero();
  for (int k = 1; k <= u.count(); ++k)
    controls.restrict(test::smooth(controls.space(), k), u.at(k));
  return u;
}

void write(const control::ControlSpace& controls, Pieces& pieces, const fs::path& file) {
  io::CheckpointWriter writer(controls, file.string() + ".part", file);
  pieces.through(writer);
  REQUIRE(writer.commit() == "");
}

Pieces read(const control::ControlSpace& controls, const fs::path& file) {
  Pieces pieces;
  pieces.value = 0;
  pieces.text = "";
  pieces.numbers.clear();
  pieces.none = {1};
  io::CheckpointReader reader(controls, file);
  reader.match_places();
  pieces.through(reader);
  return pieces;
}

/// Whether they are the same to the last bit. Collective.
bool same(const Pieces& a, const Pieces& b) {
  bool equal = a.value == b.value && a.numbers == b.numbers && a.none == b.none && a.text == b.text &&
               a.u->count() == b.u->count();
  for (int k = 1; k <= a.u->count(); ++k)
    equal = test::difference(a.u->at(k), b.u->at(k)) == 0 && equal;
  return equal;
}

} // namespace

TEST_CASE("a checkpoint is read as it was written, and where it is damaged not at all", "[io]") {
  const Folder folder;
  const fs::path file = folder.path / "checkpoint.h5";
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{"time.end=0.1"},
        {"time.end=0.1", "control.on=rest", "control.components=[\"y\"]",
         "objective.desired={displacement=[\"0\", \"0\"]}"}}) {
    const test::Ready ready("tests/data/block.toml", overrides);
    const control::ControlSpace controls(ready.problem.space, ready.problem.operators, ready.problem.grid,
                                         *ready.scene.control);
    Pieces pieces;
    pieces.u = std::make_shared<const control::Control>(some(controls));
    write(controls, pieces, file);
    CHECK(same(read(controls, file), pieces));
    {
      io::CheckpointWriter abandoned(controls, folder.path / "half-written", file);
      pieces.through(abandoned);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    CHECK(std::distance(fs::directory_iterator(folder.path), {}) == 1); // nothing half-written is left
    CHECK(same(read(controls, file), pieces));

    const std::string whole = content(file);
    MPI_Barrier(MPI_COMM_WORLD);
    for (const std::size_t length : {std::size_t{0}, std::size_t{100}, whole.size() / 2, whole.size() - 1}) {
      CAPTURE(length);
      overwrite(file, whole.substr(0, length));
      CHECK_THROWS_AS(read(controls, file), UserError);
    }
    int refused = 0;
    constexpr int places = 40;
    for (int i = 0; i < places; ++i) {
      std::string damaged = whole;
      damaged[whole.size() * static_cast<std::size_t>(i) / places] ^= 0x40;
      overwrite(file, damaged);
      try {
        const Pieces found = read(controls, file);
        CHECK(same(found, pieces)); // a byte that nobody reads
      } catch (const UserError& error) {
        ++refused;
        CHECK_THAT(error.what(), ContainsSubstring("checkpoint.h5: "));
      }
    }
    CHECK(refused > places / 2);

    overwrite(file, whole);
    std::vector<std::string> finer = overrides;
    finer.push_back("mesh.size=0.2");
    const test::Ready other("tests/data/block.toml", finer);
    const control::ControlSpace elsewhere(other.problem.space, other.problem.operators, other.problem.grid,
                                          *other.scene.control);
    CHECK_THROWS_WITH(read(elsewhere, file),
                      ContainsSubstring("use the mesh of the run that wrote the checkpoint"));
    CHECK(same(read(controls, file), pieces));
  }
}
