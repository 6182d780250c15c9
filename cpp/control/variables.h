// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include <span>
#include <vector>

namespace signorini::control {

struct CompactVariables;

/// What a search varies: a control, the parameters of a scene on their scales, or both. Parameters are the
/// same on every rank.
struct Variables {
  Control u;
  std::vector<double> x;

  /// Also a control alone.
  Variables(Control control, std::vector<double> parameters = {})
      : u(std::move(control)), x(std::move(parameters)) {}
  /// Parameters alone.
  explicit Variables(std::vector<double> parameters) : u(0, 1), x(std::move(parameters)) {}
  explicit Variables(const CompactVariables& compact);

  /// this += a v.
  void add(double a, const Variables& v) {
    u.add(a, v.u);
    axpy(a, v.x, x);
  }
  /// this += Σ a_i v_i.
  void add(std::span<const double> a, std::span<const CompactVariables> v);
  void scale(double a) {
    u.scale(a);
    signorini::scale(a, x);
  }
};

/// Variables whose control is rounded to single precision.
struct CompactVariables {
  CompactControl u{};
  std::vector<double> x{};

  CompactVariables() = default;
  explicit CompactVariables(const Variables& v) : u(v.u), x(v.x) {}

  /// As CompactControl::combine().
  static void combine(std::vector<CompactVariables>& v, const std::vector<std::vector<double>>& factors);
};

/// The controls of a list, which are shared.
[[nodiscard]] std::vector<CompactControl> controls_of(std::span<const CompactVariables> v);

/// Stores and restores variables in an archive of controls and numbers; anything else as the archive does.
/// Where there are no `parameters` the entries are those of the control.
template <class Archive>
class VariablesArchive {
public:
  VariablesArchive(Archive& archive, std::size_t parameters) : archive_(archive), parameters_(parameters) {}

  template <class T>
  void operator()(const std::string& name, T& value) {
    archive_(name, value);
  }
  void operator()(const std::string& name, std::shared_ptr<const Variables>& v) {
    auto u = std::make_shared<const Control>(v ? v->u : Control(0, 1));
    std::vector<double> x = v ? v->x : std::vector<double>();
    archive_(control(name), u);
    numbers(name, x);
    v = std::make_shared<const Variables>(*u, std::move(x));
  }
  void operator()(const std::string& name, CompactVariables& v) {
    archive_(control(name), v.u);
    numbers(name, v.x);
  }

private:
  [[nodiscard]] std::string control(const std::string& name) const {
    return parameters_ > 0 ? name + "/control" : name;
  }
  void numbers(const std::string& name, std::vector<double>& x) {
    if (parameters_ > 0)
      archive_(name + "/unknowns", x);
  }

  Archive& archive_;
  std::size_t parameters_;
};

} // namespace signorini::control
