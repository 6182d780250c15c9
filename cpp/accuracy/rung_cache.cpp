// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/rung_cache.h"
#include "base/digest.h"
#include "base/error.h"
#include "io/manifest.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

namespace signorini::accuracy {
namespace {

using Json = nlohmann::json;

constexpr const char* rungs_folder = "rungs";
const io::FolderLock::Names file_names{"study.csv", "study.json", "search.csv", rungs_folder};

Json packed(const std::vector<double>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(double));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return Json::binary(std::move(bytes));
}

std::vector<double> unpacked(const Json& json) {
  const auto& bytes = json.get_binary();
  std::vector<double> values(bytes.size() / sizeof(double));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(double));
  return values;
}

Json to_json(const Measured& measured) {
  Json json{{"unknowns", measured.unknowns}, {"steps", measured.steps},     {"seconds", measured.seconds},
            {"memory", measured.memory},     {"numbers", measured.numbers}, {"fields", Json::object()}};
  for (const auto& [name, values] : measured.fields)
    json["fields"][name] = packed(values);
  json["warnings"] = Json::array();
  for (const Warning& one : measured.warnings)
    json["warnings"].push_back({one.name, one.message, one.value, one.limit});
  if (const auto& estimate = measured.estimate) {
    json["estimate"] = {
        {"time", estimate->time}, {"initial", estimate->initial}, {"desired", estimate->desired}};
    if (estimate->space)
      json["estimate"]["space"] = *estimate->space;
  }
  return json;
}

Measured from_json(const Json& json) {
  Measured measured;
  measured.unknowns = json.at("unknowns");
  measured.steps = json.at("steps");
  measured.seconds = json.at("seconds");
  measured.memory = json.at("memory");
  measured.numbers = json.at("numbers").get<std::map<std::string, double>>();
  for (const auto& [name, values] : json.at("fields").items())
    measured.fields[name] = unpacked(values);
  for (const Json& one : json.at("warnings"))
    measured.warnings.push_back({one.at(0), one.at(1), one.at(2), one.at(3)});
  if (json.contains("estimate")) {
    const Json& parts = json.at("estimate");
    measured.estimate = {std::nullopt, parts.at("time"), parts.at("initial"), parts.at("desired")};
    if (parts.contains("space"))
      measured.estimate->space = parts.at("space");
  }
  return measured;
}

Json to_json(const SearchCost& search) {
  return {{"tolerance", search.tolerance},           {"J", search.objective},
          {"iterations", search.iterations},         {"forward_sweeps", search.forward_sweeps},
          {"adjoint_sweeps", search.adjoint_sweeps}, {"seconds", search.seconds},
          {"stop_reason", search.stop_reason}};
}

SearchCost search_from(const Json& json) {
  return {.tolerance = json.at("tolerance"),
          .objective = json.at("J"),
          .iterations = json.at("iterations"),
          .forward_sweeps = json.at("forward_sweeps"),
          .adjoint_sweeps = json.at("adjoint_sweeps"),
          .seconds = json.at("seconds"),
          .stop_reason = json.at("stop_reason")};
}

std::string digest_of(const std::vector<std::uint8_t>& bytes) {
  return Digest().add({reinterpret_cast<const char*>(bytes.data()), bytes.size()}).text();
}

constexpr const char* damaged = "its file is damaged, or from another version of this program";

/// Loads the content that store_kept() wrote to a file; absent if the file is missing, damaged or has another
/// fingerprint. In the last two cases `unfit` receives the reason. Throws Json::exception.
std::optional<Json> load_kept(const std::filesystem::path& file, const Fingerprint& fingerprint,
                              std::string& unfit) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    return std::nullopt;
  const Json whole = Json::from_cbor(in);
  const auto& bytes = whole.at("rung").get_binary();
  if (whole.at("digest") != digest_of(bytes)) {
    unfit = damaged;
    return std::nullopt;
  }
  Json json = Json::from_cbor(bytes);
  unfit = accuracy::difference(json.at("fingerprint").get<Fingerprint>(), fingerprint);
  return unfit.empty() ? std::optional(std::move(json)) : std::nullopt;
}

