// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/choices.h"
#include "scene/time_series.h"
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

/// A validated scene file in SI units with all defaults filled in. An optional that is absent means that the
/// effect is absent, unless stated otherwise.
namespace signorini::scene {

/// An expression of x, y, z (m) and t (s), or a time series in its place.
struct Expression {
  std::string text;                         ///< expression, or TOML table that names the time series
  std::shared_ptr<const TimeSeries> series; ///< null: an expression
  double factor = 1, shift = 0;             ///< value: factor · (text or series) + shift; not in files

  Expression(std::string expression) : text(std::move(expression)) {}
  Expression(const char* expression) : text(expression) {}
  template <class Number>
    requires std::is_arithmetic_v<Number>
  Expression(Number value) : text(written(static_cast<double>(value))) {}
  Expression(std::string table, TimeSeries given)
      : text(std::move(table)), series(std::make_shared<const TimeSeries>(std::move(given))) {}

  friend bool operator==(const Expression& a, const Expression& b) {
    return a.text == b.text && a.factor == b.factor && a.shift == b.shift;
  }

private:
  static std::string written(double value);
};
inline std::string_view format_as(const Expression& expression) { return expression.text; } // for fmt

/// Components of a vector field, one expression each.
using Components = std::vector<Expression>;

/// Table [mesh].
struct Mesh {
  std::filesystem::path file; ///< .geo or .msh, absolute
  std::optional<double>
      size{};       ///< element size for a .geo, m; 0: "auto"; absent: the sizes that the .geo itself sets
  double scale = 1; ///< factor of these sizes
  LengthUnit unit = LengthUnit::m; ///< unit of the file's coordinates
  int degree = 1;                  ///< Lagrange degree of the displacement
  /// A .geo with the same body, whose sizes vary with the error; set by studies, not by a key.
  std::filesystem::path graded{};

  /// Whether sizes are chosen by the error (--accuracy).
  [[nodiscard]] bool automatic() const { return size == 0.0; }
  /// Whether the file is a mesh already, a .msh.
  [[nodiscard]] bool meshed() const { return file.extension() == ".msh"; }
};

/// Table [time]: N steps of length τ, docs/method.md section 2, or steps of varying length, section 11.
struct Time {
  double end = 0;  ///< s
  double step = 0; ///< s; 0: "auto", varying
  int steps = 0;   ///< end / step; 0 if that varies
  TimeScheme scheme = TimeScheme::contact_implicit;
  double tolerance = 1e-3;                            ///< relative error allowed to steps of varying length
  StepQuantity quantity = StepQuantity::displacement; ///< quantity of that error
  std::optional<double> longest, shortest;            ///< bounds of the lengths of such steps, s

  static constexpr double least_tolerance = 1e-12, most_tolerance = 0.5;
  static constexpr int usual_longest = 8;        ///< longest steps to the end if `longest` is not given
  static constexpr int most_steps = 100'000'000; ///< beyond any run, and within 32-bit integers

