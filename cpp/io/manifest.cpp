// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/manifest.h"
#include "base/machine.h"
#include "base/timers.h"
#include "io/csv_tables.h"
#include "version.h"
#include <algorithm>
#include <chrono>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <gmsh.h>
#include <nlohmann/json.hpp>
#include <petscversion.h>
#include <unistd.h>

namespace signorini::io {

std::vector<std::pair<std::string, bool>> effects(const scene::Scene& scene) {
  const auto given = [](const std::optional<scene::Components>& field) {
    return field && !scene::vanishes(*field);
  };
  const auto moves = [](const scene::Clamp& clamp) { return clamp.value && !scene::vanishes(*clamp.value); };
  const auto obstacle_moves = [](const scene::Contact& contact) { return scene::moves(contact); };
  const auto& objective = scene.objective;
  const scene::ContactScheme scheme = scene.contact_scheme();
  const bool viscous = std::ranges::any_of(scene.materials, &scene::Material::viscous);
  return {
      {"several materials", scene.materials.size() > 1},
      {"viscosity", viscous},
      {"mass damping", std::ranges::any_of(scene.materials, &scene::Material::dragged)},
      {"relaxation", scene.relaxes()},
      {"foundation", !scene.foundations.empty()},
      {"clamp", !scene.clamps.empty()},
      {"moving clamp", std::ranges::any_of(scene.clamps, moves)},
      {"contact", !scene.contacts.empty()},
      {"contact of parts", scene.several_bodies()},
      {"friction", scene.frictional()},
      {"rigid body", scene.rigid()},
      {"drop", scene.initial.drop.has_value()},
      {"static start", scene.initial.equilibrium},
      {"steps of varying length", scene.time.automatic()},
      {"contact-stabilized", !scene.contacts.empty() && scheme == scene::ContactScheme::contact_stabilized},
      {"massless contact", std::ranges::any_of(scene.contacts, &scene::Contact::loses_mass)},
      {"moving obstacle", std::ranges::any_of(scene.contacts, obstacle_moves)},
      {"body load", scene.load && given(scene.load->body)},
      {"gravity", scene.load && given(scene.load->gravity)},
      {"traction", scene.load && !scene.load->tractions.empty()},
      {"point force", scene.load && !scene.load->points.empty()},
      {"initial displacement", given(scene.initial.displacement)},
      {"initial velocity", given(scene.initial.velocity)},
      {"control", scene.control.has_value()},
      {"control bounds", scene.control && (scene.control->lower || scene.control->upper)},
      {"objective", objective.has_value()},
      {"tracking term", objective && objective->tracking > 0},
      {"terminal term", objective && objective->gamma > 0},
      {"control cost", objective && objective->alpha > 0},
      {"scenarios", !scene.scenarios.empty()},
      {"stored fields", !scene.output.fields.empty()},
      {"tables", !scene.output.tables.empty()},
      {"probes", !scene.output.probes.empty()},
      {"unknowns", !scene.unknowns.empty()},
      {"measurements", !scene.measurements.empty()}};
}

std::string scenarios_table(const std::vector<ScenarioResult>& scenarios) {
  std::string text = "scenario,weight,share,objective,tracking,terminal\n";
  for (const ScenarioResult& one : scenarios)
    text += fmt::format("{},{},{},{},{},{}\n", one.name, one.weight, one.share, one.value.total(),
                        one.value.tracking, one.value.terminal);
  return text;
}

nlohmann::ordered_json versions() {
  return {
      {"signorini", SIGNORINI_VERSION},
      {"dolfinx", DOLFINX_VERSION},
      {"petsc", fmt::format("{}.{}.{}", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR)},
      {"gmsh", GMSH_API_VERSION}};
}

std::string version_line() {
  std::string text;
  const nlohmann::ordered_json all = versions();
  for (const auto& [name, version] : all.items())
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, version.get<std::string>());
  return text;
}

