// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/completion.h"
#include "app/run.h"
#include "app/scripts.h"
#include "app/verb_options.h"
#include "base/error.h"
#include "base/petsc.h"
#include "base/scratch_file.h"
#include "base/signals.h"
#include "base/text.h"
#include "drivers/run_manifest.h"
#include "io/output_folder.h"
#include "scene/expression.h"
#include "scene/key_reference.h"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <new>
#include <spdlog/spdlog.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace {

using signorini::UserError;
using signorini::app::Request;

using namespace signorini::exit_status;

struct Verb {
  const char *name, *text;
};
constexpr Verb verbs[] = {
    {"simulate", "forward run only"},
    {"optimize", "search for an optimal control, or fit unknown parameters"},
    {"check", "verify derivatives and discrete invariants of a scene"},
    {"batch", "simulate the cases of a table, many on one factorisation, and tabulate their results"},
    {"study", "compare errors and run times over a ladder of sizes, steps, degrees and schemes"},
    {"info",
     "list the model's effects (such as viscosity) with their costs, and the run's size and memory; "
     "--time N estimates its time from N steps. Of a mesh or CAD file: its groups, sizes and quality"},
    {"keys", "list all keys of a scene with values, units, limits, defaults and meanings"},
    {"completion", "print a script for bash that completes verbs, options and keys"}};

void require_verb(int argc, char** argv) {
  std::vector<std::string> names;
  for (const Verb& verb : verbs)
    names.emplace_back(verb.name);
  for (const signorini::app::ScriptVerb& verb : signorini::app::script_verbs())
    names.emplace_back(verb.name);
  const std::string allowed = signorini::list(names);
  if (argc < 2)
    throw UserError(fmt::format("command line: no verb; choose one of {} (see signorini --help)", allowed));
  const std::string found = argv[1];
  if (!found.starts_with("-") && std::ranges::find(names, found) == names.end())
    throw UserError(
        fmt::format("command line: unknown verb \"{}\"{}; choose one of {} (see signorini --help)", found,
                    signorini::suggestion(found, names), allowed));
}

/// Writes the JSON schema of a scene to a file. Returns the text to print: how a scene names the file. Throws
/// UserError.
std::string write_schema(const std::filesystem::path& file) {
  if (const std::error_code failed = signorini::io::try_replace_file(file, signorini::scene::json_schema()))
    throw UserError(
        fmt::format("--schema-file: {}: cannot be written ({})", file.string(), failed.message()));
  return fmt::format("An editor of TOML completes and checks a scene in the folder of {} that begins with "
                     "this line:\n#:schema {}\n",
                     file.string(), file.filename().string());
}

/// Requests of the command line other than runs.
struct Asked {
  bool quiet = false;
  std::string (*keys)() = signorini::scene::reference; ///< function that returns the text of the verb keys
  std::string schema_file{};                           ///< file to which the verb keys writes a schema
};

/// Adds the options of the verb keys, which has no scene.
void add_keys_options(CLI::App& app, Asked& asked) {
  CLI::Option* const json = app.add_flag_callback(
      "--json", [&] { asked.keys = signorini::scene::json_schema; }, "print a JSON schema of a scene");
  CLI::Option* const markdown = app.add_flag_callback(
      "--markdown", [&] { asked.keys = signorini::scene::markdown; },
      "print the table of docs/reference/keys.md");
  app.add_option("--schema-file", asked.schema_file,
                 "write the JSON schema to this file, and print the line that names it in a scene")
      ->excludes(json)
      ->excludes(markdown);
}

