// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/draft_options.h"

#include "mistyped.h"
#include "options/common_options.h"
#include "program_end.h"

namespace spheretree::tool {
namespace {

std::string faultOfMatch(const std::string& text) try {
  (void)pipeline::parseToleranceMatch(text);
  return "";
} catch (const UsageError& error) {
  return error.what();
}

}  // namespace

void addDraftOptions(CLI::App& app, pipeline::SceneDraftSettings& draft) {
  app.add_option("--tool", draft.tool,
                 "Tool in the hand: the name of an object, or a mesh file; default: the object whose name contains a word such as probe or "
                 "tool, else a ball of 1 mm")
      ->type_name("NAME|FILE");
  app.add_option_function<std::vector<std::string>>(
         "--match",
         [&draft](const std::vector<std::string>& texts) {
           draft.matches.clear();
           for (const std::string& text : texts) draft.matches.push_back(pipeline::parseToleranceMatch(text));
         },
         "Tolerance in mm of the objects whose name matches; * stands for any text and ? for any letter, such as 'tooth_*=0.1'; above 0 "
         "and at "
         "most 10^6; may be given again, the last one counts; default: --tolerance")
      ->type_name("PATTERN=MM")
      ->allow_extra_args(false)
      ->check(faultOfMatch);
  app.add_option("--reach", draft.reach_mm,
                 "Radius in mm of a ball, above 0 and at most 10^6: the tolerance of surfaces that this ball cannot touch is 5 times the "
                 "largest one; default: none, all surfaces keep their tolerance")
      ->type_name("MM")
      ->check(numberIn(1e-9, formats::kMaxSceneLength));
  app.add_flag("--components", draft.components,
               "Make an object of each connected component of the mesh files, in place of each named part; default: off");
  app.add_option("--frame", draft.frame,
                 "LPS or RAS: turn the objects of files whose header states the other one (SPACE=); default: none, as they are stored")
      ->type_name("NAME")
      ->check(CLI::IsMember({"LPS", "RAS"}));
  addUnit(app, draft.unit);
}

}  // namespace spheretree::tool
