#include "base/collective.h"
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include "contact/node_basis.h"
#include "contact/normal_operator.h"
#include "contact/placement.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>
#include <numbers>
#include <numeric>
#include <random>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
using petsc::check;

namespace {

using Point = std::array<double, 3>;
constexpr double diameter = 2.0; // of a body, m

contact::Obstacle made(const scene::Obstacle& shape, int dim = 3) {
  return {shape, "contact.obstacle", dim, diameter};
}

/// Points that lie all around the origin, half a metre to one and a half away.
std::vector<Point> points(int dim) {
  std::vector<Point> all;
  for (int i = 0; i < 40; ++i) {
    const double a = 0.7 * i, b = dim == 3 ? 0.4 * i : 0, r = 0.5 + 0.025 * i;
    all.push_back({r * std::cos(a) * std::cos(b), r * std::sin(a) * std::cos(b), r * std::sin(b)});
  }
  return all;
}

double distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// Whether an obstacle has the height and normal that a point expects.
template <class Expected>
void require_planes(const contact::Obstacle& obstacle, int dim, double tolerance, Expected&& expected) {
  for (const Point& x : points(dim)) {
    const contact::Obstacle::Plane plane = obstacle.at(x.data()), right = expected(x);
    CHECK(std::abs(plane.height - right.height) < tolerance);
    CHECK(distance(plane.normal, right.normal) < tolerance);
  }
}

/// A block or cube with several obstacles; `contacts` is a list of tables in TOML.
struct Walls {
  scene::Scene scene;
  mesh::Mesh mesh;
  fem::Space space;
  fem::DirichletDofs clamped;
  petsc::Matrix D;
  contact::ContactPairs pairs;
  contact::NormalOperator N{pairs};

  explicit Walls(const std::string& contacts, const std::string& file = "block.toml",
                 std::vector<std::string> overrides = {})
      : scene(test::parse(test::source("tests/data/" + file), with(std::move(overrides), contacts))),
        mesh(MPI_COMM_WORLD, scene.mesh), space(mesh, scene.mesh.degree), clamped(space, scene.clamps),
        D(fem::assemble_step_operator(space, scene.materials, scene.time.step)),
        pairs(space, clamped, scene.contacts, scene.time) {}

  static std::vector<std::string> with(std::vector<std::string> overrides, const std::string& contacts) {
    overrides.push_back("contact=[" + contacts + "]");
    return overrides;
  }

  [[nodiscard]] forward::SolverChoice solver(scene::LinearMethod linear,
                                             scene::ViMethod vi = scene::ViMethod::condensed) const {
    petsc::Matrix same;
    check(MatDuplicate(D, MAT_COPY_VALUES, same.put()));
    scene::Solver settings = scene.solver;
    settings.linear = linear;
    settings.vi = vi;
    return {std::move(same), &pairs, settings, true};
  }

  /// y of the contact step for r, from no contact; `state` becomes its contact.
  petsc::Vector solve(const forward::SolverChoice& solver, Vec r, contact::ContactState& state) const {
    petsc::Vector y = space.vector();
    contact::Workspace work = solver.contact()->workspace();
    solver.contact()->solve(r, pairs.psi(), {}, state, y, work);
    return y;
  }

  /// r = D y for a motion to one side.
  [[nodiscard]] petsc::Vector pushing(const scene::Components& motion) const {
    petsc::Vector y = space.vector(), r = space.vector();
    space.interpolate(scene::Field(motion, "test", false), 0, y);
    check(MatMult(D, y, r));
    return r;
  }

  /// ‖D y − r + Nλ‖∞ beside ‖r‖∞.
  double defect(Vec r, const contact::ContactState& state, Vec y) const {
    petsc::Vector defect = space.vector();
    check(MatMult(D, y, defect));
    check(VecAXPY(defect, -1, r));
    contact::NormalOperator(pairs).add(1, state.lambda, defect);
    return test::largest(defect) / test::largest(r);
  }
};

std::string half_space(const std::string& on, const std::string& point, const std::string& normal,
                       const std::string& more = "") {
  return fmt::format("{{ on = \"{}\", obstacle = {{ shape = \"half-space\", point = {}, normal = {} }}{} }},",
                     on, point, normal, more);
}

/// The box 0 ≤ x ≤ 1 + right, 0 ≤ y ≤ 1 + above around the unit square.
std::string box(const std::string& left, const std::string& right, const std::string& below,
                const std::string& above) {
  return half_space("boundary", fmt::format("[-{}, 0]", left), "[1, 0]") +
         half_space("boundary", fmt::format("[1.0{}, 0]", right), "[-1, 0]") +
         half_space("boundary", fmt::format("[0, -{}]", below), "[0, 1]") +
         half_space("boundary", fmt::format("[0, 1.0{}]", above), "[0, -1]");
}

} // namespace

