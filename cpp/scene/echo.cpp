#include "scene/scene.h"
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::scene {
namespace {

std::string number(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text; // a TOML float, not an integer
}

std::string numbers(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (double value : values)
    texts.push_back(number(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string text(const std::string& value) {
  std::string quoted = "\"";
  for (char c : value)
    quoted += (c == '"' || c == '\\') ? std::string{'\\', c} : std::string{c};
  return quoted + '"';
}

std::string texts(const Components& components) {
  std::vector<std::string> quoted;
  for (const std::string& component : components)
    quoted.push_back(text(component));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

Components zero(std::size_t size) { return Components(size, "0"); }

/// A TOML array of expressions, of which constants are written as numbers.
std::string numbers_or_texts(const Components& components) {
  std::vector<std::string> entries;
  for (const std::string& component : components) {
    double value = 0;
    const char* end = component.data() + component.size();
    const auto [last, error] = std::from_chars(component.data(), end, value);
    entries.push_back(error == std::errc() && last == end ? number(value) : text(component));
  }
  return fmt::format("[{}]", fmt::join(entries, ", "));
}

std::string bound(const std::vector<double>& values) {
  return values.size() == 1 ? number(values.front()) : numbers(values);
}

/// Writes lines `key = value`, each followed by its unit.
class Writer {
public:
  void table(const std::string& heading) { out_ += (out_.empty() ? "" : "\n") + heading + "\n"; }
  void key(const std::string& name, const std::string& value, const std::string& unit = {}) {
    out_ += fmt::format("{} = {}{}\n", name, value, unit.empty() ? "" : "  # " + unit);
  }
  [[nodiscard]] const std::string& result() const { return out_; }

private:
  std::string out_;
};

void write_body(Writer& out, const Scene& s) {
  out.table("[mesh]");
  out.key("file", text(s.mesh.file.string()));
  if (s.mesh.size)
    out.key("size", number(*s.mesh.size), "m");
  else if (s.mesh.file.extension() == ".geo")
    out.key("scale", number(s.mesh.scale));
  out.key("degree", std::to_string(s.mesh.degree));
  out.table("[time]");
  out.key("end", number(s.time.end), "s");
  out.key("step", number(s.time.step), "s");
  out.key("scheme", text(s.time.scheme));
  for (const Material& material : s.materials) {
    out.table(material.on ? "[[material]]" : "[material]");
    if (material.on)
      out.key("on", text(*material.on));
    out.key("density", number(material.density), "kg/m³");
    out.key("young", number(material.young), "Pa");
    out.key("poisson", number(material.poisson));
    if (const auto& viscosity = material.viscosity)
      out.key("viscosity",
              fmt::format("{{ bulk = {}, shear = {} }}", number(viscosity->bulk), number(viscosity->shear)),
              "Pa s");
  }
}

std::string obstacle(const HalfSpace& shape) {
  return fmt::format("{{ shape = \"half-space\", point = {}, normal = {} }}", numbers_or_texts(shape.point),
                     numbers(shape.normal));
}

std::string radius_and_side(double radius, bool inside) {
  return fmt::format("radius = {}, side = \"{}\"", number(radius), inside ? "inside" : "outside");
}

std::string obstacle(const Ball& shape) {
  return fmt::format("{{ shape = \"ball\", center = {}, {} }}", numbers(shape.center),
                     radius_and_side(shape.radius, shape.inside));
}

std::string obstacle(const Cylinder& shape) {
  const std::string axis = shape.axis.empty() ? "" : fmt::format("axis = {}, ", numbers(shape.axis));
  return fmt::format("{{ shape = \"cylinder\", point = {}, {}{} }}", numbers(shape.point), axis,
                     radius_and_side(shape.radius, shape.inside));
}

std::string obstacle(const SignedDistance& shape) {
  return fmt::format("{{ shape = \"signed-distance\", distance = {} }}", text(shape.distance));
}

void write_boundary(Writer& out, const Scene& s, int dim) {
  for (const Clamp& clamp : s.clamps) {
    out.table("[[clamp]]");
    out.key("on", text(clamp.on));
    const std::vector<std::string> components = clamp.components.value_or(component_names(dim));
    out.key("components", texts(components));
    out.key("value", texts(clamp.value.value_or(zero(components.size()))), "m");
  }
  for (const Contact& contact : s.contacts) {
    out.table(s.contacts.size() == 1 ? "[contact]" : "[[contact]]");
    out.key("on", text(contact.on));
    out.key("obstacle", std::visit([](const auto& shape) { return obstacle(shape); }, contact.obstacle), "m");
    out.key("mass", text(contact.massless ? "massless" : "consistent"));
    out.key("initial", text(contact.project ? "project" : "outside"));
  }
}

void write_initial(Writer& out, const Scene& s, int dim) {
  // With moving clamps the default is their motion at the start, which a field of expressions cannot state.
  const bool rests = std::ranges::all_of(
      s.clamps, [](const Clamp& clamp) { return !clamp.value || vanishes(*clamp.value); });
  const auto field = [&](const char* name, const std::optional<Components>& given, const char* unit) {
    if (given || rests)
      out.key(name, texts(given.value_or(zero(static_cast<std::size_t>(dim)))), unit);
  };
  out.table("[initial]");
  field("displacement", s.initial.displacement, "m");
  field("velocity", s.initial.velocity, "m/s");
}

void write_control(Writer& out, const Scene& s, int dim) {
  out.table("[control]");
  out.key("scale", number(s.control->scale), "N/m³ per unit of control, N/m² on a surface");
  if (s.control->on)
    out.key("on", text(*s.control->on));
  out.key("components", texts(s.control->components.value_or(component_names(dim))));
  out.key("constant_in_time", s.control->constant_in_time ? "true" : "false");
  out.key("space", text(s.control->space));
  out.key("initial", texts(s.control->initial.value_or(zero(static_cast<std::size_t>(dim)))));
  if (s.control->lower)
    out.key("lower", bound(*s.control->lower));
  if (s.control->upper)
    out.key("upper", bound(*s.control->upper));
}

void write_objective(Writer& out, const Scene& s) {
  out.table("[objective]");
  if (const auto* by_control = std::get_if<DesiredControl>(&s.objective->desired))
    out.key("desired", fmt::format("{{ control = {} }}", texts(by_control->control)));
  else if (const auto* by_displacement = std::get_if<DesiredDisplacement>(&s.objective->desired))
    out.key("desired", fmt::format("{{ displacement = {} }}", texts(by_displacement->displacement)), "m");
  else if (const auto* by_run = std::get_if<DesiredRun>(&s.objective->desired))
    out.key("desired", fmt::format("{{ run = {} }}", text(by_run->folder.string())));
  if (s.objective->on)
    out.key("on", text(*s.objective->on));
  out.key("tracking", number(s.objective->tracking));
  out.key("alpha", number(s.objective->alpha));
  out.key("gamma", number(s.objective->gamma), "s");
  out.table("[optimizer]");
  out.key("method", text(s.optimizer.method));
  out.key("max_iterations", std::to_string(s.optimizer.max_iterations));
  out.key("tolerance", number(s.optimizer.tolerance), "of the gradient norm, relative to the first guess's");
  out.key("checkpoint", std::to_string(s.optimizer.checkpoint), "iterations from one to the next; 0: none");
  out.table("[trajectory]");
  out.key("storage", text(s.trajectory.storage));
  if (s.trajectory.storage == "checkpoints")
    out.key("budget", number(s.trajectory.budget), "bytes");
  if (s.check.control) {
    out.table("[check]");
    out.key("control", texts(*s.check.control));
  }
}

void write_exact(Writer& out, const Exact& exact) {
  out.table("[exact]");
  if (exact.displacement)
    out.key("displacement", texts(*exact.displacement), "m");
  if (exact.pressure)
    out.key("pressure", text(*exact.pressure), "N/m²");
  const auto value = [&](const char* key, const std::optional<double>& given, const char* unit) {
    if (given)
      out.key(key, number(*given), unit);
  };
  value("impulse", exact.impulse, "N s");
  value("peak_force", exact.peak_force, "N");
  value("contact_start", exact.contact_start, "s");
  value("contact_time", exact.contact_time, "s");
}

} // namespace

std::string echo(const Scene& s, int dim) {
  Writer out;
  write_body(out, s);
  write_boundary(out, s, dim);
  if (s.load) {
    out.table("[load]");
    if (s.load->body)
      out.key("body", texts(*s.load->body), "N/m³");
    for (const Traction& traction : s.load->tractions) {
      out.table("[[load.traction]]");
      out.key("on", text(traction.on));
      out.key("value", texts(traction.value), "N/m²");
    }
  }
  write_initial(out, s, dim);
  if (s.control)
    write_control(out, s, dim);
  if (s.objective)
    write_objective(out, s);
  if (s.exact)
    write_exact(out, *s.exact);
  out.table("[solver]");
  out.key("vi", text(s.solver.vi));
  out.key("linear", text(s.solver.linear));
  out.key("memory", number(s.solver.memory), "bytes");
  out.table("[run]");
  out.key("invariants", text(s.run.invariants));
  out.key("tolerance", number(s.run.tolerance));
  out.table("[output]");
  out.key("every", std::to_string(s.output.every), "steps");
  out.key("fields", texts(s.output.fields));
  out.key("tables", texts(s.output.tables));
  return out.result();
}

} // namespace signorini::scene
