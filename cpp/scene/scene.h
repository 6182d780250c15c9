// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/body.h"
#include "scene/scenario.h"
#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// Validated scenes in SI units, with defaults. An absent optional means no effect, unless stated.
namespace signorini::scene {

/// Table [time]: steps of equal length (docs/method.md section 2) or of varying length (section 11).
struct Time {
  double end = 0;  ///< end of the motion, s
  double step = 0; ///< length τ of the steps, s; 0: "auto", varying
  int steps = 0;   ///< number of steps, end / step; 0 if their length varies
  TimeScheme scheme = TimeScheme::contact_implicit;
  double tolerance = 1e-3;                            ///< relative error allowed to steps of varying length
  StepQuantity quantity = StepQuantity::displacement; ///< quantity whose error `tolerance` limits
  std::optional<double> longest, shortest;            ///< bounds on the length of varying steps, s
  bool until_bounce = false; ///< end "auto": the motion ends after the bounce, at `end` at the latest

  static constexpr double least_tolerance = 1e-12, most_tolerance = 0.5;
  static constexpr int usual_longest = 8;        ///< the default of `longest` is end / usual_longest
  static constexpr int most_steps = 100'000'000; ///< largest number of steps: fits into 32-bit integers

  /// Whether steps vary in length.
  [[nodiscard]] bool automatic() const { return step == 0; }
  [[nodiscard]] static bool automatic_steps(const Time& time) { return time.automatic(); }
};

/// A half-space as an obstacle; may move.
struct HalfSpace {
  Components point;           ///< a point of the boundary plane, m, as expressions in t
  std::vector<double> normal; ///< outward normal of the obstacle; its length is arbitrary, but not zero
};

/// A ball, or the space outside of one, as an obstacle; may move.
struct Ball {
  Components center;         ///< centre, m, as expressions in t
  Expression radius = 0.0;   ///< radius, m, as an expression in t
  Side side = Side::outside; ///< side of the surface on which the body is
};

/// An infinite cylinder, or the space outside of one, as an obstacle; may move.
struct Cylinder {
  Components point;          ///< a point of the axis, m, as expressions in t
  std::vector<double> axis;  ///< direction, not zero; empty in the plane, where the cylinder is a disc
  Expression radius = 0.0;   ///< radius, m, as an expression in t
  Side side = Side::outside; ///< side of the surface on which the body is
};

/// An obstacle given by a level-set function.
struct SignedDistance {
  std::string distance; ///< expression in x, y, z, t, positive outside of the obstacle, in any unit
};

using Obstacle = std::variant<HalfSpace, Ball, Cylinder, SignedDistance>;

/// Table contact.friction of Tresca friction.
struct FrictionBound {
  Expression traction = 0; ///< largest tangential traction, Pa, as an expression in x, y, z, t
};

/// Mass of an obstacle that moves freely, and what acts on it besides the body. Vectors have one entry per
/// space dimension.
struct RigidBody {
  double mass = 0;                                  ///< kg; in plane strain and plane stress kg/m
  std::vector<double> velocity;                     ///< at the start, m/s; empty: at rest
  std::optional<std::vector<Component>> components; ///< free translations; absent: all
  std::vector<double> inertia;                      ///< kg m², of each free rotation; empty: it does not turn
  std::vector<double> mass_center;                  ///< m; empty: the obstacle's point or centre
  std::optional<Components> force;                  ///< N, as expressions in t
  std::vector<double> stiffness; ///< of springs to the ground, N/m: one or one per component
  std::vector<double> damping;   ///< of dashpots to the ground, N s/m, likewise

