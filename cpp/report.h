#pragma once
#include "io/manifest.h"
#include "io/output_folder.h"
#include "record.h"

/// What the verbs that leave results say and write alike.
namespace signorini {

/// Of the program.
namespace exit_status {
constexpr int done = 0, check_failed = 1, wrong_input = 2, solver_failed = 3, interrupted = 130;
}

/// What is about to be computed. Collective.
std::string headline(const Problem& problem);

/// What run.json tells of any run. Collective.
io::Manifest manifest(const Problem& problem, const std::string& verb, const std::string& stop_reason, int steps_done);

/// Puts what the recorder watched into run.json's account and says what is off. Collective.
void add_watched(io::Manifest& manifest, Recorder& recorder, const scene::Run& run, const Console& console);

/// Puts the files in place. Collective. Throws UserError.
void finish(io::OutputFolder& folder, const Console& console);

} // namespace signorini