TEST_CASE("a half-space of any orientation", "[contact]") {
  const double n = std::sqrt(0.09 + 0.04 + 1);
  require_planes(
      made(scene::HalfSpace{{"0.1", "-0.2", "0.3"}, {0.3, -0.2, 1}}), 3, 1e-15, [&](const Point& x) {
        return contact::Obstacle::Plane{{0.3 / n, -0.2 / n, 1 / n},
                                        (0.3 * (x[0] - 0.1) - 0.2 * (x[1] + 0.2) + x[2] - 0.3) / n};
      });
  // A normal of any length.
  require_planes(made(scene::HalfSpace{{"0", "0"}, {3e200, 4e200}}, 2), 2, 1e-15, [](const Point& x) {
    return contact::Obstacle::Plane{{0.6, 0.8, 0}, 0.6 * x[0] + 0.8 * x[1]};
  });
}

TEST_CASE("a half-space that moves", "[contact]") {
  const contact::Obstacle still = made(scene::HalfSpace{{"0", "-1 + 2"}, {0, 2}}, 2),
                          moving = made(scene::HalfSpace{{"t", "-1 + 2*t^2"}, {3, 4}}, 2);
  CHECK_FALSE(still.moves());
  REQUIRE(moving.moves());
  const Point x{0.3, -0.2, 0};
  const auto advance = [&](double t) {
    return moving.at(x.data()).height - moving.at(x.data(), moving.place(t)).height;
  };
  CHECK(advance(0) == 0);
  CHECK(std::abs(advance(0.5) - (0.6 * 0.5 + 0.8 * 0.5)) < 1e-15);
  CHECK_THROWS_AS(made(scene::HalfSpace{{"0", "1/(t - 1)"}, {0, 1}}, 2).place(1), UserError);
}

TEST_CASE("balls, cylinders and level sets move and grow", "[contact]") {
  constexpr double t = 0.5;
  const auto same = [&](const scene::Obstacle& moving, const scene::Obstacle& there, double tolerance) {
    const contact::Obstacle a = made(moving), b = made(there);
    CHECK(a.moves());
    CHECK_FALSE(b.moves());
    for (const Point& x : points(3)) {
      const contact::Obstacle::Plane p = a.at(x.data(), a.place(t)), q = b.at(x.data()),
                                     start = a.at(x.data());
      CHECK(std::abs(p.height - q.height) < tolerance);
      CHECK(distance(p.normal, q.normal) < tolerance);
      CHECK(std::abs(p.height - start.height) > 1e-3);
      CHECK((a.level(x.data(), a.place(t)) > 0) == (p.height > 0));
    }
  };
  for (const scene::Side side : {scene::Side::outside, scene::Side::inside}) {
    same(scene::Ball{{"t", 0.7, "0.2 - t^2"}, 0.4, side}, scene::Ball{{0.5, 0.7, -0.05}, 0.4, side}, 1e-15);
    same(scene::Ball{{0, 0, 0.1}, "0.4 + 0.2*t", side}, scene::Ball{{0, 0, 0.1}, 0.5, side}, 1e-15);
    same(scene::Cylinder{{"2*t", 0.03, 0}, {0, 1, 1}, "0.2 + 3*t^2", side},
         scene::Cylinder{{1, 0.03, 0}, {0, 1, 1}, 0.95, side}, 1e-15);
  }
  same(scene::SignedDistance{"3*(sqrt((x - t)^2 + (y - 0.7)^2 + z^2) - 0.4 - t)"},
       scene::Ball{{0.5, 0.7, 0}, 0.9, scene::Side::outside}, 1e-10);
  CHECK_THROWS_WITH(made(scene::Ball{{0, 0, 0}, "1 - t", scene::Side::outside}).place(1),
                    ContainsSubstring("radius: found 0 m at t = 1 s"));
}

