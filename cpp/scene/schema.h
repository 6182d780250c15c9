// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/key_reference.h"
#include "scene/kinds.h"
#include "scene/rules.h"
#include <functional>
#include <type_traits>

/// Table of all keys of scenes (schema.cpp), from which scenes are read and written and the reference is
/// made.
namespace signorini::scene::schema {

using kind::Json;

/// Properties of a key besides its name, its table and the kind of its value.
struct KeyInfo {
  bool required = false;
  std::string unit{};        ///< unit, written after the value in scene.toml
  std::string meaning{};     ///< explanation, in Markdown
  std::string otherwise{};   ///< default in words, if the default is not a value of the key
  const char* effect = "";   ///< effect of the key; empty: the effect of the key's table
  Part part = Part::problem; ///< part that the key affects; problem: the same part as its table
};

/// A key of any table, without the functions that depend on the table's type.
struct Entry {
  std::string name;
  KeyInfo info;                ///< properties of the key
  std::string words, fallback; ///< description of the admissible values; default
  Json json;                   ///< JSON schema of the value
  std::vector<Entry> children; ///< keys of the table, if the value is a table
};

/// A value as TOML, and its unit; a value with an empty text is not written.
struct Written {
  std::string text{}, unit{};
};

/// A key of the table type T. Either `line` or `section` is set.
template <class T>
struct Key : Entry {
  std::function<void(Reader&, T&, const Scene&)> read{}; ///< reads the value into a T
  std::function<Written(const T&)> line{};               ///< writes the value for one line
  /// Appends the value to a text, as a table under a heading with the given path.
  std::function<void(std::string&, const std::string&, const T&)> section{};
};
template <class T>
using Keys = std::vector<Key<T>>;
template <class T>
using Predicate = std::type_identity_t<bool (*)(const T&)>;

/// Tag of the table type T. An overload of keys_of() for each tag returns the keys of the table.
template <class T>
struct Of {};
template <class T>
const Keys<T>& table() {
  static const Keys<T> keys = keys_of(Of<T>{});
  return keys;
}

/// Concatenates the keys of the table types T.
template <class... T>
std::vector<Entry> entries() {
  std::vector<Entry> all;
  (all.insert(all.end(), table<T>().begin(), table<T>().end()), ...);
  return all;
}

/// JSON schema of a table with these keys.
Json object(const std::vector<Entry>& keys);

template <class T>
void read_keys(Reader& in, T& to, const Scene& scene) {
  for (const Key<T>& key : table<T>())
    (void)in.has(key.name); // none of them is a misspelling of another
  in.refuse();              // first, since a refused key may explain a missing one
  for (const Key<T>& key : table<T>())
    key.read(in, to, scene);
  require_rules(in, to, scene);
  in.finish();
}

/// Writes the keys of a table, and the tables inside it, as lines of TOML. `path`: name of the table.
template <class T>
std::string lines(const std::string& path, const T& from) {
  std::string text;
  for (const Key<T>& key : table<T>())
    if (key.section)
      key.section(text, path.empty() ? key.name : path + "." + key.name, from);
    else if (const auto [value, unit] = key.line(from); !value.empty())
      text += fmt::format("{} = {}{}\n", key.name, value, unit.empty() ? "" : "  # " + unit);
  return text;
}

/// Writes the keys of a table on one line; `text`: entries to precede them.
template <class T>
std::string listed(const T& from, std::string text = {}) {
  for (const Key<T>& key : table<T>())
    if (const Written value = key.line(from); !value.text.empty())
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key.name, value.text);
  return text;
}

/// Writes a table on one line, with the unit of its first key; `text`: entries to precede the keys.
template <class T>
Written on_one_line(const T& from, std::string text = {}) {
  return {"{ " + listed(from, std::move(text)) + " }", table<T>().front().info.unit};
}

template <class M>
struct Content {
  using Type = M;
  static M& make(M& member) { return member; }
  static const M* in(const M& member) { return &member; }
};
template <class U>
struct Content<std::optional<U>> {
  using Type = U;
  static U& make(std::optional<U>& member) { return member.emplace(); }
  static const U* in(const std::optional<U>& member) { return member ? &*member : nullptr; }
};

/// Makes a key with a value. `written`: predicate whether to write the key; null: always.
template <class T, class M, class K>
Key<T> value(const char* name, M T::* member, K kind, const char* unit = "", const char* meaning = "",
             KeyInfo info = {}, Predicate<T> written = nullptr) {
  info.unit = unit;
  info.meaning = meaning;
  if constexpr (requires { kind.limits; })
    if (kind.limits.unit.empty())
      kind.limits.unit = info.unit;
  Key<T> key{{name, info, kind.words(), info.otherwise, kind.schema(), {}}};
  if constexpr (std::is_same_v<M, typename Content<M>::Type>)
    if (!info.required && info.otherwise.empty()) {
      const std::string text = kind.write(T{}.*member);
      key.fallback = "`" + text + "`";
      key.json["default"] = Json::parse(text); // as TOML has it
    }
  key.read = [=, needed = info.required](Reader& in, T& to, const Scene& scene) {
    if (needed || in.has(name))
      to.*member = kind.read(in, name, scene);
  };
  key.line = [=](const T& from) {
    const auto* content = Content<M>::in(from.*member);
    return content && (!written || written(from)) ? Written{kind.write(*content), unit} : Written{};
  };
  return key;
}

