// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Enumerations of a scene. names() of each returns the enumerators' names in scene files, in the order of
/// the enumerators.
namespace signorini::scene {

template <std::size_t n>
using Names = std::array<std::string_view, n>;

/// Unit of the coordinates in a mesh file; metres() returns its length, m.
enum class LengthUnit { m, cm, mm, um, in };
constexpr Names<5> names(LengthUnit) { return {"m", "cm", "mm", "um", "in"}; }
constexpr double metres(LengthUnit unit) {
  constexpr std::array lengths{1.0, 1e-2, 1e-3, 1e-6, 0.0254};
  return lengths[static_cast<std::size_t>(unit)];
}

/// Assumption by which a body in the plane stands for one in space (forms/viscoelasticity.py). axisymmetric:
/// x is the radius and y the axis of a body of revolution.
enum class PlaneModel { plane_strain, plane_stress, axisymmetric };
constexpr Names<3> names(PlaneModel) { return {"plane-strain", "plane-stress", "axisymmetric"}; }
/// Suffix of the units of mass, force and energy of a body of `dim` dimensions: "/m" if they are per metre of
/// depth, else empty.
constexpr const char* per_depth(int dim, PlaneModel model) {
  return dim == 2 && model != PlaneModel::axisymmetric ? "/m" : "";
}

enum class TimeScheme { contact_implicit, contact_stabilized };
constexpr Names<2> names(TimeScheme) { return {"contact-implicit", "contact-stabilized"}; }

/// Quantity whose error controls the length of time steps that vary.
enum class StepQuantity { displacement, contact_force, energy };
constexpr Names<3> names(StepQuantity) { return {"displacement", "contact-force", "energy"}; }

enum class Component { x, y, z };
constexpr Names<3> names(Component) { return {"x", "y", "z"}; }

/// Mass of the candidates' nodes (docs/method.md section 2). consistent: unchanged; massless: moved to
/// neighbouring nodes along the contact normal ν; massless_tangential: moved along the tangents.
enum class ContactMass { consistent, massless, massless_tangential };
constexpr Names<3> names(ContactMass) { return {"consistent", "massless", "massless-tangential"}; }

/// Treatment of contact in the time stepping (docs/method.md section 2), from the keys time.scheme and
/// contact.mass. mixed: contact-implicit steps in which the candidates of some, but not all, obstacles have
/// no mass.
enum class ContactScheme { contact_implicit, contact_stabilized, massless, mixed };
constexpr Names<4> names(ContactScheme) {
  return {"contact-implicit", "contact-stabilized", "massless", "mixed"};
}
/// Whether a scheme has candidates without mass.
constexpr bool has_massless_candidates(ContactScheme scheme) {
  return scheme == ContactScheme::massless || scheme == ContactScheme::mixed;
}

/// Treatment of nodes that start inside an obstacle. outside: they are an error; project: they are moved out.
enum class ContactStart { outside, project };
constexpr Names<2> names(ContactStart) { return {"outside", "project"}; }

/// Meaning of a material's elastic constants: those at the instant of loading, or those after relaxation.
enum class Moduli { instantaneous, long_term };
constexpr Names<2> names(Moduli) { return {"instantaneous", "long-term"}; }

/// Shapes of obstacles, in the order of scene::Obstacle.
enum class Shape { half_space, ball, cylinder, signed_distance };
constexpr Names<4> names(Shape) { return {"half-space", "ball", "cylinder", "signed-distance"}; }

/// Side of contact between two parts of the body whose nodes are the candidates.
enum class ContactSide { on, against };
constexpr Names<2> names(ContactSide) { return {"on", "against"}; }

/// Side of a round obstacle's surface on which the body is.
enum class Side { outside, inside };
constexpr Names<2> names(Side) { return {"outside", "inside"}; }

/// Kind of a control's values: one at each node, or one in each cell.
enum class ControlValues { nodal, cellwise };
constexpr Names<2> names(ControlValues) { return {"nodal", "cellwise"}; }

/// Numbers of a scene that may be unknown; docs/method.md section 9.
enum class Parameter {
  young,
  poisson,
  bulk,
  shear,
  alpha,
  beta,
  prony_g,
  prony_k,
  prony_time,
  density,
  displacement,
  velocity,
  position,
  angle,
  center,
  radius,
  height,
  body,
  gravity,
  traction,
  normal_stiffness,
  tangential_stiffness,
  normal_damping,
  tangential_damping,
  friction,
  surface_velocity,
  mass,
  inertia,
  rigid_velocity,
  spring_stiffness,
  dashpot_damping
};
constexpr Names<31> names(Parameter) {
  return {"young",
          "poisson",
          "bulk",
          "shear",
          "rayleigh.alpha",
          "rayleigh.beta",
          "prony.g",
          "prony.k",
          "prony.time",
          "density",
          "initial.displacement",
          "initial.velocity",
          "position",
          "angle",
          "center",
          "radius",
          "height",
          "load.body",
          "load.gravity",
          "load.traction",
          "stiffness.normal",
          "stiffness.tangential",
          "damping.normal",
          "damping.tangential",
          "friction",
          "surface_velocity",
          "mass",
          "inertia",
          "velocity",
          "stiffness",
          "damping"};
}

/// Scale on which a fit varies an unknown and reports its uncertainty.
enum class ParameterScale { linear, logarithmic };
constexpr Names<2> names(ParameterScale) { return {"linear", "log"}; }

/// Measured quantity; docs/method.md section 10.
enum class Quantity {
  displacement,
  velocity,
  force,
  impulse,
  contact_start,
  contact_time,
  impulse_duration,
  sustained_peak
};
constexpr Names<8> names(Quantity) {
  return {"displacement", "velocity",         "force",         "impulse", "contact-start",
          "contact-time", "impulse-duration", "sustained-peak"};
}

/// Method of a search; docs/method.md section 6.
enum class OptimizerMethod { lbfgs, newton_cg, projected_gradient, gauss_newton };
constexpr Names<4> names(OptimizerMethod) {
  return {"lbfgs", "newton-cg", "projected-gradient", "gauss-newton"};
}

/// Start of a search: coarse: the optimum on a coarser mesh with longer steps; guess: the first guess.
enum class SearchStart { coarse, guess };
constexpr Names<2> names(SearchStart) { return {"coarse", "guess"}; }

/// Solver of the variational inequalities: condensed: on the candidates alone; full: PETSc's, on all
/// unknowns.
enum class ViMethod { condensed, full };
constexpr Names<2> names(ViMethod) { return {"condensed", "full"}; }

/// Solver of linear systems with the step matrix D; automatic: chosen by memory and estimated run time.
enum class LinearMethod { automatic, direct, iterative };
constexpr Names<3> names(LinearMethod) { return {"auto", "direct", "iterative"}; }

/// Storage of a motion's states for the adjoint sweep.
enum class Storage { memory, disk, checkpoints };
constexpr Names<3> names(Storage) { return {"memory", "disk", "checkpoints"}; }

/// Reaction to a violated invariant: warn: a warning at the end; stop: a stop at the step; off: no check.
enum class OnViolation { warn, stop, off };
constexpr Names<3> names(OnViolation) { return {"warn", "stop", "off"}; }

enum class StoredField {
  displacement,
  velocity,
  control,
  adjoint,
  strain,
  stress,
  von_mises,
  pressure,
  friction
};
constexpr Names<9> names(StoredField) {
  return {"displacement", "velocity",  "control",  "adjoint", "strain",
          "stress",       "von_mises", "pressure", "friction"};
}

enum class FieldFormat { xdmf, vtkhdf };
constexpr Names<2> names(FieldFormat) { return {"xdmf", "vtkhdf"}; }

enum class StoredTable {
  steps,
  contact,
  obstacles,
  bodies,
  probes,
  history,
  parameters,
  measurements,
  scenarios
};
constexpr Names<9> names(StoredTable) {
  return {"steps",   "contact",    "obstacles",    "bodies",   "probes",
          "history", "parameters", "measurements", "scenarios"};
}

/// Name of an enumerator in scene files.
template <class E>
std::string name(E value) {
  return std::string(names(value)[static_cast<std::size_t>(value)]);
}

/// Names of all enumerators of E in scene files.
template <class E>
std::vector<std::string> all_names() {
  const auto all = names(E{});
  return {all.begin(), all.end()};
}

} // namespace signorini::scene