void add_verbs(CLI::App& app, Request& request, Asked& asked) {
  for (const Verb& verb : verbs) {
    const std::string_view name = verb.name;
    CLI::App* sub = app.add_subcommand(verb.name, verb.text);
    sub->callback([&request, &verb] { request.verb = verb.name; });
    if (name == "keys")
      add_keys_options(*sub, asked);
    if (name == "keys" || name == "completion")
      continue;
    sub->allow_extras();
    sub->add_option("scene", request.scene, "scene file (TOML)")->required();
    sub->add_option("--out", request.out, "folder for the results (default results/<scene name>)");
    sub->add_option("--set", request.overrides, "key.path=value, overrides the scene; may be repeated")
        ->expected(1)
        ->allow_extra_args(false) // the scene may follow
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->check([](const std::string& text) {
          return text.ends_with('=')
                     ? fmt::format("found no value in \"{}\"; to remove a key use --unset", text)
                     : std::string();
        });
    sub->add_option_function<std::vector<std::string>>(
           "--unset",
           [&request](const std::vector<std::string>& keys) {
             for (const std::string& key : keys) // before --set, whose values are not empty
               request.overrides.insert(request.overrides.begin(), key + "=");
           },
           "key.path, removes a key, a table or one of a list (output.probe.2) before --set; may be repeated")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    sub->add_option("--threads", request.threads,
                    "threads of each rank (default: OMP_NUM_THREADS, else cores divided by ranks)")
        ->check(CLI::Range(1, 1024));
    sub->add_flag("--quiet", asked.quiet, "print errors only");
    if (name == "optimize") {
      CLI::Option* const resume = sub->add_flag(
          "--resume", request.resume, "continue from the checkpoint in the folder, if there is one");
      signorini::app::add_accuracy_options(*sub, request, "J")->excludes(resume);
    }
    if (name == "simulate") {
      CLI::Option* const accuracy = signorini::app::add_accuracy_options(*sub, request, "--quantity");
      CLI::Option* const quantity =
          sub->add_option("--quantity", request.study.quantities,
                          "quantity for --accuracy, such as impulse, contact_time or displacement")
              ->expected(1)
              ->needs(accuracy);
      accuracy->needs(quantity);
      sub->add_flag("--replace", request.replace,
                    "overwrite an optimum in the folder, and data files of --measure");
      CLI::Option* const measure =
          sub->add_flag("--measure", request.measure,
                        "write the files of the scene's measurements: simulated values with noise");
      sub->add_option("--seed", request.seed, "seed of the noise (default 1); 0: no noise")
          ->check(CLI::Range(0, std::numeric_limits<int>::max()))
          ->needs(measure);
    }
    if (name == "info")
      sub->add_option("--time", request.timed_steps,
                      "time this many steps and estimate the time of the whole run")
          ->check(CLI::Range(1, std::numeric_limits<int>::max()));
    if (name == "study")
      signorini::app::add_study_options(*sub, request);
    if (name == "batch")
      signorini::app::add_batch_options(*sub, request);
  }
  // For --help and completion only: their scripts read the command line.
  for (const signorini::app::ScriptVerb& verb : signorini::app::script_verbs()) {
    CLI::App* sub = app.add_subcommand(verb.name, verb.text);
    for (const char* option : verb.options)
      sub->add_option(option);
  }
}

/// All verbs and the names of their options.
std::vector<signorini::app::VerbOptions> options(const CLI::App& app) {
  std::vector<signorini::app::VerbOptions> all;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    all.push_back({sub->get_name(), {}});
    for (const CLI::Option* option : sub->get_options())
      for (const std::string& name : option->get_lnames())
        all.back().options.push_back("--" + name);
  }
  return all;
}

/// Throws UserError if words of the command line are left that belong to no option.
void require_no_more(const CLI::App& app, const std::string& verb) {
  const std::vector<std::string> extra = app.remaining(true);
  if (std::ranges::find(extra, "--resume") != extra.end())
    throw UserError(fmt::format("--resume: {} writes no checkpoints; use it with optimize{}", verb,
                                verb == "study" ? "; a study continues from its folder without it" : ""));
  if (extra.empty())
    return;
  std::vector<std::string> known;
  for (const auto& [name, own] : options(app))
    if (name == verb)
      known = own;
  throw UserError(fmt::format(
      "command line: unexpected \"{}\"{}; give one scene and the options {} (see signorini --help)",
      extra.front(), signorini::suggestion(extra.front(), known), signorini::list(known)));
}

/// Parses the command line. Returns an exit status if nothing is to be run. Throws UserError.
std::optional<int> parse(int argc, char** argv, bool speaks, Request& request, bool& quiet) {
  require_verb(argc, argv);
  CLI::App app("Optimal control of dynamic contact with exact discrete gradients.", "signorini");
  app.require_subcommand(1);
  app.set_version_flag("--version", signorini::io::version_line());
  app.footer(
      fmt::format("Expressions in a scene: {}, and x, y, z (m), t (s).\nOptions after -- go to PETSc. Exit "
                  "status: 0 done; 1 a check failed; 2 the scene, the mesh or an option is\n"
                  "wrong; 3 a solver failed; 130 interrupted.",
                  signorini::scene::expression_parts()));
  Asked asked;
  add_verbs(app, request, asked);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) { // --help, --version
    if (speaks)
      app.exit(success);
    return 0;
  } catch (const CLI::ParseError& error) {
    throw UserError(fmt::format("command line: {}; see signorini --help", error.what()));
  }
  quiet = asked.quiet;
  require_no_more(app, request.verb);
  if (request.verb != "keys" && request.verb != "completion")
    return std::nullopt;
  if (!speaks)
    return 0;
  signorini::print_text(stdout, request.verb == "completion" ? signorini::app::bash_completion(options(app))
                                : asked.schema_file.empty()  ? asked.keys()
                                                             : write_schema(asked.schema_file));
  return 0;
}