  [[nodiscard]] bool automatic() const { return step == 0; }
  [[nodiscard]] static bool automatic_steps(const Time& time) { return time.automatic(); }
};

/// Viscosity of a material; docs/method.md section 1.
struct Viscosity {
  double bulk = 0;  ///< κ, Pa s
  double shear = 0; ///< η, Pa s
};

/// Table [material], or one of [[material]].
struct Material {
  std::optional<std::string> on;      ///< physical group of its cells; absent: the whole body
  double density = 0;                 ///< ρ, kg/m³
  double young = 0;                   ///< E, Pa
  double poisson = 0;                 ///< ν
  std::optional<Viscosity> viscosity; ///< absent: elastic
};

/// One table [[clamp]].
struct Clamp {
  std::string on;                                   ///< physical group
  std::optional<std::vector<Component>> components; ///< clamped components; absent: all
  std::optional<Components> value; ///< motion of each clamped component, m, of x, y, z, t; absent: rest
};

/// Obstacle on one side of a plane; may move.
struct HalfSpace {
  Components point;           ///< a point of its boundary, m, as a function of t
  std::vector<double> normal; ///< normal out of the obstacle, of any length but zero
};

/// Obstacle that is a ball, or all outside of one; may move.
struct Ball {
  Components center;         ///< m, of t
  Expression radius = 0.0;   ///< m, of t
  Side side = Side::outside; ///< side of the body
};

/// Obstacle that is an infinite cylinder, or all outside of one; may move.
struct Cylinder {
  Components point;          ///< a point of the axis, m, of t
  std::vector<double> axis;  ///< any length but zero; empty in the plane, where the cylinder is a disc
  Expression radius = 0.0;   ///< m, of t
  Side side = Side::outside; ///< side of the body
};

/// Obstacle given by a level set.
struct SignedDistance {
  std::string distance; ///< level set of x, y, z, t, positive outside of the obstacle, in any unit
};

using Obstacle = std::variant<HalfSpace, Ball, Cylinder, SignedDistance>;

/// Table [contact], or one of [[contact]].
struct Contact {
  std::string on; ///< physical group of the contact candidates
  Obstacle obstacle;
  std::string name; ///< name of the obstacle in tables, unique
  ContactMass mass = ContactMass::consistent;
  ContactStart initial = ContactStart::outside;

  [[nodiscard]] bool massless() const { return mass == ContactMass::massless; }
};

/// One table [[load.traction]].
struct Traction {
  std::string on;   ///< physical group of the surface
  Components value; ///< N/m², of x, y, z, t
};

/// Table [load].
struct Load {
  std::optional<Components> body;    ///< N/m³ in 3D and plane strain, of x, y, z, t
  std::optional<Components> gravity; ///< m/s², of t; acts by the density
  std::vector<Traction> tractions;
};

/// Table [initial]; absent fields are zero except where moving clamps prescribe them.
struct Initial {
  std::optional<Components> displacement; ///< m, of x, y, z
  std::optional<Components> velocity;     ///< m/s, of x, y, z
};

/// Control stored by an earlier run.
struct StoredControl {
  std::filesystem::path folder; ///< output folder of that run, absolute
};

/// Table [control].
struct Control {
  double scale = 1;              ///< factor s, N/m³ per unit of control; N/m² where it acts on a surface
  std::optional<std::string> on; ///< physical group of a part of the body or of a surface; absent: the body
  std::optional<std::vector<Component>> components; ///< acting components; absent: all
  bool constant_in_time = false;
  std::optional<double> step; ///< length of the intervals of constant control, s; absent: the time steps
  int intervals = 0;          ///< time.end / step
  ControlValues space = ControlValues::nodal;
  std::optional<Components> initial;        ///< first guess, of x, y, z, t; absent: `stored`, else zero
  std::optional<StoredControl> stored;      ///< first guess, in place of `initial`
  std::optional<std::vector<double>> lower; ///< lower bound, one or one per component; absent: none
  std::optional<std::vector<double>> upper; ///< upper bound, one or one per component; absent: none
};

/// Desired state y_d given by a control.
struct DesiredControl {
  Components control; ///< reference control, of x, y, z, t, whose state is y_d
};
/// Desired state y_d given by expressions.
struct DesiredDisplacement {
  Components displacement; ///< m, of x, y, z, t
};

/// Desired state y_d read from an earlier run.
struct DesiredRun {
  std::filesystem::path folder; ///< output folder of that run, absolute
};

/// Table [objective]; docs/method.md section 3.
struct Objective {
  std::variant<DesiredControl, DesiredDisplacement, DesiredRun> desired;
  std::optional<std::string> on; ///< physical group of a part of the body or of a surface; absent: the body
  double tracking = 1;           ///< θ, weight of the tracking term
  double alpha = 0;              ///< α, weight of the control cost
  double gamma = 0;              ///< γ, weight of the terminal term, s
};

/// Prior distribution of an unknown: normal. On a logarithmic scale it is that of the logarithm, and the
/// deviation is relative.
struct Prior {
  double mean = 0, deviation = 0;
};

/// One table [[unknown]]: a number of the scene that is sought; docs/method.md section 9.
struct Unknown {
  Parameter of = Parameter::young;
  std::optional<std::string> on;       ///< group of a material or traction, where the scene has several
  std::optional<std::string> obstacle; ///< name of an obstacle, where the scene has several
  std::optional<Component> component;  ///< component of a field or centre; axis of an angle in space
  std::string name;                    ///< name in tables, unique
  double start = 0;
  std::optional<double> lower, upper;
  ParameterScale scale = ParameterScale::linear;
  std::optional<Prior> prior;

