#include "app/motion_writer.h"
#include "base/error.h"
#include <fmt/format.h>
#include <tuple>

namespace signorini {
using Field = scene::StoredField;

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
  const contact::ContactPairs* pairs = problem.stepper.pairs();
  const bool contact = pairs && output.table(scene::StoredTable::contact);
  if (contact || output.field(Field::pressure))
    pressure_.emplace(problem.space, *pairs, problem.scene.contacts);
  if (contact) {
    contact_table_.emplace(*pairs, *pressure_);
    contact_.emplace(folder, "contact.csv");
    contact_->append(contact_table_->header());
  }
  open_state(folder);
}

void MotionWriter::open_state(const io::OutputFolder& folder) {
  const scene::Output& output = problem_.scene.output;
  std::size_t fields = 0; // in vectors
  for (const Field field : {Field::displacement, Field::velocity, Field::von_mises, Field::pressure})
    fields += output.field(field);
  for (const Field field : {Field::strain, Field::stress})
    fields += 3 * static_cast<std::size_t>(output.field(field));
  const auto times = static_cast<std::size_t>((problem_.steps() - 1) / output.every + 2);
  if (fields > 0)
    state_.emplace(problem_.space, folder, "state.xdmf", fields * times);
  if (output.field(Field::strain) || output.field(Field::stress) || output.field(Field::von_mises))
    cell_fields_.emplace(problem_.space, fem::parts(problem_.mesh, problem_.scene.materials));
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
  if (contact_) {
    text_.clear();
    contact_table_->add_rows(text_, frame.k, problem_.stepper.grid(), frame.contact);
    contact_->append(text_);
  }
  if (state_)
    store_fields(frame);
}

void MotionWriter::store_fields(const forward::Frame& frame) {
  const scene::Output& output = problem_.scene.output;
  const double t = problem_.stepper.grid().time(frame.k);
  if (output.field(Field::displacement))
    state_->write("displacement", frame.y1, t);
  if (output.field(Field::velocity))
    state_->write("velocity", frame.v1, t);
  if (cell_fields_)
    cell_fields_->set(frame.y1, frame.v1);
  using Values = io::FieldFile::Values;
  for (const auto& [name, field, values] :
       {std::tuple{Field::strain, fem::CellField::strain, Values::cellwise_tensor},
        {Field::stress, fem::CellField::stress, Values::cellwise_tensor},
        {Field::von_mises, fem::CellField::von_mises, Values::cellwise_scalar}})
    if (output.field(name))
      state_->write(scene::name(name), (*cell_fields_)(field), t, values);
  if (output.field(Field::pressure)) {
    const double impulse = problem_.stepper.grid().scheme(frame.k).impulse();
    state_->write("pressure",
                  contact::at_nodes(problem_.space, *problem_.stepper.pairs(),
                                    (*pressure_)(frame.contact.lambda, impulse)),
                  t, Values::nodal_scalar);
  }
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
