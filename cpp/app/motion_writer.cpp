#include "app/motion_writer.h"
#include "base/error.h"
#include "io/motion_tables.h"
#include <fmt/format.h>

namespace signorini {

MotionWriter::MotionWriter(const Problem& problem, const io::OutputFolder& folder,
                           const control::Objective* objective, bool controlled)
    : problem_(problem), objective_(objective),
      plausibility_(problem.stepper, problem.scene, problem.steps()), forces_(problem.stepper),
      resolution_(problem.stepper, problem.scene) {
  const auto timer = problem.timers.time("output");
  const scene::Output& output = problem.scene.output;
  const int dim = problem.space.dim();
  const bool probed = problem.probes && output.table(scene::StoredTable::probes);
  const bool reactions = probed && problem.probes->need_reactions();
  if (output.table(scene::StoredTable::steps) || problem.scene.run.watched() || reactions) {
    balance_.emplace(problem.stepper, forward::Balance::Wanted{reactions, controlled, problem.scene_loads()});
    invariants_.emplace(problem.stepper);
    summary_.emplace(problem.stepper, problem.scene);
  }
  const auto open = [&](std::optional<io::TextFile>& file, const char* name, const std::string& header) {
    file.emplace(folder, name);
    file->append(header);
  };
  if (output.table(scene::StoredTable::steps))
    open(steps_, "steps.csv", io::steps_header(dim, objective != nullptr));
  if (output.table(scene::StoredTable::contact) && problem.stepper.pairs())
    open(contact_, "contact.csv", io::contact_header(*problem.stepper.pairs()));
  if (output.table(scene::StoredTable::obstacles) && problem.stepper.pairs())
    open(obstacles_, "obstacles.csv", io::obstacles_header(dim));
  if (probed)
    open(probes_, "probes.csv", io::probes_header(problem.probes->columns()));
  const std::size_t fields =
      output.field(scene::StoredField::displacement) + output.field(scene::StoredField::velocity);
  const auto times = static_cast<std::size_t>((problem.steps() - 1) / output.every + 2);
  if (fields > 0)
    state_.emplace(problem.space, folder, "state.xdmf", fields * times);
}

void MotionWriter::operator()(const forward::Frame& frame) {
  const auto timer = problem_.timers.time("output");
  forces_.observe(frame);
  resolution_.observe(frame, forces_);
  forward::StepBalance balance;
  if (balance_)
    weigh(frame, balance);
  plausibility_.observe(frame, balance_ ? &balance : nullptr);
  add_rows(frame, balance);
  if (stored(frame.k, problem_.scene.output.every, frame.last))
    store(frame);
}

void MotionWriter::weigh(const forward::Frame& frame, forward::StepBalance& balance) {
  balance = (*balance_)(frame);
  invariants_->observe(frame, balance);
  summary_->observe(frame, balance, forces_);
  if (problem_.scene.run.invariants == scene::OnViolation::stop)
    if (const auto violation = invariants_->violation(problem_.scene.run.tolerance))
      throw SolverFailure(fmt::format("step {} (t = {:.6g} s): {}", frame.k,
                                      problem_.stepper.grid().time(frame.k), *violation));
}

void MotionWriter::add_rows(const forward::Frame& frame, const forward::StepBalance& balance) {
  const double time = problem_.stepper.grid().time(frame.k);
  const int dim = problem_.space.dim();
  const auto append = [&](io::TextFile& file, auto&& add) {
    text_.clear();
    add();
    file.append(text_);
  };
  if (steps_) {
    std::optional<double> tracking_error;
    if (objective_)
      tracking_error = objective_->distance(frame.k, frame.y1);
    append(*steps_, [&] {
      io::add_steps_row(text_, frame.k, time, dim, balance, *invariants_, frame.contact,
                        forces_.all().normal_force, tracking_error);
    });
  }
  if (obstacles_)
    append(*obstacles_,
           [&] { io::add_obstacle_rows(text_, frame.k, time, dim, problem_.scene.contacts, forces_); });
  if (probes_)
    append(*probes_, [&] {
      values_.clear();
      problem_.probes->add_values(frame, forces_, balance_ ? balance_->reactions() : nullptr, values_);
      io::add_probes_row(text_, frame.k, time, values_);
    });
}

void MotionWriter::store(const forward::Frame& frame) {
  const forward::TimeGrid& grid = problem_.stepper.grid();
  if (contact_) {
    text_.clear();
    io::add_contact_rows(text_, frame.k, grid, *problem_.stepper.pairs(), frame.contact);
    contact_->append(text_);
  }
  if (state_ && problem_.scene.output.field(scene::StoredField::displacement))
    state_->write("displacement", frame.y1, grid.time(frame.k));
  if (state_ && problem_.scene.output.field(scene::StoredField::velocity))
    state_->write("velocity", frame.v1, grid.time(frame.k));
}

std::vector<forward::Warning> MotionWriter::warnings() {
  std::vector<forward::Warning> found = plausibility_.warnings();
  for (forward::Warning& warning : resolution_.warnings())
    found.push_back(std::move(warning));
  return found;
}

void MotionWriter::finish() {
  const auto timer = problem_.timers.time("output");
  for (std::optional<io::TextFile>* file : {&steps_, &contact_, &obstacles_, &probes_})
    if (*file)
      (*file)->close();
  if (state_)
    state_->close();
}

} // namespace signorini