  [[nodiscard]] bool logarithmic() const { return scale == ParameterScale::logarithmic; }
};

/// One table [[measurement]]: data about the motion; docs/method.md section 10.
struct Measurement {
  Quantity of = Quantity::displacement;
  std::string name;                          ///< name in tables, unique
  std::optional<std::vector<double>> point;  ///< point of the undeformed body, m
  std::optional<std::string> on;             ///< physical group of a mean, in place of a point
  std::optional<std::string> obstacle;       ///< obstacle of a force; absent: all together
  std::optional<Component> component;        ///< set for every quantity that is fitted
  std::optional<std::filesystem::path> file; ///< CSV of times and values, absolute; set where it is fitted
  std::string column = "value";
  std::optional<double> value;     ///< value of a figure of the whole contact, s or N
  std::optional<double> deviation; ///< standard deviation; absent: the file's column "deviation"
  std::optional<double> noise;     ///< standard deviation relative to the largest value

  /// Whether the misfit counts in J; figures of the whole contact are only compared.
  [[nodiscard]] bool fitted() const { return of < Quantity::contact_start; }
};

/// Table [optimizer]; docs/method.md section 6.
struct Optimizer {
  static constexpr double usual_tolerance = 1e-4, usual_of_fits = 1e-6;

  OptimizerMethod method = OptimizerMethod::lbfgs;
  std::optional<SearchStart> start; ///< set in every scene with an objective
  int max_iterations = 1000;
  /// Tolerance of the gradient's norm, relative to the first guess's; for a fit, of its decrement. Set where
  /// there is a search.
  std::optional<double> tolerance;
  int checkpoint = 10; ///< iterations between checkpoints; 0: none
  double memory = 0;   ///< limit for the controls that a method stores, bytes; 0: the default
};

/// Table [solver]; docs/method.md section 5.
struct Solver {
  ViMethod vi = ViMethod::condensed;
  LinearMethod linear = LinearMethod::automatic;
  double memory = 0; ///< limit for the factor of D and the dense matrices of contact in all, bytes
};

/// Table [trajectory]: storage of a motion's states for the adjoint sweep.
struct Trajectory {
  Storage storage = Storage::memory;
  double budget = 1e9; ///< memory of all checkpoints, bytes
};

/// Table [check].
struct Check {
  std::optional<Components> control; ///< control at which `check` takes derivatives, of x, y, z, t
};

/// Table [run]: the identities checked in every run; docs/method.md section 2.
struct Run {
  OnViolation invariants = OnViolation::warn;
  double tolerance = 1e-10; ///< relative residual beyond which an identity is violated

  [[nodiscard]] bool watched() const { return invariants != OnViolation::off; }
};

/// Table [exact]: known figures of the solution, for errors.
struct Exact {
  std::optional<Components> displacement; ///< m, of x, y, z, t
  std::optional<std::string> pressure;    ///< N/m² on the contact surface at time.end, of x, y, z
  std::optional<double> impulse;          ///< modulus of the total impulse of contact forces, N s (2D: N s/m)
  std::optional<double> peak_force;       ///< largest modulus of the resultant of these, N (2D: N/m)
  std::optional<double> contact_start;    ///< time of first contact, s
  std::optional<double> contact_time;     ///< total duration of contact, s
};

/// One table [[output.probe]]: a place or body to follow over time, given by exactly one of the members
/// after the name.
struct Probe {
  std::string name;                         ///< name of its columns, unique
  std::optional<std::vector<double>> point; ///< point of the undeformed body, m
  std::optional<std::string> on;            ///< physical group of a part of the body or of a surface
  std::optional<std::string> obstacle;      ///< name of an obstacle
  std::optional<bool> body;                 ///< true: the whole body
};

/// Table [output].
struct Output {
  int every = 0; ///< steps between stored fields; 0: with varying steps, most_frames at most
  std::vector<StoredField> fields{StoredField::displacement, StoredField::velocity, StoredField::control,
                                  StoredField::adjoint}; ///< fields to store where a run has them
  std::vector<StoredTable> tables{StoredTable::steps,       StoredTable::contact, StoredTable::obstacles,
                                  StoredTable::probes,      StoredTable::history, StoredTable::parameters,
                                  StoredTable::measurements}; ///< tables to write where a run has them
  std::vector<Probe> probes;