TEST_CASE("a pair's direction is that of the touch of an obstacle that moves", "[contact]") {
  const auto round = [](const std::string& center) {
    return "{ on = \"bottom\", obstacle = { shape = \"ball\", radius = 1, center = " + center + " } },";
  };
  for (const int file : {0, 1}) { // the ball comes from below, or passes by
    const Walls walls(round(file == 0 ? "[0.5, \"-1.5 + 2*t\"]" : "[\"-1 + 4*t\", -1.1]"));
    const std::vector<double>&x = walls.pairs.points(), &nu = walls.pairs.normals();
    contact::ContactPairs::Gaps gaps = walls.pairs.gaps();
    REQUIRE(walls.pairs.count() == 5);
    REQUIRE(walls.pairs.moving());
    for (int i = 0; i < walls.pairs.count(); ++i) {
      const auto j = static_cast<std::size_t>(i);
      const double s = x[3 * j] - 0.5, across = file == 0 ? -s : 0;
      // A secant between two steps, 0.04 m apart; or the nearest step, 0.08 m from the next.
      CHECK(std::abs(nu[2 * j] - across) < (file == 0 ? 1e-4 : 0.04 / 1.1));
      CHECK(std::abs(std::hypot(nu[2 * j], nu[2 * j + 1]) - 1) < 1e-15);
      CHECK(nu[2 * j + 1] < 0);
    }
    for (const double t : {0.0, 0.25, 0.26, 0.6}) {
      const std::span<const double> psi = walls.pairs.psi(t, gaps);
      for (std::size_t j = 0; j < psi.size(); ++j)
        CHECK(std::abs(psi[j] -
                       (file == 0 ? std::hypot(x[3 * j] - 0.5, 1.5 - 2 * t)
                                  : std::hypot(x[3 * j] + 1 - 4 * t, 1.1)) +
                       1) < 1e-15);
    }
    CHECK(std::ranges::equal(walls.pairs.psi(0, gaps), walls.pairs.psi()));
  }
}

TEST_CASE("balls and cylinders from outside and inside", "[contact]") {
  const Point c{0.2, -0.1, 0.15};
  for (const scene::Side side : {scene::Side::outside, scene::Side::inside}) {
    const double sign = side == scene::Side::inside ? -1 : 1;
    require_planes(made(scene::Ball{{c[0], c[1], c[2]}, 0.4, side}), 3, 1e-15, [&](const Point& x) {
      const double r = distance(x, c);
      return contact::Obstacle::Plane{
          {sign * (x[0] - c[0]) / r, sign * (x[1] - c[1]) / r, sign * (x[2] - c[2]) / r}, sign * (r - 0.4)};
    });
    const auto disc = [&](const Point& x) {
      const double r = std::hypot(x[0] - c[0], x[1] - c[1]);
      return contact::Obstacle::Plane{{sign * (x[0] - c[0]) / r, sign * (x[1] - c[1]) / r, 0},
                                      sign * (r - 0.4)};
    };
    require_planes(made(scene::Ball{{c[0], c[1]}, 0.4, side}, 2), 2, 1e-15, disc);
    require_planes(made(scene::Cylinder{{c[0], c[1]}, {}, 0.4, side}, 2), 2, 1e-15, disc);
    require_planes(made(scene::Cylinder{{c[0], c[1], 7}, {0, 0, -3}, 0.4, side}), 3, 1e-15, disc);
    // An axis along (1, 1, 0): distances from it by the cross product.
    require_planes(made(scene::Cylinder{{0, 0, 0}, {2, 2, 0}, 0.4, side}), 3, 1e-15, [&](const Point& x) {
      const double across = (x[0] - x[1]) / 2, r = std::hypot(std::numbers::sqrt2 * across, x[2]);
      return contact::Obstacle::Plane{{sign * across / r, -sign * across / r, sign * x[2] / r},
                                      sign * (r - 0.4)};
    });
  }
  const Point centre{1, 2, 0}, beside{1, 2, 0.5};
  CHECK_THROWS_WITH(made(scene::Ball{{1, 2, 0}, 0.5, scene::Side::inside}).at(centre.data()),
                    ContainsSubstring("(1, 2, 0)"));
  CHECK_THROWS_WITH(made(scene::Cylinder{{1, 2, 0}, {0, 0, 1}, 0.5, scene::Side::outside}).at(beside.data()),
                    ContainsSubstring("(1, 2, 0.5)"));
}

