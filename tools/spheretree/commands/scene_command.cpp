// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree scene: makes a scene for batch from mesh files; each of their parts becomes an object.
#include <memory>

#include "mistyped.h"
#include "options/command.h"
#include "options/draft_options.h"
#include "pipeline/scene_draft.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct SceneOptions {
  pipeline::SceneDraftSettings draft;
  std::filesystem::path output;
};

int runScene(const SceneOptions& options, bool quiet, builder::Progress& progress) {
  const RunFiles files(progress);
  for (const std::filesystem::path& input : options.draft.files) {
    if (isDash(input)) throw UsageError("a scene refers to its mesh files by name; standard input (-) has none. Save it as a file first.");
    files.willRead(input);
  }
  files.willWrite(options.output, {".json"}, "the scene");
  if (!isDash(options.output)) files.keepEdits(options.output);
  if (isDash(options.output)) throw UsageError("a scene names its mesh files relative to its own folder. Give -o the name of a file.");
  progress.stage("read");
  pipeline::MeshStore meshes;
  const pipeline::SceneDraft draft = draftScene(options.draft, options.output, meshes);
  files.willMake(draft.ball, draft.ball_mesh);
  clearProgressLine();
  if (!quiet)
    for (const std::string& note : draft.notes) say("spheretree: " + note);
  if (!draft.ball.empty()) formats::writeWhole(draft.ball, draft.ball_mesh);
  formats::writeWhole(options.output, formats::sceneText(draft.scene));
  const std::string name = plainText(options.output.string());
  printResult("%s: %s, tool %s\nnext: spheretree batch %s -o DIR\n", name.c_str(), counted(draft.scene.objects.size(), "object").c_str(),
              draft.scene.tool.name.c_str(), name.c_str());
  return kExitOk;
}

}  // namespace

void addSceneCommand(Program& program) {
  const auto options = std::make_shared<SceneOptions>();
  CLI::App* app = addVerb(program, "scene", "Write a scene for batch from mesh files; each of their parts becomes an object",
                          "spheretree scene mouth.glb probe.stl -o mouth.scene.json --tolerance 0.2 \\\n    --match 'tooth_*=0.1'",
                          [options, &program](builder::Progress& progress) { return runScene(*options, program.quiet, progress); });
  app->add_option("MESH", options->draft.files, "Mesh files (OBJ, STL, PLY, OFF, glTF, GLB) or trees (.stree); several may be given")
      ->required()
      ->type_name("FILE");
  app->add_option("-o,--output", options->output, "Scene to write (.scene.json); spheretree help scene lists its keys")
      ->required()
      ->type_name("FILE");
  app->add_option("--tolerance", options->draft.tolerance_mm,
                  "Tolerance of every object and of the tool in mm, above 0 and at most 10^6; default: none, each tree has its full number "
                  "of leaves")
      ->type_name("MM")
      ->check(numberIn(1e-9, formats::kMaxSceneLength));
  addDraftOptions(*app, options->draft);
  addForce(*app, program);
}

}  // namespace spheretree::tool
