// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/enclosure.h"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

namespace signorini::scene {
namespace {

using Range = std::function<Interval(const Box&)>;

/// Part of an expression; if the part is linear in time, slope · t + value, also slope and value.
struct SubExpression {
  Range range;
  struct Line {
    double value, slope;
  };
  std::optional<Line> line{};
};

/// Exception for parts of muParser's language that this file does not support.
struct NotEnclosed {};

const Interval all_numbers(-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());

Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.lower(), b.lower()), std::max(a.upper(), b.upper())};
}

Interval truth(bool never, bool always) { return {always ? 1.0 : 0.0, never ? 0.0 : 1.0}; }

bool is_true(const Interval& x) { return x.lower() > 0 || x.upper() < 0; }
bool is_false(const Interval& x) { return x.lower() == 0 && x.upper() == 0; }

/// Range of an increasing function that is defined for arguments of at least `from`.
template <double (*f)(double)>
Interval growing(const Interval& x, double from) {
  if (x.lower() < from)
    return all_numbers;
  return {f(x.lower()), f(x.upper())};
}

Interval power(const Interval& base, const Interval& exponent) {
  const double n = exponent.lower();
  constexpr double most = 1000;
  if (exponent.upper() == n && n == std::rint(n) && std::abs(n) < most)
    return boost::numeric::pow(base, static_cast<int>(n));
  if (base.lower() < 0 || (base.lower() == 0 && n <= 0))
    return all_numbers;
  // Monotone in either argument: the corners bound it.
  Interval range(std::pow(base.lower(), n));
  for (const double b : {base.lower(), base.upper()})
    for (const double e : {exponent.lower(), exponent.upper()})
      range = hull(range, Interval(std::pow(b, e)));
  return range;
}

/// Sign of a number: −1, 0 or 1.
double sign(double x) { return static_cast<double>((x > 0) - (x < 0)); }

using Arguments = std::vector<Interval>;
using Function = Interval (*)(const Arguments&);

template <double (*f)(double)>
Interval monotone(const Arguments& x) {
  return growing<f>(x[0], -std::numeric_limits<double>::infinity());
}
template <double (*f)(double)>
Interval of_positive(const Arguments& x) {
  return growing<f>(x[0], 0);
}
template <Interval (*f)(const Interval&)>
Interval within_one(const Arguments& x) {
  return x[0].lower() < -1 || x[0].upper() > 1 ? all_numbers : f(x[0]);
}
template <class Combine>
Interval folded(const Arguments& x, Combine&& combine) {
  Interval range = x[0];
  for (std::size_t i = 1; i < x.size(); ++i)
    range = combine(range, x[i]);
  return range;
}

const std::map<std::string_view, Function>& functions() {
  static const std::map<std::string_view, Function> all{
      {"sin", [](const Arguments& x) { return boost::numeric::sin(x[0]); }},
      {"cos", [](const Arguments& x) { return boost::numeric::cos(x[0]); }},
      {"tan", [](const Arguments& x) { return boost::numeric::tan(x[0]); }},
      {"asin",
       within_one<[](const Interval& x) { return Interval(std::asin(x.lower()), std::asin(x.upper())); }>},
      {"acos",
       within_one<[](const Interval& x) { return Interval(std::acos(x.upper()), std::acos(x.lower())); }>},
      {"atan", monotone<std::atan>},
      {"sinh", monotone<std::sinh>},
      {"cosh", [](const Arguments& x) { return boost::numeric::cosh(x[0]); }},
      {"tanh", monotone<std::tanh>},
      {"asinh", monotone<std::asinh>},
      {"acosh", [](const Arguments& x) { return growing<std::acosh>(x[0], 1); }},
      {"atanh",
       within_one<[](const Interval& x) { return Interval(std::atanh(x.lower()), std::atanh(x.upper())); }>},
      {"log2", of_positive<std::log2>},
      {"log10", of_positive<std::log10>},
      {"log", of_positive<std::log>},
      {"ln", of_positive<std::log>},
      {"sqrt", of_positive<std::sqrt>},
      {"exp", monotone<std::exp>},
      {"sign", monotone<sign>},
      {"rint", monotone<std::rint>},
      {"abs", [](const Arguments& x) { return boost::numeric::abs(x[0]); }},
      {"atan2", [](const Arguments&) { return Interval(-std::numbers::pi, std::numbers::pi); }},
      {"min",
       [](const Arguments& x) {
         return folded(x, [](const Interval& a, const Interval& b) { return boost::numeric::min(a, b); });
       }},
      {"max",
       [](const Arguments& x) {
         return folded(x, [](const Interval& a, const Interval& b) { return boost::numeric::max(a, b); });
       }},
      {"sum", [](const Arguments& x) { return folded(x, std::plus<Interval>()); }},
      {"avg",
       [](const Arguments& x) { return folded(x, std::plus<Interval>()) / static_cast<double>(x.size()); }}};
  return all;
}

