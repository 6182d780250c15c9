// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace signorini {

/// Array whose copies share their values until one copy is written (copy on write), so that copying is cheap.
/// The span that write() returns is valid until the array is next copied. Several threads must not write at
/// once.
template <class T>
class SharedArray {
public:
  /// Creates an empty array.
  SharedArray() : SharedArray(std::vector<T>()) {}
  explicit SharedArray(std::vector<T> values)
      : values_(std::make_shared<std::vector<T>>(std::move(values))) {}

  [[nodiscard]] std::span<const T> read() const { return *values_; }
  [[nodiscard]] std::span<T> write() {
    if (values_.use_count() > 1)
      values_ = std::make_shared<std::vector<T>>(*values_);
    return *values_;
  }

private:
  std::shared_ptr<std::vector<T>> values_;
};

} // namespace signorini
