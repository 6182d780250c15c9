// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/summary_lines.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::drivers {
namespace {

using Body = diagnostics::BodyFigures;

/// Text of the first `dim` components of a vector; components below 1e-9 of the largest one are written as 0.
std::string components(std::array<double, 3> x, int dim) {
  constexpr double rounding = 1e-9;
  const double largest = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
  for (double& component : x)
    if (std::abs(component) < rounding * largest)
      component = 0;
  return fmt::format("({:.4g})", fmt::join(x.begin(), x.begin() + dim, ", "));
}

/// Text on the sum `normal` of the moduli of nodal forces if it exceeds their resultant by more than 0.1 % of
/// the sum; else empty.
std::string by_modulus(double resultant, double normal) {
  constexpr double alike = 1e-3;
  return normal - resultant > alike * normal
             ? fmt::format(" ({:.4g} if magnitudes at nodes are added)", normal)
             : "";
}

std::string nearest(const diagnostics::Touch& touch) {
  return fmt::format("the least gap was {:.4g} m, at {:.6g} s", touch.least_gap, touch.least_gap_time);
}

std::string touch_line(const std::string& name, const diagnostics::Touch& touch, const Body& body) {
  if (!touch.occurred())
    return fmt::format("  {}: not touched; {}", name, nearest(touch));
  const std::string closed = touch.contact_time < 0.999 * (touch.end - touch.start)
                                 ? fmt::format(", with a force during {:.4g} s", touch.contact_time)
                                 : "";
  const std::array<double, 3>& J = touch.impulse;
  return fmt::format(
      "  {}: from {:.6g} to {:.6g} s{}, impulse {}{} {}, peak of two-step means {:.4g}{} {} at {:.6g} s{}\n"
      "    1 to 99 % of the impulse within {:.4g} s, sustained peak of normal forces {:.4g} {} "
      "(largest mean over {:.3g} s)",
      name, touch.start, touch.end, closed, components(J, body.dim),
      by_modulus(std::hypot(J[0], J[1], J[2]), touch.normal_impulse), "N s" + body.per_depth, touch.peak,
      by_modulus(touch.peak, touch.normal_peak), "N" + body.per_depth, touch.peak_time,
      touch.peak_at_onset ? ", as contact begins" : "", touch.impulse_duration, touch.sustained_peak,
      "N" + body.per_depth, touch.sustained_over);
}

/// Text on the velocities before and after a rebound, and its restitution.
std::string velocities(const diagnostics::Rebound& rebound, bool ended, const diagnostics::Impact& impact,
                       int dim) {
  return fmt::format("{} m/s before, {} m/s {}{}", components(rebound.before, dim),
                     components(rebound.after, dim), ended ? "after" : "at the end, still in contact",
                     rebound.restitution
                         ? fmt::format("; restitution {:.4g}{}", *rebound.restitution,
                                       rebound.obstacle_after ? " relative to " + impact.other : "")
                         : "");
}

std::string bounce_line(const diagnostics::Impact& impact, std::size_t number, const Body& body) {
  const diagnostics::Rebound& one = impact.bounces[number];
  const std::size_t of = impact.bounces.size();
  const bool ended = number + 1 < of || impact.ended;
  return fmt::format(
      "  bounce {} of {}: from {:.6g} to {:.6g} s{}, impulse {} {}, peak of normal forces {:.4g} {}; {}",
      number + 1, of, one.start, one.end, one.touches > 1 ? fmt::format(" in {} touches", one.touches) : "",
      components(one.impulse, body.dim), "N s" + body.per_depth, one.peak, "N" + body.per_depth,
      velocities(one, ended, impact, body.dim));
}

/// Adds a line for each of the first five bounces, if there are several bounces.
void add_bounces(const diagnostics::Impact& impact, const Body& body, std::vector<std::string>& lines) {
  constexpr std::size_t most = 5;
  const std::size_t number = impact.bounces.size();
  for (std::size_t i = 0; number > 1 && i < std::min(number, most); ++i)
    lines.push_back(bounce_line(impact, i, body));
  if (number > most)
    lines.emplace_back("  the others are in run.json, as impact.bounces");
}

/// Number of bounces and touches as text; empty for a single touch.
std::string over_all(const diagnostics::Impact& impact) {
  const std::size_t bounces = impact.bounces.size(), touches = static_cast<std::size_t>(impact.whole.touches);
  if (touches == 1)
    return "";
  const std::string text = bounces == 1 ? " over one bounce" : fmt::format(" over all {} bounces", bounces);
  return touches == bounces ? text : text + fmt::format(" of {} touches", touches);
}

void add_impact(const diagnostics::Impact& impact, const Body& body, std::vector<std::string>& lines) {
  if (!impact.all.occurred()) {
    lines.push_back("contact: none; " + nearest(impact.all));
    return;
  }
  lines.emplace_back("contact (impulse, its time from 1 to 99 % and, if the force is smooth, the sustained "
                     "peak converge; touch times and peaks of two-step means need not):");
  for (const diagnostics::Touch& one : impact.obstacles)
    lines.push_back(touch_line(one.name, one, body));
  if (std::ranges::count_if(impact.obstacles, &diagnostics::Touch::occurred) > 1)
    lines.push_back(touch_line("all together", impact.all, body));
  lines.push_back("  velocity of the centre of mass" + (impact.body.empty() ? "" : " of " + impact.body) +
                  ": " + velocities(impact.whole, impact.ended, impact, body.dim) + over_all(impact) +
                  (impact.whole.restitution ? "" : "; no restitution: " + impact.no_restitution));
  if (impact.whole.obstacle_before && impact.whole.obstacle_after)
    lines.push_back(fmt::format("  velocity of {}: {} m/s before, {} m/s after", impact.other,
                                components(*impact.whole.obstacle_before, body.dim),
                                components(*impact.whole.obstacle_after, body.dim)));
  for (const diagnostics::BodyImpact& one : impact.bodies)
    lines.push_back(fmt::format("  {}: {:.4g} kg{}, velocity {} m/s at the start, {} m/s at the end",
                                one.name, one.mass, body.per_depth, components(one.at_start, body.dim),
                                components(one.at_end, body.dim)));
  add_bounces(impact, body, lines);
}

void add_energy(const diagnostics::EnergyAccount& energy, const Body& body, std::vector<std::string>& lines) {
  const double start = energy.kinetic_at_start + energy.elastic_at_start + energy.foundation_at_start +
                       energy.rigid_at_start,
               end = energy.kinetic_at_end + energy.elastic_at_end + energy.foundation_at_end +
                     energy.relaxation_at_end + energy.rigid_at_end;
  const bool foundations = energy.foundation_at_start > 0 || energy.foundation_at_end > 0,
             branches = energy.relaxation_at_end > 0,
             rigid = energy.rigid_at_start > 0 || energy.rigid_at_end > 0;
  std::vector<const char*> others;
  for (const auto& [is, what] : {std::pair(foundations, "foundations"), std::pair(branches, "branches"),
                                 std::pair(rigid, "obstacles")})
    if (is)
      others.push_back(what);
  std::string text = fmt::format("energy, kinetic and elastic{}{}: {:.4g} {} at the start",
                                 others.empty() ? "" : ", with that of ", fmt::join(others, " and "), start,
                                 "J" + body.per_depth);
  constexpr double rounding = 1e-12;
  const double largest =
      std::max({start, std::abs(energy.load_work), std::abs(energy.other_work), std::abs(energy.contact_work),
                energy.viscous_dissipation, energy.foundation_dissipation, energy.drag_dissipation,
                energy.relaxation_dissipation, energy.rigid_dissipation});
  const auto add = [&](const char* by, double work) {
    if (std::abs(work) > rounding * largest)
      text += fmt::format(", {:+.4g} by {}", work, by);
  };
  add("loads", energy.load_work);
  add("control and clamps", energy.other_work);
  add("contact", energy.normal_work());
  add("friction", energy.friction_work);
  add("moving surfaces", energy.belt_work);
  add("viscosity", -energy.viscous_dissipation);
  add("dashpots of foundations", -energy.foundation_dissipation);
  add("mass damping", -energy.drag_dissipation);
  add("relaxation", -energy.relaxation_dissipation);
  add("dashpots of obstacles", -energy.rigid_dissipation);
  text += fmt::format(": {:.4g} at the end, {:.4g} of it elastic", end, energy.elastic_at_end);
  if (foundations)
    text += fmt::format(", {:.4g} in foundations", energy.foundation_at_end);
  if (branches)
    text += fmt::format(", {:.4g} in branches", energy.relaxation_at_end);
  if (rigid)
    text += fmt::format(", {:.4g} in obstacles", energy.rigid_at_end);
  lines.push_back(std::move(text));
}

/// Line on a peak of a probe, its acceleration also in units of standard gravity g.
std::string peak_line(const diagnostics::ProbePeak& one, const Body& body) {
  constexpr double standard_gravity = 9.80665; // m/s²
  const bool acceleration = one.quantity == "acceleration";
  const auto text = [&](const diagnostics::Peak& peak) {
    return acceleration ? fmt::format("{:.4g} m/s² ({:.3g} g) at {:.6g} s", peak.value,
                                      peak.value / standard_gravity, peak.time)
                        : fmt::format("{:.4g} N{} at {:.6g} s", peak.value, body.per_depth, peak.time);
  };
  std::string line =
      fmt::format("probe \"{}\": peak {} {} (mean of two steps)", one.probe, one.quantity, text(one.mean));
  if (one.channel_class)
    line += fmt::format(
        ", with CFC {:.6g} {}{}", *one.channel_class, text(one.filtered),
        one.at_end ? ", so near to the end that it depends on what comes later: set a later time.end" : "");
  return line;
}

} // namespace

