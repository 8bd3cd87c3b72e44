// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/command.h"

#include <algorithm>
#include <vector>

#include "command_reference.h"
#include "mistyped.h"
#include "options/scene_help.h"
#include "progress_bar.h"
#include "run_files.h"
#include "spheretree/formats/nearest_word.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

/// A message about a mistyped verb or option; empty if there is none.
std::string mistyped(const CLI::App& cli) {
  const std::vector<std::string> before = cli.remaining(false);  // words that no verb accepted
  if (!before.empty()) {
    const std::string& word = before.front();
    if (word.starts_with('-')) return unknownWord(cli, "", kProgram);
    std::vector<std::string> known;
    for (const CLI::App* verb : cli.get_subcommands(nullptr)) known.push_back(verb->get_name());
    const auto nearest = formats::nearestWord(word, known);
    return "unknown verb '" + word + "'" + (nearest ? "; the nearest is '" + std::string(*nearest) + "'" : "") + ". See spheretree --help.";
  }
  const auto chosen = cli.get_subcommands();
  if (chosen.empty()) return {};
  const std::string verb = chosen.front()->get_name();
  return unknownWord(*chosen.front(), " of " + verb, kProgram + " " + verb);
}

/// `help VERB` is `VERB --help`, and `help` alone is `--help`. The parser takes the words from the end.
std::vector<std::string> wordsOf(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  refuseEmptyWords(words);
  if (!words.empty() && words[0] == "help") {
    words.erase(words.begin());
    if (words.empty() || words[0].starts_with('-')) return {"--help"};
    words.insert(words.begin() + 1, "--help");
  }
  std::reverse(words.begin(), words.end());
  return words;
}

// Called last, so that the help shows them last.
void addTalkOptions(CLI::App& app, Program& program, const std::string& group) {
  app.option_defaults()->group(group);
  app.add_option("--progress", program.progress,
                 "Form of the progress on stderr: auto, bar, plain, json or none; default auto: a bar on a terminal")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "bar", "plain", "json", "none"}));
  app.add_flag("-q,--quiet", program.quiet, "Write only errors to stderr");
  app.set_help_flag("-h,--help", "Print this text");
}

int runVerb(Program& program) {
  ProgressBar progress(program.progress, program.quiet);
  const InterruptGuard guard(progress);
  const RunFiles files(progress, program.cli.get_subcommands().front()->get_name(), program.force);
  return program.run(progress);
}

}  // namespace

CLI::App* addVerb(Program& program, const std::string& verb, const std::string& description, const std::string& example,
                  std::function<int(WorkProgress&)> run) {
  CLI::App* app = program.cli.add_subcommand(verb, description);
  app->group("Verbs");
  app->footer("Example:\n  " + example);
  app->callback([&program, run = std::move(run)] { program.run = run; });
  return app;
}

void addForce(CLI::App& app, Program& program) {
  app.add_flag("--force", program.force,
               "Replace files that no earlier run of this command wrote, or that were edited since; default: they are refused");
}

int runProgram(Program& program, int argc, char** argv) {
  CLI::App& cli = program.cli;
  cli.name(kProgram);
  cli.require_subcommand(1);
  for (CLI::App* verb : cli.get_subcommands(nullptr)) addTalkOptions(*verb, program, "Options of every verb");
  addTalkOptions(cli, program, "Options, before or after the verb");
  cli.set_version_flag("--version", kGenerator, "Print the version");
  cli.footer(
      "Exit codes: 0 ok, 1 internal error, 2 usage, 3 file cannot be read or written,\n"
      "  4 input refused, 5 target missed and best result written, 6 batch partly\n"
      "  failed, 130 interrupted.\n"
      "Help of a verb: spheretree help VERB. Keys of a scene: spheretree help scene\n"
      "Completion for a shell: spheretree --completion bash|zsh|fish\n"
      "Manual page: spheretree --manual");
  try {
    if (wroteReference(cli, {argv + 1, argv + argc}, kGenerator)) return kExitOk;
    std::vector<std::string> words = wordsOf(argc, argv);
    if (argc == 3 && std::string_view(argv[1]) == "help" && std::string_view(argv[2]) == "scene") {
      writeResult(cli.get_subcommand("scene")->help() + "\n" + std::string(kSceneHelp));
      return kExitOk;
    }
    cli.parse(words);
    return runVerb(program);
  } catch (const CLI::Success& help) {
    // The parser gives --help precedence over all other errors.
    if (const std::string mistake = cli.get_subcommands().empty() ? mistyped(cli) : ""; !mistake.empty())
      return explain(kProgram, kExitUsage, mistake);
    return cli.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string mistake = mistyped(cli);
    const auto chosen = cli.get_subcommands();
    const std::string help = "spheretree " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help";
    const std::string rule = chosen.empty() && dynamic_cast<const CLI::RequiredError*>(&error) ? "a verb is required" : explained(error);
    return explain(kProgram, kExitUsage, mistake.empty() ? rule + ". See " + help + "." : mistake);
  }
}

}  // namespace spheretree::tool
