// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/shared_array.h"
#include "linalg/dense.h"
#include <span>
#include <utility>
#include <vector>

namespace signorini::control {

class CompactControl;

/// A control u, constant on intervals of time: the values of this rank in one array, interval by interval
/// (count × values). Copies share the values until one is changed, since a search, its problem and their
/// callers store the same controls.
class Control {
public:
  /// Converts a rounded control to double precision.
  explicit Control(const CompactControl& u);

  /// Creates a zero control. `size`: number of values of an interval on this rank.
  Control(std::size_t size, int count)
      : values_(std::vector<double>(size * static_cast<std::size_t>(count))), size_(size), count_(count) {}

  /// Creates a control from its values, interval by interval.
  Control(std::vector<double> values, int count)
      : values_(std::move(values)), size_(values_.read().size() / static_cast<std::size_t>(count)),
        count_(count) {}

  /// The values of an interval, j = 1 … count.
  [[nodiscard]] std::span<const double> at(int j) const { return values().subspan(begin(j), size_); }
  [[nodiscard]] std::span<double> at(int j) { return values().subspan(begin(j), size_); }
  /// The values of all intervals (count × values).
  [[nodiscard]] std::span<const double> values() const { return values_.read(); }
  [[nodiscard]] std::span<double> values() { return values_.write(); }
  /// Number of intervals.
  [[nodiscard]] int count() const { return count_; }

  /// this += a x.
  void add(double a, const Control& x) { axpy(a, x.values(), values()); }
  /// this += Σ_i a_i x_i, in one pass over this.
  void add(std::span<const double> a, std::span<const CompactControl> x);
  void scale(double a) { signorini::scale(a, values()); }

private:
  [[nodiscard]] std::size_t begin(int j) const { return size_ * (static_cast<std::size_t>(j) - 1); }

  SharedArray<double> values_;
  std::size_t size_;
  int count_;
};

/// A control rounded to single precision, in half of its memory: a search stores many, and combines them in
/// double precision. The control is values() times scale(), a power of two, so that controls in any units
/// fit. Copies share the values too.
class CompactControl {
public:
  /// Creates a control without values.
  CompactControl() = default;
  explicit CompactControl(const Control& u);

  /// Sets x_j = Σ_i factors_ji x_i (j < factors.size() <= x.size()) in place and removes the others. Makes
  /// one pass over all of them and rounds the results once.
  static void combine(std::vector<CompactControl>& x, const std::vector<std::vector<double>>& factors);

  /// The control's values over scale() (count × values), none larger than one in modulus.
  [[nodiscard]] std::span<const float> values() const { return values_.read(); }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] int count() const { return count_; }

private:
  SharedArray<float> values_;
  double scale_ = 1;
  int count_ = 1;
};

/// Products u_i·w_j of the values on this rank (u × w), in one pass over the w_j.
std::vector<double> dots(std::span<const Control> u, std::span<const CompactControl> w);

struct CompactVariables;

/// The variables of a search: a control, the parameters of a scene on their scales, or both. Parameters are
/// the same on every rank.
struct Variables {
  Control u;
  std::vector<double> x;

  /// Creates variables from a control, with or without parameters.
  Variables(Control control, std::vector<double> parameters = {})
      : u(std::move(control)), x(std::move(parameters)) {}
  /// Creates variables from parameters, without a control.
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

/// Variables of a search, with the control in single precision.
struct CompactVariables {
  CompactControl u{};
  std::vector<double> x{};

  CompactVariables() = default;
  explicit CompactVariables(const Variables& v) : u(v.u), x(v.x) {}

  /// Combines variables in place, as CompactControl::combine() does controls.
  static void combine(std::vector<CompactVariables>& v, const std::vector<std::vector<double>>& factors);
};

/// Controls of a list of variables, with which they share their values.
[[nodiscard]] std::vector<CompactControl> controls_of(std::span<const CompactVariables> v);

/// Archive adapter that stores and restores variables in an archive of controls and numbers, and passes on
/// anything else. Without `parameters` the entries are those of the control.
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
