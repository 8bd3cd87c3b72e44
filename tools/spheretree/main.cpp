// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/command.h"

int main(int argc, char** argv) {
  using namespace spheretree::tool;
  return runAndExplain(kProgram, [&] {
    Program program;
    addBuildCommand(program);
    addBatchCommand(program);
    addCheckCommand(program);
    addCompareCommand(program);
    addConvertCommand(program);
    addEvaluateCommand(program);
    addGradeCommand(program);
    addInspectCommand(program);
    addRepairCommand(program);
    addReportCommand(program);
    addRobotCommand(program);
    addSceneCommand(program);
    addSoftenCommand(program);
    addSplitCommand(program);
    addViewCommand(program);
    return runProgram(program, argc, argv);
  });
}
