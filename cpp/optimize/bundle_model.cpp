#include "optimize/bundle_model.h"
#include "base/error.h"
#include <ranges>

namespace signorini::optimize {

Direction BundleModel::minimise(std::size_t n) {
  for (;; curvature_.forget_oldest()) {
    auto B = curvature_.matrix(n);
    if (auto direction = B ? model_minimiser(cuts_, std::move(*B), n) : std::nullopt) {
      if (direction->subgradient.length != 0)
        last_minimiser_ = direction->d;
      return std::move(*direction);
    }
    if (curvature_.empty())
      throw SolverFailure("the model of J at a kink has no minimiser");
  }
}

bool BundleModel::learn(Direction& direction, Coordinates Hd) {
  const double most = highest(cuts_, direction.d), modelled = -2 * (direction.predicted + most);
  const double curvature = dot(direction.d, Hd);
  if (curvature > 0)
    curvature_.learn(direction.d, Hd);
  direction.Hd = std::move(Hd);
  direction.predicted = -most - curvature / 2;
  return std::abs(curvature - modelled) <= std::abs(direction.predicted);
}

double BundleModel::null_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs,
                              double decrease) {
  const double below = decrease + dot(g, s) - dot(s, Hs) / 2;
  Coordinates here = g;
  add(here, -1, Hs);
  make_room();
  cuts_.push_back({g, std::move(here), s, std::abs(below)});
  return -below;
}

void BundleModel::serious_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs,
                               double decrease) {
  for (Cut& cut : cuts_) {
    cut.linearisation_error =
        std::max(0.0, cut.linearisation_error - decrease - dot(cut.here, s) - dot(s, Hs) / 2);
    add(cut.here, 1, Hs);
    add(cut.offset, -1, s);
  }
  add(last_minimiser_, -1, s);
  make_room();
  cuts_.insert(cuts_.begin(), {g, g, {}, 0});
}

std::vector<Coordinates> BundleModel::drop_distant(const std::vector<double>& weights, double distance) {
  std::vector<std::size_t> carrying;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > options_.carrying)
      carrying.push_back(i);
  std::vector<Coordinates> offsets;
  for (std::size_t i : carrying)
    if (norm(cuts_[i].offset) > distance)
      if (auto offset = offset_above(cuts_, i, carrying, distance))
        offsets.push_back(std::move(*offset));
  for (std::size_t i : carrying | std::views::reverse)
    if (norm(cuts_[i].offset) > distance)
      cuts_.erase(cuts_.begin() + static_cast<std::ptrdiff_t>(i));
  return offsets;
}

void BundleModel::make_room() {
  if (cuts_.size() == options_.cuts)
    cuts_.erase(std::ranges::min_element(cuts_.begin() + 1, cuts_.end(), {}, [this](const Cut& cut) {
      return dot(cut.here, last_minimiser_) - cut.linearisation_error;
    }));
}

} // namespace signorini::optimize