  /// Whether its centre of mass may move along a component.
  [[nodiscard]] bool moves_along(Component component, bool axisymmetric) const {
    const bool radial = axisymmetric && component == Component::x;
    return !radial && (!components || std::ranges::find(*components, component) != components->end());
  }
};

/// Table [contact], or one of [[contact]].
struct Contact {
  std::string on;                     ///< physical group of the contact candidates
  std::optional<Obstacle> obstacle;   ///< absent if `against` is given
  std::optional<std::string> against; ///< physical group of another part's surface
  std::optional<ContactSide> slave; ///< side of the candidates with `against`; absent: that with finer facets
  double height = 0;                ///< shift of the surface `against` along its mean outward normal, m
  std::string name;                 ///< name of the obstacle or the pair of surfaces in tables, unique
  ContactMass mass = ContactMass::consistent;
  ContactStart initial = ContactStart::outside;
  Expression friction = 0;            ///< coefficient μ of Coulomb friction, as an expression in x, y, z, t
  std::optional<FrictionBound> bound; ///< of Tresca friction, in place of Coulomb friction
  /// Velocity of the obstacle's material along its surface, in addition to that of its motion, m/s, as
  /// expressions in x, y, z, t; its normal part has no effect.
  std::optional<Components> surface_velocity;
  std::optional<RigidBody> rigid; ///< absent if the obstacle does not move or moves as prescribed

  /// Whether the candidates of this obstacle have no mass along the contact normal.
  [[nodiscard]] bool massless() const { return mass == ContactMass::massless; }
  /// Whether candidates of this obstacle have no mass in some direction.
  [[nodiscard]] bool loses_mass() const { return mass != ContactMass::consistent; }
  /// Whether the obstacle is a cylinder.
  [[nodiscard]] bool meets_cylinder() const {
    return obstacle && std::holds_alternative<Cylinder>(*obstacle);
  }
  /// Whether the obstacle has friction.
  [[nodiscard]] bool frictional() const { return bound || friction != Expression(0); }
};

/// One table [[load.traction]].
struct Traction {
  std::string on;   ///< physical group of the surface
  Components value; ///< traction, N/m², as expressions in x, y, z, t
};

/// One table [[load.point]].
struct PointForce {
  std::vector<double> at; ///< point of the undeformed body at which there is a node, m
  Components value;       ///< force, N (plane strain, plane stress: N/m), as expressions in t
};

/// Table [load].
struct Load {
  std::optional<Components> body;    ///< force density, N/m³ in 2D and 3D, in x, y, z, t
  std::optional<Components> gravity; ///< acceleration, m/s², in t; its force is the density times this
  std::vector<Traction> tractions;
  std::vector<PointForce> points;
};

/// Table initial.drop: the body is dropped and starts as it meets an obstacle.
struct Drop {
  double height = 0; ///< of the free fall, m
};

/// Table [initial]. Absent fields are zero except where moving clamps prescribe them.
struct Initial {
  std::optional<Components> displacement; ///< m, as expressions in x, y, z
  std::optional<Components> velocity;     ///< m/s, as expressions in x, y, z
  std::optional<Drop> drop;               ///< in place of `velocity`
  bool equilibrium = false; ///< whether the displacement is that of static equilibrium without friction
};

/// A control that an earlier run stored.
struct StoredControl {
  std::filesystem::path folder; ///< absolute path of the run's output folder
};

/// Table [control].
struct Control {
  double scale = 1;              ///< factor s, N/m³ per unit of control; N/m² for a control on a surface
  std::optional<std::string> on; ///< physical group of a part of the body or of a surface; absent: the body
  std::optional<std::vector<Component>> components; ///< acting components; absent: all
  bool constant_in_time = false;
  std::optional<double> step; ///< length of the intervals of constant control, s; absent: the time steps
  int intervals = 0;          ///< number of these intervals, time.end / step
  ControlValues space = ControlValues::nodal;
  std::optional<Components> initial;        ///< first guess, in x, y, z, t; absent: `stored`, else zero
  std::optional<StoredControl> stored;      ///< first guess, in place of `initial`
  std::optional<std::vector<double>> lower; ///< lower bound, for all components or for each; absent: none
  std::optional<std::vector<double>> upper; ///< upper bound, for all components or for each; absent: none
};

/// Desired motion y_d that is the motion under a reference control.
struct DesiredControl {
  Components control; ///< reference control, as expressions in x, y, z, t
};
/// Desired motion y_d given by expressions.
struct DesiredDisplacement {
  Components displacement; ///< m, as expressions in x, y, z, t
};

/// Desired motion y_d read from an earlier run.
struct DesiredRun {
  std::filesystem::path folder; ///< absolute path of the run's output folder
};

/// Table [objective]; docs/method.md section 3.
struct Objective {
  std::variant<DesiredControl, DesiredDisplacement, DesiredRun> desired;
  std::optional<std::string> on; ///< group of cells or facets where y is compared with y_d; absent: the body
  std::optional<std::string> obstacle; ///< obstacle with mass whose translation is compared instead
  double tracking = 1;                 ///< θ, weight of the tracking term
  double alpha = 0;                    ///< α, weight of the control cost
  double gamma = 0;                    ///< γ, weight of the terminal term, s
  static constexpr double most_exponent = 1000;
  double exponent = 1; ///< p of the mean of scenarios; 1: expectation, ∞: worst case
};

/// Normal prior of an unknown or, if the unknown has a logarithmic scale, of its logarithm.
struct Prior {
  double mean = 0, deviation = 0; ///< mean of the unknown; deviation, relative if the scale is logarithmic
};

/// One table [[unknown]]: a number of the scene that a fit determines; docs/method.md section 9.
struct Unknown {
  Parameter of = Parameter::young;
  std::optional<std::string> on;       ///< group of the material or traction; absent if there is only one
  std::optional<std::string> obstacle; ///< name of the obstacle; may be absent if there is only one
  std::optional<Component> component;  ///< component of a field or centre; axis of an angle in 3D
  std::optional<int> branch;           ///< number of the Prony series' branch; absent if there is only one
  std::string name;                    ///< name in tables, unique
  double start = 0;                    ///< value at which the fit starts
  std::optional<double> lower, upper;  ///< bounds of the value
  ParameterScale scale = ParameterScale::linear;
  std::optional<Prior> prior;