void store_kept(const std::filesystem::path& file, Json json, const Fingerprint& fingerprint) {
  json["fingerprint"] = fingerprint;
  std::vector<std::uint8_t> inner = Json::to_cbor(json);
  const std::string digest = digest_of(inner);
  const std::vector<std::uint8_t> bytes =
      Json::to_cbor(Json{{"digest", digest}, {"rung", Json::binary(std::move(inner))}});
  io::replace_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// Text of a number for a table; empty if the number is absent or not finite.
std::string cell(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? fmt::format("{:.17g}", *value) : "";
}

Json given(const std::optional<Order>& order) { return order ? Json(order->slope) : Json(); }

Json scatter(const std::optional<Order>& order) {
  return order ? Json{order->least, order->largest} : Json();
}

Json asymptotic(const std::optional<Order>& order) { return order ? Json(order->asymptotic) : Json(); }

/// Writes the error bar of the reference rung and its parts as JSON.
Json given(const std::optional<ReferenceBar>& bar) {
  if (!bar)
    return {};
  const auto part = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"value", bar->value},
          {"size", part(bar->size)},
          {"step", part(bar->step)},
          {"asymptotic", bar->asymptotic},
          {"words", words(*bar)}};
}

} // namespace

RungCache::RungCache(const std::filesystem::path& folder) : folder_(folder), lock_(folder) {
  lock_.claim("study.json", file_names, file_names);
  std::error_code error;
  std::filesystem::create_directories(folder_ / rungs_folder, error);
  if (error)
    throw UserError(fmt::format("--out: the folder {} cannot be created ({}); choose another",
                                folder_.string(), error.message()));
}

RungCache::~RungCache() {
  std::error_code not_empty;
  std::filesystem::remove(folder_ / rungs_folder, not_empty);
}

std::filesystem::path RungCache::file(const Rung& rung) const {
  return folder_ / rungs_folder /
         fmt::format("{}size-{:.10g}-{}-degree-{}-{}.cbor", rung.graded ? "graded-" : "", rung.size,
                     rung.has_varying_steps() ? fmt::format("tolerance-{:.10g}", rung.tolerance)
                                              : fmt::format("steps-{}", rung.steps),
                     rung.degree, scene::name(rung.scheme));
}

std::filesystem::path RungCache::file(double tolerance) const {
  return folder_ / rungs_folder / fmt::format("search-to-{:.10g}.cbor", tolerance);
}

CachedRung RungCache::load(const Rung& rung, const Fingerprint& fingerprint,
                           const std::vector<Quantity>& wanted) const {
  try {
    std::string unfit;
    const std::optional<Json> json = load_kept(file(rung), fingerprint, unfit);
    if (!json)
      return {std::nullopt, unfit};
    Measured measured = from_json(*json);
    for (const Quantity& quantity : wanted)
      if (!(quantity.field ? measured.fields.contains(quantity.name)
                           : measured.numbers.contains(quantity.name)))
        return {std::nullopt, fmt::format("its stored results lack the {}", quantity.title)};
    return {std::move(measured), ""};
  } catch (const Json::exception&) {
    return {std::nullopt, damaged};
  }
}

void RungCache::save(const Rung& rung, const Fingerprint& fingerprint, const Measured& measured) const {
  store_kept(file(rung), to_json(measured), fingerprint);
}

CachedSearch RungCache::load(double tolerance, const Fingerprint& fingerprint) const {
  try {
    std::string unfit;
    const std::optional<Json> json = load_kept(file(tolerance), fingerprint, unfit);
    if (!json)
      return {std::nullopt, unfit};
    return {search_from(*json), ""};
  } catch (const Json::exception&) {
    return {std::nullopt, damaged};
  }
}

void RungCache::save(const SearchCost& search, const Fingerprint& fingerprint) const {
  store_kept(file(search.tolerance), to_json(search), fingerprint);
}

void RungCache::write(const std::string& name, const std::string& text) const {
  io::replace_file(folder_ / name, text);
}

void RungCache::remove(const std::string& name) const {
  std::error_code absent;
  std::filesystem::remove(folder_ / name, absent);
}

