#include "forward/trajectory.h"

namespace signorini::forward {

Trajectory::Trajectory(const Stepper& stepper, const Initial& initial, int steps, const Storage& storage,
                       bool velocities)
    : stepper_(stepper), capacity_(steps), again_(candidates(stepper)),
      march_(stepper, initial.y, initial.v,
             [this](int k, Vec y0, Vec v0, Vec y1, Vec v1) {
               const auto i = static_cast<std::size_t>(k);
               acting_ = (*load_at_)(k);
               stepper_.step(k, y0, v0, acting_, contact_[i - 1], k > steps_ ? contact_[i] : again_, y1, v1);
             }),
      states_(storage.place(march_, velocities)) {
  contact_.reserve(static_cast<std::size_t>(steps) + 1);
  for (int k = 0; k <= steps; ++k)
    contact_.emplace_back(candidates(stepper)); // not copies of one: a copy has no room for other active sets
}

void Trajectory::run(Load load, const Watch& watch) {
  load_ = std::move(load);
  load_at_.emplace(stepper_.space(), load_);
  steps_ = 0;
  const auto contact = [this](int k) -> contact::ContactState& {
    return contact_[static_cast<std::size_t>(k)];
  };
  go_through(stepper_, march_, capacity_, Stops::obeyed, contact, acting_, [&](const Frame& frame) {
    steps_ = frame.k;
    states_->keep(march_.state());
    if (watch)
      watch(frame);
  });
}

} // namespace signorini::forward
