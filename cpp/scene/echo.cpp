// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/schema.h"

namespace signorini::scene {
namespace {

Components zero(std::size_t size) { return Components(size, "0"); }

template <class T>
void fill(std::optional<T>& given, const T& otherwise) {
  if (!given)
    given = otherwise;
}

} // namespace

std::string echo(const Scene& scene, int dim) {
  Scene whole = scene;
  for (Clamp& clamp : whole.clamps) {
    fill(clamp.components, components(dim));
    fill(clamp.value, zero(clamp.components->size()));
  }
  const Components still = zero(static_cast<std::size_t>(dim));
  // With moving clamps the default is their motion at the start, which a field of expressions cannot state.
  if (std::ranges::all_of(whole.clamps, [](const Clamp& clamp) { return vanishes(*clamp.value); })) {
    fill(whole.initial.displacement, still);
    fill(whole.initial.velocity, still);
  }
  if (whole.control) {
    fill(whole.control->components, components(dim));
    if (!whole.control->stored)
      fill(whole.control->initial, still);
  }
  return schema::write(whole);
}

} // namespace signorini::scene