/// Prints an error on one line, with control characters in file names replaced.
void report_error(std::string text) {
  std::ranges::replace_if(text, [](unsigned char c) { return std::iscntrl(c); }, ' ');
  signorini::print_text(stderr, fmt::format("signorini: {}\n", text));
}

/// Prints a failure that other ranks may not know of, and ends all ranks.
[[noreturn]] void abort_all(int rank, const std::string& text, int status) {
  // If every rank fails alike, rank 0 prints and ends the others while they sleep.
  if (rank != 0)
    std::this_thread::sleep_for(std::chrono::seconds(2));
  report_error(text);
  MPI_Abort(MPI_COMM_WORLD, status);
  std::abort();
}

/// Warns about PETSc options on the command line that no solver used.
void report_unused(const std::vector<std::string>& given) {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  if (PetscOptionsLeftGet(nullptr, &count, &names, &values) != PETSC_SUCCESS)
    return;
  for (PetscInt i = 0; i < count; ++i)
    if (const std::string name = fmt::format("-{}", names[i]); std::ranges::find(given, name) != given.end())
      signorini::print_text(
          stderr, fmt::format("signorini: the PETSc option {} was not used; prefixes of solver options: "
                              "-step_, -condensed_vi_, -full_vi_\n",
                              name));
  (void)PetscOptionsLeftRestore(nullptr, &count, &names, &values);
}

int guarded(int argc, char** argv, int rank, int ranks) {
  try {
    Request request;
    bool quiet = false;
    if (const auto status = parse(argc, argv, rank == 0, request, quiet))
      return *status;
    const bool speaks = rank == 0 && !quiet;
    return signorini::app::run(request, signorini::Console(speaks, speaks && isatty(STDERR_FILENO)));
  } catch (const UserError& error) { // thrown on every rank alike
    if (rank == 0)
      report_error(error.what());
    return wrong_input;
  } catch (const signorini::Interrupted&) {
    if (rank == 0)
      report_error("interrupted before there was a result to write");
    return interrupted;
  } catch (const signorini::WriteFailure& error) {
    if (ranks > 1)
      abort_all(rank, error.what(), wrong_input);
    report_error(error.what());
    return wrong_input;
  } catch (const std::bad_alloc&) {
    const char* text = "not enough memory for this scene; use fewer time steps, larger elements or another "
                       "trajectory.storage (signorini info lists the memory of each)";
    if (ranks > 1)
      abort_all(rank, text, wrong_input);
    report_error(text);
    return wrong_input;
  } catch (const std::exception& error) {
    if (ranks > 1)
      abort_all(rank, error.what(), solver_failed);
    report_error(error.what());
    return solver_failed;
  }
}

} // namespace

int main(int argc, char** argv) {
  std::string asks_help = "--help";
  if (argc > 1 && std::string_view(argv[1]) == "help") { // "help" is --help, "help VERB" is "VERB --help"
    argv[1] = argc > 2 ? argv[2] : asks_help.data();
    if (argc > 2)
      argv[2] = asks_help.data();
  }
  if (argc > 1 && signorini::app::is_script_verb(argv[1])) {
    try {
      signorini::app::become_script({argv + 1, argv + argc + 1});
    } catch (const std::exception& error) {
      report_error(error.what());
      return wrong_input;
    }
  }
  // Arguments after -- go to PETSc.
  char** const dashes =
      std::find_if(argv, argv + argc, [](const char* a) { return std::string_view(a) == "--"; });
  const int own = static_cast<int>(dashes - argv);
  // A file .petscrc in a folder from elsewhere could load code and overwrite files.
  std::string no_file = "-skip_petscrc";
  std::vector<char*> petsc_arguments{argv[0], no_file.data()};
  if (own < argc)
    petsc_arguments.insert(petsc_arguments.end(), dashes + 1, argv + argc);
  signorini::catch_stop_signals(); // before anything is made and libraries start, so that no signal is missed
  try {
    signorini::require_temporary_folder();
  } catch (const UserError& error) {
    report_error(error.what());
    return wrong_input;
  }
  int petsc_count = static_cast<int>(petsc_arguments.size());
  petsc_arguments.push_back(nullptr);
  char** petsc_values = petsc_arguments.data();
  if (PetscInitialize(&petsc_count, &petsc_values, nullptr, nullptr) != PETSC_SUCCESS)
    return solver_failed;
  spdlog::set_level(spdlog::level::warn); // the libraries log warnings and errors only
  signorini::petsc::keep_error_messages();
  signorini::ignore_broken_pipes();                          // in place of PETSc's handler, which aborts
  (void)PetscOptionsSetValue(nullptr, "-options_left", "0"); // report_unused() covers the user's own
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int status = guarded(own, argv, rank, ranks);
  if (rank == 0)
    report_unused({argv + own, argv + argc});
  return PetscFinalize() == PETSC_SUCCESS ? status : solver_failed;
}