TEST_CASE("a signed distance is linearised by its derivatives", "[contact]") {
  // Differences of order 6 over 2e-4 m: rounding is 1e-16 (1 m / 2e-4 m) and more where the level set is
  // steep.
  constexpr double tolerance = 1e-11;
  require_planes(made(scene::SignedDistance{"sqrt(x^2 + y^2 + z^2) - 0.4"}), 3, tolerance,
                 [](const Point& x) {
                   const double r = distance(x, {});
                   return contact::Obstacle::Plane{{x[0] / r, x[1] / r, x[2] / r}, r - 0.4};
                 });
  // An ellipse by a level set that is no distance.
  require_planes(made(scene::SignedDistance{"5*(x^2/0.04 + y^2/0.01 - 1)"}, 2), 2, tolerance,
                 [](const Point& x) {
                   const Point g{10 * x[0] / 0.04, 10 * x[1] / 0.01, 0};
                   const double size = distance(g, {});
                   return contact::Obstacle::Plane{{g[0] / size, g[1] / size, 0},
                                                   5 * (x[0] * x[0] / 0.04 + x[1] * x[1] / 0.01 - 1) / size};
                 });
  // A corrugated floor with waves of a fortieth of the body.
  require_planes(made(scene::SignedDistance{"y + 0.01*sin(40*pi*x)"}, 2), 2, 1e-8, [](const Point& x) {
    const double k = 40 * std::numbers::pi, slope = 0.01 * k * std::cos(k * x[0]),
                 size = std::hypot(slope, 1);
    return contact::Obstacle::Plane{{slope / size, 1 / size, 0}, (x[1] + 0.01 * std::sin(k * x[0])) / size};
  });
  const Point x{0.5, 0, 0};
  for (const char* flat : {"1", "y^2", "0*x", "abs(y)"})
    CHECK_THROWS_WITH(made(scene::SignedDistance{flat}, 2).at(x.data()),
                      ContainsSubstring("no slope") && ContainsSubstring("(0.5, 0, 0)"));
  for (const char* infinite : {"1/y", "sqrt(y - 1)", "sqrt(y)"}) // the last one beside the node
    CHECK_THROWS_WITH(made(scene::SignedDistance{infinite}, 2).at(x.data()), ContainsSubstring("x = 0.5"));
}

TEST_CASE("a node basis finds shortest motions and forces", "[contact]") {
  contact::NodeBasis basis(3);
  const Point a{0, 0, 1}, b{0, 0.6, 0.8}, c{0, 1, 0}, d{1, 1e-9, 0};
  CHECK(basis.add(a.data()));
  CHECK(basis.add(b.data()));
  CHECK_FALSE(basis.add(c.data())); // in the plane of the first two
  CHECK(basis.add(d.data()));
  CHECK_FALSE(basis.add(a.data()));
  Point x{}, values{0.3, -0.2, 0.7};
  basis.shortest(values);
  basis.add_to(x.data(), values);
  CHECK(std::abs(x[2] - 0.3) < 1e-15);
  CHECK(std::abs(0.6 * x[1] + 0.8 * x[2] + 0.2) < 1e-15);
  CHECK(std::abs(x[0] + 1e-9 * x[1] - 0.7) < 1e-15);
  // 2 a − b + 3 d.
  const Point sum{3, -0.6 + 3e-9, 2 - 0.8};
  Point parts{basis.along(0, sum.data()), basis.along(1, sum.data()), basis.along(2, sum.data())};
  basis.combine(parts);
  CHECK(std::abs(parts[0] - 2) + std::abs(parts[1] + 1) + std::abs(parts[2] - 3) < 1e-14);
}

