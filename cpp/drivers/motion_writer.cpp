// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/motion_writer.h"
#include "base/error.h"
#include "diagnostics/warnings.h"
#include "io/csv_tables.h"
#include "io/field_writer.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>

namespace signorini::drivers {
using Field = scene::StoredField;

bool stored(const step::TimeStep& step, double end, int every, bool last) {
  if (last || step.k == 0 || every > 0)
    return last || step.k == 0 || step.k % every == 0;
  constexpr double hair = 1e-9; // of a part
  const auto part = [&](double t) { return std::floor(scene::Output::most_frames * t / end + hair); };
  return part(step.end) > part(step.begin);
}

MotionWriter::MotionWriter(const problem::Problem& problem, const io::OutputFolder& folder,
                           const control::Objective* objective, bool controlled,
                           const trajectory::StepErrors* errors)
    : problem_(problem), folder_(folder), objective_(objective),
      columns_(io::StepsColumns::of(problem.scene, objective != nullptr)),
      plausibility_(problem.stepper, problem.scene), forces_(problem.stepper),
      resolution_(problem.stepper, problem.scene),
      step_warnings_(problem.stepper, problem.scene, problem.scene_loads(), errors),
      every_(problem.scene.output.every), body_(contact::Box::empty(problem.space.dim())) {
  const auto timer = problem.timers.time("output");
  const scene::Output& output = problem.scene.output;
  const bool probed = problem.probes && output.table(scene::StoredTable::probes);
  const bool reactions = probed && problem.probes->need_reactions();
  if (output.table(scene::StoredTable::steps) || problem.scene.run.watched() || reactions ||
      problem.scene.time.until_bounce ||
      (problem.scene.several_bodies() && output.table(scene::StoredTable::bodies))) {
    balance_.emplace(problem.stepper,
                     diagnostics::Balance::Wanted{reactions, controlled, problem.scene_loads()});
    invariants_.emplace(problem.stepper, diagnostics::body_figures(problem.stepper, problem.scene));
    if (problem.scene.several_bodies())
      bodies_.emplace(problem.stepper, problem.scene.contacts);
    summary_.emplace(problem.stepper, problem.scene, bodies_ ? &*bodies_ : nullptr);
  }
  open_tables(folder, probed);
  open_state(folder);
}

void MotionWriter::open_tables(const io::OutputFolder& folder, bool probed) {
  const scene::Output& output = problem_.scene.output;
  const int dim = problem_.space.dim();
  const auto open = [&](std::optional<io::TextFile>& file, const char* name, const std::string& header) {
    file.emplace(folder, name);
    file->append(header);
  };
  if (output.table(scene::StoredTable::steps))
    open(steps_, "steps.csv", io::steps_header(dim, columns_));
  const contact::ContactPairs* pairs = problem_.stepper.pairs();
  const bool contact = pairs && output.table(scene::StoredTable::contact);
  if (contact || output.field(Field::pressure) || output.field(Field::friction))
    pressure_.emplace(problem_.space, *pairs, problem_.scene.contacts);
  if (contact) {
    contact_table_.emplace(*pairs, *pressure_, problem_.scene.contacts);
    open(contact_, "contact.csv", contact_table_->header());
  }
  if (pairs && output.table(scene::StoredTable::obstacles))
    open(obstacles_, "obstacles.csv", io::obstacles_header(dim));
  if (bodies_ && output.table(scene::StoredTable::bodies))
    open(bodies_file_, "bodies.csv", io::bodies_header(dim));
  if (probed) {
    open(probes_, "probes.csv", io::probes_header(problem_.probes->columns()));
    peaks_.emplace(problem_.scene, problem_.probes->columns());
  }
}

void MotionWriter::open_state(const io::OutputFolder& folder) {
  const scene::Output& output = problem_.scene.output;
  using enum io::Values;
  std::vector<io::FieldSeries> fields;
  for (const auto& [field, values] : {std::pair{Field::displacement, nodal},
                                      {Field::velocity, nodal},
                                      {Field::strain, cellwise_tensor},
                                      {Field::stress, cellwise_tensor},
                                      {Field::von_mises, cellwise_scalar},
                                      {Field::pressure, nodal_scalar},
                                      {Field::friction, nodal}})
    if (output.field(field))
      fields.push_back({scene::name(field), values});
  // The number of steps may not be known yet: then the disk must have room for this many.
  constexpr int usual_steps = 1000;
  const bool known = problem_.grid.complete() && !problem_.scene.time.until_bounce;
  const int steps = known ? problem_.steps() : usual_steps,
            stored = output.every > 0 ? (steps - 1) / output.every : scene::Output::most_frames;
  const auto times =
      static_cast<std::size_t>(stored + 3); // with the first, the last and that of the largest force
  if (!fields.empty())
    state_.emplace(problem_.space, folder, "state", fields, times, output.formats);
  const bool stresses = output.field(Field::stress) || output.field(Field::von_mises);
  if (output.field(Field::strain) || stresses)
    cell_fields_.emplace(problem_.space, fem::parts(problem_.mesh, problem_.scene.materials));
  if (stresses)
    largest_stress_.emplace(problem_.space, fem::parts(problem_.mesh, problem_.scene.materials));
}

void MotionWriter::operator()(const trajectory::Frame& frame) {
  diagnostics::StepBalance balance;
  {
    const auto timer = problem_.timers.time("balances");
    forces_.observe(frame);
    resolution_.observe(frame, forces_);
    if (balance_)
      weigh(frame, balance);
    plausibility_.observe(frame, balance_ ? &balance : nullptr);
    step_warnings_.observe(frame);
  }
  const auto timer = problem_.timers.time("output");
  add_rows(frame, balance);
  const bool regular = drivers::stored(frame.step, problem_.stepper.end(), every_, frame.last);
  if (regular)
    write_step({frame.step, frame.after, frame.contact});
  if (thins_out_ && regular && stored_.size() % scene::Output::most_frames == 0)
    every_ *= 2;
  if (largest_force_.observe(forces_.all().normal_force)) {
    if (regular)
      aside_.reset();
    else
      put_aside(frame);
  }
}

void MotionWriter::weigh(const trajectory::Frame& frame, diagnostics::StepBalance& balance) {
  balance = (*balance_)(frame);
  if (bodies_)
    bodies_->observe(frame, *balance_);
  invariants_->observe(frame, balance);
  summary_->observe(frame, balance, forces_);
  if (problem_.scene.run.invariants == scene::OnViolation::stop)
    if (const auto violation = invariants_->violation(problem_.scene.run.tolerance))
      throw SolverFailure(
          fmt::format("step {} (t = {:.6g} s): {}", frame.step.k, frame.step.end, *violation));
}

void MotionWriter::add_rows(const trajectory::Frame& frame, const diagnostics::StepBalance& balance) {
  const double time = frame.step.end;
  const int dim = problem_.space.dim();
  const auto append = [&](io::TextFile& file, auto&& add) {
    text_.clear();
    add();
    file.append(text_);
  };
  if (steps_) {
    const double tracking_error = objective_ ? objective_->distance(frame.step.k, frame.after.y()) : 0;
    append(*steps_, [&] {
      io::add_steps_row(text_, columns_, frame.step.k, time, dim, balance, *invariants_, frame.contact,
                        forces_.all().normal_force, tracking_error);
    });
  }
  if (obstacles_)
    append(*obstacles_,
           [&] { io::add_obstacle_rows(text_, frame.step.k, time, dim, problem_.scene.contacts, forces_); });
  if (bodies_file_)
    append(*bodies_file_, [&] { io::add_body_rows(text_, frame.step.k, time, dim, *bodies_); });
  if (probes_)
    append(*probes_, [&] {
      values_.clear();
      problem_.probes->add_values(frame, forces_, balance_ ? balance_->reactions() : nullptr, values_);
      peaks_->observe(frame.step, values_);
      io::add_probes_row(text_, frame.step.k, time, values_);
    });
}

const std::string& MotionWriter::contact_rows(const step::TimeStep& step,
                                              const contact::ContactState& contact) {
  text_.clear();
  contact_table_->add_rows(text_, step, contact);
  return text_;
}

void MotionWriter::write_step(const Snapshot& now) {
  if (contact_)
    contact_->append(contact_rows(now.step, now.contact));
  if (state_)
    store_fields(now, stored_.size());
  if (with_surfaces())
    follow(now.state.y(), stored_.size());
  stored_.push_back(now.step.k);
  times_.push_back(now.step.end);
}

void MotionWriter::put_aside(const trajectory::Frame& frame) {
  if (!aside_)
    aside_ = {.step{}, .state = problem_.stepper.state(), .contact = contact::ContactState(), .rows = 0};
  aside_->step = frame.step;
  aside_->contact = frame.contact;
  aside_->rows = contact_ ? contact_->size() : 0;
  if (state_ || with_surfaces())
    aside_->state.copy(frame.after);
}

void MotionWriter::insert(const Aside& peak) {
  const auto place = std::ranges::lower_bound(stored_, peak.step.k);
  if (contact_)
    contact_->insert(peak.rows, contact_rows(peak.step, peak.contact));
  if (state_) {
    const auto number = static_cast<std::size_t>(place - stored_.begin());
    state_->make_room(number);
    store_fields({peak.step, peak.state, peak.contact}, number);
  }
  times_.insert(times_.begin() + (place - stored_.begin()), peak.step.end);
  if (with_surfaces())
    follow(peak.state.y(), static_cast<std::size_t>(place - stored_.begin()));
  stored_.insert(place, peak.step.k);
}

void MotionWriter::store_fields(const Snapshot& now, std::size_t number) {
  const scene::Output& output = problem_.scene.output;
  const double t = now.step.end;
  const auto write = [&](Field field, auto&& values) {
    if (output.field(field))
      state_->write(scene::name(field), number, t, values());
  };
  write(Field::displacement, [&] { return now.state.y(); });
  write(Field::velocity, [&] { return now.state.v(); });
  if (cell_fields_)
    cell_fields_->set(now.state.y(), now.state.v(), now.state.q());
  for (const auto& [field, of_cells] : {std::pair{Field::strain, fem::CellField::strain},
                                        {Field::stress, fem::CellField::stress},
                                        {Field::von_mises, fem::CellField::von_mises}})
    write(field, [&] { return (*cell_fields_)(of_cells); });
  if (largest_stress_)
    largest_stress_->observe(*cell_fields_, now.state, t);
  write(Field::pressure, [&] {
    const std::vector<double> pressures =
        (*pressure_)(now.contact.normal_lambda(), now.step.scheme().impulse());
    std::vector<double> field = contact::at_nodes(problem_.space, *problem_.stepper.pairs(), pressures);
    pressure_->extend_to_axis(pressures, field);
    contact::extend_to_masters(problem_.space, *problem_.stepper.pairs(), pressures, field);
    return field;
  });
  write(Field::friction, [&] {
    friction_ = petsc::zero_like(now.state.y());
    contact::set_friction(problem_.space, *problem_.stepper.pairs(), *pressure_, now.contact.lambda,
                          now.step.scheme().impulse(), friction_);
    return Vec(friction_);
  });
}

void MotionWriter::follow(Vec y, std::size_t number) {
  const contact::ContactPairs& pairs = *problem_.stepper.pairs();
  places_.resize(static_cast<std::size_t>(pairs.obstacle_count()));
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (const contact::RigidMotion* rigid = pairs.rigid(static_cast<int>(i)))
      places_[i].insert(places_[i].begin() + static_cast<std::ptrdiff_t>(number), rigid->place(y));
  const petsc::ReadArray u(y);
  const auto dim = static_cast<std::size_t>(problem_.space.dim());
  const std::vector<double>& points = problem_.space.points();
  for (std::size_t node = 0; 3 * node < points.size(); ++node) {
    std::array<double, 3> x{points[3 * node], points[3 * node + 1], points[3 * node + 2]};
    for (std::size_t c = 0; c < dim; ++c)
      x[c] += u[dim * node + c];
    body_.include(x);
  }
}

void MotionWriter::write_obstacle_surfaces() const {
  if (!with_surfaces())
    return;
  const contact::ContactPairs* pairs = problem_.stepper.pairs();
  contact::Box body = body_;
  MPI_Allreduce(MPI_IN_PLACE, body.low.data(), 3, MPI_DOUBLE, MPI_MIN, pairs->comm());
  MPI_Allreduce(MPI_IN_PLACE, body.high.data(), 3, MPI_DOUBLE, MPI_MAX, pairs->comm());
  io::write_obstacle_surfaces(folder_, *pairs, times_, body, places_,
                              state_ && problem_.scene.output.in(scene::FieldFormat::vtkhdf));
}

std::vector<Warning> MotionWriter::warnings() {
  std::vector<Warning> found = plausibility_.warnings();
  const auto add = [&](std::vector<Warning> warnings) {
    std::ranges::move(warnings, std::back_inserter(found));
  };
  add(resolution_.warnings());
  add(step_warnings_.warnings());
  if (summary_)
    add(diagnostics::contact_loss(problem_.stepper, problem_.scene, summary_->energy().normal_work(),
                                  invariants_->largest_energy()));
  if (largest_stress_)
    add(largest_stress_->warnings());
  return found;
}

void MotionWriter::finish() {
  const auto timer = problem_.timers.time("output");
  if (aside_)
    insert(*aside_);
  for (std::optional<io::TextFile>* file : {&steps_, &contact_, &obstacles_, &probes_})
    if (*file)
      (*file)->close();
  if (state_)
    state_->close();
  write_obstacle_surfaces();
}

void write_control(const io::OutputFolder& folder, const problem::Problem& problem,
                   const control::ControlSpace& controls, const control::Control& u,
                   const AdjointStates& adjoint_states, const std::vector<int>& stored) {
  const auto timer = problem.timers.time("output");
  const scene::Output& output = problem.scene.output;
  std::vector<int> steps;
  std::ranges::copy_if(stored, std::back_inserter(steps), [](int k) { return k > 0; });
  using enum io::Values;
  const auto write = [&](scene::StoredField field, io::Values values, auto&& at) {
    if (!output.field(field))
      return;
    const std::string name = scene::name(field);
    io::FieldWriter file(problem.space, folder, name, {{name, values}}, steps.size(), output.formats);
    at([&](int k, Vec x) {
      if (const auto found = std::ranges::lower_bound(steps, k); found != steps.end() && *found == k)
        file.write(name, static_cast<std::size_t>(found - steps.begin()), problem.grid.time(k), x);
    });
    file.close();
  };
  write(scene::StoredField::control, controls.cellwise() ? cellwise : nodal, [&](auto&& store) {
    const petsc::Vector field = controls.field();
    std::vector<double> mean(controls.size());
    for (int k : steps) {
      std::ranges::fill(mean, 0);
      controls.for_each_interval(controls.grid().step(k),
                                 [&](int j, double part) { axpy(part, u.at(j), mean); });
      controls.extend(mean, field);
      store(k, field);
    }
  });
  write(scene::StoredField::adjoint, nodal, [&](auto&& store) { adjoint_states(store); });
}

} // namespace signorini::drivers