namespace {

using nlohmann::ordered_json;

ordered_json vector(const std::array<double, 3>& x, int dim) {
  return std::vector<double>(x.begin(), x.begin() + dim);
}

/// Writes a touch as JSON; start, end and time of the peak are null if there was no contact.
ordered_json touch(const diagnostics::Touch& one, int dim, bool friction) {
  const auto if_any = [&](double value) { return one.occurred() ? ordered_json(value) : ordered_json(); };
  ordered_json json;
  if (!one.name.empty())
    json["name"] = one.name;
  json["start"] = if_any(one.start);
  json["end"] = if_any(one.end);
  json["duration"] = one.end - one.start;
  json["contact_time"] = one.contact_time;
  json["impulse"] = vector(one.impulse, dim);
  json["normal_impulse"] = one.normal_impulse;
  if (friction)
    json["friction_impulse"] = vector(one.friction_impulse, dim);
  json["peak"] = one.peak;
  json["peak_time"] = if_any(one.peak_time);
  json["peak_at_onset"] = one.peak_at_onset;
  json["normal_peak"] = one.normal_peak;
  json["largest_step"] = one.largest_step;
  json["impulse_duration"] = one.impulse_duration;
  json["sustained_peak"] = one.sustained_peak;
  json["sustained_over"] = one.sustained_over;
  json["least_gap"] = one.least_gap;
  json["least_gap_time"] = one.least_gap_time;
  return json;
}

/// Writes a number as JSON; null if the number is absent.
ordered_json number(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json();
}

ordered_json bounce(const diagnostics::Rebound& one, int dim) {
  return {{"start", one.start},
          {"end", one.end},
          {"touches", one.touches},
          {"impulse", vector(one.impulse, dim)},
          {"peak", one.peak},
          {"velocity_before", vector(one.before, dim)},
          {"velocity_after", vector(one.after, dim)},
          {"restitution", number(one.restitution)}};
}

ordered_json impact_json(const diagnostics::Impact& impact, int dim, bool friction) {
  const auto if_any = [&](const std::array<double, 3>& velocity) {
    return impact.all.occurred() ? vector(velocity, dim) : ordered_json();
  };
  ordered_json json{{"mass", impact.mass}, {"obstacles", ordered_json::array()}};
  for (const diagnostics::Touch& one : impact.obstacles)
    json["obstacles"].push_back(touch(one, dim, friction));
  json["all"] = touch(impact.all, dim, friction);
  json["ended"] = impact.ended;
  json["velocity_before"] = if_any(impact.whole.before);
  json["velocity_after"] = if_any(impact.whole.after);
  json["restitution"] = number(impact.whole.restitution);
  if (!impact.body.empty())
    json["body"] = impact.body;
  for (const diagnostics::BodyImpact& one : impact.bodies)
    json["bodies"].push_back({{"name", one.name},
                              {"mass", one.mass},
                              {"velocity_at_start", vector(one.at_start, dim)},
                              {"velocity_at_end", vector(one.at_end, dim)}});
  json["bounces"] = ordered_json::array();
  for (const diagnostics::Rebound& one : impact.bounces)
    json["bounces"].push_back(bounce(one, dim));
  return json;
}

ordered_json energy_json(const diagnostics::EnergyAccount& energy, const StepsColumns& columns) {
  ordered_json json{{"kinetic_at_start", energy.kinetic_at_start},
                    {"elastic_at_start", energy.elastic_at_start},
                    {"load_work", energy.load_work},
                    {"control_and_clamp_work", energy.other_work},
                    {"contact_work", energy.contact_work},
                    {"viscous_dissipation", energy.viscous_dissipation},
                    {"residual", energy.residual},
                    {"kinetic_at_end", energy.kinetic_at_end},
                    {"elastic_at_end", energy.elastic_at_end}};
  if (columns.friction) {
    json["friction_work"] = energy.friction_work;
    json["belt_work"] = energy.belt_work;
  }
  if (columns.foundation) {
    json["foundation_at_start"] = energy.foundation_at_start;
    json["foundation_dissipation"] = energy.foundation_dissipation;
    json["foundation_at_end"] = energy.foundation_at_end;
  }
  if (columns.drag)
    json["drag_dissipation"] = energy.drag_dissipation;
  if (columns.relaxation) {
    json["relaxation_dissipation"] = energy.relaxation_dissipation;
    json["relaxation_at_end"] = energy.relaxation_at_end;
  }
  if (columns.rigid) {
    json["rigid_at_start"] = energy.rigid_at_start;
    json["rigid_dissipation"] = energy.rigid_dissipation;
    json["rigid_at_end"] = energy.rigid_at_end;
  }
  return json;
}

ordered_json body_json(const diagnostics::BodyFigures& body) {
  return {{"model", body.model},
          {"extent", vector(body.extent, body.dim)},
          {"mass", body.mass},
          {"pressure_waves", body.pressure_waves},
          {"shear_waves", body.shear_waves},
          {"crossing_time", body.crossing},
          {"doubts", body.warnings},
          {"notes", body.notes}};
}

/// Adds the entries of a search to run.json.
void add_search(ordered_json& json, const Manifest& m, const scene::Scene& scene) {
  if (m.iterations) {
    ordered_json levels = ordered_json::array();
    for (const CoarseLevel& level : m.coarse_levels)
      levels.push_back({{"size", level.size},
                        {"step", level.step},
                        {"steps", level.steps},
                        {"free_unknowns", level.free_unknowns},
                        {"iterations", level.iterations},
                        {"forward_sweeps", level.forward_sweeps},
                        {"adjoint_sweeps", level.adjoint_sweeps},
                        {"seconds", level.seconds},
                        {"objective", level.objective},
                        {"stop_reason", level.stop_reason}});
    json["optimizer"] = {{"iterations", *m.iterations},
                         {"forward_sweeps", m.forward_sweeps.value_or(0)},
                         {"adjoint_sweeps", m.adjoint_sweeps.value_or(0)},
                         {"coarse_levels", levels}};
    if (!m.fit)
      json["optimizer"]["metric"] = scene.control->lower || scene.control->upper ? "lumped L2" : "L2";
  }
  if (m.accuracy)
    json["accuracy"] = {{"quantity", m.accuracy->quantity},
                        {"asked", m.accuracy->asked},
                        {"estimated", m.accuracy->estimated()},
                        {"space", m.accuracy->space},
                        {"time", m.accuracy->time},
                        {"search", m.accuracy->search},
                        {"met", m.accuracy->met},
                        {"doubt", m.accuracy->warning}};
  if (m.kink) {
    ordered_json weak = ordered_json::array();
    for (const WeakContact& contact : m.kink->weak)
      weak.push_back({{"motion", contact.motion},
                      {"step", contact.step},
                      {"time", contact.time},
                      {"candidate", contact.candidate},
                      {"node", contact.x}});
    json["kink"] = {{"shortest_combination", m.kink->length},
                    {"radius", m.kink->radius},
                    {"gradients", m.kink->gradients},
                    {"weak_contact", weak}};
  }
}

/// Adds the entries of a fit to run.json; numbers that are not finite become null.
void add_fit(ordered_json& json, const Fit& fit) {
  json["unknowns_fitted"] = ordered_json::array();
  for (const FittedUnknown& one : fit.unknowns)
    json["unknowns_fitted"].push_back({{"name", one.name},
                                       {"of", one.quantity},
                                       {"unit", one.unit},
                                       {"scale", one.scale},
                                       {"value", one.value},
                                       {"standard_deviation", one.deviation},
                                       {"start", one.start},
                                       {"lower", one.lower},
                                       {"upper", one.upper},
                                       {"at_bound", one.at_bound},
                                       {"gradient", one.gradient}});
  const std::size_t n = fit.unknowns.size();
  ordered_json correlations = ordered_json::array(), measurements = ordered_json::array(),
               times = ordered_json::array();
  for (std::size_t i = 0; i < n; ++i)
    correlations.push_back(std::vector<double>(&fit.correlations[i * n], &fit.correlations[i * n] + n));
  for (const Comparison& one : fit.measurements)
    measurements.push_back({{"name", one.name}, {"values", one.times.size()}});
  for (const ComparedQuantity& one : fit.compared)
    times.push_back({{"name", one.name},
                     {"unit", one.unit},
                     {"value", one.value},
                     {"deviation", one.deviation},
                     {"simulated", one.simulated}});
  json["fit"] = {{"objective", fit.value},       {"values", fit.data},
                 {"misfit", fit.misfit},         {"decrement", number(fit.decrement)},
                 {"correlations", correlations}, {"singular_values", fit.singular_values},
                 {"not_told", fit.unidentified}, {"measurements", measurements},
                 {"contact_times", times}};
}

} // namespace