  [[nodiscard]] bool logarithmic() const { return scale == ParameterScale::logarithmic; }
};

/// One table [[measurement]]: data about the motion; docs/method.md section 10.
struct Measurement {
  Quantity of = Quantity::displacement;
  std::string name;                         ///< name in tables, unique
  std::optional<std::vector<double>> point; ///< point of the undeformed body, m
  std::optional<std::string> on;            ///< group over which the motion is averaged; absent: use `point`
  std::optional<std::string> obstacle; ///< obstacle that moves, or of a contact quantity; absent: sum of all
  std::optional<Component> component;  ///< component; set for every fitted quantity
  std::optional<std::filesystem::path> file; ///< absolute path of a CSV with times and values; set if fitted
  std::string column = "value";              ///< column of the values in `file`
  std::optional<double> value;               ///< measured value of a quantity that is only compared, s or N
  std::optional<double> deviation;           ///< standard deviation; absent: by `noise` or column "deviation"
  std::optional<double> noise;               ///< deviation divided by the largest modulus of the values

  /// Whether the misfit counts in J; quantities of the whole contact, as its duration, are only compared.
  [[nodiscard]] bool fitted() const { return of < Quantity::contact_start; }
};

/// Table [optimizer]; docs/method.md section 6.
struct Optimizer {
  static constexpr double usual_tolerance = 1e-4, usual_of_fits = 1e-6;

  OptimizerMethod method = OptimizerMethod::lbfgs;
  std::optional<SearchStart> start; ///< set in every scene with an objective
  int max_iterations = 1000;
  /// Tolerance for the gradient norm, relative to the first one; with gauss_newton, for the decrement.
  std::optional<double> tolerance;
  int checkpoint = 10; ///< iterations between checkpoints; 0: no checkpoints
  double memory = 0;   ///< memory limit for the controls that a method stores, bytes; 0: the default limit
};

/// Table [solver]; docs/method.md section 5.
struct Solver {
  ViMethod vi = ViMethod::condensed;
  LinearMethod linear = LinearMethod::automatic;
  double memory = 0; ///< limit for D's factor plus dense contact matrices, bytes; parse() sets the default
};

/// Table [trajectory]: storage of a motion's states for the adjoint sweep.
struct Trajectory {
  Storage storage = Storage::memory;
  double budget = 1e9; ///< memory limit of all checkpoints together, bytes
};

/// Table [check]: control at which the verb check takes derivatives, as expressions in x, y, z, t.
struct Check {
  /// Control at which to check, unless control.initial.run gives one; absent: near the reference control,
  /// else the first guess.
  std::optional<Components> control;
};

/// Table [run]: checks of discrete identities in every run; docs/method.md section 2.
struct Run {
  OnViolation invariants = OnViolation::warn;
  double tolerance = 1e-10; ///< relative residual beyond which an identity is violated

