// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/kinds.h"
#include "scene/expression.h"
#include <charconv>
#include <cmath>

namespace signorini::scene::kind {
namespace {

Json array(const Json& items, int least) {
  return {{"type", "array"}, {"items", items}, {"minItems", least}, {"maxItems", 3}};
}

const Json number{{"type", "number"}}, text{{"type", "string"}}, expression{{"type", {"string", "number"}}},
    time_series{{"type", "object"},
                {"properties", {{"file", text}, {"column", text}}},
                {"required", {"file", "column"}},
                {"additionalProperties", false}};

/// Throws UserError if an expression depends on x, y or z.
void require_time_alone(const Reader& in, Name key, const Components& components) {
  if (Field(components, key, true).depends_on_place())
    in.fail(key, fmt::format("found {}; expected expressions in t only", fmt::join(components, ", ")));
}

} // namespace

std::string written(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text; // a TOML float, not an integer
}

std::string written(const std::string& text) {
  std::string quoted = "\"";
  for (char c : text)
    if (const auto code = static_cast<unsigned char>(c); code < 0x20 || code == 0x7f)
      quoted += fmt::format("\\u{:04x}", code);
    else
      quoted += (c == '"' || c == '\\') ? std::string{'\\', c} : std::string{c};
  return quoted + '"';
}

std::string written(const Expression& expression) {
  return expression.series ? expression.text : written(expression.text);
}

std::string written_as_number(const Expression& expression) {
  const std::string& text = expression.text;
  double value = 0;
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && last == text.data() + text.size() ? written(value) : written(expression);
}

std::string quoted(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names)
    text += fmt::format("{}`\"{}\"`", text.empty() ? "" : ", ", name);
  return text;
}

std::string Changes::write(const std::vector<Change>& changes) {
  std::vector<std::string> entries;
  for (const Change& change : changes)
    entries.push_back(fmt::format("{} = {}", written(change.key), change.value));
  return entries.empty() ? "" : fmt::format("{{ {} }}", fmt::join(entries, ", "));
}

Json Number::schema() const {
  Json schema = number;
  if (std::isfinite(limits.least))
    schema[limits.open ? "exclusiveMinimum" : "minimum"] = limits.least;
  if (std::isfinite(limits.greatest))
    schema[limits.open ? "exclusiveMaximum" : "maximum"] = limits.greatest;
  return schema;
}

double NumberOrAuto::read(Reader& in, Name key, const Scene&) const {
  if (!in.is_text(key))
    return in.number(key, limits);
  if (const std::string found = in.text(key); found != "auto")
    in.fail(key, fmt::format("found \"{}\"; expected a number{} ({}), without quotes, or \"auto\"", found,
                             limits.range(), limits.unit));
  return automatic;
}

std::vector<Component> Acting::read(Reader& in, Name key, const Scene& scene) {
  std::vector<Component> components = Set::read(in, key, scene);
  if (components.empty())
    in.fail(key, "found []; expected at least one component, such as [\"y\"]");
  return components;
}

std::vector<FieldFormat> Formats::read(Reader& in, Name key, const Scene& scene) {
  std::vector<FieldFormat> formats = Set::read(in, key, scene);
  if (formats.empty())
    in.fail(key, "found []; expected at least one format, such as [\"vtkhdf\"]. `output.fields = []` stores "
                 "no fields");
  return formats;
}

Json Expressions::schema() const {
  return array(time ? Json{{"anyOf", {expression, time_series}}} : expression, 2);
}

Components ClampMotion::read(Reader& in, Name key, const Scene& scene) {
  const auto& held = scene.clamps.back().components;
  return in.expressions(key, scene.time.end, held ? held->size() : 0);
}

Json ClampMotion::schema() { return array({{"anyOf", {expression, time_series}}}, 1); }

Components ControlField::read(Reader& in, Name key, const Scene& scene) {
  if (!scene.control) // which is refused once all is read
    return in.expressions(key, scene.time.end);
  const auto& acting = scene.control->components;
  Components values =
      in.expressions(key, scene.control->constant_in_time ? std::nullopt : std::optional(scene.time.end));
  if (acting && static_cast<std::size_t>(std::ranges::max(*acting)) >= values.size())
    return values; // a component that is not there is refused once the mesh is read
  for (std::size_t c = 0; acting && c < values.size(); ++c)
    if (!vanishes({values[c]}) && std::ranges::find(*acting, static_cast<Component>(c)) == acting->end())
      in.fail(key, fmt::format("found \"{}\" for {}, which control.components leaves out; set it to \"0\"",
                               values[c], "xyz"[c]));
  return values;
}

Components Point::read(Reader& in, Name key, const Scene& scene) {
  Components components = in.expressions(key, scene.time.end);
  require_time_alone(in, key, components);
  return components;
}

std::string Point::write(const Components& components) {
  std::vector<std::string> entries;
  for (const Expression& component : components)
    entries.push_back(written_as_number(component));
  return fmt::format("[{}]", fmt::join(entries, ", "));
}

Expression Varying::read(Reader& in, Name key, const Scene& scene) const {
  Expression expression = in.number_or_expression(key, limits, scene.time.end);
  require_time_alone(in, key, {expression});
  return expression;
}

Expression Coefficient::read(Reader& in, Name key, const Scene& scene) const {
  return in.number_or_expression(key, limits, scene.time.end);
}

Json Varying::schema() const { return {{"anyOf", {Number{limits}.schema(), text, time_series}}}; }

Json Numbers::schema() { return array(number, 2); }

std::vector<double> Direction::read(Reader& in, Name key, const Scene&) const {
  std::vector<double> vector = in.numbers(key, limits);
  if (std::ranges::all_of(vector, [](double x) { return x == 0; }))
    in.fail(key, fmt::format("found a vector of length zero; {}", what));
  return vector;
}

Json Bound::schema() { return {{"anyOf", {number, Numbers::schema()}}}; }

} // namespace signorini::scene::kind
