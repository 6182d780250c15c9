// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini {

/// Visitor for std::visit that combines one function per type of a variant; a type without a function is a
/// compile error.
template <class... F>
struct Overloads : F... {
  using F::operator()...;
};

} // namespace signorini
