// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstdint>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <vector>

namespace signorini {

/// Computes a 64-bit hash (FNV-1a) of texts and their lengths, to find out whether contents differ. It is not
/// cryptographic: colliding contents can be constructed.
class Digest {
public:
  Digest& add(std::string_view piece) {
    mix(piece);
    const std::uint64_t size = piece.size(); // so that "ab", "c" and "a", "bc" differ
    mix({reinterpret_cast<const char*>(&size), sizeof size});
    return *this;
  }
  Digest& add(const std::vector<double>& values) {
    return add({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)});
  }

  /// The hash as 16 hexadecimal digits.
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", state_); }

private:
  void mix(std::string_view bytes) {
    constexpr std::uint64_t prime = 0x100000001b3;
    for (const char byte : bytes)
      state_ = (state_ ^ static_cast<unsigned char>(byte)) * prime;
  }

  std::uint64_t state_ = 0xcbf29ce484222325; // FNV's offset basis
};

} // namespace signorini