  static constexpr int most_frames = 300; ///< most stored times after the first if `every` is not given
  /// Least of 1, 2, 5, 10, 20, … that stores no more than most_frames of so many steps.
  [[nodiscard]] static int automatic(int steps);

  [[nodiscard]] bool field(StoredField one) const { return std::ranges::find(fields, one) != fields.end(); }
  [[nodiscard]] bool table(StoredTable one) const { return std::ranges::find(tables, one) != tables.end(); }
};

/// Tables of a scene file.
struct Scene {
  std::filesystem::path file; ///< absolute
  std::string name;           ///< name of the file without its extension
  Mesh mesh;
  Time time;
  std::vector<Material> materials; ///< at least one
  std::vector<Clamp> clamps;
  std::vector<Contact> contacts;
  std::optional<Load> load;
  Initial initial;
  std::optional<Control> control;
  std::optional<Objective> objective;
  std::vector<Unknown> unknowns;
  std::vector<Measurement> measurements;
  Optimizer optimizer;
  Solver solver;
  Trajectory trajectory;
  Check check;
  std::optional<Exact> exact;
  Run run;
  Output output;
  std::string digest_of_series;   ///< digest of the files of its time series; empty without any
  std::vector<std::string> given; ///< keys of --set, without the numbers of tables

  [[nodiscard]] ContactScheme contact_scheme() const;
};

/// Returns the text of a scene file. Throws UserError if it cannot be read.
std::string read(const std::filesystem::path& file);

/// Parses and validates the text of a scene file. `overrides`: the texts `key.path=value` of --set; `open`:
/// reads the files of time series. Throws UserError naming file, line, key, what was found and what is
/// expected.
Scene parse(const std::string& text, const std::filesystem::path& file,
            const std::vector<std::string>& overrides = {}, const ReadFile& open = read_file);

/// Name of a contact table in messages: `contact`, or `contact[i]` if there are several.
std::string contact_key(const std::vector<Contact>& contacts, std::size_t i);
/// Name of a clamp table in messages: `clamp`, or `clamp[i]` if there are several.
std::string clamp_key(const std::vector<Clamp>& clamps, std::size_t i);

/// Components of a vector of `dim` dimensions.
std::vector<Component> components(int dim);

/// Whether every component is written as 0 or 0.0, which has no effect.
bool vanishes(const Components& components);

/// Whether an obstacle moves.
bool moves(const Obstacle& obstacle);

/// Whether the first guess of a control is zero, which is no load: absent or written as zero, and within the
/// bounds.
bool rests(const Control& control);

/// Reason why a search of this scene cannot start on coarser meshes, and the remedy, as the end of a message;
/// empty if it can.
std::string no_coarse_start(const Scene& scene);

/// Name of an unknown's or measurement's table in messages.
std::string unknown_key(std::size_t i);
std::string measurement_key(std::size_t i);

/// Returns the scene with element size `size`, m (without mesh.size: a factor on the sizes of the .geo), and
/// `steps` steps to time.end.
Scene resized(Scene scene, double size, int steps);

/// Throws UserError unless every vector of the scene has `dim` components and names no others.
void require_dimension(const Scene& scene, int dim);

/// Returns the scene as TOML with every default and unit written out, for a mesh of `dim` dimensions; parse()
/// reads it back to the same scene. Initial fields are left out if they follow moving clamps by default.
std::string echo(const Scene& scene, int dim);

} // namespace signorini::scene
