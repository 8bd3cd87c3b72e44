// SPDX-License-Identifier: GPL-3.0-or-later
// The framework of the program's verbs: their common options, and how a verb is selected and run.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "help_formatter.h"
#include "program_end.h"
#include "work_progress.h"

namespace spheretree::tool {

inline const std::string kProgram = "spheretree";

/// The program under construction: a verb adds its options to `cli`, and sets `run` when it is selected.
struct Program {
  Program() { cli.formatter(std::make_shared<HelpFormatter>()); }

  CLI::App cli{"Builds, checks and measures certified sphere-trees of triangle meshes."};
  std::string progress = "auto";
  bool quiet = false, force = false;
  /// Returns an exit code; results go to stdout or to files, messages to stderr.
  std::function<int(WorkProgress&)> run;
};

/// Adds a subcommand with the common options of all verbs, and an example at the end of its help. `run` is called if
/// the verb is selected.
CLI::App* addVerb(Program& program, const std::string& verb, const std::string& description, const std::string& example,
                  std::function<int(WorkProgress&)> run);

/// --force, for a verb that writes files which the command line does not name.
void addForce(CLI::App& app, Program& program);

void addBatchCommand(Program& program);
void addBuildCommand(Program& program);
void addCheckCommand(Program& program);
void addCompareCommand(Program& program);
void addConvertCommand(Program& program);
void addEvaluateCommand(Program& program);
void addGradeCommand(Program& program);
void addInspectCommand(Program& program);
void addRepairCommand(Program& program);
void addReportCommand(Program& program);
void addRobotCommand(Program& program);
void addSceneCommand(Program& program);
void addSoftenCommand(Program& program);
void addSplitCommand(Program& program);
void addViewCommand(Program& program);

/// Parses the command line and runs the selected verb; errors in the command line are reported on stderr. Returns an
/// exit code.
/// @throws the exceptions of a verb, which runAndExplain() turns into messages.
int runProgram(Program& program, int argc, char** argv);

}  // namespace spheretree::tool