std::string csv(const scene::Scene& scene, const std::vector<RungResult>& results,
                const std::vector<Errors>& errors) {
  std::string text = "rung,size,step,degree,scheme,mass,unknowns,steps,seconds,memory_bytes,tolerance,graded";
  for (const Errors& one : errors)
    text +=
        fmt::format(",{0},{0}_error,{0}_estimate,{0}_effectivity,{0}_pareto,{0}_envelope", one.quantity.name);
  const bool estimated = std::ranges::any_of(
      results, [](const RungResult& result) { return result.measured && result.measured->estimate; });
  if (estimated) // relative to J, with signs
    text += ",J_estimate_space,J_estimate_time,J_estimate_initial,J_estimate_desired";
  text += '\n';
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto& [rung, run] = results[i];
    if (!run)
      continue;
    const auto [scheme, mass] = scheme_and_mass(scene, rung.scheme);
    text += fmt::format("{},{:.17g},{:.17g},{},{},{},{},{},{:.6g},{:.0f},{},{:d}", i + 1, rung.size,
                        scene.time.end / run->steps, rung.degree, scheme, mass, run->unknowns, run->steps,
                        run->seconds, run->memory,
                        rung.has_varying_steps() ? fmt::format("{:.17g}", rung.tolerance) : "", rung.graded);
    for (const Errors& one : errors) {
      const std::optional<double>&error = one.error[i], &estimate = one.estimate[i];
      text += fmt::format(
          ",{},{},{},{},{:d},{}", one.quantity.field ? "" : cell(run->numbers.at(one.quantity.name)),
          cell(error), cell(estimate), cell(one.effectivity[i]), bool(one.pareto[i]), cell(one.envelope[i]));
    }
    if (const auto& estimate = run->estimate) {
      const double J = std::abs(run->numbers.at("J"));
      const auto part = [&](const std::optional<double>& value) { return value ? cell(*value / J) : ""; };
      text += fmt::format(",{},{},{},{}", part(estimate->space), part(estimate->time),
                          part(estimate->initial), part(estimate->desired));
    } else if (estimated) {
      text += ",,,,";
    }
    text += '\n';
  }
  return text;
}

std::string json(const scene::Scene& scene, const std::vector<RungResult>& results, std::size_t searches,
                 const std::vector<Errors>& errors, const std::vector<Orders>& orders,
                 const std::vector<std::string>& sentences) {
  nlohmann::ordered_json json;
  json["scene"] = scene.name;
  bool any_exact = false, all_exact = true;
  for (const Errors& one : errors)
    (one.exact ? any_exact : all_exact) = one.exact;
  json["reference"] = all_exact   ? "exact"
                      : any_exact ? "exact where it is known, else the finest rung"
                                  : "finest rung";
  json["versions"] = io::versions();
  json["files"] = file_names;
  json["rungs"] =
      std::ranges::count_if(results, [](const RungResult& result) { return result.measured.has_value(); });
  json["searches"] = searches;
  json["warnings"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < results.size(); ++i)
    if (results[i].measured)
      for (const Warning& one : results[i].measured->warnings)
        json["warnings"].push_back({{"rung", i + 1}, {"name", one.name}, {"message", one.message}});
  json["quantities"] = nlohmann::ordered_json::object();
  for (const Errors& one : errors)
    json["quantities"][one.quantity.name] = {{"title", one.quantity.title},
                                             {"unit", one.quantity.unit},
                                             {"reference", one.exact ? "exact" : "finest rung"},
                                             {"bar", given(one.bar)}};
  json["orders"] = nlohmann::ordered_json::array();
  for (const Orders& one : orders) {
    const auto [scheme, mass] = scheme_and_mass(scene, one.scheme);
    json["orders"].push_back(
        {{"quantity", one.quantity},
         {"degree", one.degree},
         {"scheme", scheme},
         {"mass", mass},
         {"steps", one.varying_steps ? "chosen" : "of one length"},
         {"mesh", one.graded ? "graded" : "of one size"},
         {"space", given(one.space)},
         {"time", given(one.time)},
         {"both", given(one.both)},
         {"scatter",
          {{"space", scatter(one.space)}, {"time", scatter(one.time)}, {"both", scatter(one.both)}}},
         {"asymptotic",
          {{"space", asymptotic(one.space)},
           {"time", asymptotic(one.time)},
           {"both", asymptotic(one.both)}}}});
  }
  json["sentences"] = sentences;
  return io::lines(json);
}

} // namespace signorini::accuracy