TEST_CASE("the dual active-set method solves singular problems or tells that they have no solution",
          "[contact]") {
  // Columns of N in the plane: directions round the circle, of which any three depend on each other.
  constexpr int m = 7;
  std::vector<double> N, S(m * m), lambda(m);
  for (int i = 0; i < m; ++i)
    for (const double n : {std::cos(0.9 * i), std::sin(0.9 * i)})
      N.push_back(n);
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j)
      S[static_cast<std::size_t>(m * i + j)] = N[2 * i] * N[2 * j] + N[2 * i + 1] * N[2 * j + 1];
  const auto depends = [&](const contact::ActiveSet& set, int i) {
    contact::NodeBasis basis(2);
    for (int j : set)
      basis.add(&N[static_cast<std::size_t>(2 * j)]);
    return !basis.add(&N[static_cast<std::size_t>(2 * i)]);
  };
  contact::GoldfarbIdnaniWork work(m);
  contact::ActiveSet set;
  int pairs = 0;
  for (int which = 0; which < 50; ++which) {
    // Half-planes n·x ≤ 1 move by a shift: the closest point to the origin of their polygon.
    const double a = 0.3 * which, r = 0.1 * which;
    std::vector<double> gap(m);
    for (int i = 0; i < m; ++i)
      gap[static_cast<std::size_t>(i)] = 1 - r * (N[2 * i] * std::cos(a) + N[2 * i + 1] * std::sin(a));
    int steps = 0;
    REQUIRE(contact::goldfarb_idnani(S, gap, 1e-14, depends, set, lambda, steps, work));
    CHECK(set.size() <= 2);
    pairs += set.size() == 2;
    for (std::size_t i = 0; i < m; ++i) {
      double g = gap[i];
      for (std::size_t j = 0; j < m; ++j)
        g += S[m * i + j] * lambda[j];
      CHECK(g > -1e-13);
      CHECK(lambda[i] >= 0);
      CHECK(std::abs(lambda[i] * g) < 1e-12);
      CHECK((lambda[i] > 0) == std::ranges::binary_search(set, static_cast<int>(i)));
    }
  }
  CHECK(pairs > 5);
  std::vector<double> empty(m, -0.1); // n·x ≤ −0.1 all round
  int steps = 0;
  CHECK_FALSE(contact::goldfarb_idnani(S, empty, 1e-14, depends, set, lambda, steps, work));
}

TEST_CASE("candidates are numbered by place, then by obstacle", "[contact]") {
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") + half_space("bottom", "[0, -0.2]", "[0, 1]"));
  const contact::ContactPairs& pairs = walls.pairs;
  REQUIRE(pairs.count() == 10);
  CHECK_FALSE(pairs.dependent());
  // The left side from below, the corner twice, then along the bottom.
  const std::vector<int> obstacles{0, 1, 0, 0, 0, 0, 1, 1, 1, 1}, nodes{0, 0, 1, 2, 3, 4, 5, 6, 7, 8};
  CHECK(pairs.obstacles() == obstacles);
  CHECK(pairs.node_numbers() == nodes);
  for (std::size_t i = 0; i < 10; ++i) {
    const bool left = obstacles[i] == 0;
    CHECK(pairs.normals()[2 * i] == (left ? -1 : 0));
    CHECK(pairs.normals()[2 * i + 1] == (left ? 0 : -1));
    CHECK(std::abs(pairs.psi()[i] - (left ? 0.1 : 0.2)) < 1e-12);
  }
  CHECK(pairs.directions() == pairs.normals());
  CHECK(pairs.first_dofs()[0] == pairs.first_dofs()[1]);
}

