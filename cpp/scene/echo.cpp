#include "scene/scene.h"
#include <sstream>
#include <toml++/toml.hpp>

namespace signorini::scene {
namespace {

template <class T>
toml::array array(const std::vector<T>& values) {
  toml::array out;
  for (const T& value : values)
    out.push_back(value);
  return out;
}

} // namespace

std::string echo(const Scene& s) {
  toml::table root;
  toml::table mesh{{"file", s.mesh.file.string()}, {"degree", s.mesh.degree}};
  if (s.mesh.size)
    mesh.insert("size", *s.mesh.size);
  root.insert("mesh", std::move(mesh));
  root.insert("time", toml::table{{"end", s.time.end}, {"step", s.time.step}, {"scheme", s.time.scheme}});
  toml::table material{{"density", s.material.density},
                       {"young", s.material.young},
                       {"poisson", s.material.poisson}};
  if (s.material.viscosity)
    material.insert("viscosity", toml::table{{"bulk", s.material.viscosity->bulk},
                                             {"shear", s.material.viscosity->shear}});
  root.insert("material", std::move(material));
  toml::array clamps;
  for (const Clamp& clamp : s.clamps)
    clamps.push_back(toml::table{{"on", clamp.on}});
  if (!clamps.empty())
    root.insert("clamp", std::move(clamps));
  if (s.contact)
    root.insert("contact", toml::table{{"on", s.contact->on},
                                       {"mass", "consistent"},
                                       {"obstacle", toml::table{{"shape", "half-space"},
                                                                {"point", array(s.contact->obstacle.point)},
                                                                {"normal", array(s.contact->obstacle.normal)}}}});
  if (s.load)
    root.insert("load", toml::table{{"body", array(s.load->body)}});
  toml::table initial;
  if (s.initial.displacement)
    initial.insert("displacement", array(*s.initial.displacement));
  if (s.initial.velocity)
    initial.insert("velocity", array(*s.initial.velocity));
  root.insert("initial", std::move(initial));
  if (s.control) {
    toml::table control{{"scale", s.control->scale}};
    if (s.control->initial)
      control.insert("initial", array(*s.control->initial));
    if (s.control->lower)
      control.insert("lower", array(*s.control->lower));
    if (s.control->upper)
      control.insert("upper", array(*s.control->upper));
    for (const char* key : {"lower", "upper"})
      if (toml::array* bound = control[key].as_array(); bound && bound->size() == 1)
        control.insert_or_assign(key, *bound->get(0)->value<double>());
    root.insert("control", std::move(control));
  }
  if (s.objective) {
    toml::table desired;
    if (const auto* d = std::get_if<DesiredControl>(&s.objective->desired))
      desired.insert("control", array(d->control));
    else
      desired.insert("displacement", array(std::get<DesiredDisplacement>(s.objective->desired).displacement));
    root.insert("objective", toml::table{{"desired", std::move(desired)},
                                         {"alpha", s.objective->alpha},
                                         {"gamma", s.objective->gamma}});
  }
  root.insert("optimizer", toml::table{{"method", s.optimizer.method},
                                       {"max_iterations", s.optimizer.max_iterations},
                                       {"tolerance", s.optimizer.tolerance}});
  root.insert("solver", toml::table{{"vi", s.solver.vi}, {"linear", s.solver.linear}});
  if (s.check.control)
    root.insert("check", toml::table{{"control", array(*s.check.control)}});
  root.insert("output", toml::table{{"every", s.output.every}});
  std::ostringstream out;
  out << toml::toml_formatter(root) << '\n';
  return out.str();
}

} // namespace signorini::scene
