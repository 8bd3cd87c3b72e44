// SPDX-License-Identifier: Apache-2.0
// Presses a tool on an object and prints its contacts: point, normal and force of each.
// Usage: contacts TOOL.stree OBJECT.stree
#include <cstdio>
#include <exception>
#include <string>

#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"

namespace {

using namespace spheretree;

void printContacts(const Configuration& haptic, const runtime::Workspace& workspace) {
  std::printf("hand at z = %.2f mm\n", haptic.position.z());
  for (const runtime::Contact& c : runtime::contacts(workspace))
    std::printf("  on %s of object %u at (%.3f, %.3f, %.3f) mm, normal (%.3f, %.3f, %.3f), %.3f N\n", c.on_skin ? "the skin" : "a leaf",
                c.object, c.point.x(), c.point.y(), c.point.z(), c.normal.x(), c.normal.y(), c.normal.z(), c.force);
}

int run(const char* tool, const char* object) {
  runtime::SceneDescription description;
  description.tool = formats::readSphereTree(tool);
  description.objects.push_back({formats::readSphereTree(object), {}});
  runtime::Scene scene;
  std::string fault;
  if (!runtime::compileScene(description, scene, fault)) {
    std::fprintf(stderr, "%s\n", fault.c_str());
    return 4;
  }
  runtime::Workspace workspace(scene);
  Configuration haptic;  // comes down from above, 0.1 mm in each servo step, until the tool is pressed in by 1 mm
  for (haptic.position.z() = 60; haptic.position.z() > -60; haptic.position.z() -= 0.1) {
    const runtime::StepResult result = runtime::step(scene, haptic, runtime::Mode::Constrained, workspace);
    const bool is_pressed = (result.graphic.position - haptic.position).norm() > 1;
    if (is_pressed) {
      printContacts(haptic, workspace);
      return 0;
    }
  }
  std::puts("the tool has touched nothing");
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fprintf(stderr, "usage: contacts TOOL.stree OBJECT.stree\n");
    return 2;
  }
  return run(argv[1], argv[2]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 3;
}