TEST_CASE("several obstacles at a node: all solvers find the solution, which is complementary", "[contact]") {
  struct Case {
    std::string contacts;
    scene::Components motion; ///< without contact
    bool dependent;
  };
  const std::string acute = half_space("boundary", "[-0.05, 0]", "[1, 0.3]") +
                            half_space("boundary", "[0, -0.1]", "[0.2, 1]"),
                    hole = acute + half_space("boundary", "[-0.05, -0.1]", "[1, 1]"); // blunts the corner
  for (const auto& [contacts, motion, dependent] :
       {Case{acute, {"-0.4 - 0.1*y", "-0.3"}, false}, Case{acute, {"-0.3", "0.2"}, false},
        Case{hole, {"-0.4", "-0.3 - 0.1*x"}, true}, Case{hole, {"-0.1", "-0.5"}, true},
        Case{box("0.1", "1", "0.1", "1"), {"-0.4*x", "-0.3"}, true},
        // Pressed against all four walls at once, two of them without a gap.
        Case{box("0.0", "0", "0.05", "05"), {"0.4*(x - 0.5)", "0.3*(y - 0.5)"}, true},
        // The same plane three times, once shifted: only one of them carries.
        Case{half_space("bottom", "[0, -0.1]", "[0, 1]") + half_space("bottom", "[3, -0.1]", "[0, 2]") +
                 half_space("bottom", "[0, -0.2]", "[0, 1]"),
             {"0", "-0.4*x"},
             true}}) {
    const Walls walls(contacts, "block.toml", {"mesh.size=0.1"});
    REQUIRE(walls.pairs.dependent() == dependent);
    const petsc::Vector r = walls.pushing(motion);
    contact::ContactState a(walls.pairs.count()), b(walls.pairs.count());
    const forward::SolverChoice direct = walls.solver(scene::LinearMethod::direct),
                                iterative = walls.solver(scene::LinearMethod::iterative);
    const petsc::Vector y = walls.solve(direct, r, a), z = walls.solve(iterative, r, b);
    CHECK(a.count(contact::Status::strong) > 1);
    CHECK(test::difference(y, z) < 1e-10 * test::largest(y));
    CHECK(walls.defect(r, a, y) < 1e-12);
    CHECK(walls.defect(r, b, z) < 1e-9);
    for (std::size_t i = 0; i < a.lambda.size(); ++i) {
      CHECK(a.lambda[i] >= -1e-12);
      CHECK(a.gap[i] >= -1e-14);
      CHECK(std::abs(a.lambda[i] * a.gap[i]) < 1e-13);
    }
    // Sliding keeps all of the active set closed, with normal forces alone, dependent or not.
    for (const forward::SolverChoice* solver : {&direct, &iterative}) {
      const petsc::Vector q = walls.pushing({"x - y", "1 + x*y"});
      petsc::Vector p = walls.space.vector();
      contact::Workspace work = solver->contact()->workspace();
      solver->contact()->solve_sliding(q, a.active, p, work);
      std::vector<double> normal(a.lambda.size());
      walls.N.normal_components(p, normal);
      for (int i : a.active)
        CHECK(std::abs(normal[static_cast<std::size_t>(i)]) < 1e-12 * test::largest(p));
      petsc::Vector left = walls.space.vector();
      check(MatMult(walls.D, p, left));
      check(VecAYPX(left, -1, q));
      contact::ActiveSet set = a.active;
      contact::drop_dependent(walls.pairs, set);
      walls.N.forces(set, left, normal);
      walls.N.add(-1, normal, left);
      CHECK(test::largest(left) < 1e-9 * test::largest(q));
    }
  }
}

TEST_CASE("the full VI takes one obstacle per node", "[contact]") {
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") + half_space("bottom", "[0, -0.2]", "[0, 1]"));
  CHECK_THROWS_WITH(walls.solver(scene::LinearMethod::direct, scene::ViMethod::full),
                    ContainsSubstring("2 obstacles") && ContainsSubstring("(0, 0, 0)") &&
                        ContainsSubstring("condensed"));
}

TEST_CASE("obstacles that leave no room are refused, at the start and on the way", "[contact]") {
  CHECK_THROWS_WITH(
      Walls(half_space("left", "[0.1, 0]", "[1, 0]") + half_space("left", "[0.05, 0]", "[-1, 0]")),
      ContainsSubstring("no room") && ContainsSubstring("t = 0 s"));
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") +
                    half_space("left", "[\"0.1 - t\", 0]", "[-1, 0]"));
  contact::ContactPairs::Gaps gaps = walls.pairs.gaps();
  CHECK_NOTHROW(walls.pairs.psi(0.19, gaps));
  CHECK_THROWS_WITH(walls.pairs.psi(0.21, gaps),
                    ContainsSubstring("no room") && ContainsSubstring("t = 0.21 s"));
}

TEST_CASE("gaps follow obstacles that move, and others stay", "[contact]") {
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") +
                    half_space("bottom", "[0, \"-0.2 + 0.5*t\"]", "[0, 1]"));
  const std::vector<double> start(walls.pairs.psi().begin(), walls.pairs.psi().end());
  contact::ContactPairs::Gaps gaps = walls.pairs.gaps();
  const std::span<const double> later = walls.pairs.psi(0.1, gaps);
  for (std::size_t i = 0; i < later.size(); ++i)
    CHECK(std::abs(later[i] - start[i] + (walls.pairs.obstacles()[i] == 1 ? 0.05 : 0)) < 1e-15);
  const Walls still(half_space("left", "[-0.1, 0]", "[1, 0]"));
  gaps = still.pairs.gaps();
  CHECK(still.pairs.psi(7, gaps).data() == still.pairs.psi().data());
}

