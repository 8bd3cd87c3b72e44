// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/command.h"

#include "mistyped.h"
#include "progress_bar.h"
#include "run_files.h"
#include "spheretree/formats/nearest_word.h"

namespace spheretree::tool {
namespace {

/// What the user mistyped, a verb or an option; empty if neither.
std::string mistyped(const CLI::App& cli) {
  const auto chosen = cli.get_subcommands();
  if (!chosen.empty()) {
    const std::string verb = chosen.front()->get_name();
    return unknownOption(*chosen.front(), " of " + verb, kProgram + " " + verb);
  }
  const std::vector<std::string> rest = cli.remaining(true);
  if (rest.empty()) return {};
  if (rest.front().rfind('-', 0) == 0) return "unknown option '" + rest.front() + "'. See spheretree --help.";
  std::vector<std::string> known;
  for (const CLI::App* verb : cli.get_subcommands(nullptr)) known.push_back(verb->get_name());
  return "unknown verb '" + rest.front() + "'; the nearest is '" + std::string(formats::nearestWord(rest.front(), known)) +
         "'. See spheretree --help.";
}

int runVerb(Program& program) {
  ProgressBar progress(program.progress, program.quiet);
  const InterruptGuard guard(progress);
  const RunFiles files(progress);
  return program.run(progress);
}

}  // namespace

CLI::App* addVerb(Program& program, const std::string& verb, const std::string& description, const std::string& example,
                  std::function<int(builder::Progress&)> run) {
  CLI::App* app = program.cli.add_subcommand(verb, description);
  app->footer("Example:\n  " + example);
  app->add_option("--progress", program.progress,
                  "How progress is shown on stderr: auto, bar, plain, json or none; default auto: a bar on a terminal")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "bar", "plain", "json", "none"}))
      ->group("Options of every verb");
  app->add_flag("-q,--quiet", program.quiet, "Say nothing on stderr but errors")->group("Options of every verb");
  app->callback([&program, run = std::move(run)] { program.run = run; });
  return app;
}

int runProgram(Program& program, int argc, char** argv) {
  CLI::App& cli = program.cli;
  cli.name(kProgram);
  cli.set_version_flag("--version", kGenerator);
  cli.require_subcommand(1);
  cli.footer(
      "Exit codes: 0 ok, 1 internal error, 2 usage, 3 file cannot be read or written, 4 input refused,\n"
      "  5 target missed and best result written, 6 batch partly failed, 130 interrupted.\n"
      "Help of a verb: spheretree VERB --help");
  try {
    cli.parse(argc, argv);
    return runVerb(program);
  } catch (const CLI::Success& help) {
    return cli.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string mistake = mistyped(cli);
    const auto chosen = cli.get_subcommands();
    const std::string help = "spheretree " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help";
    const std::string rule = argc == 1 ? "a verb is required" : error.what();
    return explain(kProgram, kExitUsage, mistake.empty() ? rule + ". See " + help + "." : mistake);
  }
}

}  // namespace spheretree::tool