std::vector<std::string> summary_lines(const io::Manifest& manifest) {
  std::vector<std::string> lines;
  if (manifest.impact)
    add_impact(*manifest.impact, manifest.body, lines);
  if (manifest.energy)
    add_energy(*manifest.energy, manifest.body, lines);
  for (const diagnostics::ProbePeak& one : manifest.probes)
    lines.push_back(peak_line(one, manifest.body));
  if (manifest.von_mises)
    lines.push_back(fmt::format(
        "largest stored von Mises stress: {:.4g} Pa in the cell at {} m, {:.6g} s{}; {:.4g} Pa recovered "
        "from the cells around it",
        manifest.von_mises->stress.largest.value,
        components(manifest.von_mises->stress.largest.at, manifest.dim), manifest.von_mises->time,
        stress_at_onset(manifest) ? ", as contact begins" : "", manifest.von_mises->stress.recovered));
  return lines;
}

std::string cost_line(const io::Manifest& manifest, const scene::Scene& scene, const Timers& timers,
                      double bytes) {
  const auto seconds = [&](const char* phase) {
    const auto found = timers.entries().find(phase);
    return found == timers.entries().end() ? 0.0 : found->second.seconds;
  };
  const bool fields = scene.output.field(scene::StoredField::displacement) ||
                      scene.output.field(scene::StoredField::velocity);
  std::string text = fmt::format(
      "{} steps in {:.2g} s, their balances in {:.2g} s, output in {:.2g} s: {:.3g} MB", manifest.steps_done,
      seconds("forward"), seconds("balances"), seconds("output"), bytes / 1e6);
  if (fields || scene.output.table(scene::StoredTable::contact))
    text += scene.output.every == 0
                ? fmt::format(", fields and contact at {} times (output.every = 1 stores every step)",
                              manifest.stored)
                : fmt::format(", fields and contact of {} (output.every = {})",
                              scene.output.every == 1
                                  ? "every step"
                                  : fmt::format("one step in {}{}", scene.output.every,
                                                scene.contacts.empty() ? ""
                                                                       : " and of the step with the largest "
                                                                         "force"),
                              scene.output.every);
  constexpr double noticeable = 1; // s
  if (seconds("output") > std::max({noticeable, 2 * seconds("forward"), seconds("balances")}))
    text += "; output took longest: store less by output.every, output.fields or output.tables";
  return text;
}

} // namespace signorini::drivers
