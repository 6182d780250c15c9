#include "app/motion_writer.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini {

MotionWriter::MotionWriter(const Problem& problem, const io::OutputFolder& folder,
                           const control::Objective* objective)
    : problem_(problem), objective_(objective),
      plausibility_(problem.stepper, problem.scene, problem.steps()) {
  const auto timer = problem.timers.time("output");
  const scene::Output& output = problem.scene.output;
  const int dim = problem.space.dim();
  if (output.table(scene::StoredTable::steps) || problem.scene.run.watched())
    balance_.emplace(problem.stepper);
  if (balance_)
    invariants_.emplace(problem.stepper);
  if (output.table(scene::StoredTable::steps)) {
    steps_.emplace(folder, "steps.csv");
    steps_->append(io::steps_header(dim, objective != nullptr));
  }
  if (output.table(scene::StoredTable::contact) && problem.stepper.pairs()) {
    contact_.emplace(folder, "contact.csv");
    contact_->append(io::contact_header(*problem.stepper.pairs()));
  }
  const std::size_t fields =
      output.field(scene::StoredField::displacement) + output.field(scene::StoredField::velocity);
  const auto times = static_cast<std::size_t>((problem.steps() - 1) / output.every + 2);
  if (fields > 0)
    state_.emplace(problem.space, folder, "state.xdmf", fields * times);
}

void MotionWriter::operator()(const forward::Frame& frame) {
  const auto timer = problem_.timers.time("output");
  forward::StepBalance balance;
  if (balance_) {
    balance = (*balance_)(frame);
    invariants_->observe(frame, balance);
    if (problem_.scene.run.invariants == scene::OnViolation::stop)
      if (const auto violation = invariants_->violation(problem_.scene.run.tolerance))
        throw SolverFailure(fmt::format("step {} (t = {:.6g} s): {}", frame.k,
                                        problem_.stepper.grid().time(frame.k), *violation));
  }
  plausibility_.observe(frame, balance_ ? &balance : nullptr);
  if (steps_) {
    std::optional<double> tracking_error;
    if (objective_)
      tracking_error = objective_->distance(frame.k, frame.y1);
    text_.clear();
    io::add_steps_row(text_, frame.k, problem_.stepper.grid().time(frame.k), problem_.space.dim(), balance,
                      *invariants_, frame.contact, tracking_error);
    steps_->append(text_);
  }
  if (stored(frame.k, problem_.scene.output.every, frame.last))
    store(frame);
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

void MotionWriter::finish() {
  const auto timer = problem_.timers.time("output");
  if (steps_)
    steps_->close();
  if (contact_)
    contact_->close();
  if (state_)
    state_->close();
}

} // namespace signorini
