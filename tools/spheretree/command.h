// SPDX-License-Identifier: GPL-3.0-or-later
// What the verbs of the program share: options, exit codes, and how a failure becomes a message.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>
#include <string>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitFile = 3,           // cannot be read or written
  kExitRefused = 4,        // input refused, with the reason
  kExitTargetMissed = 5,   // best result written
  kExitPartlyFailed = 6,   // of a batch
  kExitInterrupted = 130,  // Ctrl-C
};

/// Options that are fine one by one but not together, or not in this version. The program exits with 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline const std::string kGenerator = "spheretree " SPHERETREE_VERSION;

/// The program under construction: a verb adds its options to `cli`, and sets `run` once it is chosen.
struct Program {
  CLI::App cli{"Builds, checks and measures certified sphere-trees of triangle meshes."};
  std::string progress = "auto";
  bool quiet = false;
  /// Returns an exit code; results go to stdout or to files, talk to stderr.
  std::function<int(builder::Progress&)> run;
};

/// A subcommand with the options that every verb has, and an example at the end of its help. `run` is called if it is chosen.
CLI::App* addVerb(Program& program, const std::string& verb, const std::string& description, const std::string& example,
                  std::function<int(builder::Progress&)> run);

void addBatchCommand(Program& program);
void addBuildCommand(Program& program);
void addCheckCommand(Program& program);
void addCompareCommand(Program& program);
void addConvertCommand(Program& program);
void addEvaluateCommand(Program& program);
void addInspectCommand(Program& program);
void addReportCommand(Program& program);

/// Parses, runs the chosen verb and turns every exception into a message on stderr and an exit code.
int runProgram(Program& program, int argc, char** argv);

}  // namespace spheretree::tool
