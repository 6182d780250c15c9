// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/expression.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <muParser.h>
#include <numbers>

namespace signorini::scene {
namespace {

/// Whether an expression has an = outside of a comparison, which muParser would take as an assignment.
bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '=') {
      if (i + 1 < text.size() && text[i + 1] == '=')
        ++i;
      else if (i == 0 || std::string("<>!").find(text[i - 1]) == std::string::npos)
        return true;
    }
  return false;
}

} // namespace

std::string Expression::written(double value) { return fmt::format("{}", value); }

const std::string& expression_parts() {
  static const std::string text = [] {
    const mu::Parser parser;
    std::vector<std::string> functions;
    for (const auto& [name, definition] : parser.GetFunDef())
      functions.push_back(name);
    return fmt::format("numbers, + - * / ^, < <= > >= == != && ||, a ? b : c, the functions {}, the "
                       "constants pi and e",
                       fmt::join(functions, " "));
  }();
  return text;
}

struct Field::Impl {
  Components text;
  std::string key;
  std::array<double, 4> variables{};
  /// One component, parsed.
  struct Component {
    mu::Parser parser; ///< without an expression if the component is a time series
    Enclosure enclosure;
    bool depends_on_time = false, depends_on_place = false;
  };
  std::vector<Component> of;
};

Field::Field(Components components, const std::string& key, bool time) : impl_(std::make_unique<Impl>()) {
  impl_->text = std::move(components);
  impl_->key = key;
  impl_->of.reserve(impl_->text.size());
  for (const auto& [text, series, factor, shift] : impl_->text) {
    Impl::Component& component = impl_->of.emplace_back();
    mu::Parser& parser = component.parser;
    if (series) {
      component.depends_on_time = true;
      continue;
    }
    parser.ClearConst();
    parser.DefineConst("pi", std::numbers::pi);
    parser.DefineConst("e", std::numbers::e);
    parser.DefineVar("x", &impl_->variables[0]);
    parser.DefineVar("y", &impl_->variables[1]);
    parser.DefineVar("z", &impl_->variables[2]);
    if (time)
      parser.DefineVar("t", &impl_->variables[3]);
    try {
      if (assigns(text))
        throw mu::ParserError("an assignment");
      parser.SetExpr(text);
      int values = 0;
      parser.Eval(values);
      if (values != 1)
        throw mu::ParserError("a comma separates two expressions; write decimal numbers with a point");
      for (const auto& [name, value] : parser.GetUsedVar())
        (name == "t" ? component.depends_on_time : component.depends_on_place) = true;
      if (component.depends_on_time)
        component.enclosure = Enclosure(text);
    } catch (const mu::ParserError& error) {
      const int position = std::min(error.GetPos(), static_cast<int>(text.size()));
      throw UserError(
          fmt::format("{}: the expression \"{}\" is wrong{}: {}; expressions have {}, and the variables {}",
                      key, text, position >= 0 ? fmt::format(" at position {}", position) : "",
                      error.GetMsg(), expression_parts(), time ? "x, y, z, t" : "x, y, z"));
    }
  }
}

Field::~Field() = default;
Field::Field(Field&&) noexcept = default;
Field& Field::operator=(Field&&) noexcept = default;

std::size_t Field::size() const { return impl_->text.size(); }
bool Field::depends_on_time() const {
  return std::ranges::any_of(impl_->of, &Impl::Component::depends_on_time);
}
bool Field::depends_on_time(std::size_t component) const { return impl_->of[component].depends_on_time; }
bool Field::depends_on_place() const {
  return std::ranges::any_of(impl_->of, &Impl::Component::depends_on_place);
}
bool Field::depends_on_place(std::size_t component) const { return impl_->of[component].depends_on_place; }
const std::string& Field::key() const { return impl_->key; }

double Field::value(std::size_t component, const double* x, double t) const {
  impl_->variables = {x[0], x[1], x[2], t};
  const Expression& expression = impl_->text[component];
  const double value =
      expression.shift +
      expression.factor * (expression.series ? (*expression.series)(t) : impl_->of[component].parser.Eval());
  if (!std::isfinite(value))
    throw UserError(fmt::format("{}: the expression \"{}\" is {} at x = {}, y = {}, z = {}, t = {}; it must "
                                "be finite everywhere at all times",
                                impl_->key, expression, value, x[0], x[1], x[2], t));
  return value;
}

void Field::evaluate(const double* x, double t, double* values) const {
  for (std::size_t i = 0; i < size(); ++i)
    values[i] = value(i, x, t);
}

const TimeSeries* Field::series(std::size_t component) const { return impl_->text[component].series.get(); }

Interval Field::enclose(std::size_t component, const Box& box) const {
  const Expression& expression = impl_->text[component];
  return expression.shift + expression.factor * impl_->of[component].enclosure(box);
}

std::vector<double> Field::knots() const {
  std::vector<double> all;
  for (const Impl::Component& component : impl_->of)
    all.insert(all.end(), component.enclosure.knots().begin(), component.enclosure.knots().end());
  return all;
}

std::optional<double> Field::slope(std::size_t component, double t, bool after) const {
  const Expression& expression = impl_->text[component];
  return expression.series ? std::optional(expression.factor * expression.series->slope(t, after))
                           : std::nullopt;
}

} // namespace signorini::scene
