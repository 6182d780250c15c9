// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/shared_array.h"
#include "linalg/dense.h"
#include <span>
#include <utility>
#include <vector>

namespace signorini::control {

class CompactControl;

/// Control u, constant on each of `count` intervals of time. Stores the values of this rank in one array,
/// interval by interval (intervals × values). Copies share the values until one copy is changed, since a
/// search, its problem and their callers store the same controls.
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

  /// Returns this rank's values in interval j, j = 1 … count.
  [[nodiscard]] std::span<const double> at(int j) const { return values().subspan(begin(j), size_); }
  [[nodiscard]] std::span<double> at(int j) { return values().subspan(begin(j), size_); }
  /// Returns this rank's values in all intervals (intervals × values).
  [[nodiscard]] std::span<const double> values() const { return values_.read(); }
  [[nodiscard]] std::span<double> values() { return values_.write(); }
  /// Number of intervals.
  [[nodiscard]] int count() const { return count_; }

  /// Adds a x to this control.
  void add(double a, const Control& x) { axpy(a, x.values(), values()); }
  /// Adds Σ_i a_i x_i to this control, in one pass over its values.
  void add(std::span<const double> a, std::span<const CompactControl> x);
  /// Multiplies all values by a.
  void scale(double a) { signorini::scale(a, values()); }

private:
  [[nodiscard]] std::size_t begin(int j) const { return size_ * (static_cast<std::size_t>(j) - 1); }

  SharedArray<double> values_;
  std::size_t size_;
  int count_;
};

/// A control rounded to single precision, which takes half the memory. A search stores many of these and
/// combines them in double precision. The control is values() times scale(), a power of two, so that controls
/// in any unit fit. Copies share the values.
class CompactControl {
public:
  /// Creates a control without values.
  CompactControl() = default;
  /// Rounds a control to single precision.
  explicit CompactControl(const Control& u);

  /// Replaces the list by its combinations: sets x_j = Σ_i factors_ji x_i for j < factors.size() and removes
  /// the other entries; factors.size() <= x.size(). Makes one pass over all of them and rounds the results
  /// once.
  static void combine(std::vector<CompactControl>& x, const std::vector<std::vector<double>>& factors);

  /// Returns the control's values divided by scale() (intervals × values); none exceeds 1 in modulus.
  [[nodiscard]] std::span<const float> values() const { return values_.read(); }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] int count() const { return count_; }

private:
  SharedArray<float> values_;
  double scale_ = 1;
  int count_ = 1;
};

/// Returns the Euclidean products u_i·w_j of this rank's values, row by row (number of u × number of w), in
/// one pass over the w_j.
std::vector<double> dots(std::span<const Control> u, std::span<const CompactControl> w);

struct CompactVariables;

/// Variables of a search: a control u, the parameters x of a scene (as they are or as logarithms), or both.
/// Parameters are the same on every rank.
struct Variables {
  Control u;
  std::vector<double> x;

  /// Creates variables from a control and, if given, parameters.
  Variables(Control control, std::vector<double> parameters = {})
      : u(std::move(control)), x(std::move(parameters)) {}
  /// Creates variables from parameters, without a control.
  explicit Variables(std::vector<double> parameters) : u(0, 1), x(std::move(parameters)) {}
  /// Converts rounded variables to double precision.
  explicit Variables(const CompactVariables& compact);

  /// Adds a v to these variables.
  void add(double a, const Variables& v) {
    u.add(a, v.u);
    axpy(a, v.x, x);
  }
  /// Adds Σ_i a_i v_i to these variables.
  void add(std::span<const double> a, std::span<const CompactVariables> v);
  void scale(double a) {
    u.scale(a);
    signorini::scale(a, x);
  }
};

/// Variables of a search with the control rounded to single precision.
struct CompactVariables {
  CompactControl u{};
  std::vector<double> x{};

  CompactVariables() = default;
  explicit CompactVariables(const Variables& v) : u(v.u), x(v.x) {}

  /// Replaces the list by its combinations Σ_i factors_ji v_i, as CompactControl::combine() does for
  /// controls.
  static void combine(std::vector<CompactVariables>& v, const std::vector<std::vector<double>>& factors);
};

/// Returns the controls of a list of variables, which share their values with the list.
[[nodiscard]] std::vector<CompactControl> controls_of(std::span<const CompactVariables> v);

/// Adapter that stores and restores variables in an archive of controls and numbers, and passes all other
/// types to that archive. `parameters`: number of parameters in the variables; if 0, only the control is
/// stored, under the name of the variables.
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
