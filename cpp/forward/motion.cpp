#include "forward/motion.h"
#include "base/collective.h"
#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

bool moves(const scene::Clamp& clamp) { return clamp.value && !scene::vanishes(*clamp.value); }

} // namespace

bool PrescribedMotion::in(const std::vector<scene::Clamp>& clamps) {
  return std::ranges::any_of(clamps, moves);
}

PrescribedMotion::PrescribedMotion(const fem::Space& space, const std::vector<scene::Clamp>& clamps, Mat D,
                                   Scheme scheme)
    : space_(space), scheme_(scheme), position_(space.vector()), force_(space.vector()) {
  for (std::size_t i = 0; i < clamps.size(); ++i)
    if (moves(clamps[i])) {
      const std::string key = scene::clamp_key(clamps, i);
      clamps_.push_back({scene::Field(*clamps[i].value, key + ".value", true),
                         space.nodes_on(clamps[i].on, key + ".on"),
                         fem::component_numbers(clamps[i].components, space.dim())});
    }
  check(MatConvert(D, MATSBAIJ, MAT_INITIAL_MATRIX, D_.put()));
}

template <class Set>
void PrescribedMotion::evaluate(double t, Set&& set) const {
  together(space_.comm(), [&] {
    std::array<double, 3> value{};
    for (const Clamp& clamp : clamps_)
      for (int node : clamp.nodes) {
        clamp.field.evaluate(&space_.points()[3 * static_cast<std::size_t>(node)], t, value.data());
        for (std::size_t c = 0; c < clamp.components.size(); ++c)
          set(static_cast<std::size_t>(node * space_.dim() + clamp.components[c]), value[c]);
      }
  });
}

void PrescribedMotion::position(double t, Vec y) const {
  const petsc::WriteArray values(y);
  evaluate(t, [&](std::size_t dof, double value) { values[dof] = value; });
}

void PrescribedMotion::initial_velocity(Vec v) const {
  const petsc::WriteArray values(v);
  evaluate(0, [&](std::size_t dof, double) { values[dof] = 0; });
  // Differences to times inside the run, of second order in a hundredth of a step.
  const double t = scheme_.tau / 100;
  for (const auto& [factor, time] : {std::pair{-3.0, 0.0}, {4.0, t}, {-1.0, 2 * t}})
    evaluate(time, [&](std::size_t dof, double value) { values[dof] += factor * value / (2 * t); });
}

void PrescribedMotion::apply(int k, const fem::Clamped& clamped, double diagonal, Vec r) const {
  const bool again =
      std::ranges::any_of(clamps_, [](const Clamp& clamp) { return clamp.field.depends_on_time(); });
  if (again || !evaluated_) {
    check(VecZeroEntries(position_));
    position(scheme_.time(k), position_);
    check(MatMult(D_, position_, force_));
    evaluated_ = true;
  }
  check(VecAXPY(r, -1, force_));
  clamped.clear(r);
  const petsc::ReadArray position(position_);
  const petsc::WriteArray values(r);
  for (const Clamp& clamp : clamps_)
    for (int node : clamp.nodes)
      for (int c : clamp.components) {
        const auto dof = static_cast<std::size_t>(node * space_.dim() + c);
        values[dof] = diagonal * position[dof];
      }
}

} // namespace signorini::forward
