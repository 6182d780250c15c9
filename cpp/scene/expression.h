#pragma once
#include "scene/scene.h"
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace signorini::scene {

/// A vector field given by one expression per component in x, y, z (m) and t (s); constants pi and e.
class Field {
public:
  /// Throws UserError, naming `key`, if an expression does not parse or uses an unknown variable.
  /// `time` says whether the expressions may depend on t.
  Field(Components components, const std::string& key, bool time);
  ~Field();
  Field(Field&&) noexcept;
  Field& operator=(Field&&) noexcept;

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] bool depends_on_time() const;
  /// Whether an expression uses x, y or z.
  [[nodiscard]] bool depends_on_place() const;

  /// Evaluates at point `x` (3 coordinates) and time `t` into `values` (size() entries).
  /// Throws UserError, naming key, point and time, if a value is not finite.
  void evaluate(const double* x, double t, double* values) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace signorini::scene
