// SPDX-License-Identifier: GPL-3.0-or-later
#include "command.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

#include "progress_bar.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/nearest_word.h"

namespace spheretree::tool {
namespace {

std::atomic<builder::Progress*> running{nullptr};
static_assert(std::atomic<builder::Progress*>::is_always_lock_free, "a signal handler may not wait");

extern "C" void interrupt(int) {
  if (builder::Progress* progress = running.load()) progress->cancel();
}

/// While it lives, the first Ctrl-C cancels `progress`, so that nothing is left half done; the second ends the program.
class InterruptGuard {
 public:
  explicit InterruptGuard(builder::Progress& progress) {
    running.store(&progress);
    struct sigaction action {};
    action.sa_handler = interrupt;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  }
  ~InterruptGuard() {
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
    running.store(nullptr);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
};

int explain(int code, const std::string& message) {
  std::cerr << "spheretree: " << message << '\n';
  return code;
}

/// CLI11 names the first rule that is broken, often a missing argument, where the user mistyped a verb or an option. Empty if not so.
std::string mistyped(const CLI::App& cli) {
  std::vector<std::string> known;
  const auto chosen = cli.get_subcommands();
  if (chosen.empty()) {
    const std::vector<std::string> rest = cli.remaining(true);
    if (rest.empty()) return {};
    if (rest.front().rfind('-', 0) == 0) return "unknown option '" + rest.front() + "'. See spheretree --help.";
    for (const CLI::App* verb : cli.get_subcommands(nullptr)) known.push_back(verb->get_name());
    return "unknown verb '" + rest.front() + "'; the nearest is '" + std::string(formats::nearestWord(rest.front(), known)) +
           "'. See spheretree --help.";
  }
  const CLI::App& verb = *chosen.front();
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string& word : verb.remaining()) {
    if (word.size() < 2 || word[0] != '-') continue;
    const std::string name = word.substr(0, word.find('='));
    return "unknown option '" + name + "' of " + verb.get_name() + "; the nearest is '" + std::string(formats::nearestWord(name, known)) +
           "'. See spheretree " + verb.get_name() + " --help.";
  }
  return {};
}

/// A full disk or a closed pipe shows only when the buffer is written.
int flushed(int code) {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return explain(kExitFile, "standard output: cannot be written. Free some space or write elsewhere.");
}

int runVerb(Program& program) {
  ProgressBar progress(program.progress, program.quiet);
  const InterruptGuard guard(progress);
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
  cli.name("spheretree");
  cli.set_version_flag("--version", kGenerator);
  cli.require_subcommand(1);
  cli.footer(
      "Exit codes: 0 ok, 1 internal error, 2 usage, 3 file cannot be read or written, 4 input refused,\n"
      "  5 target missed and best result written, 6 batch partly failed, 130 interrupted.\n"
      "Help of a verb: spheretree VERB --help");
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return flushed(cli.exit(help));
  } catch (const CLI::ParseError& error) {
    const std::string mistake = mistyped(cli);
    const auto chosen = cli.get_subcommands();
    const std::string help = "spheretree " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help";
    const std::string rule = argc == 1 ? "a verb is required" : error.what();
    return explain(kExitUsage, mistake.empty() ? rule + ". See " + help + "." : mistake);
  }
  try {
    return flushed(runVerb(program));
  } catch (const UsageError& error) {
    return explain(kExitUsage, error.what());
  } catch (const formats::FileError& error) {
    return explain(kExitFile, error.what());
  } catch (const formats::FormatError& error) {
    return explain(kExitRefused, error.what());
  } catch (const builder::BuildError& error) {
    return explain(kExitRefused, error.what());
  } catch (const builder::Cancelled&) {
    return explain(kExitInterrupted, "interrupted, nothing was written.");
  } catch (const std::bad_alloc&) {
    return explain(kExitInternal, "not enough memory. Close other programs or use a smaller mesh.");
  } catch (const std::exception& error) {
    return explain(kExitInternal, std::string("internal error: ") + error.what() + ". Please report this with the command and its input.");
  }
}

}  // namespace spheretree::tool
