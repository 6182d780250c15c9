// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/reader.h"
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

/// Kinds of values of keys. Each kind has four functions. read() reads a value; its last argument is the part
/// of the scene read so far. write() writes a value as TOML. words() describes the admissible values, and
/// schema() is their JSON schema.
namespace signorini::scene::kind {

using Json = nlohmann::ordered_json;
using Name = const std::string&;

std::string written(double value);
std::string written(const std::string& text);
std::string written(const Expression& expression);
/// Writes an expression as TOML: as a number if the expression is one, else as a string or table.
std::string written_as_number(const Expression& expression);
template <class T>
std::string written(const std::vector<T>& values) {
  std::vector<std::string> texts;
  for (const T& value : values)
    texts.push_back(written(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}
/// Joins names, each in quotes, for Markdown: `"a"`, `"b"`.
std::string quoted(const std::vector<std::string>& names);

struct Number {
  Limits limits{};
  double read(Reader& in, Name key, const Scene&) const { return in.number(key, limits); }
  static std::string write(double value) { return written(value); }
  [[nodiscard]] std::string words() const { return "number" + limits.range(); }
  [[nodiscard]] Json schema() const;
};

/// A number or the text "auto".
struct NumberOrAuto : Number {
  double automatic = 0; ///< number that stands for "auto"
  double read(Reader& in, Name key, const Scene& scene) const;
  [[nodiscard]] std::string write(double value) const {
    return value == automatic ? written(std::string("auto")) : written(value);
  }
  [[nodiscard]] std::string words() const { return Number::words() + ", or `\"auto\"`"; }
  [[nodiscard]] Json schema() const { return {{"anyOf", {Number::schema(), {{"const", "auto"}}}}}; }
};

struct Whole {
  int least, greatest;
  int read(Reader& in, Name key, const Scene&) const { return in.integer(key, least, greatest); }
  static std::string write(int value) { return std::to_string(value); }
  [[nodiscard]] std::string words() const {
    return fmt::format("whole number from {} to {}", least, greatest);
  }
  [[nodiscard]] Json schema() const {
    return {{"type", "integer"}, {"minimum", least}, {"maximum", greatest}};
  }
};

struct Flag {
  static bool read(Reader& in, Name key, const Scene&) { return in.flag(key); }
  static std::string write(bool value) { return value ? "true" : "false"; }
  static std::string words() { return "`true` or `false`"; }
  static Json schema() { return {{"type", "boolean"}}; }
};

/// A text on one line, such as a group of the mesh.
struct Text {
  const char* what = "group";
  static std::string read(Reader& in, Name key, const Scene&) { return in.text(key); }
  static std::string write(const std::string& text) { return written(text); }
  [[nodiscard]] std::string words() const { return what; }
  static Json schema() { return {{"type", "string"}, {"minLength", 1}}; }
};

/// Keys of the scene and their values.
struct Changes {
  static std::vector<Change> read(Reader& in, Name key, const Scene&) { return in.changes(key); }
  static std::string write(const std::vector<Change>& changes);
  static std::string words() { return "table of keys and their values"; }
  static Json schema() { return {{"type", "object"}}; }
};

/// A path, stored and written as an absolute path; relative paths are relative to the scene file.
struct Path : Text {
  static std::filesystem::path read(Reader& in, Name key, const Scene&) {
    return in.followed(in.text(key), key);
  }
  static std::string write(const std::filesystem::path& path) { return written(path.string()); }
  static std::string words() { return "path"; }
};

template <class E>
struct Choice {
  static E read(Reader& in, Name key, const Scene&) { return static_cast<E>(in.choice(key, all_names<E>())); }
  static std::string write(E value) { return written(name(value)); }
  static std::string words() { return quoted(all_names<E>()); }
  static Json schema() { return {{"enum", all_names<E>()}}; }
};

/// A list of choices.
template <class E>
struct Set {
  static std::vector<E> read(Reader& in, Name key, const Scene&) {
    std::vector<E> values;
    for (std::size_t i : in.choices(key, all_names<E>()))
      values.push_back(static_cast<E>(i));
    return values;
  }
  static std::string write(const std::vector<E>& values) {
    std::vector<std::string> texts;
    for (E value : values)
      texts.push_back(name(value));
    return written(texts);
  }
  static std::string words() { return "list of " + quoted(all_names<E>()); }
  static Json schema() { return {{"type", "array"}, {"items", Choice<E>::schema()}}; }
};

/// A list of the components in which a clamp or control acts; at least one.
struct Acting : Set<Component> {
  static std::vector<Component> read(Reader& in, Name key, const Scene& scene);
};

/// A list of the formats of stored fields; at least one.
struct Formats : Set<FieldFormat> {
  static std::vector<FieldFormat> read(Reader& in, Name key, const Scene& scene);
};

/// An expression in x, y, z, and in t too if `time` is true.
struct Formula : Text {
  bool time = false;
  std::string read(Reader& in, Name key, const Scene&) const { return in.expression(key, time); }
  [[nodiscard]] std::string words() const {
    return time ? "expression in x, y, z, t" : "expression in x, y, z";
  }
};

/// A vector field: one expression for each component, in x, y, z, and in t too if `time` is true.
struct Expressions {
  bool time = true;
  Components read(Reader& in, Name key, const Scene& scene) const {
    return in.expressions(key, time ? std::optional(scene.time.end) : std::nullopt);
  }
  static std::string write(const Components& components) { return written(components); }
  [[nodiscard]] std::string words() const {
    return time ? "expressions in x, y, z, t" : "expressions in x, y, z";
  }
  [[nodiscard]] Json schema() const;
};

/// The motion of the clamp read last: one expression for each of its clamped components.
struct ClampMotion : Expressions {
  static Components read(Reader& in, Name key, const Scene& scene);
  static Json schema();
};

/// A control: one expression for each component, without t if controls are constant in time, and zero in
/// components that control.components leaves out.
struct ControlField : Expressions {
  static Components read(Reader& in, Name key, const Scene& scene);
};

/// A vector of expressions in t only, such as a moving point; constant components are written as numbers.
struct Point : Expressions {
  static Components read(Reader& in, Name key, const Scene& scene);
  static std::string write(const Components& components);
  static std::string words() { return "numbers or expressions in t"; }
};

/// A number or an expression in t only.
struct Varying {
  Limits limits{}; ///< limits of the number; expressions are not checked
  Expression read(Reader& in, Name key, const Scene& scene) const;
  static std::string write(const Expression& expression) { return written_as_number(expression); }
  [[nodiscard]] std::string words() const { return "number" + limits.range() + ", or expression in t"; }
  [[nodiscard]] Json schema() const;
};

/// A number or an expression in x, y, z and t.
struct Coefficient : Varying {
  Expression read(Reader& in, Name key, const Scene& scene) const;
  [[nodiscard]] std::string words() const {
    return "number" + limits.range() + ", or expression in x, y, z, t";
  }
};

/// A constant vector: one number for each component.
struct Numbers {
  Limits limits{};
  std::vector<double> read(Reader& in, Name key, const Scene&) const { return in.numbers(key, limits); }
  static std::string write(const std::vector<double>& values) { return written(values); }
  static std::string words() { return "numbers"; }
  static Json schema();
};

/// A constant vector whose length is not zero.
struct Direction : Numbers {
  const char* what; ///< end of the message for a zero vector
  std::vector<double> read(Reader& in, Name key, const Scene& scene) const;
};

/// A bound of a control: one number for all components, or one for each.
struct Bound {
  static std::vector<double> read(Reader& in, Name key, const Scene&) {
    return in.number_or_numbers(key, {});
  }
  static std::string write(const std::vector<double>& values) {
    return values.size() == 1 ? written(values.front()) : written(values);
  }
  static std::string words() { return "number, or one for each component"; }
  static Json schema();
};

} // namespace signorini::scene::kind
