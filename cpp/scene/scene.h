#pragma once
#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

/// What a scene file says, validated, in SI units, every default filled in. An absent optional is an absent
/// effect.
namespace signorini::scene {

/// Components of a vector field as expressions, one per space dimension.
using Components = std::vector<std::string>;

struct Mesh {
  std::filesystem::path file; ///< .geo or .msh, absolute
  std::optional<double> size; ///< element size for a .geo, m; absent: the sizes that the .geo itself sets
  double scale = 1;           ///< of these
  int degree = 1;             ///< Lagrange degree of the displacement
};

struct Time {
  double end = 0;  ///< s
  double step = 0; ///< s
  int steps = 0;   ///< end / step
  std::string scheme = "contact-implicit"; ///< or "contact-stabilized"

  static constexpr int most_steps = 100'000'000; ///< which a number of 32 bits holds, and no run comes to the end of

  [[nodiscard]] bool stabilized() const { return scheme == "contact-stabilized"; }
};

struct Viscosity {
  double bulk = 0;  ///< κ, Pa s
  double shear = 0; ///< η, Pa s
};

struct Material {
  std::optional<std::string> on; ///< physical group of its cells; absent: the whole body
  double density = 0;            ///< ρ, kg/m³
  double young = 0;              ///< E, Pa
  double poisson = 0;            ///< ν
  std::optional<Viscosity> viscosity;
};

struct Clamp {
  std::string on;                                     ///< physical group
  std::optional<std::vector<std::string>> components; ///< those held, of "x", "y", "z"; absent: all
  std::optional<Components> value; ///< motion of each component held, m, of x, y, z, t; absent: at rest
};

struct HalfSpace {
  Components point;           ///< a point of the boundary plane, m, of t
  std::vector<double> normal; ///< out of the obstacle, any length but zero
};

struct Ball {
  std::vector<double> center; ///< m
  double radius = 0;          ///< m
  bool inside = false;        ///< the body is within it: the obstacle is all around
};

struct Cylinder {
  std::vector<double> point; ///< of the axis, m
  std::vector<double> axis;  ///< any length but zero; empty in the plane, where the cylinder is a disc
  double radius = 0;         ///< m
  bool inside = false;       ///< as for a ball
};

struct SignedDistance {
  std::string distance; ///< a level set of x, y, z that is positive outside of the obstacle, any unit
};

using Obstacle = std::variant<HalfSpace, Ball, Cylinder, SignedDistance>;

struct Contact {
  std::string on; ///< physical group of the contact candidates
  Obstacle obstacle;
  bool massless = false; ///< contact nodes carry no mass in the directions of their constraints
  bool project = false;  ///< nodes that start inside are moved out of the obstacle; else they are an error
};

struct Traction {
  std::string on;   ///< physical group of the surface
  Components value; ///< N/m², of x, y, z, t
};

struct Load {
  std::optional<Components> body; ///< N/m³ in 3D and plane strain, of x, y, z, t
  std::vector<Traction> tractions;
};

struct Initial {
  std::optional<Components> displacement; ///< m, of x, y, z
  std::optional<Components> velocity;     ///< m/s, of x, y, z
};

struct Control {
  double scale = 1;              ///< s, N/m³ per unit of control; N/m² where it acts on a surface
  std::optional<std::string> on; ///< physical group of a part of the body or of a surface; absent: the body
  std::optional<std::vector<std::string>> components; ///< those that act, of "x", "y", "z"; absent: all
  bool constant_in_time = false;
  std::string space = "P1";                 ///< nodal values ("P1") or one for each cell ("P0")
  std::optional<Components> initial;        ///< first guess, of x, y, z, t; absent: zero
  std::optional<std::vector<double>> lower; ///< one number or one per component
  std::optional<std::vector<double>> upper;
};

struct DesiredControl {
  Components control; ///< reference control, of x, y, z, t: its state is the desired one
};
struct DesiredDisplacement {
  Components displacement; ///< m, of x, y, z, t
};

struct DesiredRun {
  std::filesystem::path folder; ///< of an earlier run whose displacement is the desired one, absolute
};

struct Objective {
  std::variant<DesiredControl, DesiredDisplacement, DesiredRun> desired;
  std::optional<std::string> on; ///< physical group of a part of the body or of a surface; absent: the body
  double tracking = 1;           ///< weight of the tracking term
  double alpha = 0;              ///< weight of the control cost
  double gamma = 0;              ///< weight of the terminal term
};

struct Optimizer {
  std::string method = "lbfgs"; ///< or "newton-cg", "projected-gradient"
  int max_iterations = 1000;
  double tolerance = 1e-6; ///< of the gradient norm, relative to the first guess's
  int checkpoint = 10;     ///< iterations from one to the next; 0: none
};

struct Solver {
  std::string vi = "condensed";
  std::string linear = "auto"; ///< "direct", "iterative", or whichever fits the memory
  double memory = 0;           ///< that a factor of D may take in all, bytes
};

/// How the states of a motion are kept for the adjoint sweep.
struct Trajectory {
  std::string storage = "memory"; ///< or "disk", "checkpoints"
  double budget = 1e9;            ///< of all checkpoints, bytes
};

struct Check {
  std::optional<Components> control; ///< where `check` takes derivatives, of x, y, z, t
};

/// What is watched while a scene runs.
struct Run {
  std::string invariants = "warn"; ///< where one is off: "warn" at the end, "stop" there; or "off"
  double tolerance = 1e-10;        ///< relative

