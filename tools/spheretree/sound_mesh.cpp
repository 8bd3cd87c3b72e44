// SPDX-License-Identifier: GPL-3.0-or-later
#include "sound_mesh.h"

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/mesh_checks.h"

namespace spheretree::tool {
namespace {

std::string counted(std::size_t count, const char* thing) { return std::to_string(count) + " " + thing + (count == 1 ? "" : "s"); }

}  // namespace

TriangleMesh soundMesh(TriangleMesh mesh, const std::string& name, bool repair, std::vector<std::string>& notes) {
  const builder::MeshReport report = builder::checkMesh(mesh);
  const bool turns = repair && report.fixable() && !report.clean();
  if (!report.clean() && !turns) {
    std::string message = name + ": the mesh is refused:\n" + report.summary();
    while (message.back() == '\n') message.pop_back();
    if (repair)
      message += "\nThis version repairs nothing but surfaces that are inside out.";
    else if (report.fixable())
      message += "\n--repair auto turns it.";
    throw builder::BuildError(message);
  }
  if (turns) {
    notes.push_back("inside out and turned: " + counted(report.count(builder::DefectKind::InsideOut), "component") + ".");
    mesh = builder::orientOutward(std::move(mesh), report);
  }
  if (report.buriedComponents() > 0) {
    notes.push_back("left out, since within solid matter they bound nothing: " + counted(report.buriedComponents(), "component") + ".");
    mesh = builder::withoutBuried(mesh, report);
  }
  return mesh;
}

}  // namespace spheretree::tool
