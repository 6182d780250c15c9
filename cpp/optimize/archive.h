// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <vector>

namespace signorini::optimize {

/// Serialises a list element by element. One serialize(archive) both writes and reads what a method
/// remembers; an archive takes numbers, lists of numbers and shared vectors by name.
template <class Archive, class T, class Each>
void serialize_list(Archive& archive, const std::string& name, std::vector<T>& list, Each&& each) {
  auto count = static_cast<int>(list.size());
  archive(name + "/count", count);
  list.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < list.size(); ++i)
    each(list[i], name + "/" + std::to_string(i));
}

} // namespace signorini::optimize
