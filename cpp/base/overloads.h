// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini {

/// A function of each type of a variant, for std::visit: a type without one does not compile.
template <class... F>
struct Overloads : F... {
  using F::operator()...;
};

} // namespace signorini
