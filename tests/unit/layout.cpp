// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes that are in no cell, beside those of the mesh.
#include "base/collective.h"
#include "fem/space.h"
#include "fixtures.h"
#include "trajectory/time_integrator.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <cmath>

using namespace signorini;
using petsc::check;

namespace {

/// A mass on a spring with a damper, and one that is free in one component and held in the other.
const std::vector<fem::VirtualNode> two{
    {.mass = {3, 5}, .damping = {0.4, 0}, .stiffness = {7, 20}, .clamped = {}},
    {.mass = {2, 1}, .damping = {}, .stiffness = {}, .clamped = {false, true}}};

/// Global number of a virtual node's first dof.
PetscInt virtual_dof(const fem::Layout& layout, std::size_t node) {
  return layout.dofs() - static_cast<PetscInt>(layout.virtual_nodes().size() - node) * layout.dim();
}

struct Body {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::Operators operators;
  step::Stepper stepper;

  Body(const std::vector<std::string>& overrides, const std::vector<fem::VirtualNode>& nodes)
      : scene(test::parse(test::source("tests/data/block.toml"), overrides)),
        shared(test::discretised(scene)), space(shared->mesh, scene.mesh.degree, nodes),
        operators(fem::assemble_operators(space, scene.materials, true)),
        stepper(space, operators, scene, {.derivatives = true}) {}

  /// The entry of a vector at a component of a virtual node. Collective.
  double at(Vec x, std::size_t node, int component) const {
    double value = 0;
    if (space.layout().owns_virtual_nodes())
      value = petsc::ReadArray(
          x)[static_cast<std::size_t>(virtual_dof(space.layout(), node) + component - space.first_dof())];
    MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, space.comm());
    return value;
  }
  void set(Vec x, std::size_t node, int component, double value) const {
    const petsc::WriteArray values(x);
    if (space.layout().owns_virtual_nodes())
      values[static_cast<std::size_t>(virtual_dof(space.layout(), node) + component - space.first_dof())] =
          value;
  }
};

/// Those of the mesh's nodes.
std::vector<double> of_mesh(const fem::Space& space, Vec x) {
  const petsc::ReadArray values(x);
  const std::span<const double> all(values);
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(space.owned_nodes() * space.dim())};
}

} // namespace

TEST_CASE("virtual nodes stand behind the mesh's, and no form couples them", "[fem]") {
  const Body plain({}, {}), body({}, two);
  const fem::Layout& layout = body.space.layout();
  CHECK(body.space.dofs() == plain.space.dofs() + 4);
  CHECK(body.space.first_dof() == plain.space.first_dof());
  CHECK(virtual_dof(layout, 1) == body.space.dofs() - 2);
  CHECK(layout.nodes() - layout.mesh_nodes() == (layout.owns_virtual_nodes() ? 2 : 0));
  const petsc::Vector x = test::smooth(body.space, 1), like = test::smooth(plain.space, 1);
  for (std::size_t node = 0; node < 2; ++node)
    for (int c = 0; c < 2; ++c)
      body.set(x, node, c, 1);
  const double tau = body.scene.time.step;
  const petsc::Matrix D = fem::assemble_step_operator(body.space, body.scene.materials, tau),
                      D_plain = fem::assemble_step_operator(plain.space, plain.scene.materials, tau);
  const auto same = [&](Mat one, Mat other, const auto& expected) {
    petsc::Vector y = petsc::zero_like(x), z = petsc::zero_like(like);
    check(MatMult(one, x, y));
    check(MatMult(other, like, z));
    CHECK(test::difference(of_mesh(body.space, y), of_mesh(plain.space, z)) <
          1e-14 * test::largest(z)); // of assembly
    for (std::size_t node = 0; node < 2; ++node)
      for (int c = 0; c < 2; ++c)
        CHECK(std::abs(body.at(y, node, c) - expected(two[node], static_cast<std::size_t>(c))) < 1e-14);
  };
  same(body.operators.M, plain.operators.M,
       [](const fem::VirtualNode& n, std::size_t c) { return n.mass[c]; });
  same(body.operators.A, plain.operators.A,
       [](const fem::VirtualNode& n, std::size_t c) { return n.stiffness[c]; });
  same(*body.operators.B, *plain.operators.B,
       [](const fem::VirtualNode& n, std::size_t c) { return n.damping[c]; });
  same(*body.operators.W, *plain.operators.W, [](const fem::VirtualNode&, std::size_t) { return 0.0; });
  same(D, D_plain, [&](const fem::VirtualNode& n, std::size_t c) {
    return n.mass[c] + tau / 2 * n.damping[c] + tau * tau / 4 * n.stiffness[c];
  });
}

TEST_CASE("virtual nodes move as the scheme says, and the body beside them as without", "[forward]") {
  const std::string solver = GENERATE("solver.linear=direct", "solver.linear=iterative");
  CAPTURE(solver);
  const std::vector<std::string> settings{solver, "time.scheme=contact-implicit"};
  const Body plain(settings, {}), body(settings, two);
  const double tau = body.scene.time.step;
  const auto start = [](const Body& one) {
    step::State state = one.stepper.state();
    one.space.interpolate(scene::Field({"0.3", "-1"}, "test", false), 0, state.v());
    return state;
  };
  step::State a = start(plain), a_next = plain.stepper.state(), b = start(body),
              b_next = body.stepper.state();
  body.set(b.v(), 0, 1, 0.6);
  body.set(b.v(), 1, 0, -0.25);
  body.set(b.y(), 0, 0, 0.1);
  contact::ContactState none_a = plain.stepper.contact_state(), none_b = body.stepper.contact_state();
  step::Stepper::Workspace work_a = plain.stepper.workspace(), work_b = body.stepper.workspace();
  const auto energy = [&](std::size_t c) {
    return (two[0].mass[c] * std::pow(body.at(b.v(), 0, static_cast<int>(c)), 2) +
            two[0].stiffness[c] * std::pow(body.at(b.y(), 0, static_cast<int>(c)), 2)) /
           2;
  };
  const double first = energy(1);
  double damped = energy(0);
  bool closed = false;
  const int steps = body.scene.time.steps;
  for (int k = 1; k <= steps; ++k) {
    const step::TimeStep step{k, (k - 1) * tau, k * tau, tau};
    contact::ContactState now_a = plain.stepper.contact_state(), now_b = body.stepper.contact_state();
    a_next.copy(a); // a guess
    b_next.copy(b);
    plain.stepper.step({step, a, {}, none_a}, {a_next, now_a}, work_a);
    body.stepper.step({step, b, {}, none_b}, {b_next, now_b}, work_b);
    std::swap(a, a_next);
    std::swap(b, b_next);
    none_a = now_a;
    none_b = now_b;
    REQUIRE(now_a.active == now_b.active);
    closed = closed || !now_a.active.empty();
    const double dissipated = damped - energy(0);
    CHECK(dissipated >= -1e-15);
    damped = energy(0);
  }
  CHECK(closed);
  const double tolerance = body.stepper.solver().tolerance() > 0 ? 1e-8 : 1e-11;
  CHECK(test::difference(of_mesh(body.space, b.y()), of_mesh(plain.space, a.y())) <
        tolerance * test::largest(a.y()));
  CHECK(std::abs(energy(1) - first) < tolerance * first); // Newmark's scheme keeps that of a spring
  CHECK(std::abs(body.at(b.y(), 1, 0) + 0.25 * steps * tau) < tolerance); // and a free flight exactly
  CHECK(body.at(b.y(), 1, 1) == 0);
  CHECK(body.at(b.v(), 1, 1) == 0);
}
