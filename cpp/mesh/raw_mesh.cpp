// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/raw_mesh.h"
#include <cstring>
#include <stdexcept>
#include <utility>

namespace signorini::mesh {
namespace {

class Packer {
public:
  template <class T>
  void add(const std::vector<T>& values) {
    add_number(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void add(const std::string& text) { add(std::vector<char>(text.begin(), text.end())); }
  void add(const std::vector<std::string>& texts) {
    add_number(texts.size());
    for (const std::string& text : texts)
      add(text);
  }
  void add(int value) { add_number(static_cast<std::uint64_t>(value)); }
  template <class Key, class T>
  void add(const std::map<Key, T>& values) {
    add_number(values.size());
    for (const auto& [key, value] : values) {
      add(key);
      add(value);
    }
  }
  std::string take() { return std::move(bytes_); }

private:
  void add_number(std::uint64_t n) { bytes_.append(reinterpret_cast<const char*>(&n), sizeof n); }
  std::string bytes_;
};

class Unpacker {
public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void get(std::vector<T>& values) {
    values.resize(number());
    read(values.data(), values.size() * sizeof(T));
  }
  void get(std::string& text) {
    text.resize(number());
    read(text.data(), text.size());
  }
  void get(std::vector<std::string>& texts) {
    texts.resize(number());
    for (std::string& text : texts)
      get(text);
  }
  void get(int& value) { value = static_cast<int>(number()); }
  template <class Key, class T>
  void get(std::map<Key, T>& values) {
    for (std::uint64_t left = number(); left > 0; --left) {
      Key key{};
      get(key);
      get(values[key]);
    }
  }

private:
  std::uint64_t number() {
    std::uint64_t n = 0;
    read(reinterpret_cast<char*>(&n), sizeof n);
    return n;
  }
  void read(void* to, std::size_t count) {
    if (count > bytes_.size())
      throw std::logic_error("the packed mesh is truncated");
    std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }
  std::string_view bytes_;
};

template <class Packing, class Mesh>
void each_part(Packing&& packing, Mesh& mesh) {
  packing(mesh.dim);
  packing(mesh.points);
  packing(mesh.cells);
  packing(mesh.facets);
  packing(mesh.parts);
  packing(mesh.other_groups);
  packing(mesh.unusable);
  packing(mesh.notes);
}

} // namespace

std::string packed(const RawMesh& mesh) {
  Packer packer;
  each_part([&](const auto& part) { packer.add(part); }, mesh);
  return packer.take();
}

RawMesh unpacked(std::string_view bytes) {
  Unpacker unpacker(bytes);
  RawMesh mesh;
  each_part([&](auto& part) { unpacker.get(part); }, mesh);
  return mesh;
}

} // namespace signorini::mesh
