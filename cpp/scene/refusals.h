// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini::scene {

/// The message on an unknown key, or an unknown name as its value, that asks for an effect which the model
/// lacks; empty for others. `key`: without the numbers of tables, such as contact.friction.
std::string refusal(std::string_view key, std::string_view value = {});

/// Names of all effects that refusal() knows, as docs/modelling.md lists them.
std::vector<std::string> refused_effects();

} // namespace signorini::scene
