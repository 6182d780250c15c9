// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/joint_search.h"
#include "app/control_files.h"
#include "app/fit/outcome.h"
#include "app/fit/simulated.h"
#include "app/optimize.h"
#include "app/parameter_problem.h"
#include "app/resume.h"
#include "app/run_manifest.h"
#include "base/error.h"
#include "optimize/lbfgs.h"
#include "optimize/minimize.h"
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini {
namespace {

using Clock = std::chrono::steady_clock;

/// What a joint search leaves while it runs: lines, history.csv at its end, checkpoints.
class Log {
public:
  Log(control::ReducedProblem& problem, ParameterProblem& fit, const io::OutputFolder& folder, bool resume,
      const Console& console)
      : problem_(problem), fit_(fit), folder_(folder), console_(console),
        file_(folder.path() / resume::checkpoint), every_(fit.scene.optimizer.checkpoint),
        resumes_(resume && resume::found(folder, console)) {
    head_ =
        "iteration,objective,tracking,terminal,control_cost,misfit,gradient_norm,step_length,forward_sweeps,"
        "adjoint_sweeps,seconds";
    for (const scene::Unknown& unknown : fit.scene.unknowns)
      head_ += "," + unknown.name;
    head_ += "\n";
  }

  void operator()(const optimize::Iteration& iteration) {
    const control::Value& value = problem_.value();
    const std::vector<double> theta = fit_.misfit.values(problem_.variables().x);
    rows_ +=
        fmt::format("{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{:.3f},{:.17g}\n",
                    iteration.number, value.total(), value.tracking, value.terminal, value.control_cost,
                    value.misfit, iteration.gradient_norm, iteration.step_length, problem_.sweeps().forward,
                    problem_.sweeps().adjoint, seconds(), fmt::join(theta, ","));
    console_.line(fmt::format("{:4d}  J = {:.6e}, misfit {:.3e}, |g| = {:.2e}; {:.6g}", iteration.number,
                              value.total(), value.misfit, iteration.gradient_norm, fmt::join(theta, ", ")));
    last_ = iteration.number;
  }

  template <class State>
  bool restore(State& state) {
    if (!resumes_)
      return false;
    io::CheckpointReader in(problem_.controls(), file_);
    resume::require_same_problem(in, echoed(), fit_.discretisation->mesh);
    in.match_places();
    in("rows", rows_);
    in("seconds", earlier_);
    std::vector<double> sweeps;
    in("sweeps", sweeps);
    if (sweeps.size() != 2)
      in.fail("\"sweeps\" is damaged; allowed is a whole checkpoint");
    marked_ = {static_cast<int>(sweeps[0]), static_cast<int>(sweeps[1])};
    control::VariablesArchive archive(in, fit_.scene.unknowns.size());
    state.serialize(archive);
    last_ = stored_at_ = state.iteration.number;
    return true;
  }

  void restored(double stored, double found) {
    resume::require_same_value(file_, stored, found, std::abs(stored));
    problem_.count_from(marked_);
    console_.line(fmt::format("resumed after iteration {}", last_));
  }

  [[nodiscard]] bool due(const optimize::Iteration& iteration) const {
    return every_ > 0 && iteration.number % every_ == 0 && iteration.number != stored_at_;
  }
  void mark() { marked_ = problem_.sweeps(); }
  void certified(const optimize::Certificate<control::Variables>& certificate) {
    kink_ = io::Kink{.length = certificate.length,
                     .radius = certificate.radius,
                     .gradients = static_cast<int>(certificate.points.size()),
                     .weak = {}};
  }
  [[nodiscard]] const std::optional<io::Kink>& kink() const { return kink_; }

  template <class State>
  void store(State& state) {
    if (every_ == 0)
      return;
    io::CheckpointWriter out(problem_.controls(), folder_.staged(resume::checkpoint), file_);
    resume::store_problem(out, echoed(), fit_.discretisation->mesh);
    out("rows", rows_);
    out("seconds", seconds());
    out("sweeps",
        std::vector<double>{static_cast<double>(marked_.forward), static_cast<double>(marked_.adjoint)});
    control::VariablesArchive archive(out, fit_.scene.unknowns.size());
    state.serialize(archive);
    stored_at_ = state.iteration.number;
    if (const std::string failure = out.commit(); !failure.empty())
      console_.line(resume::not_written(file_, failure));
  }

  [[nodiscard]] std::string history() const { return head_ + rows_; }
  [[nodiscard]] int iterations() const { return last_; }
  [[nodiscard]] double seconds() const {
    return earlier_ + std::chrono::duration<double>(Clock::now() - start_).count();
  }

private:
  [[nodiscard]] std::string echoed() const {
    return scene::echo(fit_.scene, problem_.controls().space().dim());
  }

  control::ReducedProblem& problem_;
  ParameterProblem& fit_;
  const io::OutputFolder& folder_;
  const Console& console_;
  std::filesystem::path file_;
  int every_, stored_at_ = -1, last_ = 0;
  bool resumes_;
  std::string head_, rows_;
  double earlier_ = 0;
  Clock::time_point start_ = Clock::now();
  control::ReducedProblem::Sweeps marked_;
  std::optional<io::Kink> kink_;
};

} // namespace

int search_jointly(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console) {
  io::OutputFolder folder(comm, out, resume ? resume::checkpoint : "");
  Timers timers;
  const Problem base(comm, scene, search_needs(scene), timers);
  console.line(headline(base));
  const ControlProblem control(base, console);
  ParameterProblem fit(base.discretisation, scene, timers, &control);
  print_doubts(fit.misfit.doubts(), console);
  control::Variables guess(control.first_guess(scene), fit.misfit.start());
  control::ReducedProblem& joint = fit.reduced;
  joint.weigh_parameters(guess);
  Log log(joint, fit, folder, resume, console);
  const optimize::Options options = search_options(control.controls, scene.optimizer);
  const auto end = optimize::minimize<optimize::Lbfgs>(joint, std::move(guess), options, log, log);
  const control::ReducedProblem::Sweeps sweeps = joint.sweeps(); // of the search, without those for output

  if (scene.output.table(scene::StoredTable::history))
    folder.write("history.csv", log.history());
  folder.write("scene.toml", scene::echo(scene, base.space.dim()));
  const scene::Scene found = fit.scene_at(joint.variables().x);
  const Problem problem(base.discretisation, found, fit.needs(), timers, forward::Stops::ignored);
  const control::ControlForce force(control.controls, joint.control());
  MotionWriter recorder(problem, folder, &control.objective, true);
  Simulated simulated = simulate_measured(problem, fit, problem.load(&force), recorder);
  write_control(
      folder, problem, control.controls, joint.control(),
      [&](const auto& store) { joint.adjoint_states(store); }, recorder.stored());
  const std::vector<double>& x = joint.variables().x;
  io::Fit result = outcome(fit,
                           {.number = log.iterations(),
                            .x = x,
                            .at = joint.least_squares(joint.variables(), forward::Stops::ignored)},
                           simulated.values);
  result.compared = std::move(simulated.compared);
  result.decrement.reset(); // which leaves the control's part of J out
  const std::vector<double> by_x = joint.gradient_by_parameters(), slopes = fit.misfit.slopes(x);
  for (std::size_t j = 0; j < x.size(); ++j)
    result.unknowns[j].gradient = by_x[j] / slopes[j];
  if (scene.output.table(scene::StoredTable::parameters))
    folder.write("parameters.csv", io::parameters_table(result));
  if (scene.output.table(scene::StoredTable::measurements))
    folder.write("measurements.csv", io::measurements_table(result));
  console.line("stopped: " + optimize::name(end.stop));
  for (const std::string& line : outcome_lines(result))
    console.line(line);
  io::Manifest m = manifest(problem, "optimize", optimize::name(end.stop), problem.steps());
  add_doubts(m, fit.misfit.doubts());
  add_watched(m, recorder, scene.run, console);
  add_warning(m, desired_warning(problem), console);
  add_warning(m, misfit_warning(result), console);
  m.objective = joint.value();
  m.objective->misfit = 0; // which "fit" has
  m.iterations = log.iterations();
  m.forward_sweeps = sweeps.forward;
  m.adjoint_sweeps = sweeps.adjoint;
  m.kink = log.kink();
  m.fit = std::move(result);
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, scene, timers));
  console.line(fmt::format("J {:.6e} (tracking {:.3e}, terminal {:.3e}, control {:.3e}, misfit {:.3e}): {} "
                           "iterations, {} forward and {} adjoint sweeps in {:.1f} s",
                           joint.value().total(), joint.value().tracking, joint.value().terminal,
                           joint.value().control_cost, joint.value().misfit, log.iterations(), sweeps.forward,
                           sweeps.adjoint, log.seconds()));
  finish(folder, console);
  return end.stop == optimize::Stop::solver_failed ? exit_status::solver_failed
         : end.stop == optimize::Stop::interrupted ? exit_status::interrupted
                                                   : exit_status::done;
}

} // namespace signorini