TEST_CASE("nodes that start inside are moved out the shortest way if asked", "[contact]") {
  const auto project = [](const std::string& on, const std::string& point, const std::string& normal) {
    return half_space(on, point, normal, ", initial = \"project\"");
  };
  {
    // A plane over the bottom: its nodes go up along the normal, all others stay.
    const Walls walls(project("boundary", "[0, 0.1]", "[0.75, 1]"));
    petsc::Vector y = walls.space.vector(), exact = walls.space.vector();
    contact::place_outside(walls.pairs, y);
    walls.space.interpolate(
        scene::Field({"0.6*max(0, 0.08 - 0.6*x - 0.8*y)", "0.8*max(0, 0.08 - 0.6*x - 0.8*y)"}, "test", false),
        0, exact);
    CHECK(test::largest(exact) > 0.05);
    CHECK(test::difference(y, exact) < 1e-15);
  }
  {
    // In a corner of 45 degrees the closest place is on the edge where each alone would leave the other's
    // node inside.
    const Walls walls(project("left", "[0.1, 0]", "[1, 0]") + project("bottom", "[0, 0.2]", "[-1, 1]") +
                      project("left", "[0.05, 0]", "[1, 0]"));
    petsc::Vector y = walls.space.vector();
    contact::place_outside(walls.pairs, y);
    std::vector<double> gap(static_cast<std::size_t>(walls.pairs.count()));
    walls.N.gap(walls.pairs.psi(), y, gap);
    CHECK(std::ranges::min(gap) > -1e-15);
    // The corner node goes to (0.1, 0.3), not to (0.1, 0.2) as one after the other would.
    std::vector<double> normal(gap.size());
    walls.N.normal_components(y, normal);
    CHECK(walls.pairs.obstacles()[0] == 0);
    CHECK(std::abs(normal[0] + 0.1) < 1e-15);
    CHECK(std::abs(normal[1] + (0.3 - 0.1) / std::numbers::sqrt2) < 1e-15);
  }
  {
    // Only the contact that asks for it.
    const Walls walls(project("left", "[0.1, 0]", "[1, 0]") + half_space("bottom", "[0, 0.2]", "[0, 1]"));
    petsc::Vector y = walls.space.vector();
    CHECK_THROWS_WITH(contact::place_outside(walls.pairs, y),
                      ContainsSubstring("contact[1]: ") && ContainsSubstring("0.2 m inside"));
  }
  {
    const Walls walls(
        "{ on = \"boundary\", initial = \"project\", obstacle = { shape = \"ball\", center = [-0.2, -0.1, "
        "-0.3], radius = 0.5 } }",
        "cube.toml");
    petsc::Vector y = walls.space.vector(), exact = walls.space.vector();
    contact::place_outside(walls.pairs, y);
    const std::string out = "max(0, 0.5/sqrt((x + 0.2)^2 + (y + 0.1)^2 + (z + 0.3)^2) - 1)";
    walls.space.interpolate(
        scene::Field({"(x + 0.2)*" + out, "(y + 0.1)*" + out, "(z + 0.3)*" + out}, "test", false), 0, exact);
    CHECK(test::largest(exact) > 0.05);
    CHECK(test::difference(y, exact) < 1e-15);
  }
}

TEST_CASE("a candidate whose twin carries the force is not weak", "[contact]") {
  const std::string floor = half_space("bottom", "[0, 0]", "[0, 1]");
  for (scene::LinearMethod linear : {scene::LinearMethod::direct, scene::LinearMethod::iterative}) {
    const Walls walls(floor + floor, "block.toml", {"time.step=1e-4"});
    const forward::SolverChoice solver = walls.solver(linear);
    REQUIRE(walls.pairs.dependent());
    contact::ContactState state(walls.pairs.count());
    // Pressed down, all are held, each with a share that is any; without weight each could be lifted.
    const petsc::Vector down = walls.pushing({"0", "-1"});
    (void)walls.solve(solver, down, state);
    CHECK(state.count(contact::Status::strong) == walls.pairs.count());
    check(VecZeroEntries(down));
    (void)walls.solve(solver, down, state);
    CHECK(state.count(contact::Status::weak) == walls.pairs.count());
    // One end is pressed down, the other touches.
    const petsc::Vector tilted = walls.pushing({"0", "max(0.5 - x, 0)*(0 - 1)"});
    (void)walls.solve(solver, tilted, state);
    const std::vector<double>& x = walls.pairs.points();
    for (std::size_t i = 0; i < state.status.size(); i += 2) {
      INFO(scene::name(linear) << ", at " << x[3 * i]);
      CHECK(state.status[i] == state.status[i + 1]);
    }
    CHECK(state.count(contact::Status::strong) > 0);
    CHECK(state.count(contact::Status::strong) < walls.pairs.count());
  }
}

