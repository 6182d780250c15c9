// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/rung_cache.h"
#include "base/collective.h"
#include "fem/forms.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <unistd.h>

using namespace signorini;
using namespace signorini::accuracy;

namespace {

/// A folder of its own for each rank, gone in the end.
class Folder {
public:
  Folder() : path_(std::filesystem::temp_directory_path() / fmt::format("signorini-study-{}", getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

private:
  std::filesystem::path path_;
};

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

const Rung rung{0.25, 10, 1, scene::ContactScheme::contact_implicit};
const Quantity J{"J", "J", ""}, displacement{"displacement", "displacement", "m", true};

Measured measured() {
  Measured all;
  all.unknowns = 12;
  all.seconds = 0.1;
  all.memory = 3e6;
  all.numbers = {{"J", 1.0 / 3}, {"pressure", std::numeric_limits<double>::quiet_NaN()}};
  all.fields["displacement"] = {0.1, -1.0 / 7, 1e-300};
  all.estimate = {-1e-3, 2e-3, 0, 1.0 / 7};
  return all;
}

} // namespace

TEST_CASE("a rung comes back to the last bit, and a damaged one not at all", "[study]") {
  const Folder folder;
  const RungCache store(folder / "study");
  const Fingerprint own{{"scene", ""}, {"forms", "1"}};
  CHECK_FALSE(store.load(rung, own, {J}).measured);
  CHECK(store.load(rung, own, {J}).unfit.empty()); // nothing is there to be wrong
  store.save(rung, own, measured());
  const CachedRung kept = store.load(rung, own, {J, displacement});
  REQUIRE(kept.measured);
  CHECK(kept.unfit.empty());
  CHECK(kept.measured->numbers.at("J") == measured().numbers.at("J"));
  CHECK(std::isnan(kept.measured->numbers.at("pressure")));
  CHECK(kept.measured->fields == measured().fields);
  REQUIRE(kept.measured->estimate);
  CHECK(kept.measured->estimate->space == measured().estimate->space);
  CHECK(kept.measured->estimate->time == measured().estimate->time);
  CHECK(kept.measured->estimate->desired == measured().estimate->desired);
  CHECK(store.load(rung, own, {{"impulse", "impulse of contact", "N s"}}).unfit ==
        "its stored results lack the impulse of contact");

  const std::filesystem::path file = std::filesystem::directory_iterator(folder / "study/rungs")->path();
  const std::string whole = content(file);
  const auto refused = [&](const std::string& text) {
    write(file, text);
    const CachedRung found = store.load(rung, own, {});
    return !found.measured && found.unfit.find("damaged") != std::string::npos;
  };
  for (const std::size_t size : {std::size_t(0), std::size_t(1), whole.size() / 2, whole.size() - 1}) {
    CAPTURE(size);
    CHECK(refused(whole.substr(0, size)));
  }
  for (std::size_t at = 0; at < whole.size(); ++at) { // any byte, were it in the middle of a number
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    if (!refused(changed))
      FAIL_CHECK("byte " << at << " of " << whole.size() << " was changed and not missed");
  }
  CHECK(refused("damaged"));
  CHECK(refused("\xa0"));                                             // no keys
  CHECK(refused("\xa1\x65scene\x60"));                                // of an earlier version
  CHECK(refused("\xa1\x64rung\x5b\xff\xff\xff\xff\xff\xff\xff\xff")); // so many bytes
  write(file, whole);
  CHECK(store.load(rung, own, {J}).measured);
}

TEST_CASE("a search comes back to the last bit, where its fingerprint is the same", "[study]") {
  const Folder folder;
  const RungCache store(folder / "study");
  const Fingerprint own{{"scene", ""}, {"method of the search", "lbfgs"}};
  const SearchCost cost{.tolerance = 1e-4,
                        .objective = 1.0 / 3,
                        .iterations = 7,
                        .forward_sweeps = 9,
                        .adjoint_sweeps = 8,
                        .seconds = 0.1,
                        .stop_reason = "stationary at a kink"};
  CHECK_FALSE(store.load(cost.tolerance, own).cost);
  store.save(cost, own);
  const CachedSearch kept = store.load(cost.tolerance, own);
  REQUIRE(kept.cost);
  CHECK(csv(std::vector{*kept.cost}) == csv(std::vector{cost}));
  CHECK_FALSE(store.load(1e-5, own).cost);
  CHECK(store.load(cost.tolerance, {{"scene", ""}, {"method of the search", "newton-cg"}}).unfit ==
        "the method of the search has changed");
  const std::filesystem::path file = std::filesystem::directory_iterator(folder / "study/rungs")->path();
  write(file, content(file).substr(1));
  CHECK(store.load(cost.tolerance, own).unfit.find("damaged") != std::string::npos);
}

TEST_CASE("the search recommended is the cheapest that leaves less than the mesh does", "[study]") {
  const std::vector<SearchCost> searches{
      {.tolerance = 1e-2, .objective = -1.9, .forward_sweeps = 2, .adjoint_sweeps = 1, .seconds = 1},
      {.tolerance = 1e-3, .objective = -1.998, .forward_sweeps = 5, .adjoint_sweeps = 4, .seconds = 3},
      {.tolerance = 1e-4, .objective = -2, .forward_sweeps = 9, .adjoint_sweeps = 8, .seconds = 2}};
  const std::vector<double> above = above_least(searches);
  CHECK(above[0] == (2 - 1.9) / 2);
  CHECK(above[2] == 0);
  const std::string two = "size and step cause an error of 2 % in J. A search with optimizer.tolerance = ";
  CHECK(sentence(searches, 0.6)
            .starts_with("size and step cause an error of 60 % in J. A search with "
                         "optimizer.tolerance = 0.01 adds"));
  CHECK(sentence(searches, 0.02).starts_with(two + "0.0001 adds")); // cheaper than 1e-3
  CHECK(sentence({searches.begin(), searches.begin() + 2}, 0.02).starts_with(two + "0.001 adds"));
  CHECK(sentence({{.objective = 0}, {.objective = 1}}, 0.1)
            .starts_with("no recommendation for optimizer.tolerance"));
  CHECK(std::isnan(above_least({{.objective = 0}, {.objective = 1}})[1])); // relative to nothing
}

TEST_CASE("a fingerprint changes with everything that numbers depend on, and says with what", "[study]") {
  const Folder folder;
  const std::string include = "lower.inc";
  write(folder / "block.geo",
        content(test::source("tests/data/square.geo")) + "Include \"" + include + "\";\n");
  write(folder / include, "Include \"lowest.inc\";\n");
  write(folder / "lowest.inc", "// nothing yet\n");
  std::filesystem::create_directories(folder / "run");
  write(folder / "run/state.h5", "a motion");
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  scene.mesh.file = folder / "block.geo";
  scene.objective->desired = scene::DesiredRun{folder / "run"};
  const SamplePoints at(MPI_COMM_SELF, test::parse(test::source("tests/data/block.toml")));
  const Fingerprint own = Origin(scene, at, 1).of(rung);
  CHECK(difference(own, Origin(scene, at, 1).of(rung)).empty());
  CHECK(difference(own, Origin(scene, at, 2).of(rung)) == "the number of ranks was \"1\", and now is \"2\"");

  const auto with = [&](auto&& change) {
    scene::Scene changed = scene;
    change(changed);
    return difference(own, Origin(changed, at, 1).of(rung));
  };
  CHECK(with([](scene::Scene& s) { s.materials[0].young = 51; }) ==
        "the scene had material.young = 50, and now has material.young = 51");
  CHECK(with([](scene::Scene& s) { s.check.control = {"0", "1"}; }).find("check.control") !=
        std::string::npos);
  CHECK(with([](scene::Scene& s) { s.exact.emplace().pressure = "1"; }).find("exact.pressure") !=
        std::string::npos);
  CHECK(with([](scene::Scene& s) { s.objective->gamma = 1; }).find("objective.gamma") != std::string::npos);
  // None of these changes a number.
  CHECK(with([](scene::Scene& s) { s.exact.emplace().impulse = 1; }).empty());
  CHECK(with([](scene::Scene& s) { s.output.every = 7; }).empty());
  CHECK(with([](scene::Scene& s) { s.optimizer.max_iterations = 7; }).empty());
  CHECK(with([](scene::Scene& s) {
          s.mesh.size = 0.5, s.time.step = 0.01, s.time.steps = 60;
        }).empty()); // which the rung sets

  SamplePoints others = at;
  others.digest = "of another mesh";
  CHECK(difference(own, Origin(scene, others, 1).of(rung)) ==
        "the set of points where fields are compared has changed");
  Fingerprint edited = own;
  edited["set of compiled forms"] = "edited";
  CHECK(difference(own, edited) == "the set of compiled forms has changed");
  edited = own;
  edited["program"] = "signorini 0";
  CHECK(difference(edited, own).find("the program was \"signorini 0\", and now is") == 0);
  {
    const test::Option option("-step_ksp_rtol", "1e-4");
    CHECK(difference(own, Origin(scene, at, 1).of(rung)).find("-step_ksp_rtol 1e-4") != std::string::npos);
  }
  CHECK(difference(own, Origin(scene, at, 1).of(rung)).empty());

  const auto edit = [&](const std::filesystem::path& file, const std::string& text) {
    const std::string before = content(file);
    write(file, text);
    const std::string found = difference(own, Origin(scene, at, 1).of(rung));
    write(file, before);
    return found;
  };
  CHECK(edit(folder / "run/state.h5", "another") == "the run that objective.desired.run names has changed");
  CHECK(edit(scene.mesh.file, content(scene.mesh.file) + "Point(9) = {9, 9, 0};\n") ==
        "the mesh file has changed");
  CHECK(edit(folder / include, "Point(9) = {9, 9, 0};\n") == "the mesh file has changed");
  CHECK(edit(folder / "lowest.inc", "Point(9) = {9, 9, 0};\n") == "the mesh file has changed");
  write(folder / "block.geo.opt", "Mesh.Algorithm = 1;\n");
  CHECK(difference(own, Origin(scene, at, 1).of(rung)) == "the mesh file has changed");
  std::filesystem::remove(folder / "block.geo.opt");
  CHECK(difference(own, Origin(scene, at, 1).of(rung)).empty());
}

TEST_CASE("sample points are told apart by the base mesh, its groups and the end of time", "[study]") {
  const auto digest = [](const std::vector<std::string>& overrides) {
    return broadcast(
        MPI_COMM_WORLD,
        SamplePoints(MPI_COMM_WORLD, test::parse(test::source("tests/data/block.toml"), overrides)).digest);
  };
  const std::string own = digest({});
  CHECK(own.size() == 16);
  CHECK(own == digest({"time.step=0.01", "mesh.degree=2"}));
  CHECK(own != digest({"mesh.size=0.2"}));
  CHECK(own != digest({"time.end=0.5"}));
}

TEST_CASE("forms are told apart by dimension and degree", "[study]") {
  CHECK(fem::forms_digest(2, 1, scene::PlaneModel::plane_strain) ==
        fem::forms_digest(2, 1, scene::PlaneModel::plane_strain));
  CHECK(fem::forms_digest(2, 1, scene::PlaneModel::plane_strain) !=
        fem::forms_digest(2, 2, scene::PlaneModel::plane_strain));
  CHECK(fem::forms_digest(2, 1, scene::PlaneModel::plane_strain) !=
        fem::forms_digest(2, 1, scene::PlaneModel::axisymmetric));
  CHECK(fem::forms_digest(2, 1, scene::PlaneModel::plane_strain) !=
        fem::forms_digest(3, 1, scene::PlaneModel::plane_strain));
}
