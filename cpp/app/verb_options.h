// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/run.h"
#include <string>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace signorini::app {

/// Adds the options of the verb study.
void add_study_options(CLI::App& app, Request& request);

/// Adds the options of the verb batch.
void add_batch_options(CLI::App& app, Request& request);

/// Adds the option --accuracy and the options that need it; returns --accuracy. `quantity`: whose error it
/// is, for the help.
CLI::Option* add_accuracy_options(CLI::App& app, Request& request, const std::string& quantity);

} // namespace signorini::app
