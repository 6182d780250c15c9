#pragma once
#include "fem/deformation.h"
#include "forward/balance.h"
#include <string>
#include <vector>

namespace signorini::forward {

/// Something that makes results mean less than they seem to.
struct Warning {
  std::string name;    ///< of its kind
  std::string message; ///< with figure and place
  double value, limit; ///< the figure, and from where on it is told
};

/// Whether a motion is one of those that the model is for: small strain, obstacles linearised about the undeformed body, one
/// body. The model gives an answer for any other too, and no solver notices. It looks at a few frames as they go by, outside
/// of the steps: at `looks` evenly spaced ones, the last, and that of the largest elastic energy, if that is told.
class Plausibility {
public:
  /// Frames that are looked at on the way. Each look costs about as much as a product with a matrix.
  static constexpr int looks = 16;

  /// Of `steps` steps of a scene. Collective. The references must outlive this object.
  Plausibility(const Stepper& stepper, const scene::Scene& scene, int steps);

  /// Takes the frame after the last one, from frame 0 on, and its elastic energy if it is known. Collective.
  void observe(const Frame& frame, const StepBalance* balance);

  /// What is to be told at the end, once of each kind. Collective.
  [[nodiscard]] std::vector<Warning> warnings();

private:
  /// The largest of a kind so far, its limit not counted in.
  struct Worst {
    double value = 0, time = 0;
    std::array<double, 3> at{};
  };

  void look(Vec y, int k);
  void look_at_contact(Vec y, int k);
  void add_of_mesh(std::vector<Warning>& warnings) const;
  [[nodiscard]] std::string where(const Worst& worst) const;

  const Stepper& stepper_;
  const scene::Scene& scene_;
  int stride_;
  petsc::Vector strained_; ///< y where elastic energy was largest
  double energy_ = 0;
  int strained_at_ = -1;
  Worst strain_, rotation_, inverted_, slip_, gap_;
  std::vector<double> gaps_;
};

} // namespace signorini::forward
