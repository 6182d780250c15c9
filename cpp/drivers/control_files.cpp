// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/control_files.h"
#include "io/field_writer.h"
#include <algorithm>
#include <iterator>

namespace signorini::drivers {

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
    io::FieldWriter file(problem.space, folder, name + ".xdmf", {{name, values}}, steps.size());
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