/// Makes a required key with a value.
template <class T, class M, class K>
Key<T> required(const char* name, M T::* member, K kind, const char* unit = "", const char* meaning = "",
                KeyInfo info = {}) {
  info.required = true;
  return value(name, member, kind, unit, meaning, std::move(info));
}

/// Makes a key with a table that can be read; the caller adds how to write the key.
template <class T, class M>
Key<T> table_in(const char* name, M T::* member, const KeyInfo& info) {
  using U = typename Content<M>::Type;
  Key<T> key{{name, info, {}, {}, object(entries<U>()), entries<U>()}};
  key.read = [=, needed = info.required](Reader& in, T& to, const Scene& scene) {
    if (!needed && !in.has(name))
      return;
    Reader table = in.table(name);
    read_keys(table, Content<M>::make(to.*member), scene);
  };
  return key;
}

/// Makes a key with a table that is written on one line.
template <class T, class M>
Key<T> inline_table(const char* name, M T::* member, const KeyInfo& info) {
  Key<T> key = table_in(name, member, info);
  key.line = [=](const T& from) {
    const auto* content = Content<M>::in(from.*member);
    return content ? on_one_line(*content) : Written{};
  };
  return key;
}

/// Joins two keys of one name, of which the second has a table: each reads only its own kind of value.
template <class T>
std::array<Key<T>, 2> value_or_table(Key<T> value, Key<T> table) {
  const std::string name = value.name;
  value.read = [=, read = value.read](Reader& in, T& to, const Scene& scene) {
    if (!in.is_table(name))
      read(in, to, scene);
  };
  table.read = [=, read = table.read](Reader& in, T& to, const Scene& scene) {
    if (in.is_table(name))
      read(in, to, scene);
  };
  table.json = {{"anyOf", {value.json, table.json}}};
  return {std::move(value), std::move(table)};
}

/// Makes a key with a table that is written under a heading. `written`: predicate whether to write the key;
/// null: always.
template <class T, class M>
Key<T> section(const char* name, M T::* member, const KeyInfo& info, Predicate<T> written = nullptr) {
  Key<T> key = table_in(name, member, info);
  key.section = [=](std::string& out, const std::string& path, const T& from) {
    const auto* content = Content<M>::in(from.*member);
    if (content && (!written || written(from)))
      out += fmt::format("\n[{}]\n{}", path, lines(path, *content));
  };
  return key;
}

/// Makes a key with an array of tables under headings `[[name]]`. `alone`: predicate whether the array is
/// written as a single table under `[name]`; if given, a single table can be read too.
template <class T, class U>
Key<T> sections(const char* name, std::vector<U> T::* member, const KeyInfo& info,
                Predicate<std::vector<U>> alone = nullptr) {
  const Json one = object(entries<U>()), several{{"type", "array"}, {"items", one}};
  Key<T> key{{name, info, {}, {}, alone ? Json{{"anyOf", {one, several}}} : several, entries<U>()}};
  key.read = [=, needed = info.required](Reader& in, T& to, const Scene& scene) {
    const auto read = [&](Reader table) { read_keys(table, (to.*member).emplace_back(), scene); };
    if (!alone || in.is_array(name))
      std::ranges::for_each(in.tables(name, needed), read);
    else if (needed || in.has(name))
      read(in.table(name));
  };
  key.section = [=](std::string& out, const std::string& path, const T& from) {
    const bool single = alone && alone(from.*member);
    for (const U& table : from.*member)
      out += fmt::format("\n{}{}{}\n{}", single ? "[" : "[[", path, single ? "]" : "]]", lines(path, table));
  };
  return key;
}

/// Makes a key with an array of tables that is written on one line; an empty array is not written.
template <class T, class U>
Key<T> inline_tables(const char* name, std::vector<U> T::* member, const KeyInfo& info) {
  Key<T> key = sections(name, member, info);
  key.section = nullptr;
  key.line = [=](const T& from) {
    std::vector<std::string> tables;
    for (const U& table : from.*member)
      tables.push_back(on_one_line(table).text);
    return tables.empty() ? Written{} : Written{fmt::format("[{}]", fmt::join(tables, ", "))};
  };
  return key;
}

/// Default-constructs a variant with its i-th alternative.
template <class... A>
std::variant<A...> alternative(std::size_t i, const std::variant<A...>&) {
  return std::array<std::variant<A...>, sizeof...(A)>{A{}...}[i];
}

/// Reads the keys of all tables into `scene`, whose member `file` is set already.
void read(Reader& in, Scene& scene);
std::string write(const Scene& scene);
/// Keys of all tables of a scene.
std::vector<Entry> all();

} // namespace signorini::scene::schema
