#include "base/error.h"
#include "base/memory.h"
#include "scene/expression.h"
#include "scene/override.h"
#include "scene/reader.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <sstream>

namespace signorini::scene {
namespace {

const Limits positive_length{.least = 0, .open = true, .unit = "m"};
const Limits positive_time{.least = 0, .open = true, .unit = "s"};

/// Reads a path; relative ones are relative to the scene file.
std::filesystem::path beside(const std::filesystem::path& file, Reader& in, const std::string& key) {
  const std::filesystem::path given = in.text(key);
  std::error_code error;
  const auto path =
      std::filesystem::weakly_canonical(given.is_absolute() ? given : file.parent_path() / given, error);
  if (error)
    in.fail(key,
            fmt::format("found a path that cannot be followed ({}), allowed is another", error.message()));
  return path;
}

Mesh mesh(Reader in, const std::filesystem::path& file) {
  Mesh mesh;
  mesh.file = beside(file, in, "file");
  const std::string extension = mesh.file.extension().string();
  if (extension != ".geo" && extension != ".msh")
    in.fail("file", fmt::format("found \"{}\", allowed are files that end in .geo or .msh", in.text("file")));
  if (in.has("size")) {
    if (extension == ".msh")
      in.fail("size", "has no effect on a .msh, which is meshed already; allowed with a .geo");
    mesh.size = in.number("size", positive_length);
  }
  if (in.has("scale")) {
    if (extension == ".msh" || mesh.size)
      in.fail("scale", fmt::format("has no effect {}; allowed with a .geo that sets its own sizes",
                                   mesh.size ? "beside mesh.size" : "on a .msh, which is meshed already"));
    mesh.scale = in.number("scale", {.least = 0, .open = true});
  }
  mesh.degree = in.integer("degree", 1, 2, mesh.degree);
  in.finish();
  return mesh;
}

Time time(Reader in) {
  Time time;
  time.end = in.number("end", positive_time);
  time.step = in.number("step", positive_time);
  time.scheme = in.choice("scheme", {"contact-implicit", "contact-stabilized"}, time.scheme);
  const double steps = std::round(time.end / time.step);
  if (!(steps >= 1 && steps <= Time::most_steps))
    in.fail(
        "step",
        fmt::format("found {:.10g} s, which makes {:.10g} steps to time.end = {:.10g} s, allowed are 1 to {}",
                    time.step, time.end / time.step, time.end, Time::most_steps));
  // Decimal fractions such as 7.5e-3 / 5e-5 divide to within a few units in the last place.
  if (std::abs(steps * time.step - time.end) > 1e-9 * time.end)
    in.fail("end", fmt::format("found {:.10g} s, which is {:.10g} steps of {:.10g} s, allowed are whole "
                               "multiples of time.step, such as {:.10g} s",
                               time.end, time.end / time.step, time.step, steps * time.step));
  time.steps = static_cast<int>(steps);
  in.finish();
  return time;
}

Material material(Reader& in, bool one_of_several) {
  Material material;
  if (one_of_several)
    material.on = in.text("on");
  else if (in.has("on"))
    in.fail("on", "has no effect on [material], which is the whole body's; allowed in tables [[material]]");
  material.density = in.number("density", {.least = 0, .open = true, .unit = "kg/m³"});
  material.young = in.number("young", {.least = 0, .open = true, .unit = "Pa"});
  material.poisson = in.number("poisson", {.least = -1, .greatest = 0.5, .open = true});
  if (in.has("viscosity")) {
    Reader viscosity = in.table("viscosity");
    const Limits limits{.least = 0, .unit = "Pa s"};
    material.viscosity = Viscosity{viscosity.number("bulk", limits), viscosity.number("shear", limits)};
    viscosity.finish();
  }
  in.finish();
  return material;
}

/// Reads `components`, the components that are held or act; absent: all.
std::optional<std::vector<std::string>> components(Reader& in) {
  if (!in.has("components"))
    return std::nullopt;
  std::vector<std::string> names = in.names("components", {"x", "y", "z"});
  if (names.empty())
    in.fail("components", "found [], allowed is one component at least, such as [\"y\"]");
  return names;
}

/// Reads one table [material] for the whole body, or tables [[material]] with a group each.
std::vector<Material> materials(Reader& root, bool several) {
  if (!several) {
    Reader in = root.table("material");
    return {material(in, false)};
  }
  std::vector<Material> materials;
  for (Reader& in : root.tables("material")) {
    Material next = material(in, true);
    for (std::size_t i = 0; i < materials.size(); ++i)
      if (materials[i].on == next.on)
        in.fail("on",
                fmt::format("found \"{}\", which material[{}] is on, allowed is another group", *next.on, i));
    materials.push_back(std::move(next));
  }
  return materials;
}

Clamp clamp(Reader in) {
  Clamp clamp{.on = in.text("on"), .components = std::nullopt, .value = std::nullopt};
  clamp.components = components(in);
  if (in.has("value"))
    clamp.value = in.expressions("value", true, clamp.components ? clamp.components->size() : 0);
  in.finish();
  return clamp;
}

/// Reads a direction: a vector of any length but zero.
std::vector<double> direction(Reader& in, const std::string& key, const std::string& what) {
  std::vector<double> vector = in.numbers(key, {});
  if (std::ranges::all_of(vector, [](double x) { return x == 0; }))
    in.fail(key, fmt::format("found a vector of length zero, allowed is any other: {}", what));
  return vector;
}

HalfSpace half_space(Reader& in) {
  HalfSpace obstacle;
  obstacle.point = in.expressions("point", true);
  if (Field(obstacle.point, "point", true).depends_on_place())
    in.fail(
        "point",
        fmt::format("found [{}], allowed are expressions of t alone: the point is one for the whole plane",
                    fmt::join(obstacle.point, ", ")));
  obstacle.normal = direction(in, "normal", "it points out of the obstacle");
  if (obstacle.normal.size() != obstacle.point.size())
    in.fail("normal", fmt::format("found {} components where point has {}, allowed are as many",
                                  obstacle.normal.size(), obstacle.point.size()));
  return obstacle;
}

/// Reads `side`: whether the body is inside of a round obstacle.
bool inside(Reader& in) { return in.choice("side", {"outside", "inside"}, "outside") == "inside"; }

Cylinder cylinder(Reader& in) {
  Cylinder obstacle;
  obstacle.point = in.numbers("point", {.unit = "m"});
  if (obstacle.point.size() == 3) {
    obstacle.axis = direction(in, "axis", "it points along the cylinder");
    if (obstacle.axis.size() != 3)
      in.fail("axis", fmt::format("found {} components where point has 3, allowed are as many",
                                  obstacle.axis.size()));
  } else if (in.has("axis")) {
    in.fail("axis",
            "has no effect in the plane, where a cylinder is a disc; allowed with a point of 3 components");
  }
  obstacle.radius = in.number("radius", positive_length);
  obstacle.inside = inside(in);
  return obstacle;
}

Obstacle obstacle(Reader in) {
  in.text("shape");
  const std::string shape = in.choice("shape", {"half-space", "ball", "cylinder", "signed-distance"}, "");
  Obstacle obstacle;
  if (shape == "half-space") {
    obstacle = half_space(in);
  } else if (shape == "ball") {
    Ball ball{in.numbers("center", {.unit = "m"}), in.number("radius", positive_length), false};
    ball.inside = inside(in);
    obstacle = ball;
  } else if (shape == "cylinder") {
    obstacle = cylinder(in);
  } else {
    obstacle = SignedDistance{in.expression("distance", false)};
  }
  in.finish();
  return obstacle;
}

Contact contact(Reader in, const Time& time) {
  Contact contact;
  contact.on = in.text("on");
  contact.massless = in.choice("mass", {"consistent", "massless"}, "consistent") == "massless";
  if (contact.massless && time.stabilized())
    in.fail("mass",
            "found \"massless\" with time.scheme \"contact-stabilized\", which projects in the norm of the "
            "mass; allowed is \"consistent\"");
  contact.obstacle = obstacle(in.table("obstacle"));
  contact.project = in.choice("initial", {"outside", "project"}, "outside") == "project";
  in.finish();
  return contact;
}

/// Reads an admissible control: without t if controls are constant in time, and zero in the components that
/// control.components leaves out.
Components controls(Reader& in, const std::string& key, const Control& control) {
  Components values = in.expressions(key, !control.constant_in_time);
  for (std::size_t c = 0; control.components && c < values.size(); ++c)
    if (!vanishes({values[c]}) &&
        std::ranges::find(*control.components, std::string{"xyz"[c]}) == control.components->end())
      in.fail(key, fmt::format("found \"{}\" for {}, allowed is \"0\": control.components leaves it out",
                               values[c], "xyz"[c]));
  return values;
}

Control control(Reader in) {
  Control control;
  control.scale = in.number("scale", {.least = 0, .open = true, .unit = "N/m² (of the body, N/m³)"});
  if (in.has("on"))
    control.on = in.text("on");
  control.components = components(in);
  control.constant_in_time = in.flag("constant_in_time", control.constant_in_time);
  control.space = in.choice("space", {"P1", "P0"}, control.space);
  if (in.has("initial"))
    control.initial = controls(in, "initial", control);
  if (in.has("lower"))
    control.lower = in.number_or_numbers("lower", {});
  if (in.has("upper"))
    control.upper = in.number_or_numbers("upper", {});
  if (control.lower && control.upper && control.lower->size() > 1 && control.upper->size() > 1 &&
      control.lower->size() != control.upper->size())
    in.fail("upper", fmt::format("found {} components where lower has {}, allowed are as many, or one number",
                                 control.upper->size(), control.lower->size()));
  if (control.lower && control.upper)
    for (std::size_t i = 0; i < std::max(control.lower->size(), control.upper->size()); ++i) {
      const double lower = control.lower->size() == 1 ? control.lower->front() : control.lower->at(i);
      const double upper = control.upper->size() == 1 ? control.upper->front() : control.upper->at(i);
      if (!(lower <= upper))
        in.fail("lower",
                fmt::format("found {} above control.upper = {}, allowed is at most that", lower, upper));
    }
  in.finish();
  return control;
}

Objective objective(Reader in, const Control& control, const std::filesystem::path& file) {
  Objective objective;
  Reader desired = in.table("desired");
  std::vector<std::string> found;
  for (const char* key : {"control", "displacement", "run"})
    if (desired.has(key))
      found.emplace_back(key);
  if (found.empty())
    desired.finish(); // reports a misspelt key, the likeliest reason
  if (found.size() != 1)
    in.fail("desired", fmt::format("found {}, allowed is one of control, displacement, run",
                                   found.empty() ? "none" : list(found)));
  if (found.front() == "control")
    objective.desired = DesiredControl{controls(desired, "control", control)};
  else if (found.front() == "displacement")
    objective.desired = DesiredDisplacement{desired.expressions("displacement", true)};
  else
    objective.desired = DesiredRun{beside(file, desired, "run")};
  desired.finish();
  if (in.has("on"))
    objective.on = in.text("on");
  objective.tracking = in.number("tracking", {.least = 0, .unit = "weight"}, objective.tracking);
  objective.alpha = in.number("alpha", {.least = 0, .unit = "weight"}, objective.alpha);
  objective.gamma = in.number("gamma", {.least = 0, .unit = "weight, s"}, objective.gamma);
  if (objective.tracking == 0 && objective.gamma == 0)
    in.fail("tracking",
            "found 0 where gamma is 0 too, allowed is one of them above: nothing would be desired");
  in.finish();
  return objective;
}

Optimizer optimizer(Reader in) {
  Optimizer optimizer;
  optimizer.method = in.choice("method", {"lbfgs", "newton-cg", "projected-gradient"}, optimizer.method);
  optimizer.max_iterations = in.integer("max_iterations", 0, 1'000'000, optimizer.max_iterations);
  optimizer.tolerance = in.number("tolerance", {.least = 0, .greatest = 1}, optimizer.tolerance);
  optimizer.checkpoint = in.integer("checkpoint", 0, 1'000'000, optimizer.checkpoint);
  in.finish();
  return optimizer;
}

Solver solver(Reader in) {
  Solver solver;
  solver.memory = in.number("memory", {.least = 0, .unit = "bytes"}, machine_memory() / 2);
  solver.vi = in.choice("vi", {"condensed", "full"}, solver.vi);
  solver.linear = in.choice("linear", {"auto", "direct", "iterative"}, solver.linear);
  in.finish();
  return solver;
}

Trajectory trajectory(Reader in) {
  Trajectory trajectory;
  trajectory.storage = in.choice("storage", {"memory", "disk", "checkpoints"}, trajectory.storage);
  if (in.has("budget") && trajectory.storage != "checkpoints")
    in.fail("budget",
            fmt::format("has no effect with storage = \"{}\", which keeps every state; allowed with "
                        "\"checkpoints\"",
                        trajectory.storage));
  trajectory.budget = in.number("budget", {.least = 0, .open = true, .unit = "bytes"}, trajectory.budget);
  in.finish();
  return trajectory;
}

Exact exact(Reader in, bool contact) {
  Exact exact;
  if (in.has("displacement"))
    exact.displacement = in.expressions("displacement", true);
  for (const char* key : {"pressure", "impulse", "peak_force", "contact_start", "contact_time"})
    if (in.has(key) && !contact)
      in.fail(key, "has no meaning without contact; allowed with a table [contact]");
  if (in.has("pressure")) {
    exact.pressure = in.text("pressure");
    if (Field({*exact.pressure}, "exact.pressure", true).depends_on_time())
      in.fail("pressure",
              fmt::format("found \"{}\", allowed is an expression of x, y and z: it is that at time.end",
                          *exact.pressure));
  }
  const auto number = [&](const char* key, const char* unit, std::optional<double>& value) {
    if (in.has(key))
      value = in.number(key, {.least = 0, .open = true, .unit = unit});
  };
  number("impulse", "N s", exact.impulse);
  number("peak_force", "N", exact.peak_force);
  number("contact_start", "s", exact.contact_start);
  number("contact_time", "s", exact.contact_time);
  in.finish();
  return exact;
}

} // namespace

std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file))
    throw UserError(
        fmt::format("{}: the scene file cannot be read; allowed is the path of a TOML file", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Scene parse(const std::string& text, const std::filesystem::path& file,
            const std::vector<std::string>& overrides) {
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw UserError(fmt::format("{}:{}: not valid TOML: {}", file.string(), error.source().begin.line,
                                error.description()));
  }
  for (const std::string& assignment : overrides)
    override_key(root, assignment, file);
  Reader in(root, "", file);
  Scene scene;
  scene.file = std::filesystem::absolute(file);
  scene.name = file.stem().string();
  scene.mesh = mesh(in.table("mesh"), scene.file);
  scene.time = time(in.table("time"));
  scene.materials = materials(in, root.contains("material") && root.get("material")->is_array());
  for (Reader& table : in.tables("clamp"))
    scene.clamps.push_back(clamp(table));
  if (in.has("contact") && root.get("contact")->is_array())
    for (Reader& table : in.tables("contact"))
      scene.contacts.push_back(contact(table, scene.time));
  else if (in.has("contact"))
    scene.contacts.push_back(contact(in.table("contact"), scene.time));
  if (in.has("load")) {
    Reader load = in.table("load");
    scene.load.emplace();
    if (load.has("body"))
      scene.load->body = load.expressions("body", true);
    for (Reader& traction : load.tables("traction")) {
      scene.load->tractions.push_back({traction.text("on"), traction.expressions("value", true)});
      traction.finish();
    }
    load.finish();
  }
  if (in.has("initial")) {
    Reader initial = in.table("initial");
    if (initial.has("displacement"))
      scene.initial.displacement = initial.expressions("displacement", false);
    if (initial.has("velocity"))
      scene.initial.velocity = initial.expressions("velocity", false);
    initial.finish();
  }
  if (in.has("control"))
    scene.control = control(in.table("control"));
  if (in.has("objective")) {
    if (!scene.control)
      in.fail("objective", "needs a control to act on; add a table [control] or leave the objective out");
    scene.objective = objective(in.table("objective"), *scene.control, scene.file);
  }
  if (in.has("optimizer")) {
    if (!scene.objective)
      in.fail("optimizer",
              "has no effect without an objective; add [control] and [objective] or leave it out");
    scene.optimizer = optimizer(in.table("optimizer"));
  }
  scene.solver = in.has("solver") ? solver(in.table("solver")) : Solver{.memory = machine_memory() / 2};
  if (in.has("trajectory")) {
    if (!scene.objective)
      in.fail("trajectory",
              "has no effect without an objective, since nothing is looked at again; add [control] and "
              "[objective] or leave it out");
    scene.trajectory = trajectory(in.table("trajectory"));
  }
  if (in.has("check")) {
    Reader check = in.table("check");
    if (!scene.objective)
      in.fail(
          "check",
          "takes derivatives of an objective by a control; add [control] and [objective] or leave it out");
    scene.check.control = controls(check, "control", *scene.control);
    check.finish();
  }
  if (in.has("exact"))
    scene.exact = exact(in.table("exact"), !scene.contacts.empty());
  if (in.has("run")) {
    Reader run = in.table("run");
    scene.run.invariants = run.choice("invariants", {"warn", "stop", "off"}, scene.run.invariants);
    scene.run.tolerance =
        run.number("tolerance", {.least = 0, .greatest = 1, .open = true}, scene.run.tolerance);
    run.finish();
  }
  if (in.has("output")) {
    Reader output = in.table("output");
    scene.output.every = output.integer("every", 1, Time::most_steps, scene.output.every);
    if (output.has("fields"))
      scene.output.fields = output.names("fields", Output{}.fields);
    if (output.has("tables"))
      scene.output.tables = output.names("tables", Output{}.tables);
    output.finish();
  }
  in.finish();
  return scene;
}

std::string contact_key(const std::vector<Contact>& contacts, std::size_t i) {
  return contacts.size() == 1 ? "contact" : fmt::format("contact[{}]", i);
}

std::string clamp_key(const std::vector<Clamp>& clamps, std::size_t i) {
  return clamps.size() == 1 ? "clamp" : fmt::format("clamp[{}]", i);
}

std::vector<std::string> component_names(int dim) {
  std::vector<std::string> names{"x", "y", "z"};
  names.resize(static_cast<std::size_t>(dim));
  return names;
}

bool vanishes(const Components& components) {
  return std::ranges::all_of(components,
                             [](const std::string& text) { return text == "0" || text == "0.0"; });
}

bool rests(const Control& control) {
  const auto all = [](const std::optional<std::vector<double>>& bound, auto&& allows) {
    return !bound || std::ranges::all_of(*bound, allows);
  };
  return (!control.initial || vanishes(*control.initial)) &&
         all(control.lower, [](double x) { return x <= 0; }) &&
         all(control.upper, [](double x) { return x >= 0; });
}

void require_dimension(const Scene& scene, int dim) {
  const auto require = [&](std::size_t size, const std::string& key, bool one_allowed = false) {
    if (size != static_cast<std::size_t>(dim) && !(one_allowed && size == 1))
      throw UserError(fmt::format("{}: {}: found {} components, allowed are {}: the mesh is {}-dimensional",
                                  scene.file.string(), key, size, dim, dim));
  };
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const std::string key = contact_key(scene.contacts, i) + ".obstacle.";
    const Obstacle& obstacle = scene.contacts[i].obstacle;
    if (const auto* half_space = std::get_if<HalfSpace>(&obstacle))
      require(half_space->point.size(), key + "point");
    else if (const auto* ball = std::get_if<Ball>(&obstacle))
      require(ball->center.size(), key + "center");
    else if (const auto* cylinder = std::get_if<Cylinder>(&obstacle))
      require(cylinder->point.size(), key + "point");
  }
  const std::vector<std::string> names = component_names(dim);
  const auto require_names = [&](const std::optional<std::vector<std::string>>& components,
                                 const std::string& key) {
    for (const std::string& name : components.value_or(names))
      if (std::ranges::find(names, name) == names.end())
        throw UserError(fmt::format("{}: {}: found \"{}\", allowed: {}: the mesh is {}-dimensional",
                                    scene.file.string(), key, name, list(names), dim));
  };
  for (std::size_t i = 0; i < scene.clamps.size(); ++i) {
    const Clamp& clamp = scene.clamps[i];
    require_names(clamp.components, clamp_key(scene.clamps, i) + ".components");
    if (clamp.value && !clamp.components)
      require(clamp.value->size(), clamp_key(scene.clamps, i) + ".value");
  }
  if (scene.load && scene.load->body)
    require(scene.load->body->size(), "load.body");
  for (std::size_t i = 0; scene.load && i < scene.load->tractions.size(); ++i)
    require(scene.load->tractions[i].value.size(), fmt::format("load.traction[{}].value", i).c_str());
  if (scene.initial.displacement)
    require(scene.initial.displacement->size(), "initial.displacement");
  if (scene.initial.velocity)
    require(scene.initial.velocity->size(), "initial.velocity");
  if (scene.control) {
    require_names(scene.control->components, "control.components");
    if (scene.control->initial)
      require(scene.control->initial->size(), "control.initial");
    if (scene.control->lower)
      require(scene.control->lower->size(), "control.lower", true);
    if (scene.control->upper)
      require(scene.control->upper->size(), "control.upper", true);
  }
  if (scene.objective) {
    if (const auto* desired = std::get_if<DesiredControl>(&scene.objective->desired))
      require(desired->control.size(), "objective.desired.control");
    if (const auto* desired = std::get_if<DesiredDisplacement>(&scene.objective->desired))
      require(desired->displacement.size(), "objective.desired.displacement");
  }
  if (scene.check.control)
    require(scene.check.control->size(), "check.control");
  if (scene.exact && scene.exact->displacement)
    require(scene.exact->displacement->size(), "exact.displacement");
}

} // namespace signorini::scene