bool stress_at_onset(const Manifest& m) {
  return m.von_mises && m.impact && m.impact->begins(m.von_mises->time, m.body.crossing);
}

namespace {

ordered_json stress_json(const Manifest& m) {
  const fem::StressPeak& peak = m.von_mises->stress;
  return {{"value", peak.largest.value},
          {"recovered", peak.recovered},
          {"point", vector(peak.largest.at, m.dim)},
          {"time", m.von_mises->time},
          {"at_onset", stress_at_onset(m)}};
}

} // namespace

std::string lines(const ordered_json& json) {
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string to_json(const Manifest& m, const scene::Scene& scene, const Timers& timers) {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  ordered_json json;
  json["program"] = "signorini";
  json["verb"] = m.verb;
  json["scene"] = scene.name;
  json["stop_reason"] = m.stop_reason;
  json["finished"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::now()));
  json["versions"] = versions();
  json["host"] = {{"name", host}, {"ranks", m.ranks}, {"threads", threads()}};
  json["unknowns"] = m.unknowns;
  json["free_unknowns"] = m.free_unknowns;
  json["cells"] = m.cells;
  json["body"] = body_json(m.body);
  json["candidates"] = m.candidates;
  json["steps"] = {
      {"asked", m.steps_asked}, {"done", m.steps_done}, {"stored", m.stored}, {"wave_time", m.wave_time}};
  if (m.lengths)
    json["steps"].update({{"shortest", m.lengths->shortest},
                          {"longest", m.lengths->longest},
                          {"made_again", m.lengths->rejected},
                          {"factorisations", m.lengths->factorisations},
                          {"factorisation_seconds", m.lengths->seconds}});
  json["solver"] = m.solver;
  if (!m.control_unit.empty())
    json["control_unit"] = m.control_unit;
  for (const auto& [name, on] : effects(scene))
    json["effects"][name] = on;
  if (m.objective)
    json["objective"] = {{"value", m.objective->total()},
                         {"tracking", m.objective->tracking},
                         {"terminal", m.objective->terminal},
                         {"control_cost", m.objective->control_cost}};
  for (const ScenarioResult& one : m.scenarios)
    json["scenarios"].push_back(
        {{"name", one.name}, {"weight", one.weight}, {"share", one.share}, {"objective", one.value.total()}});
  add_search(json, m, scene);
  if (m.fit)
    add_fit(json, *m.fit);
  if (m.impact)
    json["impact"] = impact_json(*m.impact, m.dim, scene.frictional());
  if (m.von_mises)
    json["largest_von_mises"] = stress_json(m);
  for (const diagnostics::ProbePeak& one : m.probes) {
    ordered_json peak{
        {"name", one.probe}, {"quantity", one.quantity}, {"peak", one.mean.value}, {"time", one.mean.time}};
    if (one.channel_class)
      peak.update({{"cfc", *one.channel_class},
                   {"filtered_peak", one.filtered.value},
                   {"filtered_time", one.filtered.time},
                   {"filtered_at_end", one.at_end}});
    json["probe_peaks"].push_back(std::move(peak));
  }
  if (m.energy)
    json["energy"] = energy_json(*m.energy, StepsColumns::of(scene, false));
  for (const diagnostics::Invariants::Defect& defect : m.invariants)
    json["invariants"][defect.name] = {{"worst", defect.worst}, {"step", defect.step}};
  json["warnings"] = ordered_json::array();
  for (const Warning& warning : m.warnings)
    json["warnings"].push_back({{"name", warning.name},
                                {"message", warning.message},
                                {"value", warning.value},
                                {"limit", warning.limit}});
  for (const auto& [phase, entry] : timers.entries())
    json["timings"][phase] = {{"seconds", entry.seconds}, {"calls", entry.calls}};
  json["files"] = m.files;
  json["counters"] = counts();
  json["peak_memory_bytes"] = m.peak_memory;
  return lines(json);
}

} // namespace signorini::io
