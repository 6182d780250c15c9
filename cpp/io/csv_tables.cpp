// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/csv_tables.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <limits>
#include <sstream>

namespace signorini::io {

namespace {

constexpr const char* axes[] = {"x", "y", "z"};

} // namespace

StepsColumns StepsColumns::of(const scene::Scene& scene, bool tracking) {
  return {tracking,
          !scene.foundations.empty(),
          std::ranges::any_of(scene.materials, &scene::Material::dragged),
          std::ranges::any_of(scene.materials, &scene::Material::relaxes),
          scene.frictional(),
          scene.rigid()};
}

std::string steps_header(int dim, const StepsColumns& columns) {
  std::string text = "step,time,kinetic_energy,elastic_energy,viscous_dissipation,external_work,contact_work,"
                     "energy_residual,";
  for (int c = 0; c < dim; ++c)
    text += fmt::format("contact_force_{},", axes[c]);
  return text + fmt::format("active,weak,min_gap,vi_iterations,momentum_residual,complementarity{},"
                            "normal_force,load_work{}{}{}{}{}\n",
                            columns.tracking ? ",tracking_error" : "",
                            columns.foundation ? ",foundation_energy,foundation_dissipation" : "",
                            columns.drag ? ",drag_dissipation" : "",
                            columns.relaxation ? ",relaxation_energy,relaxation_dissipation" : "",
                            columns.friction ? ",friction_work,belt_work,slip,stick" : "",
                            columns.rigid ? ",rigid_energy,rigid_dissipation" : "");
}

void add_steps_row(std::string& text, const StepsColumns& columns, int k, double time, int dim,
                   const diagnostics::StepBalance& balance, const diagnostics::Invariants& invariants,
                   const contact::ContactState& contact, double normal_force, double tracking_error) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{},{:.10g},{},{},{},{},{},{:.6e},", k, time, balance.kinetic_energy,
                 balance.elastic_energy, balance.viscous_dissipation, balance.external_work,
                 balance.contact_work, balance.energy_residual);
  for (int c = 0; c < dim; ++c)
    fmt::format_to(out, "{},", balance.contact_force[static_cast<std::size_t>(c)]);
  const int weak = contact.count(contact::Status::weak);
  const double least =
      contact.gap.empty() ? std::numeric_limits<double>::quiet_NaN() : std::ranges::min(contact.normal_gap());
  fmt::format_to(out, "{},{},{},{},{:.3e},{:.3e}", contact.count(contact::Status::strong) + weak, weak, least,
                 contact.vi_iterations, invariants.momentum(), invariants.complementarity());
  if (columns.tracking)
    fmt::format_to(out, ",{}", tracking_error);
  fmt::format_to(out, ",{},{}", normal_force, balance.load_work);
  if (columns.foundation)
    fmt::format_to(out, ",{},{}", balance.foundation_energy, balance.foundation_dissipation);
  if (columns.drag)
    fmt::format_to(out, ",{}", balance.drag_dissipation);
  if (columns.relaxation)
    fmt::format_to(out, ",{},{}", balance.relaxation_energy, balance.relaxation_dissipation);
  if (columns.friction)
    fmt::format_to(out, ",{},{},{},{}", balance.friction_work, balance.belt_work,
                   contact.count(contact::Motion::slips), contact.count(contact::Motion::sticks));
  if (columns.rigid)
    fmt::format_to(out, ",{},{}", balance.rigid_energy, balance.rigid_dissipation);
  text += '\n';
}

void History::add(const Row& row) {
  const bool first = columns.empty();
  for (const auto& [column, value] : row) {
    if (first)
      columns.push_back(column);
    numbers.push_back(value);
  }
}

double History::at(std::size_t row, const std::string& column) const {
  const auto found = std::ranges::find(columns, column);
  return numbers.at(row * columns.size() + static_cast<std::size_t>(found - columns.begin()));
}

std::string History::table() const {
  std::string all = fmt::format("{}\n", fmt::join(columns, ","));
  for (std::size_t row = 0; row < rows(); ++row)
    all += text(row);
  return all;
}

std::string History::text(std::size_t row) const {
  std::string line;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const double value = numbers[row * columns.size() + c];
    const char* end = c + 1 == columns.size() ? "\n" : ",";
    line += columns[c] == "seconds" ? fmt::format("{:.3f}{}", value, end) : fmt::format("{}{}", value, end);
  }
  return line;
}

std::vector<std::string> History::split(const std::string& header) {
  std::vector<std::string> names;
  std::istringstream in(header);
  for (std::string name; std::getline(in, name, ',');)
    names.push_back(name);
  return names;
}

std::string obstacles_header(int dim) {
  return fmt::format("step,time,obstacle,force_x,force_y,{}normal_force,active,min_gap\n",
                     dim == 3 ? "force_z," : "");
}