Interval equal(const Interval& a, const Interval& b) {
  return truth(a.upper() < b.lower() || a.lower() > b.upper(),
               a.lower() == b.upper() && a.upper() == b.lower());
}
Interval at_most(const Interval& a, const Interval& b) {
  return truth(a.lower() > b.upper(), a.upper() <= b.lower());
}
Interval below(const Interval& a, const Interval& b) {
  return truth(a.lower() >= b.upper(), a.upper() < b.lower());
}

struct Comparison {
  std::string_view token;
  Interval (*compare)(const Interval& a, const Interval& b);
};
/// Comparison operators, longer ones first, so that "<=" is not read as "<".
constexpr Comparison comparisons[]{
    {"<=", at_most}, {">=", [](const Interval& a, const Interval& b) { return at_most(b, a); }},
    {"==", equal},   {"!=", [](const Interval& a, const Interval& b) { return 1.0 - equal(a, b); }},
    {"<", below},    {">", [](const Interval& a, const Interval& b) { return below(b, a); }}};

/// Recursive-descent parser of muParser's operators, from the lowest precedence to the highest.
class ExpressionReader {
public:
  explicit ExpressionReader(std::string_view text) : left_(text) {}

  SubExpression whole() {
    SubExpression part = conditional();
    if (!left().empty())
      throw NotEnclosed();
    return part;
  }

  std::vector<double> knots;

private:
  using Line = SubExpression::Line;

  std::string_view left() {
    left_.remove_prefix(std::min(left_.find_first_not_of(" \t\r\n"), left_.size()));
    return left_;
  }
  bool take(std::string_view token) {
    if (!left().starts_with(token))
      return false;
    left_.remove_prefix(token.size());
    return true;
  }
  void require(std::string_view token) {
    if (!take(token))
      throw NotEnclosed();
  }

  /// Adds to the knots the time at which two parts are equal, if both are linear in time.
  void meet(const SubExpression& a, const SubExpression& b) {
    if (a.line && b.line && a.line->slope != b.line->slope)
      knots.push_back((b.line->value - a.line->value) / (a.line->slope - b.line->slope));
  }

  SubExpression conditional() {
    SubExpression condition = disjunction();
    if (!take("?"))
      return condition;
    SubExpression yes = conditional();
    require(":");
    SubExpression no = conditional();
    return {[condition = condition.range, yes = yes.range, no = no.range](const Box& box) {
      const Interval holds = condition(box);
      return is_true(holds) ? yes(box) : is_false(holds) ? no(box) : hull(yes(box), no(box));
    }};
  }

  SubExpression disjunction() {
    SubExpression part = conjunction();
    while (take("||"))
      part = {[a = part.range, b = conjunction().range](const Box& box) {
        const Interval x = a(box), y = b(box);
        return truth(is_false(x) && is_false(y), is_true(x) || is_true(y));
      }};
    return part;
  }

  SubExpression conjunction() {
    SubExpression part = comparison();
    while (take("&&"))
      part = {[a = part.range, b = comparison().range](const Box& box) {
        const Interval x = a(box), y = b(box);
        return truth(is_false(x) || is_false(y), is_true(x) && is_true(y));
      }};
    return part;
  }

  SubExpression comparison() {
    SubExpression part = sum();
    for (;;) {
      const Comparison* found = nullptr;
      for (const Comparison& one : comparisons)
        if (!found && take(one.token))
          found = &one;
      if (!found)
        return part;
      const SubExpression other = sum();
      meet(part, other);
      part = {[a = part.range, b = other.range, compare = found->compare](const Box& box) {
        return compare(a(box), b(box));
      }};
    }
  }

  SubExpression sum() {
    SubExpression part = product();
    for (;;) {
      if (take("+"))
        part = combined(part, product(), std::plus<Interval>(),
                        [](Line a, Line b) { return Line{a.value + b.value, a.slope + b.slope}; });
      else if (take("-"))
        part = combined(part, product(), std::minus<Interval>(),
                        [](Line a, Line b) { return Line{a.value - b.value, a.slope - b.slope}; });
      else
        return part;
    }
  }