  [[nodiscard]] bool watched() const { return invariants != "off"; }
};

/// What is known of the solution, for errors.
struct Exact {
  std::optional<Components> displacement; ///< m, of x, y, z, t
  std::optional<std::string> pressure;    ///< N/m² on the contact surface at time.end, of x, y, z
  std::optional<double> impulse;          ///< N s (in the plane N s/m): modulus of the contact forces' in all
  std::optional<double> peak_force;       ///< N (in the plane N/m): largest modulus of the contact forces' resultant
  std::optional<double> contact_start;    ///< s
  std::optional<double> contact_time;     ///< s in all
};

struct Output {
  int every = 1; ///< steps between stored fields
  std::vector<std::string> fields{"displacement", "velocity", "control",
                                  "adjoint"};                     ///< stored where a run has them
  std::vector<std::string> tables{"steps", "contact", "history"}; ///< likewise

  [[nodiscard]] bool field(const std::string& name) const {
    return std::ranges::find(fields, name) != fields.end();
  }
  [[nodiscard]] bool table(const std::string& name) const {
    return std::ranges::find(tables, name) != tables.end();
  }
};

struct Scene {
  std::filesystem::path file;
  std::string name;
  Mesh mesh;
  Time time;
  std::vector<Material> materials; ///< one at least
  std::vector<Clamp> clamps;
  std::vector<Contact> contacts;
  std::optional<Load> load;
  Initial initial;
  std::optional<Control> control;
  std::optional<Objective> objective;
  Optimizer optimizer;
  Solver solver;
  Trajectory trajectory;
  Check check;
  std::optional<Exact> exact;
  Run run;
  Output output;
};

/// The text of a scene file. Throws UserError.
std::string read(const std::filesystem::path& file);

/// Validates the text of a scene file; `overrides` are the texts `key.path=value` of --set.
/// Throws UserError naming file, line, key, what was found and what is allowed.
Scene parse(const std::string& text, const std::filesystem::path& file,
            const std::vector<std::string>& overrides = {});

/// The name of one table of contact in messages: `contact`, or `contact[i]` of several.
std::string contact_key(const std::vector<Contact>& contacts, std::size_t i);
/// Likewise of a clamp.
std::string clamp_key(const std::vector<Clamp>& clamps, std::size_t i);

/// The components of a vector: "x", "y" and in space "z".
std::vector<std::string> component_names(int dim);

/// Whether a field is written as zero, which is no effect.
bool vanishes(const Components& components);

/// Whether the first guess of a control is zero, which is no load: written so, or absent, and within the
/// bounds.
bool rests(const Control& control);

/// Throws UserError unless every vector of the scene has `dim` components, and no other component is named.
void require_dimension(const Scene& scene, int dim);

/// The scene as TOML with every default and unit written out, for a mesh of `dim` dimensions; parse() reads
/// it back to the same scene. What the clamps do at the start is a default that is left out.
std::string echo(const Scene& scene, int dim);

} // namespace signorini::scene
