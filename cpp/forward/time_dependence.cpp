// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/time_dependence.h"
#include "base/collective.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::forward {
namespace {

/// Some nodes of the first rank that has any, on every rank. Collective.
std::vector<double> some_nodes(const fem::Space& space) {
  constexpr std::size_t some = 5;
  std::vector<double> mine;
  const auto count = static_cast<std::size_t>(space.owned_nodes());
  for (std::size_t i = 0; count > 0 && i < some; ++i) {
    const double* x = &space.points()[3 * (i * (count - 1) / (some - 1))];
    mine.insert(mine.end(), x, x + 3);
  }
  std::vector<double> all = gather(space.comm(), mine);
  all.resize(std::min(all.size(), 3 * some));
  return all;
}

/// The fields by which an obstacle moves.
std::vector<scene::Field> fields_of(const scene::Obstacle& obstacle) {
  std::vector<scene::Field> fields;
  const auto add = [&](const scene::Components& components) {
    fields.emplace_back(components, "obstacle", true);
  };
  if (const auto* plane = std::get_if<scene::HalfSpace>(&obstacle)) {
    add(plane->point);
  } else if (const auto* ball = std::get_if<scene::Ball>(&obstacle)) {
    add(ball->center);
    add({ball->radius});
  } else if (const auto* cylinder = std::get_if<scene::Cylinder>(&obstacle)) {
    add(cylinder->point);
    add({cylinder->radius});
  } else {
    add({std::get<scene::SignedDistance>(obstacle).distance});
  }
  return fields;
}

} // namespace

TimeDependence::TimeDependence(const fem::Space& space, const scene::Scene& scene)
    : end_(scene.time.end), nodes_(some_nodes(space)) {
  const auto take = [&](scene::Field field, bool load) {
    add(std::make_shared<const scene::Field>(std::move(field)), load);
  };
  if (scene.load) {
    if (scene.load->body)
      take({*scene.load->body, "load.body", true}, true);
    if (scene.load->gravity)
      take({*scene.load->gravity, "load.gravity", true}, true);
    for (std::size_t i = 0; i < scene.load->tractions.size(); ++i)
      take({scene.load->tractions[i].value, fmt::format("load.traction[{}].value", i), true}, true);
  }
  for (std::size_t i = 0; i < scene.clamps.size(); ++i)
    if (scene.clamps[i].value)
      take({*scene.clamps[i].value, scene::clamp_key(scene.clamps, i) + ".value", true}, false);
  for (const scene::Contact& contact : scene.contacts)
    for (scene::Field& field : fields_of(contact.obstacle))
      take(std::move(field), false);
}

void TimeDependence::add(const std::shared_ptr<const scene::Field>& field, bool load) {
  if (!field->depends_on_time())
    return;
  const std::size_t places = field->depends_on_place() ? nodes_.size() / 3 : 1;
  for (std::size_t place = 0; place < places; ++place)
    for (std::size_t component = 0; component < field->size(); ++component) {
      Signal signal{.load = load};
      signal.value = [this, field, place, component](double t) {
        std::array<double, 3> values{};
        field->evaluate(&nodes_[3 * place], t, values.data());
        return values[component];
      };
      for (int i = 0; i <= looks; ++i)
        signal.samples.push_back(signal.value(end_ * i / looks));
      const auto [least, most] = std::ranges::minmax(signal.samples);
      if (load)
        for (const double value : signal.samples)
          signal.size += std::abs(value) * end_ / looks;
      else
        signal.size = most - least;
      if (signal.size > 0)
        signals_.push_back(std::move(signal));
    }
}

double TimeDependence::deviation(const Signal& signal, double from, double to) const {
  constexpr std::size_t points = 5;
  std::array<double, points> values{};
  for (std::size_t i = 0; i < points; ++i)
    values[i] = signal.value(from + (to - from) * static_cast<double>(i) / (points - 1));
  const auto polynomial = [&](double x) { // 0 … points − 1
    double sum = 0;
    for (std::size_t i = 0; i < points; ++i) {
      double weight = values[i];
      for (std::size_t j = 0; j < points; ++j)
        if (j != i)
          weight *= (x - static_cast<double>(j)) / (static_cast<double>(i) - static_cast<double>(j));
      sum += weight;
    }
    return sum;
  };
  double most = 0;
  const auto look = [&](double t, double value) {
    most = std::max(most, std::abs(value - polynomial((t - from) / (to - from) * (points - 1))));
  };
  for (std::size_t i = 0; i + 1 < points; ++i) { // between them, for steps that no sample falls into
    const double t = from + (to - from) * (static_cast<double>(i) + 0.5) / (points - 1);
    look(t, signal.value(t));
  }
  const double between = end_ / looks;
  for (auto i = static_cast<std::size_t>(from / between) + 1; static_cast<double>(i) * between < to; ++i)
    look(static_cast<double>(i) * between, signal.samples[i]);
  return most;
}

bool TimeDependence::resolves(double from, double to, double tolerance) const {
  return std::ranges::all_of(signals_, [&](const Signal& signal) {
    return deviation(signal, from, to) * (signal.load ? to - from : 1) <= tolerance * signal.size;
  });
}

} // namespace signorini::forward