  SubExpression product() {
    SubExpression part = signed_power();
    for (;;) {
      if (take("*"))
        part = combined(part, signed_power(), std::multiplies<Interval>(), [](Line a, Line b) {
          return a.slope == 0 || b.slope == 0
                     ? std::optional(Line{a.value * b.value, a.slope * b.value + a.value * b.slope})
                     : std::nullopt;
        });
      else if (take("/"))
        part = combined(part, signed_power(), std::divides<Interval>(), [](Line a, Line b) {
          return b.slope == 0 && b.value != 0 ? std::optional(Line{a.value / b.value, a.slope / b.value})
                                              : std::nullopt;
        });
      else
        return part;
    }
  }

  template <class Operation, class OfLines>
  static SubExpression combined(const SubExpression& a, const SubExpression& b, Operation operation,
                                OfLines of_lines) {
    SubExpression part{
        [a = a.range, b = b.range, operation](const Box& box) { return operation(a(box), b(box)); }};
    if (a.line && b.line)
      part.line = of_lines(*a.line, *b.line);
    return part;
  }

  /// Parses a sign and a power. The power has the higher precedence: −2^2 is −4.
  SubExpression signed_power() {
    if (take("+"))
      return signed_power();
    if (!take("-"))
      return raised();
    SubExpression part = signed_power();
    if (part.line)
      part.line = Line{-part.line->value, -part.line->slope};
    part.range = [of = part.range](const Box& box) { return -of(box); };
    return part;
  }

  SubExpression raised() {
    SubExpression base = primary();
    if (!take("^"))
      return base;
    return {[a = base.range, b = signed_power().range](const Box& box) { return power(a(box), b(box)); }};
  }

  SubExpression primary() {
    if (take("(")) {
      SubExpression part = conditional();
      require(")");
      return part;
    }
    const std::string_view text = left();
    if (text.empty())
      throw NotEnclosed();
    if (std::isdigit(static_cast<unsigned char>(text[0])) || text[0] == '.')
      return number();
    return named();
  }

  static SubExpression constant(double value) {
    return {[value](const Box&) { return Interval(value); }, Line{value, 0}};
  }

  SubExpression number() {
    double value = 0;
    const auto [end, error] = std::from_chars(left_.data(), left_.data() + left_.size(), value);
    if (error != std::errc())
      throw NotEnclosed();
    left_.remove_prefix(static_cast<std::size_t>(end - left_.data()));
    return constant(value);
  }

  SubExpression named() {
    std::size_t length = 0;
    while (length < left_.size() &&
           (std::isalnum(static_cast<unsigned char>(left_[length])) || left_[length] == '_'))
      ++length;
    const std::string_view name = left_.substr(0, length);
    left_.remove_prefix(length);
    constexpr std::string_view variables = "xyzt";
    if (const std::size_t i = variables.find(name); length == 1 && i != std::string_view::npos)
      return {[i](const Box& box) { return box[i]; }, name == "t" ? std::optional(Line{0, 1}) : std::nullopt};
    if (name == "pi")
      return constant(std::numbers::pi);
    if (name == "e")
      return constant(std::numbers::e);
    return call(name);
  }

  SubExpression call(std::string_view name) {
    const auto function = functions().find(name);
    if (function == functions().end())
      throw NotEnclosed();
    require("(");
    std::vector<SubExpression> arguments{conditional()};
    while (take(","))
      arguments.push_back(conditional());
    require(")");
    if (name == "abs" || name == "sign") // kinks and jumps
      meet(arguments[0], constant(0));
    for (std::size_t i = 1; i < arguments.size(); ++i)
      meet(arguments[i - 1], arguments[i]);
    std::vector<Range> ranges;
    for (SubExpression& argument : arguments)
      ranges.push_back(std::move(argument.range));
    return {[ranges = std::move(ranges), apply = function->second](const Box& box) {
      Arguments values;
      for (const Range& range : ranges)
        values.push_back(range(box));
      return apply(values);
    }};
  }

  std::string_view left_;
};

} // namespace

Enclosure::Enclosure(const std::string& expression) {
  ExpressionReader reader(expression);
  try {
    range_ = reader.whole().range;
    knots_ = std::move(reader.knots);
    known_ = true;
  } catch (const NotEnclosed&) {
  }
}

Interval Enclosure::operator()(const Box& box) const { return known_ ? range_(box) : all_numbers; }

} // namespace signorini::scene
