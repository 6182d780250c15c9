// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/schema.h"
#include "base/text.h"

namespace signorini::scene::schema {
using namespace kind;
namespace {

const Limits above_zero{.least = 0, .open = true}, not_negative{.least = 0};
const Limits weight{.least = 0, .unit = "weight"};

// Keys that several tables have.

template <class T>
Key<T> acting(const char* meaning) {
  return value("components", &T::components, Acting{}, "", meaning, {.otherwise = "`[\"x\", \"y\"]`"});
}

template <class T>
Key<T> radius() {
  return required("radius", &T::radius, Varying{above_zero}, "m", "of a ball or a cylinder");
}

template <class T>
Key<T> side() {
  return value("side", &T::side, Choice<Side>{}, "", "where the body is, of a ball or a cylinder");
}

} // namespace

Keys<Mesh> keys_of(Of<Mesh>) {
  return {
      required(
          "file", &Mesh::file, Path{}, "",
          "a .geo, which is meshed, or a .msh, relative to the scene file; physical groups are used by name",
          {.part = Part::none}),
      value("size", &Mesh::size, NumberOrAuto{{above_zero}}, "m",
            "element size for a .geo; `\"auto\"`: sizes that vary, small where the error comes from "
            "(`--accuracy`)",
            {.otherwise = "those that the .geo itself sets"}),
      value("scale", &Mesh::scale, Number{above_zero}, "",
            "in place of `mesh.size`, of the element sizes that the .geo itself sets", {.otherwise = "1.0"},
            [](const Mesh& mesh) { return !mesh.size && !mesh.meshed(); }),
      value("unit", &Mesh::unit, Choice<LengthUnit>{}, "",
            "of the coordinates in the file, which are brought to metres; all else of a scene, `mesh.size` "
            "too, is in "
            "metres"),
      value("degree", &Mesh::degree, Whole{1, 2}, "", "Lagrange degree of the displacement")};
}

Keys<Time> keys_of(Of<Time>) {
  return {
      required("end", &Time::end, Number{above_zero}, "s", "of the motion, which starts at 0"),
      required(
          "step", &Time::step, NumberOrAuto{{above_zero}}, "s",
          "`time.end` is a whole multiple of it; `\"auto\"`: lengths that vary, chosen by an estimate of "
          "their error",
          {.effect = "steps of varying length"}),
      value(
          "tolerance", &Time::tolerance,
          Number{{.least = Time::least_tolerance, .greatest = Time::most_tolerance}}, "",
          "of `step = \"auto\"`: error that the steps may leave, relative to the largest value of `quantity`",
          {.effect = "steps of varying length"}, &Time::automatic_steps),
      value("quantity", &Time::quantity, Choice<StepQuantity>{}, "",
            "of `step = \"auto\"`: what the error is of; `\"contact-force\"` the impulses of contact, "
            "`\"energy\"` the whole motion, in the norm of its energy",
            {.effect = "steps of varying length"}, &Time::automatic_steps),
      value("longest", &Time::longest, Number{above_zero}, "s",
            "of `step = \"auto\"`: no step is longer; shortened to a part of `time.end`",
            {.otherwise = "a tenth of `time.end`", .effect = "steps of varying length"}),
      value("shortest", &Time::shortest, Number{above_zero}, "s",
            "of `step = \"auto\"`: no step is shorter, whatever its error",
            {.otherwise = "the longest halved 20 times", .effect = "steps of varying length"}),
      value("scheme", &Time::scheme, Choice<TimeScheme>{}, "",
            "`\"contact-stabilized\"`: the motion without forces is first moved out of the obstacle, which "
            "smooths the contact forces",
            {.effect = "contact-stabilized"})};
}

Keys<Viscosity> keys_of(Of<Viscosity>) {
  return {required("bulk", &Viscosity::bulk, Number{not_negative}, "Pa s",
                   "without `viscosity` the body is elastic"),
          required("shear", &Viscosity::shear, Number{not_negative}, "Pa s")};
}

Keys<Material> keys_of(Of<Material>) {
  return {value("on", &Material::on, Text{}, "",
                "for a body of several materials, each in a table `[[material]]` in place of `[material]`: a "
                "group of surfaces (in space, volumes). Every cell must be in the group of one; `--set "
                "material.0.young=…` names the first",
                {.effect = "several materials"}),
          required("density", &Material::density, Number{above_zero}, "kg/m³"),
          required("young", &Material::young, Number{above_zero}, "Pa", "Young's modulus"),
          required("poisson", &Material::poisson, Number{{.least = -1, .greatest = 0.5, .open = true}}),
          inline_table("viscosity", &Material::viscosity, {.effect = "viscosity"})};
}

Keys<Clamp> keys_of(Of<Clamp>) {
  return {
      required("on", &Clamp::on, Text{}, "", "of the boundary that is held, in a table `[[clamp]]`"),
      acting<Clamp>("those held"),
      value("value", &Clamp::value, ClampMotion{}, "m",
            "the motion of each component held; its velocity at all times is their derivative. An "
            "`initial.velocity` that is written down is kept there, and must agree with it but for 1e-5 of "
            "its size",
            {.otherwise = "`[\"0\", \"0\"]`", .effect = "moving clamp"})};
}

Keys<HalfSpace> keys_of(Of<HalfSpace>) {
  return {
      required("point", &HalfSpace::point, Point{}, "m",
               "on the plane or the cylinder's axis; where an expression of an obstacle has t it moves (see "
               "Candidates)",
               {.effect = "moving obstacle"}),
      required("normal", &HalfSpace::normal, Direction{{}, "it points out of the obstacle"}, "",
               "of a half-space, out of the obstacle, of any length")};
}

Keys<Ball> keys_of(Of<Ball>) {
  return {required("center", &Ball::center, Point{}, "m", "of a ball"), radius<Ball>(), side<Ball>()};
}

Keys<Cylinder> keys_of(Of<Cylinder>) {
  return {required("point", &Cylinder::point, Point{}, "m"),
          value("axis", &Cylinder::axis, Direction{{}, "it points along the cylinder"}, "",
                "of a cylinder in space; in the plane it is a disc and has none",
                {.otherwise = "required in space"},
                [](const Cylinder& cylinder) { return !cylinder.axis.empty(); }),
          radius<Cylinder>(), side<Cylinder>()};
}

Keys<SignedDistance> keys_of(Of<SignedDistance>) {
  return {required(
      "distance", &SignedDistance::distance, Formula{{}, true}, "",
      "of a signed distance: positive outside of the obstacle, such as `\"y + 1 - 0.1*x^2\"`, in any unit")};
}

namespace {

template <class... Shapes>
std::vector<std::vector<Entry>> entries_of(const std::variant<Shapes...>*) {
  return {entries<Shapes>()...};
}

static_assert(std::variant_size_v<Obstacle> == names(Shape{}).size());

/// Makes the key with the table of an obstacle of any shape.
Key<Contact> obstacle() {
  const std::vector<std::string> shapes = all_names<Shape>();
  const KeyInfo said{
      .required = true,
      .meaning = "in turn with `point` and `normal`; with `center`, `radius`, `side`; with `point`, `axis`, "
                 "`radius`, `side`; with `distance`"};
  const Entry called{"name",
                     {.meaning = "in tables and messages", .part = Part::none},
                     Text{"text"}.words(),
                     "by order, `\"obstacle 1\"`, `\"obstacle 2\"` …",
                     Text::schema(),
                     {}};
  Key<Contact> key{{"obstacle", {.required = true, .effect = "contact"}, {}, {}, {}, {}}};
  for (const auto& keys : entries_of(static_cast<const Obstacle*>(nullptr))) {
    const std::string& name = shapes[key.json["oneOf"].size()];
    std::vector<Entry> all{{"shape", said, quoted(shapes), {}, {{"const", name}}, {}}, called};
    all.insert(all.end(), keys.begin(), keys.end());
    key.json["oneOf"].push_back(object(all));
    key.children.insert(key.children.end(), all.begin(), all.end());
  }
  key.read = [](Reader& in, Contact& to, const Scene& scene) {
    Reader table = in.table("obstacle");
    to.name = obstacle_name(table, scene);
    to.obstacle = alternative(table.choice("shape", all_names<Shape>()), to.obstacle);
    std::visit([&](auto& one) { read_keys(table, one, scene); }, to.obstacle);
  };
  key.line = [](const Contact& from) {
    const auto shape = static_cast<Shape>(from.obstacle.index());
    const std::string first = fmt::format("name = {}, shape = {}", written(from.name), written(name(shape)));
    const auto on_line = [&](const auto& one) { return on_one_line(one, first); };
    return std::visit(on_line, from.obstacle);
  };
  return key;
}

} // namespace

Keys<Contact> keys_of(Of<Contact>) {
  return {required("on", &Contact::on, Text{}, "", "of the boundary whose nodes are the contact candidates",
                   {.effect = "contact"}),
          obstacle(),
          value("mass", &Contact::mass, Choice<ContactMass>{}, "",
                "`\"massless\"`: candidates that face the obstacle have no mass towards it, their neighbours "
                "have it; not "
                "with `\"contact-stabilized\"`",
                {.effect = "massless contact"}),
          value("initial", &Contact::initial, Choice<ContactStart>{}, "",
                "`\"project\"`: nodes that start inside the obstacle are moved the shortest way out")};
}

Keys<Traction> keys_of(Of<Traction>) {
  return {required("on", &Traction::on, Text{}, "",
                   "of the boundary that is pushed, in a table `[[load.traction]]`"),
          required("value", &Traction::value, Expressions{}, "N/m²")};
}

Keys<Load> keys_of(Of<Load>) {
  return {value("body", &Load::body, Expressions{}, "N/m³", "", {.otherwise = "none", .effect = "body load"}),
          value("gravity", &Load::gravity, Point{}, "m/s²",
                "acts by the density of each material, such as `[0, -9.81]`",
                {.otherwise = "none", .effect = "gravity"}),
          sections("traction", &Load::tractions, {.effect = "traction"})};
}

Keys<Initial> keys_of(Of<Initial>) {
  return {value("displacement", &Initial::displacement, Expressions{.time = false}, "m", "",
                {.otherwise = "`[\"0\", \"0\"]`", .effect = "initial displacement"}),
          value("velocity", &Initial::velocity, Expressions{.time = false}, "m/s", "",
                {.otherwise = "`[\"0\", \"0\"]`", .effect = "initial velocity"})};
}

Keys<StoredControl> keys_of(Of<StoredControl>) {
  return {required("run", &StoredControl::folder, Path{}, "",
                   "in place of expressions: the folder of an earlier `optimize`, relative to the scene "
                   "file. Body, place, `control.scale` and `control.on` must be the same, its components "
                   "among this scene's; other meshes and steps are interpolated",
                   {.part = Part::none})};
}

namespace {

/// Makes the two keys `initial` of the first guess: expressions, or the table that names a run.
std::array<Key<Control>, 2> first_guess() {
  Key<Control> given =
      value("initial", &Control::initial, ControlField{}, "",
            "the first guess, and what `simulate` applies, moved into the bounds; without t if "
            "constant in time",
            {.otherwise = "`[\"0\", \"0\"]`"});
  Key<Control> stored = inline_table("initial", &Control::stored, {});
  given.read = [read = given.read](Reader& in, Control& to, const Scene& scene) {
    if (!in.is_table("initial"))
      read(in, to, scene);
  };
  stored.read = [read = stored.read](Reader& in, Control& to, const Scene& scene) {
    if (in.is_table("initial"))
      read(in, to, scene);
  };
  stored.json = {{"anyOf", {given.json, stored.json}}};
  return {given, stored};
}

} // namespace

Keys<Control> keys_of(Of<Control>) {
  const auto [given, stored] = first_guess();
  return {
      required("scale", &Control::scale,
               Number{{.least = 0, .open = true, .unit = "N/m² (of the body, N/m³)"}},
               "N/m³ per unit of control, N/m² on a surface"),
      value("on", &Control::on, Text{}, "",
            "of the body, or of the boundary, where the control is a traction", {.otherwise = "the body"}),
      acting<Control>("those that act"),
      value("constant_in_time", &Control::constant_in_time, Flag{}, "", "the same at all times"),
      value("step", &Control::step, Number{above_zero}, "s",
            "length of the intervals on which the control is constant, a whole part of `time.end`; a time "
            "step takes the mean over its duration",
            {.otherwise = "the time steps"}),
      value("space", &Control::space, Choice<ControlValues>{}, "",
            "values at the displacement's own nodes, of degree 2 midpoints of edges too, or in the cells"),
      given,
      stored,
      value("lower", &Control::lower, Bound{}, "", "bound",
            {.otherwise = "none", .effect = "control bounds"}),
      value("upper", &Control::upper, Bound{}, "", "bound",
            {.otherwise = "none", .effect = "control bounds"})};
}

Keys<DesiredControl> keys_of(Of<DesiredControl>) {
  return {required("control", &DesiredControl::control, ControlField{}, "",
                   "the desired motion is that under this control")};
}

Keys<DesiredDisplacement> keys_of(Of<DesiredDisplacement>) {
  return {required("displacement", &DesiredDisplacement::displacement, Expressions{}, "m",
                   "in place of `control`: the desired motion")};
}

Keys<DesiredRun> keys_of(Of<DesiredRun>) {
  return {
      required("run", &DesiredRun::folder, Path{}, "",
               "in place of `control`: the folder of an earlier run with a stored displacement, relative to "
               "the scene file. Degree 1, the same mesh, any number of ranks; interpolated linearly in time",
               {.part = Part::none})};
}

namespace {

/// Makes the key with the table of the desired motion, whose only key is its kind.
Key<Objective> desired() {
  Key<Objective> key{{"desired",
                      {.required = true},
                      {},
                      {},
                      {},
                      entries<DesiredControl, DesiredDisplacement, DesiredRun>()}};
  for (const Entry& one : key.children)
    key.json["oneOf"].push_back(object({one}));
  key.read = [names = key.children](Reader& in, Objective& to, const Scene& scene) {
    Reader table = in.table("desired");
    std::vector<std::string> found;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (table.has(names[i].name)) {
        found.push_back(names[i].name);
        to.desired = alternative(i, to.desired);
      }
    if (found.empty())
      table.finish(); // reports a misspelt key, the likeliest reason
    if (found.size() != 1)
      in.fail("desired", fmt::format("found {}; give one of control, displacement, run",
                                     found.empty() ? "none" : list(found)));
    std::visit([&](auto& one) { read_keys(table, one, scene); }, to.desired);
  };
  key.line = [](const Objective& from) {
    return std::visit([](const auto& one) { return on_one_line(one); }, from.desired);
  };
  return key;
}

} // namespace

Keys<Objective> keys_of(Of<Objective>) {
  return {desired(),
          value("on", &Objective::on, Text{}, "", "of the body or the boundary where the motion counts",
                {.otherwise = "the body"}),
          value("tracking", &Objective::tracking, Number{weight}, "", "weight of the motion",
                {.effect = "tracking term"}),
          value("alpha", &Objective::alpha, Number{weight}, "", "weight of the control's cost",
                {.effect = "control cost"}),
          value("gamma", &Objective::gamma, Number{{.least = 0, .unit = "weight, s"}}, "s",
                "weight of the end state", {.effect = "terminal term"})};
}

Keys<Prior> keys_of(Of<Prior>) {
  return {required("mean", &Prior::mean, Number{}, "",
                   "what is known of it before, a normal distribution; in the unknown's unit"),
          required("deviation", &Prior::deviation, Number{above_zero}, "",
                   "standard; of an unknown on a logarithmic scale relative, such as 0.1")};
}

Keys<Unknown> keys_of(Of<Unknown>) {
  return {
      required("of", &Unknown::of, Choice<Parameter>{}, "",
               "what is sought, in a table `[[unknown]]`. Of a material: a modulus or the density. Of the "
               "initial fields: a component's value in the whole body or, without `component`, a factor. Of "
               "an obstacle: a plane's shift along its normal (m) and angle (rad), a ball's or cylinder's "
               "`center` and `radius`. Of a load: a factor"),
      value("name", &Unknown::name, Text{"text"}, "", "in tables",
            {.otherwise = "by `of`, such as `\"young\"`"}),
      value("on", &Unknown::on, Text{}, "", "whose material or traction, where there are several",
            {.otherwise = "the only one"}),
      value("obstacle", &Unknown::obstacle, Text{"name of an obstacle"}, "", "whose, where there are several",
            {.otherwise = "the only one"}),
      value("component", &Unknown::component, Choice<Component>{}, "",
            "of an initial field or a centre; in space, the axis about which a plane's `angle` turns",
            {.otherwise = "none"}),
      value("start", &Unknown::start, Number{}, "", "first guess", {.otherwise = "the scene's own value"}),
      value("lower", &Unknown::lower, Number{}, "", "bound",
            {.otherwise = "its nature's; with `\"log\"` 1.5e-8 `start`"}),
      value("upper", &Unknown::upper, Number{}, "", "bound",
            {.otherwise = "its nature's; with `\"log\"` 6.7e7 `start`"}),
      value("scale", &Unknown::scale, Choice<ParameterScale>{}, "",
            "on which it is sought and its deviation given, relative for `\"log\"`",
            {.otherwise = "`\"log\"` for moduli, viscosities, densities"}),
      inline_table("prior", &Unknown::prior, {})};
}

Keys<Measurement> keys_of(Of<Measurement>) {
  return {
      required(
          "of", &Measurement::of, Choice<Quantity>{}, "",
          "in a table `[[measurement]]`: motion of a point or group; an obstacle's resultant force or "
          "impulse so far. With the contact-implicit scheme the force is the mean of two steps. Contact "
          "times, the time from 1 to 99 % of the impulse and the sustained peak are compared, not fitted"),
      value("name", &Measurement::name, Text{"text"}, "", "in tables",
            {.otherwise = "by order, `\"measurement 1\"` …"}),
      value("point", &Measurement::point, Numbers{}, "m", "of the undeformed body", {.otherwise = "none"}),
      value("on", &Measurement::on, Text{}, "", "in place of `point`: the mean over it",
            {.otherwise = "none"}),
      value("obstacle", &Measurement::obstacle, Text{"name of an obstacle"}, "", "of a force or an impulse",
            {.otherwise = "all together"}),
      value("component", &Measurement::component, Choice<Component>{}, "", "of the quantity",
            {.otherwise = "required where fitted"}),
      value("file", &Measurement::file, Path{}, "",
            "CSV of its own times and values, relative to the scene file; `simulate --measure` writes it. "
            "Names of columns may end with units, as `time [ms]`",
            {.otherwise = "required where fitted", .part = Part::none}),
      value("column", &Measurement::column, Text{"text"}, "", "of the values in the file"),
      value("value", &Measurement::value, Number{above_zero}, "s or N", "of what is compared",
            {.otherwise = "none"}),
      value("deviation", &Measurement::deviation, Number{above_zero}, "",
            "standard, of each value, in its unit", {.otherwise = "the file's column `deviation`"}),
      value("noise", &Measurement::noise, Number{above_zero}, "",
            "in place of `deviation` and of the file's column: relative to the largest value",
            {.otherwise = "none"})};
}

Keys<Optimizer> keys_of(Of<Optimizer>) {
  const auto with_controls = [](const Optimizer& optimizer) {
    return optimizer.method != OptimizerMethod::gauss_newton;
  };
  return {
      value("method", &Optimizer::method, Choice<OptimizerMethod>{}, "", "see The optimizers",
            {.part = Part::search}),
      value("start", &Optimizer::start, Choice<SearchStart>{}, "",
            "`\"coarse\"`: the search begins on meshes of 4 and 2 times `mesh.size`, with steps as many "
            "times as long; `\"guess\"`: at `control.initial` (see From coarse to fine)",
            {.otherwise = "`\"coarse\"` for a .geo with `mesh.size`; `\"guess\"` with a .msh, "
                          "`control.initial.run`, `objective.desired.run` or `\"projected-gradient\"`"}),
      value("max_iterations", &Optimizer::max_iterations, Whole{0, 1'000'000}, "",
            "0: the first guess alone"),
      value("tolerance", &Optimizer::tolerance, Number{{.least = 0, .greatest = 1, .unit = "no unit"}}, "",
            "of the gradient norm, relative to the first guess's; of the decrement with `\"gauss-newton\"`",
            {.otherwise = fmt::format("`{:g}`; `{:g}` with `\"gauss-newton\"`", Optimizer::usual_tolerance,
                                      Optimizer::usual_of_fits)}),
      value("checkpoint", &Optimizer::checkpoint, Whole{0, 1'000'000},
            "iterations from one to the next; 0: none", "see Long runs", {}, with_controls),
      value("memory", &Optimizer::memory, Number{not_negative}, "bytes",
            "of the controls and gradients that a search stores, in single precision, on all ranks (see Long "
            "runs)",
            {.otherwise = "`0`: `1e8`, at least the room of 128 controls"}, with_controls)};
}

Keys<Trajectory> keys_of(Of<Trajectory>) {
  return {value("storage", &Trajectory::storage, Choice<Storage>{}, "",
                "where the states of a motion are stored for the adjoint sweep. `\"disk\"`: in a file "
                "without a name in `$TMPDIR`, else `/var/tmp`. `\"checkpoints\"`: a few in memory, from "
                "which the others are recomputed. The gradients are the same (see Long runs)"),
          value("budget", &Trajectory::budget, Number{above_zero}, "bytes",
                "of all checkpoints, on all ranks; a computed desired motion (`objective.desired.control`) "
                "has half of them",
                {.otherwise = "`1e9` with checkpoints"},
                [](const Trajectory& trajectory) { return trajectory.storage == Storage::checkpoints; })};
}

Keys<Check> keys_of(Of<Check>) {
  return {required("control", &Check::control, ControlField{}, "",
                   "where `check` takes derivatives: expressions as those of `control.initial`, whose run is "
                   "taken without this key",
                   {.otherwise = "near the reference control; without one, the first guess"})};
}

Keys<Exact> keys_of(Of<Exact>) {
  const char* about = "what is known of the solution, for `study`";
  return {value("displacement", &Exact::displacement, Expressions{}, "m", about),
          value("pressure", &Exact::pressure, Formula{{}, false}, "N/m²",
                "on the contact surface at `time.end`", {.part = Part::measurement}),
          value("impulse", &Exact::impulse, Number{above_zero}, "N s",
                "of the contact forces in all (in the plane N s/m), modulus"),
          value("peak_force", &Exact::peak_force, Number{above_zero}, "N",
                "largest modulus of their resultant (in the plane N/m)"),
          value("contact_start", &Exact::contact_start, Number{above_zero}, "s", "of the first contact"),
          value("contact_time", &Exact::contact_time, Number{above_zero}, "s", "in all")};
}

Keys<Solver> keys_of(Of<Solver>) {
  return {
      value("vi", &Solver::vi, Choice<ViMethod>{}, "",
            "inequalities in the m candidates; or `\"full\"`: by PETSc's VI solver on all unknowns, the "
            "reference"),
      value(
          "linear", &Solver::linear, Choice<LinearMethod>{}, "",
          "conjugate gradients are `\"iterative\"`; `\"auto\"`: direct if the factor of D fits `memory` and "
          "conjugate gradients are not estimated to take clearly less time"),
      value("memory", &Solver::memory, Number{not_negative}, "bytes",
            "for the factor of D and the matrices of contact",
            {.otherwise = "half of the machine's", .part = Part::measurement})};
}

Keys<Run> keys_of(Of<Run>) {
  return {value("invariants", &Run::invariants, Choice<OnViolation>{}, "",
                "where the energy or momentum law or the contact condition is off: say so at the end, or "
                "stop there, or do not look"),
          value("tolerance", &Run::tolerance, Number{{.least = 0, .greatest = 1, .open = true}}, "",
                "of these and of those that `check` evaluates, relative")};
}

Keys<Probe> keys_of(Of<Probe>) {
  return {value("name", &Probe::name, Text{"text"}, "", "of its columns in `probes.csv`",
                {.otherwise = "by order, `\"probe 1\"`, `\"probe 2\"` …"}),
          value("point", &Probe::point, Numbers{}, "m",
                "of the undeformed body, in a table `[[output.probe]]`: displacement and velocity there"),
          value("on", &Probe::on, Text{}, "",
                "in place of `point`, of the body or of the boundary: mean displacement and velocity; where "
                "clamps hold nodes of the boundary, their reaction"),
          value("obstacle", &Probe::obstacle, Text{"name of an obstacle"}, "",
                "in place of `point`: the force by which it pushes the body, and its impulse so far"),
          value("body", &Probe::body, Flag{}, "",
                "in place of `point`, `true`: centre of mass, momentum, mean rotation (rad) of the body")};
}

Keys<Output> keys_of(Of<Output>) {
  return {
      value(
          "every", &Output::every, Whole{1, Time::most_steps}, "steps",
          "between stored fields and contact; the last step and that of the largest contact force are stored "
          "too. Other tables have a row for each step",
          {.otherwise = fmt::format("the least of 1, 2, 5, 10, … that stores {0} at most; with "
                                    "`time.step = \"auto\"` the first step after each {0}th of the time",
                                    Output::most_frames)},
          [](const Output& output) { return output.every > 0; }),
      value("fields", &Output::fields, Set<StoredField>{}, "",
            "those stored, where the verb has them, `\"strain\"` to `\"pressure\"` only if named (see "
            "Stress and "
            "pressure); `[]` for none, which then cost nothing",
            {.effect = "stored fields"}),
      value("tables", &Output::tables, Set<StoredTable>{}, "", "likewise", {.effect = "tables"}),
      sections("probe", &Output::probes, {.effect = "probes"})};
}

Keys<Scene> keys_of(Of<Scene>) {
  const auto searches = [](const Scene& scene) {
    return scene.objective.has_value() || !scene.unknowns.empty();
  };
  return {section("mesh", &Scene::mesh, {.required = true}),
          section("time", &Scene::time, {.required = true}),
          sections("material", &Scene::materials, {.required = true},
                   [](const std::vector<Material>& materials) { return !materials.front().on; }),
          sections("clamp", &Scene::clamps, {.effect = "clamp"}),
          sections("contact", &Scene::contacts, {.effect = "contact"},
                   [](const std::vector<Contact>& contacts) { return contacts.size() == 1; }),
          section("load", &Scene::load, {}),
          section("initial", &Scene::initial, {}),
          section("control", &Scene::control, {.effect = "control"}),
          section("objective", &Scene::objective, {.effect = "objective"}),
          sections("unknown", &Scene::unknowns, {.effect = "unknowns"}),
          sections("measurement", &Scene::measurements, {.effect = "measurements"}),
          section("optimizer", &Scene::optimizer, {.part = Part::none}, searches),
          section("trajectory", &Scene::trajectory, {.part = Part::measurement}, searches),
          section("check", &Scene::check, {.part = Part::measurement},
                  [](const Scene& scene) { return scene.check.control.has_value(); }),
          section("exact", &Scene::exact, {.part = Part::none}),
          section("solver", &Scene::solver, {}),
          section("run", &Scene::run, {.part = Part::none}),
          section("output", &Scene::output, {.part = Part::none})};
}

void read(Reader& in, Scene& scene) { read_keys(in, scene, scene); }
std::string write(const Scene& scene) { return lines("", scene).substr(1); }
std::vector<Entry> all() { return entries<Scene>(); }

} // namespace signorini::scene::schema
