// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/command.h"

int main(int argc, char** argv) {
  using namespace spheretree::tool;
  return runAndExplain(kProgram, [&] {
    Program program;  // the help shows the verbs in this order
    addBuildCommand(program);
    addCheckCommand(program);
    addRepairCommand(program);
    addEvaluateCommand(program);
    addInspectCommand(program);
    addViewCommand(program);
    addConvertCommand(program);
    addCompareCommand(program);
    addSceneCommand(program);
    addBatchCommand(program);
    addReportCommand(program);
    addSplitCommand(program);
    addSoftenCommand(program);
    addGradeCommand(program);
    addRobotCommand(program);
    return runProgram(program, argc, argv);
  });
}
