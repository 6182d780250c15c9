#include "scene/kinds.h"
#include <charconv>
#include <cmath>

namespace signorini::scene::kind {
namespace {

Json array(const Json& items, int least) {
  return {{"type", "array"}, {"items", items}, {"minItems", least}, {"maxItems", 3}};
}

const Json number{{"type", "number"}}, expression{{"type", {"string", "number"}}};

} // namespace

std::string written(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text; // a TOML float, not an integer
}

std::string written(const std::string& text) {
  std::string quoted = "\"";
  for (char c : text)
    quoted += (c == '"' || c == '\\') ? std::string{'\\', c} : std::string{c};
  return quoted + '"';
}

std::string quoted(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names)
    text += fmt::format("{}`\"{}\"`", text.empty() ? "" : ", ", name);
  return text;
}

Json Number::schema() const {
  Json schema = number;
  if (std::isfinite(limits.least))
    schema[limits.open ? "exclusiveMinimum" : "minimum"] = limits.least;
  if (std::isfinite(limits.greatest))
    schema[limits.open ? "exclusiveMaximum" : "maximum"] = limits.greatest;
  return schema;
}

std::filesystem::path Path::read(Reader& in, Name key, const Scene& scene) {
  const std::filesystem::path given = in.text(key);
  std::error_code error;
  const auto path = std::filesystem::weakly_canonical(
      given.is_absolute() ? given : scene.file.parent_path() / given, error);
  if (error)
    in.fail(key,
            fmt::format("found a path that cannot be followed ({}), allowed is another", error.message()));
  return path;
}

std::vector<Component> Acting::read(Reader& in, Name key, const Scene& scene) {
  std::vector<Component> components = Set::read(in, key, scene);
  if (components.empty())
    in.fail(key, "found [], allowed is one component at least, such as [\"y\"]");
  return components;
}

Json Expressions::schema() { return array(expression, 2); }

Components ClampMotion::read(Reader& in, Name key, const Scene& scene) {
  const auto& held = scene.clamps.back().components;
  return in.expressions(key, true, held ? held->size() : 0);
}

Json ClampMotion::schema() { return array(expression, 1); }

Components ControlField::read(Reader& in, Name key, const Scene& scene) {
  if (!scene.control) // which is refused once all is read
    return in.expressions(key, true);
  const auto& acting = scene.control->components;
  Components values = in.expressions(key, !scene.control->constant_in_time);
  for (std::size_t c = 0; acting && c < values.size(); ++c)
    if (!vanishes({values[c]}) && std::ranges::find(*acting, static_cast<Component>(c)) == acting->end())
      in.fail(key, fmt::format("found \"{}\" for {}, allowed is \"0\": control.components leaves it out",
                               values[c], "xyz"[c]));
  return values;
}

std::string Point::write(const Components& components) {
  std::vector<std::string> entries;
  for (const std::string& component : components) {
    double value = 0;
    const char* end = component.data() + component.size();
    const auto [last, error] = std::from_chars(component.data(), end, value);
    entries.push_back(error == std::errc() && last == end ? written(value) : written(component));
  }
  return fmt::format("[{}]", fmt::join(entries, ", "));
}

Json Numbers::schema() { return array(number, 2); }

std::vector<double> Direction::read(Reader& in, Name key, const Scene&) const {
  std::vector<double> vector = in.numbers(key, limits);
  if (std::ranges::all_of(vector, [](double x) { return x == 0; }))
    in.fail(key, fmt::format("found a vector of length zero, allowed is any other: {}", what));
  return vector;
}

Json Bound::schema() { return {{"anyOf", {number, Numbers::schema()}}}; }

} // namespace signorini::scene::kind