void add_obstacle_rows(std::string& text, int k, double time, int dim,
                       const std::vector<scene::Contact>& contacts,
                       const diagnostics::ObstacleForces& forces) {
  auto out = std::back_inserter(text);
  for (std::size_t o = 0; o < contacts.size(); ++o) {
    const diagnostics::ObstacleForce& one = forces.each()[o];
    fmt::format_to(out, "{},{:.10g},{}", k, time, contacts[o].name);
    for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c)
      fmt::format_to(out, ",{}", one.force[c]);
    fmt::format_to(out, ",{},{},{}\n", one.normal_force, one.active, one.min_gap);
  }
}

std::string bodies_header(int dim) {
  std::string text = "step,time,body";
  for (const char* of : {"displacement", "momentum"})
    for (const char* component : {"x", "y", "z"})
      if (dim == 3 || *component != 'z')
        text += fmt::format(",{}_{}", of, component);
  return text + ",kinetic_energy,elastic_energy\n";
}

void add_body_rows(std::string& text, int k, double time, int dim, const diagnostics::Bodies& bodies) {
  auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < bodies.all().size(); ++i) {
    const diagnostics::BodyMotion& motion = bodies.motions()[i];
    fmt::format_to(out, "{},{:.10g},{}", k, time, bodies.all()[i].name);
    for (const std::array<double, 3>& of : {motion.displacement, motion.momentum})
      for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c)
        fmt::format_to(out, ",{}", of[c]);
    fmt::format_to(out, ",{},{}\n", motion.kinetic_energy, motion.elastic_energy);
  }
}

std::string probes_header(const std::vector<std::string>& columns) {
  std::string text = "step,time";
  for (const std::string& column : columns)
    text += "," + column;
  return text + "\n";
}

void add_probes_row(std::string& text, int k, double time, std::span<const double> values) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{},{:.10g}", k, time);
  for (const double value : values)
    fmt::format_to(out, ",{}", value);
  text += '\n';
}

ContactTable::ContactTable(const contact::ContactPairs& pairs, const contact::Pressure& pressure,
                           const std::vector<scene::Contact>& contacts)
    : pairs_(pairs), dim_(pairs.dim()), pressure_(pressure), fixed_(static_cast<std::size_t>(pairs.count())),
      friction_(std::ranges::any_of(contacts, &scene::Contact::frictional)) {
  const auto dim = static_cast<std::size_t>(dim_);
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    auto point = std::back_inserter(fixed_[i].point), surface = std::back_inserter(fixed_[i].surface);
    fmt::format_to(surface, ",{}", contacts[static_cast<std::size_t>(pairs.obstacles()[i])].name);
    for (std::size_t c = 0; c < dim; ++c) {
      fmt::format_to(point, ",{}", pairs.points()[3 * i + c]);
      fmt::format_to(surface, ",{}", 0 - pairs.normals()[dim * i + c]); // 0 − 0 is no −0
    }
    fmt::format_to(surface, ",{}", pressure.area()[i]);
  }
}

std::string ContactTable::header() const {
  std::string text =
      dim_ == 3 ? "step,time,x,y,z,gap,force,obstacle,normal_x,normal_y,normal_z,area,pressure,status"
                : "step,time,x,y,gap,force,obstacle,normal_x,normal_y,area,pressure,status";
  if (friction_) {
    for (const char* vector : {"tangential_force", "slip_velocity"})
      for (int c = 0; c < dim_; ++c)
        text += fmt::format(",{}_{}", vector, axes[c]);
    text += ",motion";
  }
  return text + "\n";
}

void ContactTable::add_rows(std::string& text, const step::TimeStep& step,
                            const contact::ContactState& contact) const {
  const double impulse = step.scheme().impulse();
  const std::vector<double> pressure = pressure_(contact.normal_lambda(), impulse);
  const std::string when = fmt::format("{},{:.10g}", step.k, step.end);
  const std::vector<contact::Motion> motions = friction_ ? contact.motions() : std::vector<contact::Motion>();
  auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    fmt::format_to(out, "{}{},{},{}{},{},{}", when, fixed_[i].point, contact.gap[i],
                   contact.lambda[i] / impulse, fixed_[i].surface, pressure[i],
                   contact::name(contact.status[i]));
    if (friction_) {
      add_along(text, static_cast<int>(i), contact.lambda, -1 / impulse);
      add_along(text, static_cast<int>(i), contact.gap, step.k > 0 ? -1 / step.tau : 0); // w = −U_t
      fmt::format_to(out, ",{}", contact::name(motions[i]));
    }
    text += '\n';
  }
}

void ContactTable::add_along(std::string& text, int pair, std::span<const double> rows, double factor) const {
  const contact::ConstraintRows& H = pairs_.rows();
  std::array<double, 3> vector{};
  for (std::size_t c = 1; c < H.size(pair); ++c)
    for (std::size_t component = 0; component < static_cast<std::size_t>(dim_); ++component)
      vector[component] +=
          factor * rows[H.row(pair, c)] * H.lift(static_cast<int>(H.row(pair, c)))[component];
  for (std::size_t component = 0; component < static_cast<std::size_t>(dim_); ++component)
    fmt::format_to(std::back_inserter(text), ",{}", vector[component] + 0.0); // no −0
}

} // namespace signorini::io