  /// Whether the identities are checked.
  [[nodiscard]] bool watched() const { return invariants != OnViolation::off; }
};

/// Table [exact]: known values of the solution, from which errors are computed. In plane strain and plane
/// stress the impulse and the force are per metre of depth.
struct Exact {
  std::optional<Components> displacement; ///< m, as expressions in x, y, z, t
  std::optional<std::string> pressure;    ///< contact pressure at time.end, N/m², as expression in x, y, z
  std::optional<double> impulse;          ///< modulus of the total impulse of contact forces, N s or N s/m
  std::optional<double> peak_force;       ///< largest modulus of the resultant contact force, N or N/m
  std::optional<double> contact_start;    ///< time of first contact, s
  std::optional<double> contact_time;     ///< total duration of contact, s
};

/// Table output.probe.filter.
struct ChannelFilter {
  double cfc = 0; ///< channel frequency class of SAE J211, Hz

  /// Returns the longest distance of samples, s: SAE J211 asks for ten in a period of the class.
  [[nodiscard]] double longest_sampling() const { return 1 / (10 * cfc); }
};

/// One table [[output.probe]]: a point, group or obstacle, or the whole body, whose quantities are written
/// over time. Exactly one member besides the name is set.
struct Probe {
  std::string name;                         ///< name of the probe's columns, unique
  std::optional<std::vector<double>> point; ///< point of the undeformed body, m
  std::optional<std::string> on;            ///< physical group of a part of the body or of a surface
  std::optional<std::string> obstacle;      ///< name of an obstacle
  std::optional<bool> body;                 ///< true: the whole body
  bool acceleration = false;                ///< whether its acceleration is recorded too
  std::optional<ChannelFilter> filter;      ///< of the peaks of acceleration and force
};

/// Table [output].
struct Output {
  int every = 0; ///< steps between stored fields; 0: chosen, so that at most most_frames are stored
  std::vector<StoredField> fields{StoredField::displacement, StoredField::velocity, StoredField::control,
                                  StoredField::adjoint}; ///< fields to store where a run has them
  std::vector<StoredTable> tables{
      StoredTable::steps,    StoredTable::contact, StoredTable::obstacles,  StoredTable::bodies,
      StoredTable::probes,   StoredTable::history, StoredTable::parameters, StoredTable::measurements,
      StoredTable::scenarios}; ///< tables to write where a run has them
  std::vector<FieldFormat> formats{FieldFormat::xdmf, FieldFormat::vtkhdf}; ///< files of stored fields
  std::vector<Probe> probes;

  static constexpr int most_frames = 300; ///< largest number of stored times after t = 0 if `every` is absent
  /// Default of `every`: the least of 1, 2, 5, 10, 20, … with which at most most_frames of `steps` steps are
  /// stored.
  [[nodiscard]] static int automatic(int steps);

  /// Whether a field is to be stored.
  [[nodiscard]] bool field(StoredField one) const { return std::ranges::find(fields, one) != fields.end(); }
  /// Whether fields are to be written in a format.
  [[nodiscard]] bool in(FieldFormat one) const { return std::ranges::find(formats, one) != formats.end(); }
  /// Whether a table is to be written.
  [[nodiscard]] bool table(StoredTable one) const { return std::ranges::find(tables, one) != tables.end(); }
};

/// All tables of a scene file.
struct Scene {
  std::filesystem::path file; ///< absolute path of the scene file
  std::string name;           ///< name of the file without its extension
  Mesh mesh;
  Time time;
  std::vector<Material> materials; ///< at least one
  std::vector<Foundation> foundations;
  std::vector<Clamp> clamps;
  std::vector<Contact> contacts;
  std::optional<Load> load;
  Initial initial;
  std::optional<Control> control;
  std::optional<Objective> objective;
  std::vector<Scenario> scenarios;
  std::vector<Unknown> unknowns;
  std::vector<Measurement> measurements;
  Optimizer optimizer;
  Solver solver;
  Trajectory trajectory;
  Check check;
  std::optional<Exact> exact;
  Run run;
  Output output;
  std::string digest_of_series;   ///< digest of the files of all time series; empty if there are none
  std::vector<std::string> given; ///< keys given by --set, without the numbers of tables

