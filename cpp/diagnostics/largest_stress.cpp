// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/largest_stress.h"
#include "base/text.h"
#include <fmt/format.h>

namespace signorini::diagnostics {
using petsc::check;

namespace {

/// A mesh resolves a largest stress that is less than so many times the recovered one.
constexpr double resolved = 1.3;

} // namespace

LargestStress::LargestStress(const fem::Space& space, std::vector<fem::Part> parts)
    : space_(space), parts_(std::move(parts)), y_(space.vector()), v_(space.vector()) {}

void LargestStress::observe(fem::CellFields& fields, Vec y, Vec v, double t) {
  const double now = fields.largest_von_mises().value;
  if (!(now > largest_))
    return;
  largest_ = now;
  time_ = t;
  check(VecCopy(y, y_));
  check(VecCopy(v, v_));
  peak_.reset();
}

std::optional<LargestStress::Peak> LargestStress::peak() {
  if (!peak_ && largest_ >= 0) {
    fem::CellFields fields(space_, parts_);
    fields.set(y_, v_);
    peak_ = {fem::stress_peak(space_, parts_, fields), time_};
  }
  return peak_;
}

std::vector<Warning> LargestStress::warnings() {
  const std::optional<Peak> found = peak();
  if (!found || !(found->stress.largest.value > resolved * found->stress.recovered))
    return {};
  const fem::StressPeak& stress = found->stress;
  const auto place = [&](const std::array<double, 3>& x) {
    return point_text(x.data(), space_.dim()) + " m";
  };
  const double factor = stress.largest.value / stress.recovered;
  std::string text = fmt::format(
      "the largest von Mises stress, {:.4g} Pa in the cell at {}, is {:.3g} times what the cells around it "
      "make of it, where a resolved one is less than {}: it is of the mesh",
      stress.largest.value, place(stress.largest.at), factor, resolved);
  if (stress.corner && stress.angle > fem::reentrant)
    text += fmt::format(", and as elements become smaller it grows without bound at the corner {}, around "
                        "which {:.2g} of the full angle is body: round the corner, or look elsewhere",
                        place(*stress.corner), stress.angle);
  else if (stress.corner)
    text +=
        fmt::format("; smaller elements at {} show whether it converges, which it does not where a clamp, "
                    "a load or contact ends there",
                    place(*stress.corner));
  else
    text += "; smaller elements there show whether it converges";
  return {{stress_of_the_mesh, text, factor, resolved}};
}

} // namespace signorini::diagnostics
