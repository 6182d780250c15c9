// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/schema.h"
#include "base/text.h"

namespace signorini::scene::schema {
using namespace kind;
namespace {

const Limits above_zero{.least = 0, .open = true}, not_negative{.least = 0};
const Limits fraction{.least = 0, .greatest = 1}, weight{.least = 0, .unit = "weight"};

// Keys that several tables have.

template <class T>
Key<T> acting(const char* meaning) {
  return value("components", &T::components, Acting{}, "", meaning, {.otherwise = "`[\"x\", \"y\"]`"});
}

template <class T>
Key<T> radius() {
  return required("radius", &T::radius, Varying{above_zero}, "m", "radius of a ball or a cylinder");
}

template <class T>
Key<T> side() {
  return value("side", &T::side, Choice<Side>{}, "", "side of a ball or a cylinder on which the body is");
}

} // namespace

Keys<Mesh> keys_of(Of<Mesh>) {
  return {
      required("file", &Mesh::file, Path{}, "",
               "geometry (.geo or CAD), which the program meshes, or mesh (see Mesh files); the path is "
               "relative to "
               "the scene file. The scene names groups of this file",
               {.part = Part::none}),
      value(
          "size", &Mesh::size, NumberOrAuto{{above_zero}}, "m",
          "element size for a geometry; `\"auto\"`: variable sizes, small where the error arises (only with "
          "`--accuracy`)",
          {.otherwise = "the sizes that the .geo sets; required for CAD"}),
      value("scale", &Mesh::scale, Number{above_zero}, "",
            "in place of `mesh.size`: factor on the element sizes that the .geo sets", {.otherwise = "1.0"},
            [](const Mesh& mesh) { return !mesh.size && !mesh.meshed(); }),
      value("unit", &Mesh::unit, Choice<LengthUnit>{}, "",
            "length unit of the coordinates in the file, which are converted to metres; all other lengths of "
            "a scene, also `mesh.size`, are in metres. A .step or .iges names its unit itself",
            {}, [](const Mesh& mesh) { return !names_its_unit(mesh.file); }),
      value("split", &Mesh::split, Flag{}, "",
            "`true`: quadrilaterals, hexahedra, prisms and pyramids of a mesh are divided into triangles or "
            "tetrahedra; else they are refused",
            {}, [](const Mesh& mesh) { return mesh.format() != MeshFormat::shape; }),
      value("degree", &Mesh::degree, Whole{1, 2}, "", "Lagrange degree of the displacement"),
      value("model", &Mesh::model, Choice<PlaneModel>{}, "",
            "model of a body in the plane (see Bodies in the plane). `\"plane-strain\"`: a slice of a long "
            "body, per metre of depth. `\"plane-stress\"`: a thin plate, per metre of thickness. "
            "`\"axisymmetric\"`: the half section x >= 0 of a body of revolution, x is the radius and y the "
            "axis",
            {.otherwise = "`\"plane-strain\"` in the plane"})};
}

Keys<Time> keys_of(Of<Time>) {
  return {
      required(
          "end", &Time::end, NumberOrAuto{{above_zero}}, "s",
          "end time of the motion, which starts at 0. `\"auto\"`, only for `simulate` of a drop: until its "
          "restitution is decided, at the latest when a perfectly elastic bounce would have come down"),
      required(
          "step", &Time::step, NumberOrAuto{{above_zero}}, "s",
          "length of the time steps, which divides `time.end`; `\"auto\"`: variable lengths, chosen by an "
          "error estimate",
          {.effect = "steps of varying length"}),
      value("tolerance", &Time::tolerance,
            Number{{.least = Time::least_tolerance, .greatest = Time::most_tolerance}}, "",
            "with `step = \"auto\"`: largest error of the steps, relative to the largest value of `quantity`",
            {.effect = "steps of varying length"}, &Time::automatic_steps),
      value("quantity", &Time::quantity, Choice<StepQuantity>{}, "",
            "with `step = \"auto\"`: quantity whose error is estimated; `\"contact-force\"`: the impulses of "
            "contact, `\"energy\"`: the whole motion in the energy norm",
            {.effect = "steps of varying length"}, &Time::automatic_steps),
      value("longest", &Time::longest, Number{above_zero}, "s",
            "with `step = \"auto\"`: longest step, shortened so that it divides `time.end`, and to twice the "
            "times "
            "of branches of `material.prony` that the shortest step resolves",
            {.otherwise = "an eighth of `time.end`", .effect = "steps of varying length"}),
      value("shortest", &Time::shortest, Number{above_zero}, "s",
            "with `step = \"auto\"`: shortest step, whatever its error",
            {.otherwise = "the longest step, halved 20 times", .effect = "steps of varying length"}),
      value("scheme", &Time::scheme, Choice<TimeScheme>{}, "",
            "`\"contact-stabilized\"`: each step first projects the displacement at constant velocity out of "
            "the obstacle, which smooths the contact forces",
            {.effect = "contact-stabilized"})};
}

Keys<Viscosity> keys_of(Of<Viscosity>) {
  return {required("bulk", &Viscosity::bulk, Number{not_negative}, "Pa s",
                   "bulk viscosity; a material without `viscosity`, `rayleigh` and `prony` is elastic"),
          required("shear", &Viscosity::shear, Number{not_negative}, "Pa s")};
}

Keys<Rayleigh> keys_of(Of<Rayleigh>) {
  return {value("alpha", &Rayleigh::alpha, Number{not_negative}, "1/s",
                "damping `alpha` times the mass: a drag on every motion, also on a flight",
                {.effect = "mass damping"}),
          value("beta", &Rayleigh::beta, Number{not_negative}, "s",
                "damping `beta` times the stiffness, as the viscosities `beta` K and `beta` G; with `prony` "
                "the long-term stiffness")};
}

Keys<Branch> keys_of(Of<Branch>) {
  return {value("g", &Branch::g, Number{fraction}, "",
                "fraction of the instantaneous shear modulus that relaxes with the time `time`. A list "
                "`prony = [{ g = 0.3, k = 0.0, time = 1e-3 }, …]` has one table for each branch of the Prony "
                "series. The sum of all `g` is below 1"),
          value("k", &Branch::k, Number{fraction}, "",
                "fraction of the instantaneous bulk modulus that relaxes with the time `time`; the sum of "
                "all `k` is below 1. Each branch has `g` or `k` above 0"),
          required("time", &Branch::time, Number{above_zero}, "s", "relaxation time of the branch")};
}

Keys<Material> keys_of(Of<Material>) {
  return {value("on", &Material::on, Text{}, "",
                "for a body of several materials, each in a table `[[material]]` in place of `[material]`: "
                "group of surfaces (in space, volumes) of this material. Every cell must be in the group of "
                "exactly one material; `--set material.0.young=…` sets a key of the first table",
                {.effect = "several materials"}),
          required("density", &Material::density, Number{above_zero}, "kg/m³"),
          required("young", &Material::young, Number{above_zero}, "Pa",
                   "Young's modulus; with `prony` that of the moduli which `moduli` names"),
          required("poisson", &Material::poisson, Number{{.least = -1, .greatest = 0.5, .open = true}}, "",
                   "Poisson's ratio, of the same moduli"),
          inline_table("viscosity", &Material::viscosity, {.effect = "viscosity"}),
          inline_table("rayleigh", &Material::rayleigh, {.effect = "viscosity"}),
          inline_tables("prony", &Material::prony, {.effect = "relaxation"}),
          value("moduli", &Material::moduli, Choice<Moduli>{}, "",
                "with `prony`: meaning of `young` and `poisson`. `\"instantaneous\"`: at the instant of "
                "loading; `\"long-term\"`: after relaxation. The fractions `g` and `k` are of the "
                "instantaneous moduli in both cases",
                {.effect = "relaxation"}, [](const Material& material) { return material.relaxes(); })};
}

Keys<FoundationStiffness> keys_of(Of<FoundationStiffness>) {
  return {value("normal", &FoundationStiffness::normal, Number{not_negative}, "N/m³",
                "springs along the normal of the surface, to the ground"),
          value("tangential", &FoundationStiffness::tangential, Number{not_negative}, "N/m³",
                "springs across the normal")};
}

Keys<FoundationDamping> keys_of(Of<FoundationDamping>) {
  return {value("normal", &FoundationDamping::normal, Number{not_negative}, "N s/m³",
                "dashpots along the normal of the surface, to the ground"),
          value("tangential", &FoundationDamping::tangential, Number{not_negative}, "N s/m³",
                "dashpots across the normal")};
}

Keys<Foundation> keys_of(Of<Foundation>) {
  return {
      required("on", &Foundation::on, Text{}, "",
               "group of the boundary that springs and dashpots connect to the ground; each foundation is "
               "a table `[[foundation]]`"),
      inline_table("stiffness", &Foundation::stiffness, {}),
      inline_table("damping", &Foundation::damping, {}),
      value("absorbing", &Foundation::absorbing, Flag{}, "",
            "`true`, in place of `damping`: dashpots that absorb plane waves arriving along the normal. "
            "Along the "
            "normal they are `density` times the speed of pressure waves, across it of shear waves")};
}

Keys<Clamp> keys_of(Of<Clamp>) {
  return {required("on", &Clamp::on, Text{}, "",
                   "group of the boundary that is clamped; each clamp is a table `[[clamp]]`"),
          acting<Clamp>("components that are clamped"),
          value("value", &Clamp::value, ClampMotion{}, "m",
                "prescribed displacement of each clamped component; its velocity is the time derivative. If "
                "`initial.velocity` is given, it applies at t = 0 and must agree with this derivative to a "
                "relative error of 1e-5",
                {.otherwise = "`[\"0\", \"0\"]`", .effect = "moving clamp"})};
}

Keys<HalfSpace> keys_of(Of<HalfSpace>) {
  return {
      required("point", &HalfSpace::point, Point{}, "m",
               "point on the plane or on the cylinder's axis; an obstacle whose expressions contain t moves "
               "(see Candidates)",
               {.effect = "moving obstacle"}),
      required("normal", &HalfSpace::normal, Direction{{}, "it must point out of the obstacle"}, "",
               "normal of a half-space, pointing out of the obstacle, of any length")};
}

Keys<Ball> keys_of(Of<Ball>) {
  return {required("center", &Ball::center, Point{}, "m", "centre of a ball"), radius<Ball>(), side<Ball>()};
}

Keys<Cylinder> keys_of(Of<Cylinder>) {
  return {required("point", &Cylinder::point, Point{}, "m"),
          value("axis", &Cylinder::axis, Direction{{}, "it must point along the cylinder"}, "",
                "direction of a cylinder's axis in space; in the plane a cylinder is a disc and has no axis",
                {.otherwise = "required in space"},
                [](const Cylinder& cylinder) { return !cylinder.axis.empty(); }),
          radius<Cylinder>(), side<Cylinder>()};
}

Keys<SignedDistance> keys_of(Of<SignedDistance>) {
  return {required(
      "distance", &SignedDistance::distance, Formula{{}, true}, "",
      "expression for the shape `\"signed-distance\"`: positive outside of the obstacle, such as `\"y + 1 - "
      "0.1*x^2\"`, in any unit")};
}

Keys<RigidBody> keys_of(Of<RigidBody>) {
  const auto moves = [](KeyInfo info = {}) {
    info.effect = "rigid body";
    return info;
  };
  const auto without = [&](const char* otherwise) { return moves({.otherwise = otherwise}); };
  return {
      required("mass", &RigidBody::mass, Number{not_negative}, "kg",
               "mass of an obstacle that moves freely, hit by the body (in plane strain and plane stress "
               "kg/m; in axial symmetry of the whole obstacle). It starts at the given place, and "
               "`load.gravity` acts on it. 0 if `stiffness` holds it",
               moves()),
      value("velocity", &RigidBody::velocity, Numbers{}, "m/s", "velocity of its centre of mass at the start",
            without("at rest"), [](const RigidBody& body) { return !body.velocity.empty(); }),
      value("components", &RigidBody::components, Acting{}, "", "components in which it moves",
            without("`[\"x\", \"y\"]`; in axial symmetry `[\"y\"]`")),
      value("inertia", &RigidBody::inertia, Bound{}, "kg m²",
            "moments of inertia about its centre of mass: one in the plane, three in space, about the axes. "
            "It turns too, by small angles",
            without("it does not turn"), [](const RigidBody& body) { return !body.inertia.empty(); }),
      value("mass_center", &RigidBody::mass_center, Numbers{}, "m",
            "its centre of mass, about which it turns", without("the obstacle's point or centre"),
            [](const RigidBody& body) { return !body.mass_center.empty(); }),
      value("force", &RigidBody::force, Point{}, "N", "force on it, in plane strain and plane stress N/m",
            without("none")),
      value("stiffness", &RigidBody::stiffness, Bound{}, "N/m",
            "stiffness of springs to the ground, as those of a load cell; they are relaxed at the start",
            without("none"), [](const RigidBody& body) { return !body.stiffness.empty(); }),
      value("damping", &RigidBody::damping, Bound{}, "N s/m", "of dashpots to the ground", without("none"),
            [](const RigidBody& body) { return !body.damping.empty(); })};
}

namespace {

/// Reads the keys of an obstacle's mass if the table has any of them.
std::optional<RigidBody> rigid_body(Reader& table, const Scene& scene) {
  std::optional<RigidBody> body;
  for (const Key<RigidBody>& key : schema::table<RigidBody>())
    if (table.has(key.name))
      body.emplace();
  for (const Key<RigidBody>& key : schema::table<RigidBody>())
    if (body)
      key.read(table, *body, scene);
  return body;
}

template <class... Shapes>
std::vector<std::vector<Entry>> entries_of(const std::variant<Shapes...>*) {
  return {entries<Shapes>()...};
}

static_assert(std::variant_size_v<Obstacle> == names(Shape{}).size());

constexpr const char* surface_velocity = "surface_velocity";

/// Makes the key `obstacle`, a table whose keys depend on the shape.
Key<Contact> obstacle() {
  const std::vector<std::string> shapes = all_names<Shape>();
  const KeyInfo info{
      .required = true,
      .meaning = "shape; keys of the four shapes, in this order: `point` and `normal`; `center`, `radius` "
                 "and `side`; `point`, `axis`, `radius` and `side`; `distance`"};
  const Entry called{"name",
                     {.meaning = "name in tables and messages", .part = Part::none},
                     Text{"text"}.words(),
                     "`\"obstacle 1\"`, `\"obstacle 2\"` … by position in the scene",
                     Text::schema(),
                     {}};
  const Entry surface{
      surface_velocity,
      {.unit = "m/s",
       .meaning =
           "velocity of the obstacle's surface, added to that of the obstacle: a belt, or a roller that "
           "turns. Only with `contact.friction`",
       .effect = "friction"},
      Expressions{}.words(),
      "none",
      Expressions{}.schema(),
      {}};
  std::vector<Entry> of_mass = entries<RigidBody>();
  of_mass.front().info.required = false; // only with the others
  of_mass.front().fallback = "the obstacle rests or moves as its expressions say";
  Key<Contact> key{{"obstacle", {.effect = "contact"}, {}, "required without `against`", {}, {}}};
  for (const auto& keys : entries_of(static_cast<const Obstacle*>(nullptr))) {
    const std::string& name = shapes[key.json["oneOf"].size()];
    std::vector<Entry> all{{"shape", info, quoted(shapes), {}, {{"const", name}}, {}}, called, surface};
    for (const std::vector<Entry>& more : {keys, of_mass})
      all.insert(all.end(), more.begin(), more.end());
    key.json["oneOf"].push_back(object(all));
    key.children.insert(key.children.end(), all.begin(), all.end());
  }
  key.read = [](Reader& in, Contact& to, const Scene& scene) {
    if (in.has("against") && !in.has("obstacle"))
      return;
    if (!in.has("obstacle"))
      in.fail("obstacle", "missing, but required without `against`");
    Reader table = in.table("obstacle");
    to.name = obstacle_name(table, scene);
    to.obstacle = alternative(table.choice("shape", all_names<Shape>()), Obstacle{});
    to.surface_velocity.reset();
    if (table.has(surface_velocity))
      to.surface_velocity = Expressions{}.read(table, surface_velocity, scene);
    to.rigid = rigid_body(table, scene);
    std::visit([&](auto& one) { read_keys(table, one, scene); }, *to.obstacle);
  };
  key.line = [](const Contact& from) {
    if (!from.obstacle)
      return Written{};
    const auto shape = static_cast<Shape>(from.obstacle->index());
    std::string first = fmt::format("name = {}, shape = {}", written(from.name), written(name(shape)));
    if (from.surface_velocity)
      first += fmt::format(", {} = {}", surface_velocity, written(*from.surface_velocity));
    if (from.rigid)
      first += ", " + listed(*from.rigid);
    const auto on_line = [&](const auto& one) { return on_one_line(one, first); };
    return std::visit(on_line, *from.obstacle);
  };
  return key;
}

/// Makes the keys of contact with another part of the body.
std::array<Key<Contact>, 3> other_part() {
  const auto of_parts = [](const char* otherwise) {
    return KeyInfo{.otherwise = otherwise, .effect = "contact of parts"};
  };
  Key<Contact> against =
      value("against", &Contact::against, Text{}, "",
            "in place of `obstacle`: group of the boundary of another part of the same mesh, with which the "
            "group `on` is in contact. The two groups have no node in common. In tables and messages the "
            "pair has the name `\"on/against\"`, of the two groups",
            of_parts("contact with `obstacle`"));
  against.read = [read = against.read](Reader& in, Contact& to, const Scene& scene) {
    read(in, to, scene);
    if (to.against)
      to.name = pair_name(in, to, scene);
  };
  return {std::move(against),
          value("slave", &Contact::slave, Choice<ContactSide>{}, "",
                "side whose nodes are the candidates: `\"on\"` or `\"against\"`",
                of_parts("the side with the smaller facets")),
          value("height", &Contact::height, Number{}, "m",
                "shift of the surface `against` along its mean outward normal, by which the gap is smaller "
                "than in the mesh",
                {.effect = "contact of parts"},
                [](const Contact& contact) { return contact.against.has_value(); })};
}

/// Makes the two keys named `friction`: one with a coefficient, one with a table that has a bound.
std::array<Key<Contact>, 2> friction() {
  Key<Contact> coefficient =
      value("friction", &Contact::friction, Coefficient{{not_negative}}, "",
            "coefficient of Coulomb friction between the body and the obstacle", {.effect = "friction"},
            [](const Contact& contact) { return !contact.bound; });
  return value_or_table(std::move(coefficient), inline_table("friction", &Contact::bound, {}));
}

} // namespace

Keys<FrictionBound> keys_of(Of<FrictionBound>) {
  return {
      required("bound", &FrictionBound::traction, Coefficient{{not_negative}}, "Pa",
               "in place of a coefficient: largest tangential traction of Tresca friction. It acts on the "
               "whole group `contact.on`, whether or not it touches the obstacle",
               {.effect = "friction"})};
}

Keys<Contact> keys_of(Of<Contact>) {
  const auto [coefficient, bound] = friction();
  const auto [against, slave, height] = other_part();
  return {required("on", &Contact::on, Text{}, "",
                   "group of the boundary whose nodes are the contact candidates", {.effect = "contact"}),
          obstacle(),
          against,
          slave,
          height,
          value("mass", &Contact::mass, Choice<ContactMass>{}, "",
                "`\"massless\"`: candidates that face the obstacle have no mass in the normal direction; "
                "their neighbours take this mass. Not with `\"contact-stabilized\"`. "
                "`\"massless-tangential\"`: they have no mass along the obstacle, which smooths friction "
                "forces; only with friction and `\"contact-stabilized\"`",
                {.effect = "massless contact"}),
          coefficient,
          bound,
          value("initial", &Contact::initial, Choice<ContactStart>{}, "",
                "`\"project\"`: nodes that start inside the obstacle are moved out by the shortest path")};
}

Keys<Traction> keys_of(Of<Traction>) {
  return {required("on", &Traction::on, Text{}, "",
                   "group of the boundary that is loaded; each traction is a table `[[load.traction]]`"),
          required("value", &Traction::value, Expressions{}, "N/m²")};
}

Keys<PointForce> keys_of(Of<PointForce>) {
  return {
      required("at", &PointForce::at, Numbers{}, "m",
               "point of the undeformed body at which there is a node; each force is a table "
               "`[[load.point]]`"),
      required(
          "value", &PointForce::value, Point{}, "N",
          "force, as expressions in t; in plane strain and plane stress N/m. The displacement of its node "
          "depends on the mesh")};
}

Keys<Load> keys_of(Of<Load>) {
  return {value("body", &Load::body, Expressions{}, "N/m³", "", {.otherwise = "none", .effect = "body load"}),
          value("gravity", &Load::gravity, Point{}, "m/s²",
                "acceleration, such as `[0, -9.81]`; the force density is the density of each material times "
                "this vector",
                {.otherwise = "none", .effect = "gravity"}),
          sections("traction", &Load::tractions, {.effect = "traction"}),
          sections("point", &Load::points, {.effect = "point force"})};
}

Keys<Drop> keys_of(Of<Drop>) {
  return {
      required("height", &Drop::height, Number{above_zero}, "m",
               "height from which the body is dropped. It starts with the speed of a free fall from there by "
               "`load.gravity`, moved along gravity until it touches an obstacle. Not with `velocity`",
               {.effect = "drop"})};
}

Keys<Initial> keys_of(Of<Initial>) {
  return {
      value("displacement", &Initial::displacement, Expressions{.time = false}, "m", "",
            {.otherwise = "`[\"0\", \"0\"]`", .effect = "initial displacement"}),
      value("velocity", &Initial::velocity, Expressions{.time = false}, "m/s", "",
            {.otherwise = "`[\"0\", \"0\"]`", .effect = "initial velocity"}),
      inline_table("drop", &Initial::drop, {.effect = "drop"}),
      value("static", &Initial::equilibrium, Flag{}, "",
            "`true`: the displacement is that of the equilibrium without friction under the loads of t = 0. "
            "Along directions in which nothing holds the body it is that of a body which the loads "
            "accelerate without vibrations. Not with `displacement`",
            {.effect = "static start"})};
}

Keys<StoredControl> keys_of(Of<StoredControl>) {
  return {
      required("run", &StoredControl::folder, Path{}, "",
               "in place of expressions: folder of an earlier run of `optimize`, relative to the scene "
               "file. Body, its position, `control.scale` and `control.on` must be the same. The components "
               "of the stored control must be among those of this scene's control; from another mesh or "
               "other steps the control is interpolated",
               {.part = Part::none})};
}

namespace {

/// Makes the two keys named `initial` for a control's first guess: one with expressions, one with a table
/// that names a run.
std::array<Key<Control>, 2> first_guess() {
  return value_or_table(value("initial", &Control::initial, ControlField{}, "",
                              "first guess of `optimize` and control of `simulate`, clipped to the bounds; "
                              "expressions must not contain t if the control is constant in time",
                              {.otherwise = "`[\"0\", \"0\"]`"}),
                        inline_table("initial", &Control::stored, {}));
}

} // namespace

Keys<Control> keys_of(Of<Control>) {
  const auto [given, stored] = first_guess();
  return {
      required("scale", &Control::scale,
               Number{{.least = 0, .open = true, .unit = "N/m² (of the body, N/m³)"}},
               "N/m³ per unit of control, N/m² on a surface"),
      value("on", &Control::on, Text{}, "",
            "group of the body where the control acts, or of the boundary, where it is a traction",
            {.otherwise = "the body"}),
      acting<Control>("components of the control"),
      value("constant_in_time", &Control::constant_in_time, Flag{}, "",
            "`true`: the control is the same at all times"),
      value("step", &Control::step, Number{above_zero}, "s",
            "length of the intervals on which the control is constant, which divides `time.end`; each time "
            "step uses the mean of the control over the step",
            {.otherwise = "the time steps"}),
      value("space", &Control::space, Choice<ControlValues>{}, "",
            "`\"nodal\"`: values at the nodes of the displacement, with degree 2 also at midpoints of edges; "
            "`\"cellwise\"`: one value per cell"),
      given,
      stored,
      value("lower", &Control::lower, Bound{}, "", "lower bound of the control",
            {.otherwise = "none", .effect = "control bounds"}),
      value("upper", &Control::upper, Bound{}, "", "upper bound of the control",
            {.otherwise = "none", .effect = "control bounds"})};
}

Keys<DesiredControl> keys_of(Of<DesiredControl>) {
  return {required("control", &DesiredControl::control, ControlField{}, "",
                   "reference control; the motion under this control is the desired motion")};
}

Keys<DesiredDisplacement> keys_of(Of<DesiredDisplacement>) {
  return {required("displacement", &DesiredDisplacement::displacement, Expressions{}, "m",
                   "in place of `control`: desired displacement")};
}

Keys<DesiredRun> keys_of(Of<DesiredRun>) {
  return {required(
      "run", &DesiredRun::folder, Path{}, "",
      "in place of `control`: folder of an earlier run that stored the displacement, relative to the scene "
      "file. That run must have degree 1 and the same mesh; the number of ranks may differ. The "
      "displacement is interpolated linearly in time",
      {.part = Part::none})};
}

namespace {

/// Makes the key `desired`, a table with one key, which determines the kind of the desired motion.
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
  return {
      desired(),
      value("on", &Objective::on, Text{}, "",
            "group of the body or the boundary on which the motion is compared with the desired one",
            {.otherwise = "the body"}),
      value("obstacle", &Objective::obstacle, Text{"name of an obstacle"}, "",
            "in place of `on`: obstacle with mass whose translation is compared; squared distances are in "
            "m² then",
            {.otherwise = "none"}),
      value("tracking", &Objective::tracking, Number{weight}, "",
            "weight of the distance to the desired motion over time", {.effect = "tracking term"}),
      value("alpha", &Objective::alpha, Number{weight}, "", "weight of the control's cost",
            {.effect = "control cost"}),
      value("gamma", &Objective::gamma, Number{{.least = 0, .unit = "weight, s"}}, "s",
            "weight of the distance to the desired state at `time.end`", {.effect = "terminal term"}),
      value("exponent", &Objective::exponent, Number{{.least = 1, .greatest = Objective::most_exponent}}, "",
            "with tables `[[scenario]]`: p in J = (Σ w_s J_s^p)^(1/p). `1`: the expectation; a large one, "
            "such as `20`: nearly the worst case",
            {.otherwise = "`1.0`, the expectation", .effect = "scenarios"},
            [](const Objective& objective) { return objective.exponent != 1; })};
}

Keys<Scenario> keys_of(Of<Scenario>) {
  return {
      value("name", &Scenario::name, Text{"text"}, "",
            "name in tables; each scenario is a table `[[scenario]]`. `optimize` then seeks one control for "
            "all scenarios; `simulate` computes the motion of the scene itself",
            {.otherwise = "`\"scenario 1\"` … by position in the scene"}),
      value("weight", &Scenario::weight, Number{weight}, "",
            "weight w_s of the scenario's J_s, relative to the sum of all weights"),
      value("set", &Scenario::set, Changes{}, "",
            "keys of `material`, `foundation`, `clamp`, `contact`, `load`, `initial` or `objective.desired`, "
            "as `--set` takes them, with their values in this scenario, such as "
            "`{ \"initial.velocity\" = [\"1.2\", \"0\"] }`",
            {.otherwise = "none: the scene itself"})};
}

Keys<Prior> keys_of(Of<Prior>) {
  return {
      required("mean", &Prior::mean, Number{}, "",
               "mean of the unknown's normal prior distribution, in the unknown's unit"),
      required("deviation", &Prior::deviation, Number{above_zero}, "",
               "standard deviation of the prior; for an unknown on a logarithmic scale it is relative, such "
               "as 0.1")};
}

Keys<Unknown> keys_of(Of<Unknown>) {
  return {
      required(
          "of", &Unknown::of, Choice<Parameter>{}, "",
          "parameter to fit; each unknown is a table `[[unknown]]`. Of a material: a modulus, a "
          "viscosity, a Rayleigh coefficient, the fractions or the time of a branch of `prony`, or the "
          "density. Of a foundation: springs or dashpots. Of "
          "an initial field: the value of one component in the whole body, "
          "or without `component` a factor on the field. Of two parts in contact `height`. Of an obstacle: a "
          "plane's shift along its "
          "normal (m) or angle (rad), a ball's or cylinder's `center` or `radius`. Of its friction: the "
          "coefficient, or a factor on the `surface_velocity`. Of its mass: `mass`, and with "
          "`component`, if the "
          "obstacle has one for each, `inertia`, `velocity`, `stiffness` and `damping`. Of a load: a "
          "factor on the load"),
      value("name", &Unknown::name, Text{"text"}, "", "name in tables",
            {.otherwise = "made from `of`, such as `\"young\"`"}),
      value("on", &Unknown::on, Text{}, "",
            "group of the material, foundation or traction, if there are several",
            {.otherwise = "the only one"}),
      value("obstacle", &Unknown::obstacle, Text{"name of an obstacle"}, "",
            "obstacle of the parameter, if there are several obstacles", {.otherwise = "the only one"}),
      value("component", &Unknown::component, Choice<Component>{}, "",
            "component of an initial field, a centre or a number of an obstacle's mass; in space also the "
            "axis about which a plane's `angle` "
            "turns",
            {.otherwise = "none"}),
      value("branch", &Unknown::branch, Whole{0, 999}, "",
            "number of the branch in the list `prony` of the material, counted from 0, if there are several",
            {.otherwise = "the only one"}),
      value("start", &Unknown::start, Number{}, "", "first guess", {.otherwise = "the scene's own value"}),
      value("lower", &Unknown::lower, Number{}, "", "lower bound of the unknown",
            {.otherwise = "natural limit of the parameter; with `\"log\"` 1.5e-8 times `start`"}),
      value("upper", &Unknown::upper, Number{}, "", "upper bound of the unknown",
            {.otherwise = "natural limit of the parameter; with `\"log\"` 6.7e7 times `start`"}),
      value("scale", &Unknown::scale, Choice<ParameterScale>{}, "",
            "scale on which the parameter is fitted; with `\"log\"` steps and the deviation of a prior are "
            "relative",
            {.otherwise =
                 "`\"log\"` for moduli, viscosities, Rayleigh coefficients, relaxation times, densities, "
                 "foundations, friction and obstacles with mass but for velocities; else `\"linear\"`"}),
      inline_table("prior", &Unknown::prior, {})};
}

Keys<Measurement> keys_of(Of<Measurement>) {
  return {
      required(
          "of", &Measurement::of, Choice<Quantity>{}, "",
          "measured quantity; each measurement is a table `[[measurement]]`. It is a motion of a point, a "
          "group or an obstacle with mass, the resultant force of an obstacle, or its impulse so far. With "
          "the contact-implicit scheme the force is the mean of two steps. Contact times, the time from 1 to "
          "99 % of the impulse and the sustained "
          "peak are compared, but not fitted"),
      value("name", &Measurement::name, Text{"text"}, "", "name in tables",
            {.otherwise = "`\"measurement 1\"` … by position in the scene"}),
      value("point", &Measurement::point, Numbers{}, "m", "point of the undeformed body",
            {.otherwise = "none"}),
      value("on", &Measurement::on, Text{}, "",
            "in place of `point`: group over which the motion is averaged", {.otherwise = "none"}),
      value(
          "obstacle", &Measurement::obstacle, Text{"name of an obstacle"}, "",
          "obstacle whose force or impulse is measured; of a displacement or velocity, in place of `point`: "
          "obstacle with mass that moves",
          {.otherwise = "all obstacles together"}),
      value("component", &Measurement::component, Choice<Component>{}, "", "component of the quantity",
            {.otherwise = "required where fitted"}),
      value("file", &Measurement::file, Path{}, "",
            "CSV file with times and values, relative to the scene file; `simulate --measure` can write it. "
            "Names of columns may end with units, as `time [ms]`",
            {.otherwise = "required where fitted", .part = Part::none}),
      value("column", &Measurement::column, Text{"text"}, "", "column of the values in the file"),
      value("value", &Measurement::value, Number{above_zero}, "s or N",
            "measured value of a quantity that is compared, but not fitted", {.otherwise = "none"}),
      value("deviation", &Measurement::deviation, Number{above_zero}, "",
            "standard deviation of each value in SI units, whatever unit the file's column has",
            {.otherwise = "the file's column `deviation`"}),
      value("noise", &Measurement::noise, Number{above_zero}, "",
            "in place of `deviation` and of the file's column: standard deviation relative to the largest "
            "value",
            {.otherwise = "none"})};
}

Keys<Optimizer> keys_of(Of<Optimizer>) {
  const auto with_controls = [](const Optimizer& optimizer) {
    return optimizer.method != OptimizerMethod::gauss_newton;
  };
  return {
      value("method", &Optimizer::method, Choice<OptimizerMethod>{}, "",
            "optimization method; see The optimizers", {.part = Part::search}),
      value("start", &Optimizer::start, Choice<SearchStart>{}, "",
            "`\"coarse\"`: the search begins on meshes of 4 and 2 times `mesh.size`, with time steps 4 and 2 "
            "times as long. `\"guess\"`: the search begins at `control.initial` on the scene's mesh (see "
            "From coarse to fine)",
            {.otherwise = "`\"coarse\"` for a .geo with `mesh.size`; `\"guess\"` with a .msh, "
                          "`control.initial.run`, `objective.desired.run` or `\"projected-gradient\"`"}),
      value("max_iterations", &Optimizer::max_iterations, Whole{0, 1'000'000}, "",
            "largest number of iterations; 0 evaluates only the first guess"),
      value("tolerance", &Optimizer::tolerance, Number{{.least = 0, .greatest = 1, .unit = "no unit"}}, "",
            "the search stops at this norm of the gradient, relative to the norm at the first guess. "
            "`\"gauss-newton\"` stops at this decrement, the length of its next step in standard deviations",
            {.otherwise = fmt::format("`{:g}`; `{:g}` with `\"gauss-newton\"`", Optimizer::usual_tolerance,
                                      Optimizer::usual_of_fits)}),
      value("checkpoint", &Optimizer::checkpoint, Whole{0, 1'000'000}, "iterations; 0: none",
            "number of iterations between checkpoints; see Long runs", {}, with_controls),
      value("memory", &Optimizer::memory, Number{not_negative}, "bytes",
            "memory for the controls and gradients that a search stores in single precision, on all ranks "
            "together (see Long runs)",
            {.otherwise = "`0`: `1e8`, or the size of 128 controls if larger"}, with_controls)};
}

Keys<Trajectory> keys_of(Of<Trajectory>) {
  return {value("storage", &Trajectory::storage, Choice<Storage>{}, "",
                "storage of the states of a motion for the adjoint sweep. `\"disk\"`: in an unnamed file in "
                "`$TMPDIR`, else in `/var/tmp`. `\"checkpoints\"`: a few states in memory, from which the "
                "others are recomputed. Gradients do not depend on this choice (see Long runs)"),
          value("budget", &Trajectory::budget, Number{above_zero}, "bytes",
                "memory of all checkpoints, on all ranks together; a computed desired motion "
                "(`objective.desired.control`) uses half of it",
                {.otherwise = "`1e9` with checkpoints"},
                [](const Trajectory& trajectory) { return trajectory.storage == Storage::checkpoints; })};
}

Keys<Check> keys_of(Of<Check>) {
  return {
      required("control", &Check::control, ControlField{}, "",
               "control at which `check` takes derivatives: expressions as in `control.initial`, but no run; "
               "the control of `control.initial.run`, if given, has priority",
               {.otherwise = "near the reference control; without one, the first guess"})};
}

Keys<Exact> keys_of(Of<Exact>) {
  const char* about = "exact displacement, from which `study` computes errors";
  return {
      value("displacement", &Exact::displacement, Expressions{}, "m", about),
      value("pressure", &Exact::pressure, Formula{{}, false}, "N/m²",
            "exact pressure on the contact surface at `time.end`", {.part = Part::measurement}),
      value("impulse", &Exact::impulse, Number{above_zero}, "N s",
            "exact modulus of the impulse of all contact forces; in plane strain and plane stress N s/m"),
      value("peak_force", &Exact::peak_force, Number{above_zero}, "N",
            "exact largest modulus of the resultant contact force; in plane strain and plane stress N/m"),
      value("contact_start", &Exact::contact_start, Number{above_zero}, "s",
            "exact start of the first contact"),
      value("contact_time", &Exact::contact_time, Number{above_zero}, "s", "exact total time in contact")};
}

Keys<Solver> keys_of(Of<Solver>) {
  return {
      value("vi", &Solver::vi, Choice<ViMethod>{}, "",
            "`\"condensed\"`: each step solves an inequality in the candidates only; `\"full\"`: PETSc's VI "
            "solver solves it in all unknowns, as a reference"),
      value("linear", &Solver::linear, Choice<LinearMethod>{}, "",
            "solver for the step operator D. `\"direct\"`: factorisation; `\"iterative\"`: conjugate "
            "gradients. `\"auto\"`: direct if the factor fits `memory`, unless conjugate gradients are "
            "estimated to be clearly faster"),
      value("memory", &Solver::memory, Number{not_negative}, "bytes",
            "largest memory for the factor of D and the matrices of contact",
            {.otherwise = "half of the machine's memory", .part = Part::measurement})};
}

Keys<Run> keys_of(Of<Run>) {
  return {value("invariants", &Run::invariants, Choice<OnViolation>{}, "",
                "if the energy law, the momentum law or the contact condition is violated: `\"warn\"` at the "
                "end, `\"stop\"` at that step; `\"off\"`: no check"),
          value("tolerance", &Run::tolerance, Number{{.least = 0, .greatest = 1, .open = true}}, "",
                "relative tolerance of the laws that `run.invariants` checks, and of those that `check` "
                "evaluates")};
}

Keys<ChannelFilter> keys_of(Of<ChannelFilter>) {
  return {
      required("cfc", &ChannelFilter::cfc, Number{above_zero}, "",
               "channel frequency class of SAE J211, such as 60, 180, 600 or 1000, by which acceleration and "
               "force of an obstacle are filtered before their peaks are taken")};
}

Keys<Probe> keys_of(Of<Probe>) {
  return {
      value("name", &Probe::name, Text{"text"}, "", "name of the probe's columns in `probes.csv`",
            {.otherwise = "`\"probe 1\"`, `\"probe 2\"` … by position in the scene"}),
      value("point", &Probe::point, Numbers{}, "m",
            "point of the undeformed body where displacement and velocity are recorded; each probe is a "
            "table `[[output.probe]]`. Outside, up to a hundredth of the body's diameter, the values of the "
            "nearest element are continued"),
      value("on", &Probe::on, Text{}, "",
            "in place of `point`: group of the body or of the boundary whose mean displacement and "
            "velocity are recorded. On a boundary, the reaction of clamped nodes is recorded too"),
      value("obstacle", &Probe::obstacle, Text{"name of an obstacle"}, "",
            "in place of `point`: obstacle whose force on the body and impulse so far are recorded"),
      value("body", &Probe::body, Flag{}, "",
            "in place of `point`, `true`: centre of mass, momentum and mean rotation (rad) of the body "
            "are recorded"),
      value("acceleration", &Probe::acceleration, Flag{}, "",
            "`true`: the acceleration is recorded too, as the change of the velocity in each step, and its "
            "peak is reported. Of an obstacle only if it has mass"),
      inline_table("filter", &Probe::filter, {})};
}

Keys<Output> keys_of(Of<Output>) {
  return {
      value("every", &Output::every, Whole{1, Time::most_steps}, "steps",
            "number of steps between stored fields and rows of `contact.csv`; the last step and the step of "
            "the largest contact force are always stored. Other tables have a row for each step",
            {.otherwise =
                 fmt::format("the least of 1, 2, 5, 10, … that stores at most {0} steps. With "
                             "`time.step = \"auto\"` the first step after each {0}th of `time.end`. With "
                             "`time.end = \"auto\"` an eighth of the time in which a wave crosses the "
                             "body, doubled after each {0} stored times",
                             Output::most_frames)},
            [](const Output& output) { return output.every > 0; }),
      value("fields", &Output::fields, Set<StoredField>{}, "",
            "fields to store, if the verb computes them; `\"strain\"`, `\"stress\"`, `\"von_mises\"`, "
            "`\"pressure\"` and `\"friction\"` are stored only if named (see Stress and pressure). `[]` "
            "stores none and saves their cost",
            {.effect = "stored fields"}),
      value("format", &Output::formats, Formats{}, "",
            "files of stored fields: `\"xdmf\"` for ParaView, meshio and the program's own pages; "
            "`\"vtkhdf\"` for "
            "ParaView, VTK and PyVista, with the obstacles. The values are in a `.h5` file for both; with "
            "`[\"vtkhdf\"]` each `.vtkhdf` file has its own",
            {.effect = "stored fields"}),
      value("tables", &Output::tables, Set<StoredTable>{}, "",
            "tables to write, if the verb computes them; `[]` writes none", {.effect = "tables"}),
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
          sections("foundation", &Scene::foundations, {.effect = "foundation"}),
          sections("clamp", &Scene::clamps, {.effect = "clamp"}),
          sections("contact", &Scene::contacts, {.effect = "contact"},
                   [](const std::vector<Contact>& contacts) { return contacts.size() == 1; }),
          section("load", &Scene::load, {}),
          section("initial", &Scene::initial, {}),
          section("control", &Scene::control, {.effect = "control"}),
          section("objective", &Scene::objective, {.effect = "objective"}),
          sections("scenario", &Scene::scenarios, {.effect = "scenarios"}),
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