  /// Treatment of contact, from time.scheme and contact.mass.
  [[nodiscard]] ContactScheme contact_scheme() const;
  /// Whether an obstacle has friction.
  [[nodiscard]] bool frictional() const { return std::ranges::any_of(contacts, &Contact::frictional); }
  /// Whether an obstacle has mass.
  [[nodiscard]] bool rigid() const {
    return std::ranges::any_of(contacts, [](const Contact& contact) { return contact.rigid.has_value(); });
  }
  /// Whether parts of the body are in contact with each other.
  [[nodiscard]] bool several_bodies() const {
    return std::ranges::any_of(contacts, [](const Contact& contact) { return contact.against.has_value(); });
  }
  /// Whether a material relaxes.
  [[nodiscard]] bool relaxes() const { return std::ranges::any_of(materials, &Material::relaxes); }
};

/// Returns the text of a scene file. Throws UserError if the file cannot be read.
std::string read(const std::filesystem::path& file);

/// Parses and validates the text of a scene file. `file`: path of the file, for messages and relative paths;
/// `overrides`: the texts `key.path=value` of --set; `open`: function that reads the files of time series.
/// Throws UserError naming file, line, key, and the value found and expected.
Scene parse(const std::string& text, const std::filesystem::path& file,
            const std::vector<std::string>& overrides = {}, const ReadFile& open = read_file);

/// Name of a contact table in messages: `contact`, or `contact[i]` if there are several.
std::string contact_key(const std::vector<Contact>& contacts, std::size_t i);
/// Name of the i-th table [[foundation]] in messages.
std::string foundation_key(std::size_t i);
/// Name of a clamp table in messages: `clamp`, or `clamp[i]` if there are several.
std::string clamp_key(const std::vector<Clamp>& clamps, std::size_t i);

/// The first `dim` of the components x, y, z.
std::vector<Component> components(int dim);

/// Whether every component is written as 0 or 0.0, so that the field has no effect.
bool vanishes(const Components& components);

/// Whether an obstacle moves or changes its shape, since an expression of its depends on t.
bool moves(const Obstacle& obstacle);
/// Whether the obstacle of a contact moves as the scene prescribes; false for another part of the body.
bool moves(const Contact& contact);

/// Whether the first guess of a control is zero: absent or written as zero, not read from an earlier run, and
/// within the bounds.
bool rests(const Control& control);

/// Reason why a search of this scene cannot start on coarser meshes, with the remedy, as the end of a
/// message; empty if the search can.
std::string no_coarse_start(const Scene& scene);

/// Name of the i-th table [[scenario]] in messages.
std::string scenario_key(std::size_t i);
/// Name of the i-th table [[unknown]] in messages.
std::string unknown_key(std::size_t i);
/// Name of the i-th table [[measurement]] in messages.
std::string measurement_key(std::size_t i);

/// Returns the scene with element size `size` and with `steps` steps to time.end. `size`: m; without
/// mesh.size, a factor on the sizes that the .geo sets. Steps of varying length stay unchanged.
Scene resized(Scene scene, double size, int steps);

/// Throws UserError unless every vector of the scene has `dim` components and no key names another component.
void require_dimension(const Scene& scene, int dim);

/// Writes the resolved scene as TOML, with all defaults and units, for a mesh of `dim` dimensions. parse()
/// reads the text back to the same scene. Initial fields that follow moving clamps by default are left out.
std::string echo(const Scene& scene, int dim);

} // namespace signorini::scene