TEST_CASE("the obstacles of a node follow each other in their order, at many nodes too", "[contact]") {
  const Walls walls(half_space("bottom", "[0, -0.1]", "[0, 1]") +
                        half_space("bottom", "[0, -0.2]", "[0.1, 1]") +
                        half_space("bottom", "[0, -0.3]", "[0.2, 1]"),
                    "block.toml", {"mesh.size=0.02"});
  const contact::ContactPairs& pairs = walls.pairs;
  REQUIRE(pairs.count() == 3 * 51);
  for (int i = 0; i < pairs.count(); ++i) {
    const auto j = static_cast<std::size_t>(i);
    CHECK(pairs.obstacles()[j] == i % 3);
    CHECK(pairs.node_numbers()[j] == i / 3);
    CHECK(std::abs(pairs.points()[3 * j] - 0.02 * (i / 3)) < 1e-10);
  }
}

TEST_CASE("a node that clamps hold wholly is no candidate and needs no plane", "[contact]") {
  // At the corner (0, 0) the level set has no slope.
  const std::string nowhere =
      "{ on = \"boundary\", obstacle = { shape = \"signed-distance\", distance = \"x^2 + y^2 + "
      "0.01\" } },";
  CHECK_THROWS_WITH(Walls(nowhere), ContainsSubstring("no slope") && ContainsSubstring("(0, 0, 0)"));
  const Walls walls(nowhere, "block.toml", {"clamp=[{on=\"bottom\"}]"});
  CHECK(walls.pairs.count() == 16 - 5);
  for (int i = 0; i < walls.pairs.count(); ++i)
    CHECK(walls.pairs.points()[3 * static_cast<std::size_t>(i) + 1] > 0.2);
}

TEST_CASE("directions may follow each other without a gap", "[contact]") {
  // A basis looks at as many components as there are dimensions, whatever stands behind them.
  for (const std::size_t dim : {2, 3}) {
    std::vector<double> packed;
    for (std::size_t i = 0; i < dim; ++i)
      for (std::size_t c = 0; c < dim; ++c)
        packed.push_back(i == c ? 0.8 : 0.1);
    packed.push_back(std::numeric_limits<double>::quiet_NaN());
    contact::NodeBasis basis(static_cast<int>(dim));
    for (std::size_t i = 0; i < dim; ++i)
      CHECK(basis.add(&packed[i * dim]));
    CHECK(basis.size() == dim);
  }
}

TEST_CASE("the dual active-set method solves regular problems with many constraints closed", "[contact]") {
  // S = N Nᵀ of m directions in more dimensions, with gaps of both signs.
  constexpr std::size_t m = 9, n = 11;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto depends = [](const contact::ActiveSet&, int) { return false; };
  contact::GoldfarbIdnaniWork work(m);
  std::size_t most = 0;
  int left = 0; // constraints that were in the set on the way, but not at the end
  for (int which = 0; which < 100; ++which) {
    std::vector<double> N(m * n), S(m * m), gap0(m), lambda(m);
    for (double& x : N)
      x = 0.5 + normal(random); // to the same side, so that one constraint makes others superfluous
    for (std::size_t i = 0; i < m; ++i)
      for (std::size_t j = 0; j < m; ++j)
        S[i * m + j] = std::inner_product(&N[i * n], &N[i * n] + n, &N[j * n], 0.0);
    for (double& g : gap0)
      g = normal(random) - 0.5;
    contact::ActiveSet set;
    int steps = 0;
    REQUIRE(contact::goldfarb_idnani(S, gap0, 1e-13, depends, set, lambda, steps, work));
    most = std::max(most, set.size());
    left += steps - static_cast<int>(set.size());
    for (std::size_t i = 0; i < m; ++i) {
      const double g = std::inner_product(&S[i * m], &S[i * m] + m, lambda.begin(), gap0[i]);
      const bool closed = std::ranges::binary_search(set, static_cast<int>(i));
      CHECK(g > -1e-12);
      CHECK((lambda[i] > 0) == closed);
      if (closed)
        CHECK(std::abs(g) < 1e-11);
    }
  }
  CHECK(most > 4);
  CHECK(left > 0);
}
