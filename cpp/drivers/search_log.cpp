// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/search_log.h"
#include "base/collective.h"
#include <cmath>
#include <compare>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <tuple>

namespace signorini::drivers {

io::Kink describe(control::ReducedProblem& reduced,
                  const optimize::Certificate<control::Variables>& certificate) {
  const auto sweeps = reduced.sweeps();
  using Where = std::tuple<std::size_t, int, int>; // motion, step, candidate
  struct How {
    bool touches = false;
    contact::Motion motion = contact::Motion::free;
    bool at_predictor = false; ///< whether the projection of the predictor holds it
    auto operator<=>(const How&) const = default;
  };
  std::map<Where, std::map<How, std::size_t>> closed; // number of points where it moves so
  for (const auto& point : certificate.points) {
    reduced.simulate(*point);
    const auto contact = reduced.trial_contact();
    const std::size_t steps = reduced.trial_trajectory().contact().size();
    for (std::size_t n = 0; n < contact.size(); ++n) {
      if (n % steps == 0)
        continue;
      std::map<int, How> of_step;
      for (std::size_t j = 0; j < contact[n].active.size(); ++j)
        of_step[contact[n].active[j]] = {contact[n].closed(j), contact[n].motion(j)};
      for (const int i : contact[n].predictor)
        of_step[i].at_predictor = true;
      for (const auto& [i, how] : of_step)
        ++closed[{n / steps, static_cast<int>(n % steps), i}][how];
    }
  }
  reduced.restore_sweeps(sweeps);
  io::Kink kink{certificate.length, certificate.radius, static_cast<int>(certificate.points.size()), {}};
  for (const auto& [where, motions] : closed)
    if (motions.begin()->second < certificate.points.size()) {
      const auto& [motion, k, i] = where;
      const double* x = &reduced.stepper().pairs()->points()[3 * static_cast<std::size_t>(i)];
      kink.weak.push_back({static_cast<int>(motion),
                           k,
                           reduced.controls().grid().time(k),
                           i,
                           {x, x + reduced.stepper().space().dim()}});
    }
  return kink;
}

std::vector<double> numbers(const io::Kink& kink) {
  std::vector<double> all{kink.length, kink.radius, static_cast<double>(kink.gradients)};
  for (const io::WeakContact& weak : kink.weak) {
    all.insert(all.end(), {static_cast<double>(weak.motion), static_cast<double>(weak.step), weak.time,
                           static_cast<double>(weak.candidate)});
    all.insert(all.end(), weak.x.begin(), weak.x.end());
  }
  return all;
}

std::optional<io::Kink> kink_of(const std::vector<double>& numbers, int dim) {
  constexpr std::size_t head = 3, before = 4; // entries of the kink, and of a candidate before its point
  const std::size_t each = before + static_cast<std::size_t>(dim);
  if (numbers.size() < head || (numbers.size() - head) % each != 0)
    return std::nullopt;
  io::Kink kink{numbers[0], numbers[1], static_cast<int>(numbers[2]), {}};
  for (auto n = numbers.begin() + head; n != numbers.end(); n += static_cast<std::ptrdiff_t>(each))
    kink.weak.push_back({static_cast<int>(n[0]),
                         static_cast<int>(n[1]),
                         n[2],
                         static_cast<int>(n[3]),
                         {n + before, n + static_cast<std::ptrdiff_t>(each)}});
  return kink;
}

namespace {

/// Ends of the intervals on which controls are constant, s.
std::vector<double> edges(const control::ControlSpace& controls) {
  std::vector<double> times;
  for (int j = 1; j <= controls.count() + 1; ++j)
    times.push_back(controls.begin(j));
  return times;
}

} // namespace

SearchLog::SearchLog(const SearchSubject& subject, const io::OutputFolder& folder, bool resume,
                     const Console& console, Files files)
    : subject_(subject), folder_(folder), console_(console), file_(folder.path() / resume::checkpoint),
      files_(files), every_(subject.scene.optimizer.checkpoint),
      resumes_(resume && resume::found(folder, console)) {
  if (subject.parameters)
    return;
  progress_.emplace(console, "iterations", static_cast<std::size_t>(subject.scene.optimizer.max_iterations),
                    0, Progress::Total::limit);
  if (const auto& reference = subject.control->reference)
    reference_norm_ = subject.control->controls.norm(*reference);
}

double SearchLog::seconds() const {
  return earlier_ + std::chrono::duration<double>(Clock::now() - start_).count();
}

std::vector<double> SearchLog::add(io::History::Row row, std::span<const double> x) {
  evaluated_ = true;
  std::vector<double> theta;
  if (subject_.parameters)
    theta = subject_.parameters->misfit.values(x);
  for (std::size_t j = 0; j < theta.size(); ++j)
    row.emplace_back(subject_.parameters->scene.unknowns[j].name, theta[j]);
  history_.add(row);
  show_row();
  return theta;
}

void SearchLog::operator()(const optimize::Iteration& iteration) {
  const control::ReducedProblem& reduced = subject_.reduced;
  const control::ObjectiveValue& value = reduced.value();
  io::History::Row row{{"iteration", iteration.number},
                       {"objective", value.total()},
                       {"tracking", value.tracking},
                       {"terminal", value.terminal},
                       {"control_cost", value.control_cost}};
  if (subject_.parameters)
    row.emplace_back("misfit", value.misfit);
  row.insert(row.end(), {{"gradient_norm", iteration.gradient_norm},
                         {"step_length", iteration.step_length},
                         {"forward_sweeps", reduced.sweeps().forward},
                         {"adjoint_sweeps", reduced.sweeps().adjoint},
                         {"seconds", seconds()}});
  if (!subject_.parameters) {
    double distance = std::numeric_limits<double>::quiet_NaN();
    if (reference_norm_ > 0) {
      control::Control difference = reduced.control();
      difference.add(-1, *subject_.control->reference);
      distance = subject_.control->controls.norm(difference) / reference_norm_;
    }
    row.emplace_back("relative_distance_to_reference", distance);
  }
  const std::vector<double> theta = add(std::move(row), reduced.variables().x);
  if (progress_)
    progress_->update(static_cast<std::size_t>(iteration.number),
                      fmt::format("J = {:.6e}  |g| = {:.2e}  step {:.2g}", value.total(),
                                  iteration.gradient_norm, iteration.step_length));
  else
    console_.line(fmt::format("{:4d}  J = {:.6e}, misfit {:.3e}, |g| = {:.2e}; {:.6g}", iteration.number,
                              value.total(), value.misfit, iteration.gradient_norm, fmt::join(theta, ", ")));
}

void SearchLog::operator()(const optimize::GaussNewtonIterate& iterate) {
  const std::vector<double> theta = add({{"iteration", iterate.number},
                                         {"objective", iterate.at.value()},
                                         {"decrement", iterate.decrement},
                                         {"damping", iterate.damping},
                                         {"forward_sweeps", subject_.reduced.sweeps().forward},
                                         {"seconds", seconds()}},
                                        iterate.x);
  console_.line(fmt::format("{:4d}  J = {:.6e}, decrement {:.2e}; {:.6g}", iterate.number, iterate.at.value(),
                            iterate.decrement, fmt::join(theta, ", ")));
}

void SearchLog::show_row() {
  if (files_ == Files::with_results || rank(folder_.comm()) != 0 ||
      !subject_.scene.output.table(scene::StoredTable::history))
    return;
  if (table_.is_open()) {
    table_ << history_.text(history_.rows() - 1) << std::flush;
    return;
  }
  // The earlier run's file is replaced as a whole, by renaming.
  const std::filesystem::path part = folder_.staged("history.csv.part");
  table_.open(part, std::ios::binary);
  table_ << history_.table() << std::flush;
  std::error_code ignored; // the whole table is written again, and checked, at the end
  if (table_)
    std::filesystem::rename(part, folder_.path() / "history.csv", ignored);
  if (!table_ || ignored)
    std::filesystem::remove(part, ignored);
}

std::string SearchLog::echoed() const {
  return scene::echo(subject_.scene, subject_.discretisation.space.dim());
}

void SearchLog::write(io::CheckpointWriter& out) const {
  resume::store_problem(out, echoed(), subject_.discretisation.mesh);
  if (const problem::Problem* problem = subject_.problem) {
    out(solver, std::string(problem->stepper.solver().iterates() ? iterative : "direct"));
    out("edges", edges(subject_.control->controls));
    out(levels, problem->grid.levels());
  }
  out("columns", fmt::format("{}", fmt::join(history_.columns, ",")));
  out("history", history_.numbers);
  out("seconds", seconds());
  out("sweeps",
      std::vector<double>{static_cast<double>(marked_.forward), static_cast<double>(marked_.adjoint)});
  out("kink", kink_ ? numbers(*kink_) : std::vector<double>());
}

void SearchLog::read(io::CheckpointReader& in) {
  resume::require_same_problem(in, echoed(), subject_.discretisation.mesh);
  if (subject_.control)
    in.match_places();
  std::string columns;
  in("columns", columns);
  in("history", history_.numbers);
  history_.columns = io::History::split(columns);
  if (history_.numbers.empty() || history_.numbers.size() % history_.columns.size() != 0)
    in.fail("\"history\" is damaged; use an undamaged checkpoint");
  in("seconds", earlier_);
  std::vector<double> sweeps, kink;
  in("sweeps", sweeps);
  if (sweeps.size() != 2)
    in.fail("\"sweeps\" is damaged; use an undamaged checkpoint");
  marked_ = {static_cast<int>(sweeps[0]), static_cast<int>(sweeps[1])};
  in("kink", kink);
  if (!kink.empty()) {
    kink_ = kink_of(kink, subject_.discretisation.space.dim());
    if (!kink_)
      in.fail("\"kink\" is damaged; use an undamaged checkpoint");
  }
}

void SearchLog::restored(double stored, double found) {
  // If the data have no noise J itself is rounding.
  const double least = subject_.control ? 0 : static_cast<double>(subject_.parameters->misfit.count());
  resume::require_same_value(file_, stored, found, std::max(std::abs(stored), least));
  evaluated_ = true;
  subject_.reduced.restore_sweeps(marked_); // later sweeps are repeated
  stored_at_ = static_cast<int>(history_.last("iteration"));
  start_ = Clock::now();
  if (progress_)
    progress_.emplace(console_, "iterations",
                      static_cast<std::size_t>(subject_.scene.optimizer.max_iterations),
                      static_cast<std::size_t>(stored_at_), Progress::Total::limit);
  console_.line(fmt::format("resumed after iteration {}", stored_at_));
  show_row();
}

} // namespace signorini::drivers
